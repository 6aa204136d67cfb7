//! The runs of a study, side by side on threads of their own; what has been run before with the same inputs is taken over.

use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

use super::plan::{PlannedRun, Study};
use super::series::History;
use crate::folder::{CASE, HISTORY, MANIFEST};
use crate::results::replace_with_json;
use crate::{Observer, Outcome, Performance, Progress, Registry, RunOptions, Wish, run};

/// Where the runs are, in the folder of the study.
pub(super) const RUNS: &str = "runs";
/// What a finished run was made from, beside its results.
const INPUTS: &str = "study-run.json";

/// Somebody who watches a study. Runs call it from their own threads.
pub trait StudyObserver: Sync {
    /// The folder is there, and the runs with these names are about to begin.
    fn started(&self, _folder: &Path, _runs: &[&str]) {}

    /// Called every few milliseconds by every run; the run is named by its number. [`Wish::Stop`] ends all of them.
    fn advanced(&self, run: usize, progress: &Progress) -> Wish;

    /// Something about a run that the user should know; it goes on.
    fn warned(&self, _run: usize, _message: &str) {}

    /// A run has ended, or was taken over.
    fn ended(&self, _run: usize, _report: &RunReport) {}
}

impl StudyObserver for crate::Silent {
    fn advanced(&self, _run: usize, _progress: &Progress) -> Wish {
        Wish::Continue
    }
}

/// What became of a run of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunReport {
    /// Its name.
    pub name: String,
    /// Whether it is a reference; a variant otherwise.
    pub is_reference: bool,
    /// Its results folder.
    pub folder: PathBuf,
    /// How it ended. A run that did not begin because the study was stopped counts as interrupted.
    pub outcome: Outcome,
    /// Time steps made.
    pub steps: u64,
    /// Wall time of the step loop (s); of the earlier run if it was taken over.
    pub wall_s: f64,
    /// Particles times steps over wall time (1/s).
    pub particle_steps_per_s: f64,
    /// Whether an earlier run with the same inputs was taken over.
    pub reused: bool,
}

impl RunReport {
    /// Whether its results are complete.
    pub fn is_finished(&self) -> bool {
        self.outcome == Outcome::Finished
    }
}

/// Runs what has to be run, on so many threads.
pub(super) fn execute(
    study: &Study,
    registry: &Registry,
    folder: &Path,
    threads: NonZeroUsize,
    fresh: bool,
    observer: &dyn StudyObserver,
) -> Vec<RunReport> {
    let shared =
        Shared { study, registry, folder, fresh, observer, next: AtomicUsize::new(0), stop: AtomicBool::new(false) };
    let reports: Vec<Mutex<Option<RunReport>>> = study.runs.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..threads.get().min(study.runs.len()) {
            scope.spawn(|| {
                while let Some((number, run)) = shared.take() {
                    let report = shared.report(number, run);
                    observer.ended(number, &report);
                    *reports[number].lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(report);
                }
            });
        }
    });
    let reports =
        reports.into_iter().map(|report| report.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()));
    reports.flatten().collect()
}

/// What all threads share.
struct Shared<'a> {
    study: &'a Study,
    registry: &'a Registry,
    folder: &'a Path,
    fresh: bool,
    observer: &'a dyn StudyObserver,
    next: AtomicUsize,
    stop: AtomicBool,
}

