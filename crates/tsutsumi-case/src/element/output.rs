//! An element test from its file to its folder.

use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::draw::{draw, draw_resistance};
use super::execute::{Executed, StageReport, execute};
use super::plan::ElementTest;
use super::record::Record;
use super::resistance::{ResistancePoint, ResistanceRun, run_resistance, to_csv};
use crate::folder::{FIGURES, MANIFEST, claim_listed, claim_numbered, write_error};
use crate::results::{Host, replace_with_json};
use crate::{CaseError, Outcome, Registry, ResultsError};

/// What a test writes at the top of its folder.
const TEST: &str = "test.toml";
const ELEMENT: &str = "element.csv";
const RESISTANCE: &str = "resistance.csv";
/// The folder of the tests of a set.
const RUNS: &str = "runs";
/// The name of the figure of resistance curves.
const RESISTANCE_FIGURE: &str = "resistance";

/// How a test is to be run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TestOptions {
    /// The results folder. Without it a new one is made under `results/`, named after the file.
    pub out: Option<PathBuf>,
    /// Replaces the test that the folder holds.
    pub force: bool,
    /// The number of tests of a set side by side. Without it, as many as there are cores.
    pub threads: Option<NonZeroUsize>,
}

/// Why a test could not begin, or its results not be written.
#[derive(Debug, thiserror::Error)]
pub enum TestError {
    /// The file is wrong.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The folder holds something else.
    #[error("`{}` is not empty and holds no element test: choose another folder with --out", path.display())]
    NotATest {
        /// The folder.
        path: PathBuf,
    },
    /// A file or folder could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
}

/// What is left of a test.
#[derive(Debug, Clone, PartialEq)]
pub struct TestSummary {
    /// The results folder.
    pub folder: PathBuf,
    /// How it ended: failed if the test did. A test of the set that fails is told in its point.
    pub outcome: Outcome,
    /// The stages that were begun.
    pub stages: Vec<StageReport>,
    /// What was recorded.
    pub record: Record,
    /// The points of the resistance curves, criterion by criterion.
    pub resistance: Vec<ResistancePoint>,
}

/// `manifest.json`: what was tested, where, and how it ended.
#[derive(Debug, Serialize)]
struct Manifest<'a> {
    program: &'static str,
    version: &'static str,
    title: &'a str,
    element_test: PathBuf,
    overrides: Vec<&'a str>,
    host: Host,
    started_unix_s: u64,
    outcome: &'a Outcome,
    stages: &'a [StageReport],
    resistance: &'a [ResistancePoint],
    /// The files of the test, from its folder: what a later one may replace.
    files: Vec<String>,
}

/// The part of a manifest that tells which files are the test's.
#[derive(Debug, Deserialize)]
struct Held {
    #[serde(rename = "element_test")]
    _element_test: PathBuf,
    files: Vec<String>,
}

