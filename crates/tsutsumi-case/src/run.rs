//! Running a case: steps between outputs, and an end that never loses what was computed.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use tsutsumi::solver::{Solver, StepError};

use crate::build::build;
use crate::pictures::{Snapshot, draw};
use crate::results::{Host, Manifest, Outcome, Performance, Results, ResultsError};
use crate::simulation::Simulation;
use crate::{Case, CaseError, CaseSource, Registry, Step};

/// How a case is to be run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunOptions {
    /// The results folder. Without it a new one is made under `results/`, named after the case.
    pub out: Option<PathBuf>,
    /// Replaces the results that the folder holds.
    pub force: bool,
    /// Runs even if the fixed step is longer than the stable limit.
    pub allow_unstable: bool,
}

/// Why a run could not begin, or its results not be written.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The case is wrong.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The results could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
}

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Time simulated so far (s).
    pub time: f64,
    /// Time at the end (s).
    pub end: f64,
    /// Steps made.
    pub steps: u64,
    /// The step at present (s).
    pub dt: f64,
}

/// What the observer wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// Go on.
    Continue,
    /// End here, with the results so far.
    Stop,
}

/// Somebody who watches a run.
pub trait Observer {
    /// The results folder is there and the first step is about to be made.
    fn started(&mut self, _folder: &Path, _progress: &Progress) {}

    /// Called every few milliseconds between steps.
    fn advanced(&mut self, progress: &Progress) -> Wish;
}

/// An observer that lets a run go on in silence.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn advanced(&mut self, _progress: &Progress) -> Wish {
        Wish::Continue
    }
}

/// What is left of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSummary {
    /// The results folder.
    pub folder: PathBuf,
    /// How it ended.
    pub outcome: Outcome,
    /// The time reached (s).
    pub time: f64,
    /// What it cost.
    pub performance: Performance,
}

/// Reads and checks a case.
///
/// # Errors
/// Everything that is wrong with the case, each with its place in the file.
pub fn read_case(source: &CaseSource) -> Result<Case, CaseError> {
    let case = source.parse()?;
    source.validate(&case)?;
    Ok(case)
}

/// Runs a case from its file to its results folder.
///
/// # Errors
/// A wrong case, or results that cannot be written. A step that fails is not an error here: it is the
/// [`RunSummary::outcome`], and the results up to it are kept.
pub fn run(
    source: &CaseSource,
    registry: &Registry,
    options: &RunOptions,
    observer: &mut dyn Observer,
) -> Result<RunSummary, RunError> {
    let case = read_case(source)?;
    match case.dimension {
        1 => run_in::<1>(source, &case, registry, options, observer),
        2 => run_in::<2>(source, &case, registry, options, observer),
        _ => run_in::<3>(source, &case, registry, options, observer),
    }
}

fn run_in<const D: usize>(
    source: &CaseSource,
    case: &Case,
    registry: &Registry,
    options: &RunOptions,
    observer: &mut dyn Observer,
) -> Result<RunSummary, RunError> {
    let simulation = build::<D>(source, case, registry)?;
    if !options.allow_unstable {
        refuse_unstable(source, case, simulation.solver())?;
    }
    let results = Results::create(source, options.out.as_deref(), options.force, simulation.reading_names())?;
    let started_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let peak = Snapshot::take(&simulation);
    let run = Run { source, case, simulation, results, peak, started_unix_s, loop_time: Duration::ZERO, iterations: 0 };
    Ok(run.complete(observer)?)
}

/// Refuses a fixed step beyond the stable limit.
///
/// # Errors
/// An error at `time.step` that names the limit and what governs it.
pub fn refuse_unstable<const D: usize>(source: &CaseSource, case: &Case, solver: &Solver<D>) -> Result<(), CaseError> {
    let limits = solver.step_limits();
    match case.time.step {
        Step::Seconds(step) if step > limits.longest() => Err(source.invalid(
            "time.step",
            format!(
                "the step of {step} s is longer than the stable limit of {:.4e} s ({})",
                limits.longest(),
                limits.governing
            ),
            "write `step = \"auto\"` or a shorter step; `--allow-unstable` runs it all the same",
        )),
        _ => Ok(()),
    }
}

/// The number and length of the equal steps that lead from now to a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    pub(crate) count: u64,
    pub(crate) dt: f64,
}

impl Steps {
    /// The steps up to `target` (s). With `auto` they divide the interval; a fixed step overshoots by less than one.
    pub(crate) fn up_to<const D: usize>(target: f64, case: &Case, solver: &Solver<D>) -> Steps {
        // A count that is whole but for rounding is whole.
        let whole = |count: f64| (count - 1e-9 * count.max(1.0)).ceil().max(0.0);
        match case.time.step {
            Step::Seconds(dt) => Steps { count: (whole(target / dt) as u64).saturating_sub(solver.steps()), dt },
            Step::Auto => {
                let interval = target - solver.time();
                // What rounding leaves of an interval is no interval.
                if interval <= 1e-12 * target {
                    return Steps { count: 0, dt: interval };
                }
                let count = whole(interval / (case.time.safety * solver.step_limits().accurate())).max(1.0);
                Steps { count: count as u64, dt: interval / count }
            }
        }
    }
}

/// A run under way.
struct Run<'a, const D: usize> {
    source: &'a CaseSource,
    case: &'a Case,
    simulation: Simulation<D>,
    results: Results,
    peak: Snapshot,
    started_unix_s: u64,
    loop_time: Duration,
    iterations: u64,
}

