//! Running a case: steps between outputs, and an end that never loses what was computed.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::build::build;
use crate::failed_point::failed_point;
use crate::pictures::{Snapshot, draw};
use crate::results::{Host, Manifest, Outcome, Performance, Results, ResultsError};
use crate::simulation::Simulation;
use crate::{Case, CaseError, CaseSource, Model, Registry, Step};

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

    /// Something that the user should know; the run goes on.
    fn warned(&mut self, _message: &str) {}
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
    /// The element test of the point whose law has failed, if that has ended the run.
    pub failed_point: Option<PathBuf>,
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
        refuse_unstable(source, case, simulation.model())?;
    }
    let results = Results::create(source, options.out.as_deref(), options.force, simulation.reading_names())?;
    let started_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let peak = Snapshot::take(&simulation);
    let run = Run {
        source,
        case,
        simulation,
        results,
        peak,
        started_unix_s,
        loop_time: Duration::ZERO,
        iterations: 0,
        pace: Pace::new(),
        beyond_limit: options.allow_unstable,
        failed_point: None,
    };
    Ok(run.complete(observer)?)
}

/// Refuses a fixed step beyond the stable limit, and an automatic one that never comes to the end.
///
/// # Errors
/// An error at `time.step` that names the limit and what governs it.
pub fn refuse_unstable<const D: usize>(
    source: &CaseSource,
    case: &Case,
    model: &dyn Model<D>,
) -> Result<(), CaseError> {
    let Some(limits) = model.step_limits() else { return Ok(()) };
    match case.time.step {
        Step::Seconds(step) if step > limits.longest() => Err(source.invalid(
            "time.step",
            format!(
                "the step of {step} s is longer than the stable limit of {} s ({})",
                significant(limits.longest()),
                limits.governing
            ),
            "write `step = \"auto\"` or a shorter step; `--allow-unstable` runs it all the same",
        )),
        Step::Auto if case.time.end / limits.accurate() > MAX_STEPS => Err(source.invalid(
            "time.step",
            format!(
                "the automatic step of {} s ({}) needs too many steps",
                significant(limits.accurate()),
                limits.governing
            ),
            format!("up to {MAX_STEPS:e} are possible: is the stiffness right? a coarser grid has a longer step"),
        )),
        _ => Ok(()),
    }
}

/// More steps than any run will make.
const MAX_STEPS: f64 = 1e12;

/// The number and length of the equal steps that lead from now to a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    pub(crate) count: u64,
    pub(crate) dt: f64,
}