/// Runs an element test from its file to its results folder. `stop` is asked after every increment whether to end here.
///
/// # Errors
/// A law whose parameters do not fit, or results that cannot be written. A law that fails on the way is not an error here: it is the
/// [`TestSummary::outcome`], and what was recorded up to it is kept.
pub fn run_element_test(
    test: &ElementTest,
    registry: &Registry,
    options: &TestOptions,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<TestSummary, TestError> {
    let specimen = test.specimen(registry)?;
    let folder = claim(test, options)?;
    let started_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let mut writer = Writer { folder: folder.clone(), files: Vec::new() };
    writer.bytes(TEST, Ok(test.source.text().as_bytes().to_vec()))?;
    let executed = execute(&test.file, specimen, stop);
    writer.record(ELEMENT, &executed)?;
    writer.figures(test, &executed)?;
    let runs = match (&test.file.resistance, &executed.outcome) {
        (Some(resistance), Outcome::Finished | Outcome::Failed(_)) => {
            let threads = options.threads.or_else(|| std::thread::available_parallelism().ok());
            run_resistance(test, resistance, registry, threads.unwrap_or(NonZeroUsize::MIN), stop)?
        }
        _ => Vec::new(),
    };
    let is_interrupted = runs.iter().any(|run| run.point.outcome == Outcome::Interrupted);
    let resistance = writer.resistance(test, runs)?;
    let Executed { record, stages, outcome } = executed;
    let outcome = if is_interrupted { Outcome::Interrupted } else { outcome };
    let summary = TestSummary { folder, outcome, stages, record, resistance };
    writer.manifest(test, &summary, started_unix_s)?;
    Ok(summary)
}

/// Writes files into the folder and remembers which.
struct Writer {
    folder: PathBuf,
    files: Vec<String>,
}

impl Writer {
    fn bytes(&mut self, name: &str, content: Result<Vec<u8>, csv::Error>) -> Result<(), ResultsError> {
        let path = self.folder.join(name);
        let written = content.map_err(io::Error::from).and_then(|content| fs::write(&path, content));
        written.map_err(write_error(&path))?;
        self.files.push(name.to_owned());
        Ok(())
    }

    fn record(&mut self, name: &str, executed: &Executed) -> Result<(), ResultsError> {
        self.bytes(name, executed.record.to_csv())
    }

    fn figures(&mut self, test: &ElementTest, executed: &Executed) -> Result<(), ResultsError> {
        if !test.file.output.figures {
            return Ok(());
        }
        let folder = self.folder.join(FIGURES);
        make(&folder)?;
        let names = draw(&test.file, &executed.record, &folder)?;
        self.remember_figures(names.iter().map(String::as_str));
        Ok(())
    }

    fn remember_figures<'a>(&mut self, names: impl Iterator<Item = &'a str>) {
        self.files.extend(names.flat_map(|name| ["svg", "png"].map(|ending| format!("{FIGURES}/{name}.{ending}"))));
    }

    /// The tests of a set, their table and curves.
    fn resistance(
        &mut self,
        test: &ElementTest,
        runs: Vec<ResistanceRun>,
    ) -> Result<Vec<ResistancePoint>, ResultsError> {
        for run in &runs {
            make(&self.folder.join(RUNS))?;
            self.record(&format!("{RUNS}/{}.csv", run.name), &run.executed)?;
        }
        let points: Vec<ResistancePoint> = runs.into_iter().map(|run| run.point).collect();
        if let (Some(resistance), false) = (&test.file.resistance, points.is_empty()) {
            self.bytes(RESISTANCE, to_csv(&points))?;
            if test.file.output.figures {
                let path = self.folder.join(FIGURES).join(RESISTANCE_FIGURE);
                draw_resistance(&test.file, resistance, &points, &path)?;
                self.remember_figures(std::iter::once(RESISTANCE_FIGURE));
            }
        }
        Ok(points)
    }

    fn manifest(self, test: &ElementTest, summary: &TestSummary, started_unix_s: u64) -> Result<(), ResultsError> {
        let path = self.folder.join(MANIFEST);
        let file = test.source.path();
        let manifest = Manifest {
            program: "tsutsumi",
            version: env!("CARGO_PKG_VERSION"),
            title: test.title(),
            element_test: fs::canonicalize(file).unwrap_or_else(|_| file.to_owned()),
            overrides: test.source.overrides().collect(),
            host: Host::this(),
            started_unix_s,
            outcome: &summary.outcome,
            stages: &summary.stages,
            resistance: &summary.resistance,
            files: self.files,
        };
        replace_with_json(&path, &manifest).map_err(write_error(&path))
    }
}

fn make(folder: &Path) -> Result<(), ResultsError> {
    fs::create_dir_all(folder).map_err(write_error(folder))
}

/// Makes a folder for the results: the one asked for, or a new one under `results/`. With `force`, the files of an earlier test in it are
/// removed; whatever else it holds stays.
fn claim(test: &ElementTest, options: &TestOptions) -> Result<PathBuf, TestError> {
    let Some(folder) = options.out.clone() else { return Ok(claim_numbered(&test.source)?) };
    let is_ours = claim_listed(&folder, MANIFEST, options.force, |text| {
        serde_json::from_str(text).ok().map(|held: Held| held.files)
    })?;
    match is_ours {
        true => Ok(folder),
        false => Err(TestError::NotATest { path: folder }),
    }
}
