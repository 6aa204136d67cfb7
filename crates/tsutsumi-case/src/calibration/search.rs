//! The parameters with the least misfit: the simplex method of Nelder and Mead, begun anew once from where it has ended.

use std::sync::Mutex;

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::neldermead::NelderMead;

use super::plan::Calibration;
use crate::Registry;

/// The edges of the simplex at the start, in the numbers that stand for the parameters: a part of the way from bound to bound, which
/// is π long. The second start is as large: a simplex that has collapsed too early opens again.
const EDGES: [f64; 2] = [0.4, 0.2];

/// What a search has found.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Found {
    /// The values of the parameters.
    pub(super) values: Vec<f64>,
    pub(super) misfit: f64,
    /// Sets of element tests that were run.
    pub(super) evaluations: usize,
    /// Whether it was stopped.
    pub(super) interrupted: bool,
}

/// Seeks the parameters with the least misfit. Deterministic: the same file has the same answer.
pub(super) fn search(calibration: &Calibration, registry: &Registry, stop: &(dyn Fn() -> bool + Sync)) -> Found {
    let start = calibration.start();
    let misfit = calibration.misfit(&calibration.follow(&start, registry));
    let best = Found { values: start, misfit, evaluations: 1, interrupted: false };
    let best = Mutex::new(best);
    for edge in EDGES {
        let centre = best.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).values.clone();
        let problem = Problem { calibration, registry, stop, best: &best };
        let solver = NelderMead::new(simplex(calibration, &centre, edge)).with_sd_tolerance(calibration.file.tolerance);
        let Ok(solver) = solver else { break };
        let executor = Executor::new(problem, solver).configure(|state| state.max_iters(calibration.file.iterations));
        // The only errors are those of the problem: it was stopped. The best so far is kept there.
        if executor.run().is_err() {
            break;
        }
    }
    best.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Corners around the values of the parameters, in the numbers that stand for them.
fn simplex(calibration: &Calibration, centre: &[f64], edge: f64) -> Vec<Vec<f64>> {
    let ranges = calibration.ranges.iter().zip(centre);
    let centre: Vec<f64> = ranges.map(|(range, value)| range.number(*value)).collect();
    let corner = |axis: usize| {
        let mut corner = centre.clone();
        // Inwards: at a bound the sine turns, and outwards would be the same.
        corner[axis] += if corner[axis] > 0.0 { -edge } else { edge };
        corner
    };
    std::iter::once(centre.clone()).chain((0..centre.len()).map(corner)).collect()
}

struct Problem<'a> {
    calibration: &'a Calibration,
    registry: &'a Registry,
    stop: &'a (dyn Fn() -> bool + Sync),
    best: &'a Mutex<Found>,
}

/// The search was stopped.
#[derive(Debug, thiserror::Error)]
#[error("stopped")]
struct Stopped;

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, numbers: &Vec<f64>) -> Result<f64, Error> {
        let mut best = self.best.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if (self.stop)() {
            best.interrupted = true;
            return Err(Stopped.into());
        }
        let ranges = self.calibration.ranges.iter().zip(numbers);
        let values: Vec<f64> = ranges.map(|(range, number)| range.value(*number)).collect();
        let misfit = self.calibration.misfit(&self.calibration.follow(&values, self.registry));
        best.evaluations += 1;
        if misfit < best.misfit {
            (best.values, best.misfit) = (values, misfit);
        }
        Ok(misfit)
    }
}
