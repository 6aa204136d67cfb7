//! `tsutsumi calibrate`: its arguments and its last words.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use clap::Args;
use tsutsumi_case::calibration::{Calibration, CalibrationError, CalibrationOptions, CalibrationSummary};
use tsutsumi_case::{Outcome, Registry};

use crate::progress::stop_on_signal;
use crate::{INPUT_WRONG, INTERRUPTED, RUN_FAILED, print, refuse, without_results};

#[derive(Debug, Args)]
pub(crate) struct CalibrateArguments {
    /// The file of the calibration.
    calibration: PathBuf,
    /// The results folder [default: a new one under results/, named after the file].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the calibration that the folder holds.
    #[arg(long)]
    force: bool,
    /// Print nothing but the table and errors.
    #[arg(long, short)]
    quiet: bool,
}

/// Fits the parameters; the exit code.
pub(crate) fn calibrate(arguments: &CalibrateArguments, registry: &Registry) -> u8 {
    let calibration = match Calibration::read(&arguments.calibration, registry) {
        Ok(calibration) => calibration,
        Err(error) => return refuse(&error),
    };
    let options = CalibrationOptions { out: arguments.out.clone(), force: arguments.force };
    let stop = stop_on_signal();
    let stop = || stop.load(Ordering::Relaxed);
    match tsutsumi_case::calibration::calibrate(&calibration, registry, &options, &stop) {
        Ok(summary) => report(&summary, arguments.quiet),
        Err(CalibrationError::Case(error)) => refuse(&error),
        Err(error @ CalibrationError::NotACalibration { .. }) => {
            eprintln!("error: {error}");
            INPUT_WRONG
        }
        Err(CalibrationError::Results(error)) => without_results(&error),
    }
}

fn report(summary: &CalibrationSummary, quiet: bool) -> u8 {
    let printed = print(summary.table().trim_end());
    let code = match &summary.outcome {
        Outcome::Finished | Outcome::Running => printed,
        Outcome::Interrupted => {
            eprintln!("interrupted: this is the best so far");
            INTERRUPTED
        }
        Outcome::Failed(reason) => {
            eprintln!("error: {reason}");
            RUN_FAILED
        }
    };
    if code != 0 || !quiet {
        eprintln!("{} sets of element tests", summary.evaluations);
        eprintln!("results in {}", summary.folder.display());
    }
    code
}
