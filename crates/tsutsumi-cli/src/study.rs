//! `tsutsumi study`: its arguments, its progress, its last words.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use tsutsumi_case::study::{RunReport, Study, StudyError, StudyObserver, StudyOptions, StudySummary, run_study};
use tsutsumi_case::{Outcome, Progress, Registry, Wish};

use crate::progress::{BETWEEN_LINES, FIRST_LINE, RESOLUTION, bar, stop_on_signal};
use crate::{INPUT_WRONG, INTERRUPTED, RUN_FAILED, print, refuse, without_results};

#[derive(Debug, Args)]
pub(crate) struct StudyArguments {
    /// The study file.
    study: PathBuf,
    /// Set a value in the case of every run, after what the study sets. Repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// The folder of the results [default: one under results/, named after the study, the same every time].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of runs side by side [default: the number of cores].
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Run everything anew, also what has been run before with the same inputs.
    #[arg(long)]
    fresh: bool,
    /// Print nothing but the table and errors.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs a study; the exit code.
pub(crate) fn study(arguments: &StudyArguments, registry: &Registry) -> u8 {
    let study = match Study::read(&arguments.study, registry, &arguments.overrides) {
        Ok(study) => study,
        Err(error) => return refuse(&error),
    };
    let options = StudyOptions { out: arguments.out.clone(), threads: arguments.threads, fresh: arguments.fresh };
    let display = StudyDisplay::new(arguments.quiet, study.runs().map(str::to_owned).collect());
    let result = run_study(&study, registry, &options, &display);
    display.finish();
    match result {
        Ok(summary) => report(&summary, arguments.quiet),
        Err(StudyError::Results(error)) => without_results(&error),
        Err(error @ (StudyError::NotAStudy { .. } | StudyError::Occupied { .. })) => {
            eprintln!("error: {error}");
            INPUT_WRONG
        }
    }
}

fn report(summary: &StudySummary, quiet: bool) -> u8 {
    let printed = print(summary.table().trim_end());
    for (name, reason) in summary.failures() {
        eprintln!("error: {name}: {reason}");
    }
    for figure in &summary.figures {
        if let Some(problem) = &figure.problem {
            eprintln!("error: figure {}: {problem}", figure.name);
        }
        if let Some(note) = &figure.note {
            eprintln!("warning: figure {}: {note}", figure.name);
        }
    }
    let code = match &summary.outcome {
        Outcome::Finished | Outcome::Running => printed,
        Outcome::Interrupted => {
            eprintln!("interrupted: what has finished is kept, and taken over next time");
            INTERRUPTED
        }
        Outcome::Failed(_) => RUN_FAILED,
    };
    if code != 0 || !quiet {
        eprintln!("results in {}", summary.folder.display());
    }
    code
}

/// Shows all runs of a study to a person, as one.
struct StudyDisplay {
    stop: Arc<AtomicBool>,
    style: Style,
    names: Vec<String>,
    state: Mutex<State>,
}

enum Style {
    Quiet,
    Bar(ProgressBar),
    Lines,
}

/// How far the runs are.
struct State {
    started: Instant,
    next_line: Instant,
    /// Shares done of the runs under way (–).
    under_way: BTreeMap<usize, f64>,
    ended: usize,
    /// Runs that were taken over: they say nothing about the time that is left.
    reused: usize,
}

impl StudyDisplay {
    fn new(quiet: bool, names: Vec<String>) -> Self {
        let style = match (quiet, std::io::stderr().is_terminal()) {
            (true, _) => Style::Quiet,
            (false, true) => Style::Bar(bar()),
            (false, false) => Style::Lines,
        };
        let now = Instant::now();
        let state =
            State { started: now, next_line: now + FIRST_LINE, under_way: BTreeMap::new(), ended: 0, reused: 0 };
        StudyDisplay { stop: stop_on_signal(), style, names, state: Mutex::new(state) }
    }

    fn finish(&self) {
        if let Style::Bar(bar) = &self.style {
            bar.finish_and_clear();
        }
    }

    /// A line that stays.
    fn say(&self, line: &str) {
        match &self.style {
            Style::Bar(bar) => bar.suspend(|| eprintln!("{line}")),
            _ => eprintln!("{line}"),
        }
    }

    /// The share that is done (–), and the words for it.
    fn words(&self, state: &State) -> (f64, String) {
        let all = self.names.len() as f64;
        let share = (state.ended as f64 + state.under_way.values().sum::<f64>()) / all;
        let own = share - state.reused as f64 / all;
        let left = state.started.elapsed().as_secs_f64() * (1.0 - share) / own;
        let left = if left.is_finite() { format!(", {left:.0} s left") } else { String::new() };
        let runs = state.under_way.iter().map(|(run, share)| format!("{} {:.0} %", self.names[*run], 100.0 * share));
        let runs: Vec<String> = runs.collect();
        (share, format!("{} of {all} runs done; {}{left}", state.ended, runs.join(", ")))
    }
}

impl StudyObserver for StudyDisplay {
    fn started(&self, folder: &Path, runs: &[&str]) {
        if !matches!(self.style, Style::Quiet) {
            let runs = if runs.len() == 1 { "1 run".to_owned() } else { format!("{} runs", runs.len()) };
            self.say(&format!("{runs}, writing to {}", folder.display()));
        }
    }

    fn advanced(&self, run: usize, progress: &Progress) -> Wish {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.under_way.insert(run, progress.time / progress.end);
        match &self.style {
            Style::Quiet => {}
            Style::Bar(bar) => {
                let (share, words) = self.words(&state);
                bar.set_position((RESOLUTION * share) as u64);
                bar.set_message(words);
            }
            Style::Lines if Instant::now() >= state.next_line => {
                state.next_line = Instant::now() + BETWEEN_LINES;
                eprintln!("{}", self.words(&state).1);
            }
            Style::Lines => {}
        }
        if self.stop.load(Ordering::Relaxed) { Wish::Stop } else { Wish::Continue }
    }

    fn warned(&self, run: usize, message: &str) {
        self.say(&format!("warning: {}: {message}", self.names[run]));
    }

    fn ended(&self, run: usize, report: &RunReport) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.under_way.remove(&run);
        state.ended += 1;
        state.reused += usize::from(report.reused);
        if matches!(self.style, Style::Quiet) {
            return;
        }
        let name = &self.names[run];
        match &report.outcome {
            Outcome::Finished if report.reused => self.say(&format!("{name}: taken over, nothing has changed")),
            Outcome::Finished => self.say(&format!("{name}: {} steps in {:.1} s", report.steps, report.wall_s)),
            Outcome::Failed(_) => self.say(&format!("{name}: failed")),
            Outcome::Interrupted | Outcome::Running => self.say(&format!("{name}: interrupted")),
        }
    }
}