impl<const D: usize> Run<'_, D> {
    fn complete(mut self, observer: &mut dyn Observer) -> Result<RunSummary, ResultsError> {
        self.write_output(true)?;
        self.write_manifest(&Outcome::Running)?;
        let first = Steps::up_to(self.output_time(1), self.case, self.simulation.solver());
        observer.started(self.results.folder(), &self.progress(first.dt));
        let outcome = self.run_outputs(observer)?;
        self.write_manifest(&outcome)?;
        if self.case.output.figures {
            let last = Snapshot::take(&self.simulation);
            draw(&self.results, self.case, &self.simulation, &self.peak, &last)?;
        }
        Ok(RunSummary {
            folder: self.results.folder().to_owned(),
            outcome,
            time: self.simulation.solver().time(),
            performance: self.performance(),
        })
    }

    /// The time of output number `number` (s): the last one is the end.
    fn output_time(&self, number: u64) -> f64 {
        (number as f64 * self.case.output.every).min(self.case.time.end)
    }

    fn run_outputs(&mut self, observer: &mut dyn Observer) -> Result<Outcome, ResultsError> {
        let every_fields = self.case.output.fields_every.unwrap_or(self.case.output.every);
        let mut fields_written = 0;
        for number in 1.. {
            let target = self.output_time(number);
            let ended = self.run_steps(target, observer);
            let is_last = target >= self.case.time.end || ended.is_some();
            let fields_due = (target / every_fields * (1.0 + 1e-12)).floor() as u64;
            self.write_output(is_last || fields_due > fields_written)?;
            fields_written = fields_due;
            match ended {
                Some(outcome) => return Ok(outcome),
                None if is_last => break,
                None => {}
            }
        }
        Ok(Outcome::Finished)
    }

    /// Steps up to a time. An outcome means that the run ends here.
    fn run_steps(&mut self, target: f64, observer: &mut dyn Observer) -> Option<Outcome> {
        let started = Instant::now();
        let mut looked = started;
        let mut outcome = None;
        while outcome.is_none() {
            let steps = Steps::up_to(target, self.case, self.simulation.solver());
            let cells = self.simulation.solver().active().generation();
            if steps.count == 0 {
                break;
            }
            for count in 0..steps.count {
                outcome = self.step(steps.dt, count, &mut looked, observer);
                // An automatic step is chosen anew when the surface has moved into other cells.
                let moved = cells != self.simulation.solver().active().generation();
                if outcome.is_some() || (moved && self.case.time.step == Step::Auto) {
                    break;
                }
            }
        }
        self.loop_time += started.elapsed();
        outcome
    }

    /// One step, and now and then a word with the observer.
    fn step(&mut self, dt: f64, count: u64, looked: &mut Instant, observer: &mut dyn Observer) -> Option<Outcome> {
        const BETWEEN_LOOKS: Duration = Duration::from_millis(5);
        match self.simulation.solver_mut().step(dt) {
            Ok(report) => self.iterations += report.pressure.iterations as u64,
            Err(error) => return Some(Outcome::Failed(explain(&error, self.case))),
        }
        // Looking at the clock costs a hundredth of the smallest step when done every 16.
        if count.is_multiple_of(16) && looked.elapsed() > BETWEEN_LOOKS {
            *looked = Instant::now();
            if observer.advanced(&self.progress(dt)) == Wish::Stop {
                return Some(Outcome::Interrupted);
            }
        }
        None
    }

    fn progress(&self, dt: f64) -> Progress {
        let solver = self.simulation.solver();
        Progress { time: solver.time(), end: self.case.time.end, steps: solver.steps(), dt }
    }

    /// Appends to the history and, if asked, writes the fields.
    fn write_output(&mut self, fields: bool) -> Result<(), ResultsError> {
        let row = self.simulation.readings();
        // A run that fails or stops just after an output has nothing new to write.
        if self.results.rows.last().is_some_and(|last| last[0] >= row[0]) {
            return Ok(());
        }
        self.results.write_row(row)?;
        if self.simulation.largest_pressure() > self.peak.largest() {
            self.peak = Snapshot::take(&self.simulation);
        }
        if fields {
            self.results.write_fields(&self.simulation)?;
        }
        Ok(())
    }

    fn performance(&self) -> Performance {
        let steps = self.simulation.solver().steps();
        let wall_s = self.loop_time.as_secs_f64();
        let particle_steps = steps as f64 * self.simulation.solver().particles().len() as f64;
        let particle_steps_per_s = if wall_s > 0.0 { particle_steps / wall_s } else { 0.0 };
        Performance { steps, wall_s, particle_steps_per_s, pressure_iterations: self.iterations }
    }

    fn write_manifest(&self, outcome: &Outcome) -> Result<(), ResultsError> {
        let solver = self.simulation.solver();
        self.results.write_manifest(&Manifest {
            program: "tsutsumi",
            version: env!("CARGO_PKG_VERSION"),
            title: self.case.title.clone(),
            case: self.source.path().to_owned(),
            overrides: self.source.overrides().map(str::to_owned).collect(),
            host: Host::this(),
            started_unix_s: self.started_unix_s,
            dimension: D,
            particles: solver.particles().len(),
            cells: solver.grid().num_cells(),
            outcome: outcome.clone(),
            time: solver.time(),
            balances: self.simulation.balances(),
            performance: self.performance(),
        })
    }
}

/// The reason of a failed step, with a hint where the step may be to blame.
fn explain(error: &StepError, case: &Case) -> String {
    match (error, case.time.step) {
        (StepError::Outside { .. } | StepError::Law { .. }, Step::Seconds(_)) => {
            format!("{error} (if the velocities grew without reason, try `step = \"auto\"`)")
        }
        _ => error.to_string(),
    }
}
