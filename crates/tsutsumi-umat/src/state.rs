use serde::{Deserialize, Serialize};
use tsutsumi::tensor::{Matrix3, Sym3};

/// The most state variables that a routine may have.
pub const MAX_STATE_VARIABLES: usize = 96;

/// What a UMAT finds again in the next step.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(into = "Written", from = "Written")]
pub struct UmatState {
    /// `STATEV`.
    pub(crate) variables: [f64; MAX_STATE_VARIABLES],
    /// The total strain `STRAN` (–, tensor shear).
    pub(crate) strain: Sym3,
    /// The rotation since the last call, `DROT`.
    pub(crate) turn: Matrix3,
    /// The deformation gradient at the end of the last step, `DFGRD0`.
    pub(crate) deformation: Matrix3,
}

impl Default for UmatState {
    fn default() -> Self {
        UmatState::starting_with(&[])
    }
}

impl UmatState {
    pub(crate) fn starting_with(variables: &[f64]) -> Self {
        let mut all = [0.0; MAX_STATE_VARIABLES];
        all.iter_mut().zip(variables).for_each(|(to, from)| *to = *from);
        UmatState { variables: all, strain: Sym3::ZERO, turn: Matrix3::identity(), deformation: Matrix3::identity() }
    }

    /// The total strain turns; the routine is told to turn what it keeps.
    pub(crate) fn rotated(self, rotation: &Matrix3) -> Self {
        UmatState { strain: self.strain.rotated(rotation), turn: rotation * self.turn, ..self }
    }

    /// The state variables of the routine.
    pub fn variables(&self) -> &[f64] {
        &self.variables
    }
}

/// The state in a file: variables without the zeros at their end.
#[derive(Serialize, Deserialize)]
struct Written {
    variables: Vec<f64>,
    strain: Sym3,
    turn: Matrix3,
    deformation: Matrix3,
}

impl From<UmatState> for Written {
    fn from(state: UmatState) -> Self {
        let used = state.variables.iter().rposition(|&value| value != 0.0).map_or(0, |last| last + 1);
        let UmatState { variables, strain, turn, deformation } = state;
        Written { variables: variables[..used].to_vec(), strain, turn, deformation }
    }
}

impl From<Written> for UmatState {
    fn from(written: Written) -> Self {
        let Written { variables, strain, turn, deformation } = written;
        UmatState { strain, turn, deformation, ..UmatState::starting_with(&variables) }
    }
}
