use std::fmt;

use super::Specimen;
use crate::law::LawError;
use crate::tensor::Sym3;

/// The last good state of a specimen, and the strain increment that led nowhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecimenState {
    /// The effective stress (Pa).
    pub stress: Sym3,
    /// The strain since the start of the test (–).
    pub strain: Sym3,
    /// The last strain increment that was tried (–).
    pub increment: Sym3,
}

impl SpecimenState {
    pub(super) fn of(specimen: &Specimen, increment: Sym3) -> Box<Self> {
        Box::new(SpecimenState { stress: specimen.stress(), strain: specimen.strain(), increment })
    }
}

impl fmt::Display for SpecimenState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SpecimenState { stress, strain, increment } = self;
        write!(formatter, "stress {stress}; strain {strain}; increment tried {increment}")
    }
}

/// Why an element test cannot go on. The specimen keeps the state that the error carries.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElementError {
    /// The law has no answer, even for the smallest increments.
    #[error("the law failed: {source} ({state})")]
    Law {
        /// The law's reason.
        #[source]
        source: LawError,
        /// Where.
        state: Box<SpecimenState>,
    },
    /// The conditions could not be met, even in the smallest increments: stress beyond the strength, or an iteration that does not
    /// converge.
    #[error(
        "the conditions were not met in {iterations} iterations, a relative residual of {residual:e} is left ({state})"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// The largest residual over what is tolerated, times the tolerance (–).
        residual: f64,
        /// Where.
        state: Box<SpecimenState>,
    },
    /// The conditions do not tell the strain: two of them say the same, or the material has no stiffness left in some direction.
    #[error(
        "the conditions leave the strain open: two of them say the same, or the material has no stiffness left ({state})"
    )]
    Singular {
        /// Where.
        state: Box<SpecimenState>,
    },
    /// The quantity at whose value the load would turn does not reach it.
    #[error(
        "the load does not turn: {value:e} is reached, not {target:e}, after a strain of {limit} in one direction ({state})"
    )]
    OutOfReach {
        /// The value reached, in the unit of the quantity.
        value: f64,
        /// The value wanted.
        target: f64,
        /// The strain that is given up at (–).
        limit: f64,
        /// Where.
        state: Box<SpecimenState>,
    },
}

impl ElementError {
    /// The last good state of the specimen.
    pub fn state(&self) -> &SpecimenState {
        match self {
            ElementError::Law { state, .. }
            | ElementError::NotConverged { state, .. }
            | ElementError::Singular { state }
            | ElementError::OutOfReach { state, .. } => state,
        }
    }
}
