//! The command line of Tsutsumi, for the program `tsutsumi` and for programs with laws of their own:
//!
//! ```no_run
//! # use tsutsumi::law::LinearElastic as MyLaw;
//! use std::process::ExitCode;
//! use tsutsumi_case::Registry;
//!
//! fn main() -> ExitCode {
//!     tsutsumi_cli::main_with(&Registry::built_in().law::<MyLaw>("my-law"))
//! }
//! ```
//!
//! Exit codes: 0 done, 1 the run failed (results so far kept), 2 the input is wrong, 130 interrupted.

// This is the room that talks to the terminal.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod calibrate;
mod element_test;
mod progress;
mod study;

use std::io::{ErrorKind, IsTerminal, Write};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use tsutsumi_case::{
    CaseError, CaseSource, Outcome, Registry, ResultsError, RunError, RunOptions, RunSummary, check, run,
};

use crate::calibrate::CalibrateArguments;
use crate::element_test::ElementTestArguments;
use crate::progress::Display;
use crate::study::StudyArguments;

/// The input is wrong.
const INPUT_WRONG: u8 = 2;
/// The run failed, or its results could not be written.
const RUN_FAILED: u8 = 1;
/// Stopped by Ctrl-C: 128 + SIGINT.
const INTERRUPTED: u8 = 130;

/// Tsutsumi: the MPM–FDM laboratory for saturated ground.
#[derive(Debug, Parser)]
#[command(name = "tsutsumi", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a case: from its file to histories, fields and figures.
    Run(RunArguments),
    /// Check a case without running it, and print what follows from its numbers.
    Check(CheckArguments),
    /// Run a study: variants of a case against references, to one table and figures.
    Study(StudyArguments),
    /// Test a law as a specimen in the laboratory: oedometer, triaxial, simple shear, cyclic.
    ElementTest(ElementTestArguments),
    /// Fit parameters of a law to measured element tests.
    Calibrate(CalibrateArguments),
    /// List the constitutive laws and their parameters.
    Laws,
    /// Print the JSON Schema of case files, for the completion of an editor.
    Schema(SchemaArguments),
}

#[derive(Debug, Args)]
#[group(multiple = false)]
struct SchemaArguments {
    /// That of study files instead.
    #[arg(long)]
    study: bool,
    /// That of element tests instead.
    #[arg(long)]
    element_test: bool,
    /// That of calibrations instead.
    #[arg(long)]
    calibration: bool,
}

#[derive(Debug, Args)]
struct CaseArguments {
    /// The case file.
    case: PathBuf,
    /// Set a value of the case, such as `--set time.step=auto` or `--set loads.0.applied_to=surface`. Repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Accept a fixed time step beyond the stable limit.
    #[arg(long)]
    allow_unstable: bool,
}

#[derive(Debug, Args)]
struct RunArguments {
    #[command(flatten)]
    case: CaseArguments,
    /// The results folder [default: a new one under results/, named after the case].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the results that the folder holds.
    #[arg(long)]
    force: bool,
    /// Number of threads [default: one for each physical core]. Results do not depend on it, bit for bit.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Print nothing but errors.
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Debug, Args)]
struct CheckArguments {
    #[command(flatten)]
    case: CaseArguments,
}

/// The whole command line, with the laws of a registry.
pub fn main_with(registry: &Registry) -> ExitCode {
    let code = match Arguments::parse().command {
        Command::Run(arguments) => run_case(&arguments, registry),
        Command::Check(arguments) => check_case(&arguments, registry),
        Command::Laws => print(&list_laws(registry)),
        Command::Study(arguments) => study::study(&arguments, registry),
        Command::ElementTest(arguments) => element_test::element_test(&arguments, registry),
        Command::Schema(arguments) if arguments.study => print(&format!("{:#}", tsutsumi_case::study::schema())),
        Command::Calibrate(arguments) => calibrate::calibrate(&arguments, registry),
        Command::Schema(arguments) if arguments.calibration => {
            print(&format!("{:#}", tsutsumi_case::calibration::schema()))
        }
        Command::Schema(arguments) if arguments.element_test => print(&format!("{:#}", registry.element_test_schema())),
        Command::Schema(_) => print(&format!("{:#}", registry.schema())),
    };
    ExitCode::from(code)
}

