//! `tsutsumi element-test`: its arguments and its last words.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use clap::Args;
use tsutsumi_case::element::{
    ElementTest, ResistancePoint, StageReport, TestError, TestOptions, TestSummary, run_element_test,
};
use tsutsumi_case::{Outcome, Registry};

use crate::progress::stop_on_signal;
use crate::{INPUT_WRONG, INTERRUPTED, RUN_FAILED, print, refuse, without_results};

#[derive(Debug, Args)]
pub(crate) struct ElementTestArguments {
    /// The file of the test.
    test: PathBuf,
    /// Set a value of the file, such as `--set material.parameters.young=3e7`. Repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// The results folder [default: a new one under results/, named after the file].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the test that the folder holds.
    #[arg(long)]
    force: bool,
    /// Number of tests of a resistance curve side by side [default: the number of cores].
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Print nothing but the table of a resistance curve and errors.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs an element test; the exit code.
pub(crate) fn element_test(arguments: &ElementTestArguments, registry: &Registry) -> u8 {
    let test = match ElementTest::read(&arguments.test, registry, &arguments.overrides) {
        Ok(test) => test,
        Err(error) => return refuse(&error),
    };
    let options = TestOptions { out: arguments.out.clone(), force: arguments.force, threads: arguments.threads };
    let stop = stop_on_signal();
    match run_element_test(&test, registry, &options, &|| stop.load(Ordering::Relaxed)) {
        Ok(summary) => report(&summary, arguments.quiet),
        Err(TestError::Case(error)) => refuse(&error),
        Err(error @ TestError::NotATest { .. }) => {
            eprintln!("error: {error}");
            INPUT_WRONG
        }
        Err(TestError::Results(error)) => without_results(&error),
    }
}

fn report(summary: &TestSummary, quiet: bool) -> u8 {
    if !quiet {
        summary.stages.iter().enumerate().for_each(|(index, stage)| eprintln!("{}", line(index + 1, stage)));
    }
    let printed = match summary.resistance.as_slice() {
        [] => 0,
        points => print(&table(points)),
    };
    let mut has_failed = false;
    for point in &summary.resistance {
        if let Outcome::Failed(reason) = &point.outcome {
            eprintln!("error: stress ratio {}, {} {}: {reason}", point.stress_ratio, point.criterion, point.value);
            has_failed = true;
        }
    }
    let code = match &summary.outcome {
        Outcome::Finished | Outcome::Running if has_failed => RUN_FAILED,
        Outcome::Finished | Outcome::Running => printed,
        Outcome::Interrupted => {
            eprintln!("interrupted: what was recorded is kept");
            INTERRUPTED
        }
        Outcome::Failed(reason) => {
            eprintln!("error: {reason}");
            RUN_FAILED
        }
    };
    if code != 0 || !quiet {
        eprintln!("results in {}", summary.folder.display());
    }
    code
}

/// What became of a stage.
fn line(number: usize, stage: &StageReport) -> String {
    let increments = stage.increments;
    let cycles = stage.cycles.map_or_else(String::new, |cycles| format!(", {cycles:.2} cycles"));
    let end = stage.ended_by.map_or_else(String::new, |key| format!(", ended by `{key}`"));
    format!("stage {number}: {increments} increments{cycles}{end}")
}

/// The points of resistance curves.
fn table(points: &[ResistancePoint]) -> String {
    let rows = points.iter().map(|point| {
        let criterion = format!("{} {}", point.criterion, point.value);
        let more = if point.reached { "" } else { "not reached in " };
        format!("{criterion:<28}{:>14}  {more}{:.2}", point.stress_ratio, point.cycles)
    });
    let head = format!("{:<28}{:>14}  {}", "criterion", "stress ratio", "cycles");
    std::iter::once(head).chain(rows).collect::<Vec<_>>().join("\n")
}
