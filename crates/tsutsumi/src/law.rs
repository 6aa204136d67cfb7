//! Constitutive laws of the effective stress, and laws of the conductivity.
//!
//! A law is a pure function of one material point: it gets the effective stress and its history at the start of a step
//! and the strain increment, and returns both at the end. Laws are three-dimensional; the dimension of the problem never
//! reaches them.
//!
//! To write one, implement [`ConstitutiveLaw`]: two methods are required. `examples/my-law` is a complete one.

mod aligned;
mod bingham;
mod block;
mod closed_path;
mod conductivity;
mod drucker_prager;
mod frictional;
mod group;
mod hencky;
mod left_cauchy_green;
mod linear_elastic;
mod liquid_pressure;
mod meridian;
mod modified_cam_clay;
mod mohr_coulomb;
mod mu_i;
mod neo_hookean;
mod newtonian;
mod oka_cyclic;
mod parameter;
mod pm4sand;
mod pressure_elastic;
mod principal;
mod root_pressure;
mod sanisand;
pub mod substepping;
mod von_mises;

pub use bingham::{Bingham, BinghamState};
pub(crate) use block::{BLOCK, LANES};
pub use block::{IncrementBlock, StressBlock};
pub use closed_path::ClosedPathWork;
pub use conductivity::{ConductivityLaw, ConstantConductivity, KozenyCarman, XieLeo};
pub use drucker_prager::{Cone, DruckerPrager};
pub use frictional::FrictionalState;
pub use group::{BlockOutcome, Group, LawFailure, MaterialGroup, Question};
pub use hencky::Hencky;
pub use left_cauchy_green::LeftCauchyGreen;
pub use linear_elastic::LinearElastic;
pub use modified_cam_clay::{CamClayState, ModifiedCamClay};
pub use mohr_coulomb::MohrCoulomb;
pub use mu_i::{MuI, MuIState};
pub use neo_hookean::NeoHookean;
pub use newtonian::{Newtonian, NewtonianState};
pub use oka_cyclic::{OkaCyclic, OkaCyclicState};
pub use pm4sand::{PlaneDeviator, Pm4Sand, Pm4SandState};
pub use pressure_elastic::PressureElastic;
pub use sanisand::{Sanisand, SanisandState};
pub use von_mises::{VonMises, VonMisesState};

use serde::Serialize;
use serde::de::DeserializeOwned;

use self::substepping::SubStepFailure;
use crate::tensor::{Matrix3, Matrix6, Sym3, Vector, rotation, spin};

/// How a material point moves in one step: the gradient ∇u of the displacement over the place at the start of the step, in two parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Increment {
    /// The strain increment Δε = ½ (∇u + ∇uᵀ) (–).
    pub strain: Sym3,
    /// The axial vector of the spin increment ½ (∇u − ∇uᵀ) (rad).
    pub spin: Vector<3>,
    /// How long it takes (s); infinite where time plays no part.
    pub duration: f64,
}

/// No motion, and all the time in the world for it.
impl Default for Increment {
    fn default() -> Self {
        Increment { strain: Sym3::ZERO, spin: Vector::zeros(), duration: f64::INFINITY }
    }
}

impl Increment {
    /// The two parts of a displacement gradient ∇u, without a duration.
    #[inline(always)]
    pub fn of(displacement_gradient: &Matrix3) -> Self {
        let (strain, spin) = (Sym3::symmetric_part(displacement_gradient), spin(displacement_gradient));
        Increment { strain, spin, duration: f64::INFINITY }
    }

    /// The same motion within this time (s).
    #[inline(always)]
    #[must_use]
    pub fn within(self, duration: f64) -> Self {
        Increment { duration, ..self }
    }

    /// The displacement gradient ∇u; I + ∇u is the deformation gradient of the step.
    pub fn displacement_gradient(&self) -> Matrix3 {
        self.strain.to_matrix() + self.spin.cross_matrix()
    }
}

/// Why a law cannot be used or could not be integrated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LawError {
    /// A parameter is out of range.
    #[error("parameter `{name}` is {value}, but must be {expected}")]
    Parameter {
        /// The name of the parameter, as users write it.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range that was expected, in words.
        expected: &'static str,
    },
    /// A parameter that is not a plain number is wrong.
    #[error("`{name}`: {message}")]
    Setting {
        /// The name of the parameter, as users write it.
        name: &'static str,
        /// What is wrong with it.
        message: String,
    },
    /// A law outside this library refused.
    #[error("{message}")]
    Foreign {
        /// What it said.
        message: String,
    },
    /// The stress at the end of the step is infinite or not a number.
    #[error("the stress is not finite after the strain increment {strain}")]
    NotFinite {
        /// The strain increment (–).
        strain: Sym3,
    },
    /// A law whose stiffness comes from compression alone has none.
    #[error("the mean effective pressure is {pressure:.3e} Pa, but this law needs compression (a positive one)")]
    NoCompression {
        /// The mean effective pressure (Pa, positive in compression).
        pressure: f64,
    },
    /// An iteration did not converge.
    #[error("the return mapping did not converge in {iterations} iterations (residual {residual:e})")]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// The residual reached, in the law's own measure.
        residual: f64,
    },
    /// Plastic strain would lower the stress faster than the elastic strain it replaces: there is no answer to a strain increment.
    #[error("the material snaps back: the plastic modulus is {modulus:e} Pa")]
    SnapBack {
        /// The modulus (Pa) by which plastic loading divides; not positive.
        modulus: f64,
    },
    /// A law for plane strain met a component out of the plane.
    #[error("the law is for plane strain in x and y, but the {what} has a component {component} of {value:e}")]
    OutOfPlane {
        /// Stress or strain increment.
        what: &'static str,
        /// The component.
        component: &'static str,
        /// Its value (Pa or –).
        value: f64,
    },
    /// Sub-steps could not be made small enough.
    #[error("{0}")]
    SubSteps(Box<SubStepFailure>),
}