impl Shared<'_> {
    /// The next run that nobody has taken.
    fn take(&self) -> Option<(usize, &PlannedRun)> {
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        Some((number, self.study.runs.get(number)?))
    }

    fn report(&self, number: usize, planned: &PlannedRun) -> RunReport {
        let folder = self.folder.join(RUNS).join(&planned.name);
        let earlier = if self.fresh { None } else { earlier_run(&folder, planned) };
        let reused = earlier.is_some();
        let (outcome, cost) = match earlier {
            Some(cost) => (Outcome::Finished, cost),
            None if self.stop.load(Ordering::Relaxed) => (Outcome::Interrupted, Cost::default()),
            None => self.run(number, planned, &folder),
        };
        let (name, is_reference) = (planned.name.clone(), planned.is_reference);
        let Cost { steps, wall_s, particle_steps_per_s } = cost;
        RunReport { name, is_reference, folder, outcome, steps, wall_s, particle_steps_per_s, reused }
    }

    /// Runs a case; its outcome and cost.
    fn run(&self, number: usize, planned: &PlannedRun, folder: &Path) -> (Outcome, Cost) {
        let options = RunOptions { out: Some(folder.to_owned()), force: true, allow_unstable: planned.allow_unstable };
        let mut watch = Watch { shared: self, number };
        // What is about to be replaced is not to be taken for a finished run, whatever happens.
        let cleared = match fs::remove_file(folder.join(INPUTS)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error.to_string()),
            _ => Ok(()),
        };
        let ended = cleared.and_then(|()| {
            run(&planned.source, self.registry, &options, &mut watch).map_err(|error| error.to_string())
        });
        match ended {
            Ok(summary) => {
                let Performance { steps, wall_s, particle_steps_per_s, .. } = summary.performance;
                let kept = match summary.outcome {
                    Outcome::Finished => replace_with_json(&folder.join(INPUTS), &Inputs::of(planned)),
                    _ => Ok(()),
                };
                let outcome = kept.map_or_else(|error| Outcome::Failed(error.to_string()), |()| summary.outcome);
                (outcome, Cost { steps, wall_s, particle_steps_per_s })
            }
            Err(reason) => (Outcome::Failed(reason), Cost::default()),
        }
    }
}

/// Passes the words of a run on, and the wish to stop to all others.
struct Watch<'a> {
    shared: &'a Shared<'a>,
    number: usize,
}

impl Observer for Watch<'_> {
    fn advanced(&mut self, progress: &Progress) -> Wish {
        if self.shared.observer.advanced(self.number, progress) == Wish::Stop {
            self.shared.stop.store(true, Ordering::Relaxed);
        }
        if self.shared.stop.load(Ordering::Relaxed) { Wish::Stop } else { Wish::Continue }
    }

    fn warned(&mut self, message: &str) {
        self.shared.observer.warned(self.number, message);
    }
}

/// What a run is made from, beside the text of its case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Inputs {
    version: String,
    executable: Option<Executable>,
    allow_unstable: bool,
}

/// Which build of the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Executable {
    size: u64,
    modified_unix_ns: u128,
}

impl Inputs {
    fn of(planned: &PlannedRun) -> Self {
        Inputs {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            executable: Executable::this(),
            allow_unstable: planned.allow_unstable,
        }
    }
}

impl Executable {
    /// The program that runs; none if the system does not tell.
    fn this() -> Option<Self> {
        let metadata = fs::metadata(std::env::current_exe().ok()?).ok()?;
        let modified = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(Executable { size: metadata.len(), modified_unix_ns: modified.as_nanos() })
    }
}

/// The part of a run's manifest that the table shows.
#[derive(Debug, Default, Deserialize)]
struct Cost {
    steps: u64,
    wall_s: f64,
    particle_steps_per_s: f64,
}

/// A finished run in the folder that was made from the same inputs; none if anything about it is in doubt.
fn earlier_run(folder: &Path, planned: &PlannedRun) -> Option<Cost> {
    #[derive(Deserialize)]
    struct Manifest {
        performance: Cost,
    }
    let text = |name: &str| fs::read_to_string(folder.join(name)).ok();
    let inputs: Inputs = serde_json::from_str(&text(INPUTS)?).ok()?;
    let same = inputs.executable.is_some() && inputs == Inputs::of(planned) && text(CASE)? == planned.source.text();
    let manifest: Manifest = serde_json::from_str(&text(MANIFEST)?).ok()?;
    History::read(&folder.join(HISTORY)).ok()?;
    same.then_some(manifest.performance)
}
