//! Element tests: one specimen in the laboratory, from one file to numbers and figures.
//!
//! ```no_run
//! use tsutsumi_case::Registry;
//! use tsutsumi_case::element::{ElementTest, TestOptions, run_element_test};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let registry = Registry::built_in();
//! let test = ElementTest::read("element-tests/triaxial-drained.toml", &registry, &[])?;
//! let summary = run_element_test(&test, &registry, &TestOptions::default(), &|| false)?;
//! println!("results in {}", summary.folder.display());
//! # Ok(())
//! # }
//! ```
//!
//! | module | what is in it |
//! |---|---|
//! | `schema`, `validate` | the file and its checks |
//! | `plan` | a file that can begin |
//! | `motion` | from a stage to a loading of the library |
//! | `quantity`, `record` | what is recorded, its names and units, row by row |
//! | `execute` | the stages, one after the other |
//! | `resistance` | the test with other stress ratios, side by side |
//! | `draw` | the figures |
//! | `output` | a test from its file to its folder |

mod draw;
mod execute;
mod motion;
mod output;
mod plan;
mod quantity;
mod record;
mod resistance;
pub(crate) mod schema;
mod validate;

pub use execute::StageReport;
pub(crate) use execute::execute;
pub use output::{TestError, TestOptions, TestSummary, run_element_test};
pub use plan::ElementTest;
pub(crate) use quantity::shown;
pub use record::Record;
pub(crate) use record::columns;
pub use resistance::ResistancePoint;
pub use schema::*;

#[cfg(test)]
mod tests;
