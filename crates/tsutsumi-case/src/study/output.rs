//! A study from its runs to its folder: table, observed orders, figures, manifest.

use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;

use super::compare::{Order, Row, orders, rows};
use super::draw::draw;
use super::execute::{RUNS, RunReport, StudyObserver, execute};
use super::plan::Study;
use super::problems::{ProblemLine, problem_lines};
use super::series::History;
use super::summary::{FigureReport, StudyError, StudySummary, write};
use super::table::{as_markdown, orders_csv, problems_csv, table_csv};
use crate::folder::{FIGURES, HISTORY, is_same_file, write_error};
use crate::results::{Host, replace_with_json};
use crate::{Outcome, Registry, ResultsError};

/// What a study writes at the top of its folder.
const STUDY: &str = "study.toml";
const MANIFEST: &str = "study.json";
const TABLE_CSV: &str = "table.csv";
const TABLE_MARKDOWN: &str = "table.md";
const ORDERS: &str = "orders.csv";
const PROBLEMS: &str = "problems.csv";

/// How a study is to be run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StudyOptions {
    /// The folder of its results. Without it, one under `results/` named after the study file, the same every time.
    pub out: Option<PathBuf>,
    /// The number of runs side by side. Without it, as many as there are cores.
    pub threads: Option<NonZeroUsize>,
    /// Runs everything anew, and takes over a folder with the results of another study.
    pub fresh: bool,
}

/// `study.json`: what was studied, and what came out.
#[derive(Debug, Serialize)]
struct Manifest<'a> {
    program: &'static str,
    version: &'static str,
    title: &'a str,
    /// The study file, from the root of the file system.
    study: PathBuf,
    host: Host,
    started_unix_s: u64,
    outcome: &'a Outcome,
    runs: &'a [RunReport],
    comparisons: &'a [Row],
    orders: &'a [Order],
    problems: &'a [ProblemLine],
    figures: &'a [FigureReport],
}

/// Runs a study: what has to be run, then the table and the figures from all that is there.
///
/// A run that fails stops neither the others nor the table.
///
/// # Errors
/// A folder that belongs to something else, or results of the study that cannot be written.
pub fn run_study(
    study: &Study,
    registry: &Registry,
    options: &StudyOptions,
    observer: &dyn StudyObserver,
) -> Result<StudySummary, StudyError> {
    let folder = options.out.clone().unwrap_or_else(|| default_folder(study.source.path()));
    claim(&folder, study, options.fresh)?;
    let started_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let text = folder.join(STUDY);
    if !is_same_file(&text, study.source.path()) {
        fs::write(&text, study.source.text()).map_err(write_error(&text))?;
    }
    let mut summary = StudySummary {
        folder: folder.clone(),
        outcome: Outcome::Running,
        runs: Vec::new(),
        rows: Vec::new(),
        orders: Vec::new(),
        problems: Vec::new(),
        figures: Vec::new(),
    };
    write_manifest(study, &summary, started_unix_s)?;
    observer.started(&folder, &study.runs().collect::<Vec<_>>());
    let threads = options.threads.or_else(|| std::thread::available_parallelism().ok()).unwrap_or(NonZeroUsize::MIN);
    summary.runs = execute(study, registry, &folder, threads, options.fresh, observer);
    let histories: Vec<Option<History>> = summary.runs.iter().map(history).collect();
    summary.rows = rows(study, &summary.runs, &histories);
    summary.orders = orders(study, &summary.rows);
    summary.problems = problem_lines(study, &summary.runs, &histories, &summary.rows);
    write_tables(study, &summary)?;
    summary.figures = draw(study, &summary, &histories)?;
    summary.outcome = outcome(&summary);
    write_manifest(study, &summary, started_unix_s)?;
    Ok(summary)
}

/// The history of a finished run.
fn history(report: &RunReport) -> Option<History> {
    report.is_finished().then(|| History::read(&report.folder.join(HISTORY)).ok()).flatten()
}

fn outcome(summary: &StudySummary) -> Outcome {
    if summary.runs.iter().any(|run| run.outcome == Outcome::Interrupted) {
        return Outcome::Interrupted;
    }
    let of_runs = summary.failures().into_iter();
    let of_figures = summary.figures.iter().filter_map(|figure| Some((figure.name.clone(), figure.problem.clone()?)));
    let mut reasons = of_runs.chain(of_figures).map(|(name, reason)| format!("{name}: {reason}"));
    reasons.next().map_or(Outcome::Finished, Outcome::Failed)
}

