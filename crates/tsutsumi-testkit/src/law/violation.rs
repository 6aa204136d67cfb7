use tsutsumi::law::{ClosedPathWork, LawError};

/// How a law breaks its contract.
#[derive(Debug, thiserror::Error)]
pub enum LawViolation {
    /// The law refuses its own parameters.
    #[error("the parameters are not valid: {0}")]
    Parameters(#[source] LawError),
    /// The law gives no answer.
    #[error("increment {increment}: the law failed: {source}")]
    Failed {
        /// The number of the increment on the path.
        increment: usize,
        /// The law's reason.
        source: LawError,
    },
    /// A stress, a tangent, a modulus or an output is infinite or not a number.
    #[error("increment {increment}: {what} is not finite")]
    NotFinite {
        /// The number of the increment on the path.
        increment: usize,
        /// What is not finite.
        what: &'static str,
    },
    /// The stress changes though nothing is strained.
    #[error("increment {increment}: a strain increment of zero changes the stress by {change:e} Pa")]
    Creeps {
        /// The number of the increment on the path.
        increment: usize,
        /// The norm of the change (Pa).
        change: f64,
    },
    /// Stress, history and strain turned together give another result than the turned one.
    #[error(
        "increment {increment}: turned stress, history and strain give a stress that is {off:e} Pa off the turned one; \
         does `rotate_state` turn every tensor of the history?"
    )]
    NotObjective {
        /// The number of the increment on the path.
        increment: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// A rigid rotation does more to the stress than turn it.
    #[error("increment {increment}: after a rigid rotation by {degrees}° the stress is {off:e} Pa off the turned one")]
    Turned {
        /// The number of the increment on the path.
        increment: usize,
        /// The angle so far.
        degrees: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// The tangent is not the derivative of the stress.
    #[error("increment {increment}: column {column} of the tangent is {off:e} Pa off the difference quotient")]
    Tangent {
        /// The number of the increment on the path.
        increment: usize,
        /// The Kelvin component of the strain, 0 = xx … 5 = zx.
        column: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// The law is stiffer in uniaxial compression than it says, so that steps would be too long.
    #[error(
        "increment {increment}: the stiffness in compression is {stiffness:e} Pa, but p_wave_modulus is {bound:e} Pa"
    )]
    CompressionModulus {
        /// The number of the increment on the path.
        increment: usize,
        /// dσ/dε along one axis (Pa).
        stiffness: f64,
        /// What the law says (Pa).
        bound: f64,
    },
    /// The law is stiffer in shear than it says.
    #[error("increment {increment}: the stiffness in shear is {stiffness:e} Pa, but s_wave_modulus is {bound:e} Pa")]
    ShearModulus {
        /// The number of the increment on the path.
        increment: usize,
        /// dτ/dγ = dσ_xy/(2 dε_xy) (Pa).
        stiffness: f64,
        /// What the law says (Pa).
        bound: f64,
    },
    /// The history cannot be written, or cannot be read back.
    #[error("increment {increment}: the history cannot be written and read: {source}")]
    Serialization {
        /// The number of the increment on the path.
        increment: usize,
        /// What serde says.
        source: serde_json::Error,
    },
    /// The history that was written and read back is another.
    #[error("increment {increment}: after writing and reading the history the next stress is {off:e} Pa off")]
    HistoryLost {
        /// The number of the increment on the path.
        increment: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// An output was not written.
    #[error("increment {increment}: the output `{name}` is not written")]
    Output {
        /// The number of the increment on the path.
        increment: usize,
        /// The name of the output.
        name: &'static str,
    },
    /// A closed path of strain takes a work that the law has promised it does not.
    #[error(
        "increment {increment}: a closed path of strain ({path}) takes a work of {work:e} J/m³, but the law promises {promised}"
    )]
    ClosedPath {
        /// The number of the increment on the path before which the closed path was gone.
        increment: usize,
        /// Which path.
        path: &'static str,
        /// The work ∮ σ' : dε (J/m³); negative if the law gives it back.
        work: f64,
        /// What was promised.
        promised: ClosedPathWork,
    },
    /// Smaller steps do not lead to one answer.
    #[error(
        "increment {increment}: in {parts} parts the stress is {off:e} Pa, or {relative:e} of itself, off that in half as many, and \
         the difference does not fall with the size of the parts"
    )]
    StepSize {
        /// The number of the increment on the path after which the difference is largest.
        increment: usize,
        /// The number of equal parts that every increment is done in.
        parts: u32,
        /// The norm of the difference (Pa).
        off: f64,
        /// The same relative to the stress (–).
        relative: f64,
    },
    /// A step that has an answer asks for memory.
    #[error("increment {increment}: a step allocates memory {count} times")]
    Allocates {
        /// The number of the increment on the path.
        increment: usize,
        /// The number of allocations.
        count: u64,
    },
}
