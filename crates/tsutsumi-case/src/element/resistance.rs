//! The test with other stress ratios in its last stage, side by side: cycles to liquefaction.

use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;

use super::execute::{Executed, execute};
use super::plan::ElementTest;
use super::schema::{Amplitude, ElementTestFile, LiquefactionCriterion, Resistance, Until};
use crate::{CaseError, Outcome, Registry};

/// A point of a liquefaction resistance curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResistancePoint {
    /// The cyclic stress ratio (–).
    pub stress_ratio: f64,
    /// What counts as liquefaction, by its key and value.
    pub criterion: &'static str,
    /// Its value (–).
    pub value: f64,
    /// Cycles made (–): those to liquefaction if it was reached.
    pub cycles: f64,
    /// Whether it was reached.
    pub reached: bool,
    /// How the test ended.
    pub outcome: Outcome,
}

/// A test of the set.
pub(super) struct ResistanceRun {
    pub(super) point: ResistancePoint,
    /// The name of its file.
    pub(super) name: String,
    pub(super) executed: Executed,
}

/// Runs the tests of a set on so many threads. Each is on its own: results do not depend on the number of threads.
pub(super) fn run_resistance(
    test: &ElementTest,
    resistance: &Resistance,
    registry: &Registry,
    threads: NonZeroUsize,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<ResistanceRun>, CaseError> {
    let wanted: Vec<(LiquefactionCriterion, usize, f64)> = resistance
        .criteria
        .iter()
        .enumerate()
        .flat_map(|(number, criterion)| resistance.stress_ratios.iter().map(move |ratio| (*criterion, number, *ratio)))
        .collect();
    let next = AtomicUsize::new(0);
    let runs: Vec<Mutex<Option<Result<ResistanceRun, CaseError>>>> = wanted.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..threads.get().min(wanted.len()) {
            scope.spawn(|| {
                while let Some((number, (criterion, set, ratio))) = take(&next, &wanted) {
                    let run = run_one(test, registry, criterion, *set, *ratio, stop);
                    *runs[number].lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(run);
                }
            });
        }
    });
    runs.into_iter().filter_map(|run| run.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())).collect()
}

/// The next that nobody has taken.
fn take<'a, T>(next: &AtomicUsize, wanted: &'a [T]) -> Option<(usize, &'a T)> {
    let number = next.fetch_add(1, Ordering::Relaxed);
    Some((number, wanted.get(number)?))
}

fn run_one(
    test: &ElementTest,
    registry: &Registry,
    criterion: &LiquefactionCriterion,
    set: usize,
    stress_ratio: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<ResistanceRun, CaseError> {
    let file = with(&test.file, criterion, stress_ratio);
    let executed = execute(&file, test.specimen(registry)?, stop);
    let given = criterion.all().into_iter().find_map(|(name, value)| Some((name, value?)));
    // One is given, as has been checked.
    let (key, value) = given.unwrap_or(("cycles", f64::NAN));
    let last = executed.stages.last();
    let point = ResistancePoint {
        stress_ratio,
        criterion: key,
        value,
        cycles: last.and_then(|stage| stage.cycles).unwrap_or(f64::NAN),
        reached: last.is_some_and(|stage| stage.ended_by == Some(key)),
        outcome: executed.outcome.clone(),
    };
    Ok(ResistanceRun { point, name: format!("criterion-{}-csr-{stress_ratio}", set + 1), executed })
}

/// The file with another stress ratio and limit in its last stage.
fn with(file: &ElementTestFile, criterion: &LiquefactionCriterion, stress_ratio: f64) -> ElementTestFile {
    let mut file = file.clone();
    if let Some(stage) = file.stages.last_mut() {
        stage.amplitude = Some(Amplitude { stress_ratio: Some(stress_ratio), ..Default::default() });
        let cycles = stage.until.map_or(f64::INFINITY, |until| until.cycles);
        let LiquefactionCriterion { single_strain, double_strain, pore_pressure_ratio } = *criterion;
        stage.until = Some(Until { cycles, single_strain, double_strain, pore_pressure_ratio });
    }
    file
}

/// The points as CSV.
pub(super) fn to_csv(points: &[ResistancePoint]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["criterion", "value", "stress_ratio", "cycles", "reached"])?;
    for point in points {
        let [value, ratio, cycles] = [point.value, point.stress_ratio, point.cycles].map(|x| format!("{x:.16e}"));
        writer.write_record([
            point.criterion,
            &value,
            &ratio,
            &cycles,
            if point.reached { "true" } else { "false" },
        ])?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}