/// Prints to the standard output; a reader that has gone away (`| head`) is no error.
fn print(text: &str) -> u8 {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            eprintln!("error: cannot write the output: {error}");
            RUN_FAILED
        }
        _ => 0,
    }
}

fn open(arguments: &CaseArguments) -> Result<CaseSource, CaseError> {
    let source = CaseSource::read(&arguments.case)?;
    arguments.overrides.iter().try_fold(source, |source, assignment| source.with_override(assignment))
}

fn refuse(error: &CaseError) -> u8 {
    eprintln!("{}", error.render(std::io::stderr().is_terminal()));
    INPUT_WRONG
}

/// Says why results could not be written; the exit code is that of wrong input where another folder is the remedy.
fn without_results(error: &ResultsError) -> u8 {
    eprintln!("error: {error}");
    match error {
        ResultsError::Occupied { .. } | ResultsError::NotAFolder { .. } | ResultsError::OverTheCase { .. } => {
            INPUT_WRONG
        }
        ResultsError::Write { .. } | ResultsError::Vtk(_) | ResultsError::Figure(_) => RUN_FAILED,
    }
}

fn check_case(arguments: &CheckArguments, registry: &Registry) -> u8 {
    let report = open(&arguments.case).and_then(|source| check(&source, registry, arguments.case.allow_unstable));
    match report {
        Ok(report) => print(&report.to_string()),
        Err(error) => refuse(&error),
    }
}

fn run_case(arguments: &RunArguments, registry: &Registry) -> u8 {
    let source = match open(&arguments.case) {
        Ok(source) => source,
        Err(error) => return refuse(&error),
    };
    let options = RunOptions {
        out: arguments.out.clone(),
        force: arguments.force,
        allow_unstable: arguments.case.allow_unstable,
    };
    let threads = arguments.threads.map_or_else(num_cpus::get_physical, NonZeroUsize::get);
    let pool = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool,
        Err(error) => {
            eprintln!("error: {threads} threads cannot be started: {error}");
            return RUN_FAILED;
        }
    };
    let mut display = Display::new(arguments.quiet);
    let result = pool.install(|| run(&source, registry, &options, &mut display));
    display.finish();
    match result {
        Ok(summary) => report(&summary, arguments.quiet),
        Err(RunError::Case(error)) => refuse(&error),
        Err(RunError::Results(error)) => without_results(&error),
    }
}

fn report(summary: &RunSummary, quiet: bool) -> u8 {
    let performance = &summary.performance;
    // A time to nine digits: rounding errors of a sum of steps are nobody's business.
    let time = format!("{:.8e}", summary.time).parse().unwrap_or(summary.time);
    let code = match &summary.outcome {
        Outcome::Finished | Outcome::Running => 0,
        Outcome::Interrupted => {
            eprintln!("interrupted at t = {time} s");
            INTERRUPTED
        }
        Outcome::Failed(reason) => {
            eprintln!("error: {reason}");
            if let Some(path) = &summary.failed_point {
                eprintln!("the point is kept as an element test: {}", path.display());
            }
            RUN_FAILED
        }
    };
    if code != 0 || !quiet {
        let steps = match performance.steps {
            1 => "1 step".to_owned(),
            steps => format!("{steps} steps"),
        };
        let each = 1e6 * performance.wall_s / performance.steps.max(1) as f64;
        eprintln!("{steps} in {:.1} s ({each:.2} µs each), t = {time} s", performance.wall_s);
        eprintln!("results in {}", summary.folder.display());
    }
    code
}

fn list_laws(registry: &Registry) -> String {
    let mut text = String::new();
    for law in registry.laws() {
        text += &format!("{}\n    {}\n", law.name, law.description());
        let width = law.parameters().map(|(name, _)| name.len()).max().unwrap_or_default();
        for (name, description) in law.parameters() {
            text += &format!("    {name:<width$} {description}\n");
        }
    }
    text.trim_end().to_owned()
}
