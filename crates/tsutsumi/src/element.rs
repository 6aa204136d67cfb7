//! Element tests: one material point as a laboratory's specimen, under mixed control of stress and strain.
//!
//! A [`Specimen`] is a law with its stress, strain and history. A [`Loading`] says how it is held and driven: six linear
//! [`Condition`]s on stress and strain, of which one or more grow with a loading parameter. A [`Course`] follows a loading increment
//! by increment, [`Cycles`] goes back and forth.
//!
//! The axis of a triaxial test and the vertical of all others is z; simple shear is in the plane zx: horizontal planes slide along x.
//! Components are positive in tension, as everywhere; the named quantities ([`Condition::MEAN_STRESS`] and the others) are those of soil
//! mechanics, positive in compression. Stress is effective. Time plays no part unless an increment is given a duration.
//!
//! ```
//! use tsutsumi::element::{Condition, Course, Drainage, Loading, Specimen};
//! use tsutsumi::law::LinearElastic;
//! use tsutsumi::tensor::Sym3;
//!
//! # fn main() -> Result<(), tsutsumi::element::ElementError> {
//! let mut specimen = Specimen::new(LinearElastic { young: 30e6, poisson: 0.3 }, Sym3::IDENTITY * -100e3);
//! let loading = Loading::triaxial(Drainage::Drained, Condition::AXIAL_STRAIN);
//! let mut course = Course::begin(loading, &specimen);
//! for _ in 0..10 {
//!     course.advance(&mut specimen, 1e-3)?;
//! }
//! // E times the strain of one per cent.
//! assert!((Condition::STRESS_DIFFERENCE.of(&specimen) - 300e3).abs() < 1e-3);
//! # Ok(())
//! # }
//! ```

mod condition;
mod course;
mod cycles;
mod error;
mod loading;
mod specimen;
mod water;

pub use condition::Condition;
pub use course::Course;
pub use cycles::{Criterion, CycleLimits, CycleProgress, Cycles};
pub use error::{ElementError, SpecimenState};
pub use loading::{Drainage, Loading};
pub use specimen::{Solution, Specimen};
pub use water::ExcessPressure;

#[cfg(test)]
mod tests;
