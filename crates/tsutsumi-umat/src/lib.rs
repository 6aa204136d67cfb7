//! Laws from elsewhere: shared libraries with the UMAT interface of Abaqus, in Fortran or C.
//!
//! Many laws of the field exist as UMATs. [`Umat`] loads one and is a [`ConstitutiveLaw`] like any other:
//!
//! ```toml
//! [materials.sand]
//! law = "umat"
//! parameters = { library = "./libsand.so", properties = [125.0, 0.05, 1.25], state_variables = 20 }
//! ```
//!
//! Signs agree (tension positive). The order of the components and the shear do not: UMATs count 11, 22, 33, 12, 13, 23 and take engineering shear;
//! both are converted here and nowhere else.

mod interface;
mod state;

pub use state::{MAX_STATE_VARIABLES, UmatState};

use std::path::PathBuf;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tsutsumi::law::{ConstitutiveLaw, LawError};
use tsutsumi::tensor::{Matrix3, Matrix6, Sym3};

use interface::{Answer, Question, Routine};

/// A law in a shared library with the UMAT interface of Abaqus (Fortran or C).
///
/// The effective stress, the total strain and the strain increment are handed over in full, three-dimensional (`NDI = NSHR = 3`). Stress and strain are turned by
/// Jaumann's rule before the call, as Abaqus does; the state variables are not: a UMAT that keeps tensors turns them with `DROT`. `DTIME` is the length of the step,
/// `DFGRD0` and `DFGRD1` are the products of the steps' deformation gradients. Temperatures, fields and coordinates are zero. A `PNEWDT` below 1 is an error: there is no
/// way back in an explicit step.
///
/// Calls are made one at a time, since UMATs may keep values in `COMMON` or `SAVE`. The wave moduli, which limit the step, are the largest entries of the diagonal of
/// `DDSDDE` for a step without strain.
///
/// # Reference
///
/// The argument list of the user subroutine UMAT, Abaqus User Subroutines Reference Guide (cited from memory).
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Umat {
    /// The shared library, `./libname.so`: from the folder in which the command runs. A name without `/` is looked for where the system keeps its libraries.
    pub library: PathBuf,
    /// The name of the routine in the library.
    #[serde(default = "default_routine")]
    pub routine: String,
    /// The name of the material that the routine is given (`CMNAME`), at most 80 characters.
    #[serde(default)]
    pub material_name: String,
    /// The properties `PROPS` in the order and the units that the routine expects; this program's units are SI.
    pub properties: Vec<f64>,
    /// The number of state variables `NSTATV`.
    pub state_variables: usize,
    /// Their values at the start; the rest is zero.
    #[serde(default)]
    pub initial_state: Vec<f64>,
    #[serde(skip)]
    #[schemars(skip)]
    loaded: OnceLock<Result<Routine, String>>,
}

fn default_routine() -> String {
    "umat_".to_owned()
}

impl Umat {
    /// A law from the routine `umat_` of a library, without state variables.
    pub fn new(library: impl Into<PathBuf>, properties: Vec<f64>) -> Self {
        Umat {
            library: library.into(),
            routine: default_routine(),
            material_name: String::new(),
            properties,
            state_variables: 0,
            initial_state: Vec::new(),
            loaded: OnceLock::new(),
        }
    }

    /// The routine, loaded when it is first needed.
    fn routine(&self) -> Result<&Routine, LawError> {
        let loaded = self.loaded.get_or_init(|| Routine::load(&self.library, &self.routine));
        loaded.as_ref().map_err(|message| setting("library", message.clone()))
    }

    fn ask(&self, stress: Sym3, state: &UmatState, strain: Sym3, duration: f64) -> Result<Answer, LawError> {
        // The routine divides by DTIME, if at all: as slow as can be is one second here.
        let duration = if duration.is_finite() { duration } else { 1.0 };
        let question = Question {
            stress,
            state,
            strain,
            duration,
            properties: &self.properties,
            state_variables: self.state_variables,
            material_name: &self.material_name,
        };
        let answer = self.routine()?.call(&question);
        match answer.shorter_step < 1.0 {
            true => Err(LawError::Foreign {
                message: format!(
                    "the routine `{}` asks for a step shortened to {} of its length (PNEWDT)",
                    self.routine, answer.shorter_step
                ),
            }),
            false => Ok(answer),
        }
    }

    /// The largest entries of the diagonal of DDSDDE (Pa) without strain: of compression, of shear. Infinite if the routine fails, so that no step is long
    /// enough to hide it.
    fn moduli(&self, stress: Sym3, state: &UmatState) -> (f64, f64) {
        let largest =
            |tangent: &Matrix6, range: std::ops::Range<usize>| range.map(|i| tangent[(i, i)]).fold(0.0, f64::max);
        match self.ask(stress, state, Sym3::ZERO, f64::INFINITY) {
            Ok(answer) => (largest(&answer.tangent, 0..3), 0.5 * largest(&answer.tangent, 3..6)),
            Err(_) => (f64::INFINITY, f64::INFINITY),
        }
    }
}

fn setting(name: &'static str, message: String) -> LawError {
    LawError::Setting { name, message }
}

impl ConstitutiveLaw for Umat {
    type State = UmatState;

    fn update(&self, stress: Sym3, state: UmatState, strain: Sym3) -> Result<(Sym3, UmatState), LawError> {
        self.update_within(stress, state, strain, f64::INFINITY)
    }

    fn update_within(
        &self,
        stress: Sym3,
        state: UmatState,
        strain: Sym3,
        duration: f64,
    ) -> Result<(Sym3, UmatState), LawError> {
        let answer = self.ask(stress, &state, strain, duration)?;
        Ok((answer.stress, answer.state))
    }

    fn p_wave_modulus(&self, stress: Sym3, state: &UmatState) -> f64 {
        self.moduli(stress, state).0
    }

    fn s_wave_modulus(&self, stress: Sym3, state: &UmatState) -> f64 {
        self.moduli(stress, state).1
    }

    fn validate(&self) -> Result<(), LawError> {
        if self.state_variables > MAX_STATE_VARIABLES {
            let message = format!(
                "{} state variables are more than the {MAX_STATE_VARIABLES} there is room for",
                self.state_variables
            );
            return Err(setting("state_variables", message));
        }
        if self.initial_state.len() > self.state_variables {
            let message = format!("{} values for {} state variables", self.initial_state.len(), self.state_variables);
            return Err(setting("initial_state", message));
        }
        if self.material_name.len() > 80 || !self.material_name.is_ascii() {
            return Err(setting("material_name", "more than 80 characters, or not ASCII".to_owned()));
        }
        self.routine().map(|_| ())
    }

    fn initial_state(&self, _stress: Sym3) -> UmatState {
        UmatState::starting_with(&self.initial_state)
    }

    fn rotate_state(&self, state: UmatState, rotation: &Matrix3) -> UmatState {
        state.rotated(rotation)
    }

    /// DDSDDE.
    fn tangent(&self, stress: Sym3, state: UmatState, strain: Sym3) -> Result<Matrix6, LawError> {
        Ok(self.ask(stress, &state, strain, f64::INFINITY)?.tangent)
    }
}