/// A constitutive law: effective stress from strain increments, for one material point.
pub trait ConstitutiveLaw: Send + Sync + 'static {
    /// The history variables: plain data, `()` if there are none.
    type State: Copy + Default + Send + Sync + Serialize + DeserializeOwned + 'static;

    /// Effective stress σ' (Pa, positive in tension) and history at the end of a step.
    ///
    /// `stress` and `state` are those at the start, already turned with the material; `strain` is the increment Δε (–,
    /// tensor shear components, positive in extension).
    ///
    /// # Errors
    /// The law's own reasons why there is no answer.
    fn update(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<(Sym3, Self::State), LawError>;

    /// True for laws of finite strain: they implement [`deform`](Self::deform) and follow the deformation gradient themselves.
    const FINITE_STRAIN: bool = false;

    /// Effective stress σ' (Pa) and history at the end of a step, from the whole motion of the material in it.
    ///
    /// Small increments, the default: stress and history turn by the rotation of the step (Jaumann's rate), then comes
    /// [`update`](Self::update). A law of finite strain implements this method instead: it keeps what it needs of the deformation gradient
    /// F ← (I + ∇u) F in its history, as [`LeftCauchyGreen`] does for isotropic ones, and gets stress and history as they were, not turned.
    /// Its `update` is a step without spin.
    ///
    /// # Errors
    /// Those of [`update`](Self::update).
    #[inline(always)]
    fn deform(&self, stress: Sym3, state: Self::State, motion: &Increment) -> Result<(Sym3, Self::State), LawError> {
        let turn = rotation(&motion.spin);
        self.update_within(stress.rotated(&turn), self.rotate_state(state, &turn), motion.strain, motion.duration)
    }

    /// The same as [`update`](Self::update), for laws to which it matters how long the step takes (s): viscous fluids, rate-dependent soils.
    ///
    /// Without an implementation time plays no part. A law that has one answers `update` as if the step took for ever.
    ///
    /// # Errors
    /// Those of [`update`](Self::update).
    #[inline(always)]
    fn update_within(
        &self,
        stress: Sym3,
        state: Self::State,
        strain: Sym3,
        _duration: f64,
    ) -> Result<(Sym3, Self::State), LawError> {
        self.update(stress, state, strain)
    }

    /// The largest stiffness against a compression wave (Pa): limits the time step.
    fn p_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64;

    /// The largest stiffness against a shear wave (Pa): limits the time step.
    ///
    /// Without an implementation it is ¾ of the compression modulus, the most an isotropic solid can have (ν = −1 to ½
    /// with K ≥ 0).
    fn s_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64 {
        0.75 * self.p_wave_modulus(stress, state)
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// [`LawError::Parameter`] for the first one out of range.
    fn validate(&self) -> Result<(), LawError> {
        Ok(())
    }

    /// What the law promises of the work on closed paths of strain, with the parameters that it has.
    ///
    /// Without an implementation nothing is promised. `check_law` of the testkit holds a law to what it promises.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Any
    }

    /// The history of a material point that starts with this effective stress (Pa).
    fn initial_state(&self, _stress: Sym3) -> Self::State {
        Self::State::default()
    }

    /// Turns the tensors of the history with the material: a → R a Rᵀ. Histories of scalars stay as they are.
    fn rotate_state(&self, state: Self::State, _rotation: &Matrix3) -> Self::State {
        state
    }

    /// The tangent dσ'/dε (Pa) in Kelvin components ([`Sym3::to_kelvin`]), at a strain increment.
    ///
    /// Without an implementation it is found by central differences of [`ConstitutiveLaw::update`].
    ///
    /// # Errors
    /// Those of [`ConstitutiveLaw::update`].
    fn tangent(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<Matrix6, LawError> {
        tangent_by_differences(self, stress, state, strain)
    }

    /// The names of the law's own output quantities, written beside the stress.
    fn outputs(&self) -> &'static [&'static str] {
        &[]
    }

    /// The values of [`ConstitutiveLaw::outputs`], in the same order.
    fn write_outputs(&self, _stress: Sym3, _state: &Self::State, _values: &mut [f64]) {}
}

/// The tangent dσ'/dε (Pa) in Kelvin components by central differences of [`ConstitutiveLaw::update`].
fn tangent_by_differences<L: ConstitutiveLaw + ?Sized>(
    law: &L,
    stress: Sym3,
    state: L::State,
    strain: Sym3,
) -> Result<Matrix6, LawError> {
    differences(|strain| Ok(law.update(stress, state, strain)?.0), strain)
}

/// The derivative of a stress (Pa) with respect to the strain, in Kelvin components, by central differences.
fn differences(stress_at: impl Fn(Sym3) -> Result<Sym3, LawError>, strain: Sym3) -> Result<Matrix6, LawError> {
    // The cube root of the machine precision balances rounding and truncation of a central difference.
    let step = strain.to_kelvin().norm().max(1e-6) * f64::EPSILON.cbrt();
    let mut tangent = Matrix6::zeros();
    for column in 0..6 {
        let mut direction = nalgebra::Vector6::zeros();
        direction[column] = step;
        let nudge = Sym3::from_kelvin(&direction);
        let (forward, backward) = (stress_at(strain + nudge)?, stress_at(strain - nudge)?);
        tangent.set_column(column, &((forward - backward).to_kelvin() / (2.0 * step)));
    }
    Ok(tangent)
}
