//! Studies: variants of a case against references, in one table and in figures, from one file.
//!
//! ```no_run
//! use tsutsumi_case::study::{Study, StudyOptions, run_study};
//! use tsutsumi_case::{Registry, Silent};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let registry = Registry::built_in();
//! let study = Study::read("paper-cases/poroelastic-column/study.toml", &registry, &[])?;
//! let summary = run_study(&study, &registry, &StudyOptions::default(), &Silent)?;
//! println!("{}", summary.table());
//! # Ok(())
//! # }
//! ```
//!
//! | module | what is in it |
//! |---|---|
//! | `schema`, `validate` | the study file and its checks |
//! | `runs`, `sweep`, `setting` | the runs that it asks for |
//! | `plan` | these with their cases, ready to begin |
//! | [`solutions`] | the exact solutions by name: the only file that knows them |
//! | `reference` | exact solutions, files of numbers and reference runs, asked alike |
//! | `quantity`, `series` | columns of histories, their units, rates and values in between |
//! | `execute` | the runs, side by side, and which of them need not be run again |
//! | `compare`, `problems`, `table` | errors, observed orders, and a line for every variant of a problem |
//! | `draw`, `numbers` | the figures and their numbers |
//! | `output`, `summary` | a study from its runs to its folder, and what is left of it |

mod compare;
mod draw;
mod execute;
mod numbers;
mod output;
mod plan;
mod problems;
mod quantity;
mod reference;
mod runs;
pub(crate) mod schema;
mod series;
mod setting;
pub mod solutions;
mod summary;
mod sweep;
mod table;
mod validate;

pub use compare::{Errors, Order, Row};
pub use execute::{RunReport, StudyObserver};
pub use output::{StudyOptions, run_study};
pub use plan::Study;
pub use problems::ProblemLine;
pub use quantity::Quantity;
pub(crate) use reference::Table;
pub use schema::*;
pub use summary::{FigureReport, StudyError, StudySummary};

/// The JSON Schema of study files.
pub fn schema() -> serde_json::Value {
    let solutions: Vec<_> = solutions::solutions().into_iter().map(solutions::NamedSolution::schema).collect();
    crate::json_schema::study_schema(&solutions)
}

#[cfg(test)]
mod tests;