impl Steps {
    /// The steps up to `target` (s). With `auto` they divide the interval; a fixed step overshoots by less than one.
    pub(crate) fn up_to<const D: usize>(target: f64, case: &Case, model: &dyn Model<D>) -> Steps {
        // A count that is whole but for rounding is whole.
        let whole = |count: f64| (count - 1e-9 * count.max(1.0)).ceil().max(0.0);
        match case.time.step {
            Step::Seconds(dt) => Steps { count: (whole(target / dt) as u64).saturating_sub(model.steps()), dt },
            Step::Auto => {
                let interval = target - model.time();
                // What rounding leaves of an interval is no interval.
                if interval <= 1e-12 * target {
                    return Steps { count: 0, dt: interval };
                }
                // Where any step is stable, the output says how fine the time has to be.
                let accurate = model.step_limits().map_or(case.output.every, |limits| limits.accurate());
                let count = whole(interval / (case.time.safety * accurate)).max(1.0);
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
    pace: Pace,
    beyond_limit: bool,
    /// The element test of the point whose law has failed, or why there is none.
    failed_point: Option<Result<String, String>>,
}

impl<const D: usize> Run<'_, D> {
    fn complete(mut self, observer: &mut dyn Observer) -> Result<RunSummary, ResultsError> {
        self.write_output(true)?;
        self.write_manifest(&Outcome::Running)?;
        let first = Steps::up_to(self.output_time(1), self.case, self.simulation.model());
        observer.started(self.results.folder(), &self.progress(first.dt));
        let outcome = self.run_outputs(observer)?;
        let failed_point = self.write_failed_point(observer)?;
        self.write_manifest(&outcome)?;
        if self.case.output.figures {
            let last = Snapshot::take(&self.simulation);
            draw(&self.results, self.case, &self.simulation, &self.peak, &last)?;
        }
        Ok(RunSummary {
            folder: self.results.folder().to_owned(),
            outcome,
            failed_point,
            time: self.simulation.model().time(),
            performance: self.performance(),
        })
    }

    fn write_failed_point(&self, observer: &mut dyn Observer) -> Result<Option<PathBuf>, ResultsError> {
        match &self.failed_point {
            Some(Ok(text)) => self.results.write_failed_point(text).map(Some),
            Some(Err(reason)) => {
                observer.warned(&format!("there is no element test of the point that has failed: {reason}"));
                Ok(None)
            }
            None => Ok(None),
        }
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
            self.watch_limit(observer);
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
        let mut outcome = None;
        while outcome.is_none() {
            let steps = Steps::up_to(target, self.case, self.simulation.model());
            let cells = self.simulation.model().active().generation();
            if steps.count == 0 {
                break;
            }
            for _ in 0..steps.count {
                outcome = self.step(steps.dt, observer);
                // An automatic step is chosen anew when the surface has moved into other cells.
                let moved = cells != self.simulation.model().active().generation();
                if outcome.is_some() || (moved && self.case.time.step == Step::Auto) {
                    break;
                }
            }
        }
        self.loop_time += started.elapsed();
        outcome
    }

    /// One step, and now and then a word with the observer.
    fn step(&mut self, dt: f64, observer: &mut dyn Observer) -> Option<Outcome> {
        match self.simulation.model_mut().step(dt) {
            Ok(report) => self.iterations += report.pressure.iterations as u64,
            Err(error) => {
                self.failed_point = failed_point(&*error, self.case, self.simulation.model());
                return Some(Outcome::Failed(error.to_string()));
            }
        }
        let is_time = self.pace.is_time(self.simulation.model().steps());
        (is_time && observer.advanced(&self.progress(dt)) == Wish::Stop).then_some(Outcome::Interrupted)
    }

    /// Says once when a fixed step has become longer than the stable limit because the body has changed.
    fn watch_limit(&mut self, observer: &mut dyn Observer) {
        let Step::Seconds(dt) = self.case.time.step else { return };
        let Some(limits) = self.simulation.model().step_limits() else { return };
        if dt > limits.longest() && !self.beyond_limit {
            self.beyond_limit = true;
            observer.warned(&format!(
                "from t = {} s on the step of {dt} s is longer than the stable limit of {} s ({})",
                significant(self.simulation.model().time()),
                significant(limits.longest()),
                limits.governing
            ));
        }
    }

    fn progress(&self, dt: f64) -> Progress {
        let model = self.simulation.model();
        Progress { time: model.time(), end: self.case.time.end, steps: model.steps(), dt }
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
        let steps = self.simulation.model().steps();
        let wall_s = self.loop_time.as_secs_f64();
        let particle_steps = steps as f64 * self.simulation.model().particles().len() as f64;
        let particle_steps_per_s = if wall_s > 0.0 { particle_steps / wall_s } else { 0.0 };
        Performance { steps, wall_s, particle_steps_per_s, pressure_iterations: self.iterations }
    }

    fn write_manifest(&self, outcome: &Outcome) -> Result<(), ResultsError> {
        let model = self.simulation.model();
        self.results.write_manifest(&Manifest {
            program: "tsutsumi",
            version: env!("CARGO_PKG_VERSION"),
            title: self.case.title.clone(),
            case: self.source.path().to_owned(),
            overrides: self.source.overrides().map(str::to_owned).collect(),
            host: Host::this(),
            started_unix_s: self.started_unix_s,
            dimension: D,
            particles: model.particles().len(),
            cells: model.grid().num_cells(),
            outcome: outcome.clone(),
            time: model.time(),
            balances: self.simulation.balances(),
            performance: self.performance(),
        })
    }
}

/// When to look at the clock: every few milliseconds, without asking it the time after every step.
struct Pace {
    looked: Instant,
    /// The number of steps at which to look next, and after how many more then.
    next: u64,
    stride: u64,
}

impl Pace {
    fn new() -> Self {
        Pace { looked: Instant::now(), next: 0, stride: 1 }
    }

    fn is_time(&mut self, steps: u64) -> bool {
        if steps < self.next {
            return false;
        }
        match self.looked.elapsed() {
            short if short < Duration::from_millis(2) => self.stride = self.stride.saturating_mul(2).min(1 << 20),
            long if long > Duration::from_millis(8) => self.stride = (self.stride / 2).max(1),
            _ => {}
        }
        self.looked = Instant::now();
        self.next = steps + self.stride;
        true
    }
}

/// A number for people: four significant digits.
pub(crate) fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    match rounded.abs() {
        size if (1e-3..1e6).contains(&size) || size == 0.0 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}