/// The folder of a study without one of its own: `results/` and the name of the file, with that of its folder before it
/// where the file is called `study`.
fn default_folder(path: &Path) -> PathBuf {
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let parent = parent.map(Path::to_owned).or_else(|| std::env::current_dir().ok());
    let folder = parent.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let name = match folder {
        Some(folder) if stem == "study" || stem.starts_with("study-") => format!("{folder}-{stem}"),
        _ => stem,
    };
    Path::new("results").join(name)
}

/// Makes the folder, unless it belongs to something else.
fn claim(folder: &Path, study: &Study, fresh: bool) -> Result<(), StudyError> {
    if folder.exists() && !folder.is_dir() {
        return Err(ResultsError::NotAFolder { path: folder.to_owned() }.into());
    }
    fs::create_dir_all(folder).map_err(write_error(folder))?;
    let is_empty = fs::read_dir(folder).map_err(write_error(folder))?.next().is_none();
    let held = held_study(&folder.join(MANIFEST));
    match held {
        None if !is_empty => return Err(StudyError::NotAStudy { path: folder.to_owned() }),
        Some(other) if !fresh && other != absolute(study.source.path()).to_string_lossy() => {
            return Err(StudyError::Occupied { path: folder.to_owned(), other });
        }
        _ => {}
    }
    for below in [RUNS, FIGURES] {
        let below = folder.join(below);
        fs::create_dir_all(&below).map_err(write_error(&below))?;
    }
    Ok(())
}

/// The study file that a manifest names.
fn held_study(manifest: &Path) -> Option<String> {
    let text = fs::read_to_string(manifest).ok()?;
    let manifest: serde_json::Value = serde_json::from_str(&text).ok()?;
    Some(manifest["study"].as_str()?.to_owned())
}

fn absolute(path: &Path) -> PathBuf {
    fs::canonicalize(path).or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_owned())
}

fn write_tables(study: &Study, summary: &StudySummary) -> Result<(), StudyError> {
    let StudySummary { folder, rows, orders, problems, .. } = summary;
    write(&folder.join(TABLE_MARKDOWN), Ok(as_markdown(summary, study.title()).into_bytes()))?;
    write(&folder.join(TABLE_CSV), table_csv(rows))?;
    write_or_remove(&folder.join(ORDERS), (!orders.is_empty()).then(|| orders_csv(orders)))?;
    write_or_remove(&folder.join(PROBLEMS), (!problems.is_empty()).then(|| problems_csv(problems)))
}

/// Writes a file, or takes away the one that is not of this study.
fn write_or_remove(path: &Path, content: Option<Result<Vec<u8>, csv::Error>>) -> Result<(), StudyError> {
    match content {
        Some(content) => write(path, content),
        None => match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(write_error(path)(error).into()),
            _ => Ok(()),
        },
    }
}

fn write_manifest(study: &Study, summary: &StudySummary, started_unix_s: u64) -> Result<(), StudyError> {
    let path = summary.folder.join(MANIFEST);
    let manifest = Manifest {
        program: "tsutsumi",
        version: env!("CARGO_PKG_VERSION"),
        title: study.title(),
        study: absolute(study.source.path()),
        host: Host::this(),
        started_unix_s,
        outcome: &summary.outcome,
        runs: &summary.runs,
        comparisons: &summary.rows,
        orders: &summary.orders,
        problems: &summary.problems,
        figures: &summary.figures,
    };
    Ok(replace_with_json(&path, &manifest).map_err(write_error(&path))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_is_called_by_its_file_and_its_folder() {
        let name = |path: &str| default_folder(Path::new(path)).to_string_lossy().replace('\\', "/");
        assert_eq!(name("paper-cases/poroelastic-column/study.toml"), "results/poroelastic-column-study");
        assert_eq!(
            name("paper-cases/poroelastic-column/study-spacing.toml"),
            "results/poroelastic-column-study-spacing"
        );
        assert_eq!(name("a/spacing.toml"), "results/spacing");
    }
}
