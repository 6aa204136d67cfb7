//! Case files to simulations to results folders.
//!
//! A case file is read strictly ([`CaseSource`]), its names become types ([`Registry`]), its bodies particles ([`build`](mod@build)),
//! and a run ([`run()`]) leaves a folder with histories, fields and figures.
//!
//! ```no_run
//! use tsutsumi_case::{CaseSource, Registry, RunOptions, Silent, run};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let source = CaseSource::read("paper-cases/poroelastic-column/case.toml")?.with_override("time.step=auto")?;
//! let summary = run(&source, &Registry::built_in(), &RunOptions::default(), &mut Silent)?;
//! println!("{} steps, results in {}", summary.performance.steps, summary.folder.display());
//! # Ok(())
//! # }
//! ```
//!
//! | module | what is in it |
//! |---|---|
//! | `schema`, `source`, `validate`, `file_checks`, `error` | the case file: types, text with places, checks, messages |
//! | [`registry`] | the names of the variants: the only file that knows them |
//! | `motions` | the exact motions by name |
//! | [`model`], `fill`, [`build`], [`simulation`] | a case in motion |
//! | [`mod@check`] | what follows from a case before it runs |
//! | [`mod@run`], [`results`] | a run and what it leaves |
//! | `failed_point` | an element test of a point whose law has failed |
//! | [`study`] | variants against references: one table, figures |
//! | [`element`] | element tests: one specimen in the laboratory |
//! | [`calibration`] | parameters of a law from measured element tests |
//! | [`figures`], [`vtk`] | pictures and fields from plain data |

pub mod build;
pub mod calibration;
pub mod check;
mod deserializer;
pub mod element;
mod error;
mod failed_point;
pub mod figures;
mod file_checks;
mod file_kind;
mod fill;
mod folder;
mod json_schema;
mod key_path;
pub mod model;
mod motions;
mod overrides;
mod pictures;
pub mod registry;
pub mod results;
pub mod run;
mod schema;
pub mod simulation;
mod source;
pub mod study;
mod syntax;
mod tree;
mod validate;
pub mod vtk;
mod vtk_reader;

pub use check::{CheckReport, check};
pub use error::{CaseError, Location, Problem, ProblemKind, did_you_mean};
pub use figures::FigureError;
pub use file_kind::{FileKind, SIZE_LIMIT};
pub use json_schema::{
    KeyDocumentation, calibration_key_documentation, case_schema, element_test_key_documentation, key_documentation,
    study_key_documentation,
};
pub use key_path::{KeyPath, Segment};
pub use model::Model;
pub use registry::Registry;
pub use results::{Outcome, Performance, ResultsError};
pub use run::{Observer, Progress, RunError, RunOptions, RunSummary, Silent, Wish, read_case, run};
pub use schema::*;
pub use simulation::{Balances, Simulation};
pub use source::CaseSource;

#[cfg(test)]
mod case_tests;
#[cfg(test)]
mod order_tests;
