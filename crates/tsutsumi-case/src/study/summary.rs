//! What is left of a study, and why it could not be written.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::compare::{Order, Row};
use super::execute::RunReport;
use super::problems::ProblemLine;
use super::table::for_terminal;
use crate::folder::write_error;
use crate::{Outcome, ResultsError};

/// Why a study could not write its results.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The folder holds something that is not a study's.
    #[error("`{}` is not empty and holds no study: choose another folder with --out", path.display())]
    NotAStudy {
        /// The folder.
        path: PathBuf,
    },
    /// The folder holds another study.
    #[error(
        "`{}` holds the results of another study, `{other}`: choose another folder with --out, or replace them with --fresh",
        path.display()
    )]
    Occupied {
        /// The folder.
        path: PathBuf,
        /// The file of the study that it holds.
        other: String,
    },
    /// A file or folder could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
}

/// What is left of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct StudySummary {
    /// The folder of its results.
    pub folder: PathBuf,
    /// How it ended: failed if a run did, or a figure could not be drawn.
    pub outcome: Outcome,
    /// The runs: the variants, and behind them the reference runs.
    pub runs: Vec<RunReport>,
    /// Every variant beside every reference.
    pub rows: Vec<Row>,
    /// The observed orders of the refinements.
    pub orders: Vec<Order>,
    /// The lines of the problems, if the study has some.
    pub problems: Vec<ProblemLine>,
    /// The figures.
    pub figures: Vec<FigureReport>,
}

impl StudySummary {
    /// The lines of the problems, or else the table and the observed orders, for a terminal, ending with a newline.
    pub fn table(&self) -> String {
        for_terminal(&self.rows, &self.orders, &self.problems)
    }

    /// The runs that failed, each with the reason.
    pub fn failures(&self) -> Vec<(String, String)> {
        failures(&self.runs)
    }
}

fn failures(runs: &[RunReport]) -> Vec<(String, String)> {
    let reason = |run: &RunReport| match &run.outcome {
        Outcome::Failed(reason) => Some((run.name.clone(), reason.clone())),
        _ => None,
    };
    runs.iter().filter_map(reason).collect()
}

/// What became of a figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureReport {
    /// Its name, that of its files in the folder `figures`.
    pub name: String,
    /// Why it could not be drawn.
    pub problem: Option<String>,
    /// What the reader should know about it: curves that are missing, another time than the one asked for.
    pub note: Option<String>,
}

/// Writes what a `csv` writer has made.
pub(super) fn write(path: &Path, content: Result<Vec<u8>, csv::Error>) -> Result<(), StudyError> {
    let written = content.map_err(io::Error::from).and_then(|content| fs::write(path, content));
    Ok(written.map_err(write_error(path))?)
}
