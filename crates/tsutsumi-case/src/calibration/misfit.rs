//! How far element tests are from the data.

use serde::Serialize;

use super::plan::{Calibration, MeasuredCurve};
use crate::element::{Record, execute};
use crate::{Outcome, Registry};

/// What a measured point counts that the element test does not come to, as a multiple of the largest measured value.
const MISSING: f64 = 10.0;

/// How far the element test of one measurement is from it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CurveReport {
    /// The name of the measurement.
    pub name: String,
    /// Measured points.
    pub points: usize,
    /// Those that the element test does not come to.
    pub missing: usize,
    /// The root of the mean square of the differences at the others, in SI units.
    pub rms: f64,
    /// The same over the largest measured value (–).
    pub relative_rms: f64,
    /// Why the element test could not go on, if it could not.
    pub problem: Option<String>,
}

/// The element test of a measurement with some parameters.
pub(super) struct Followed {
    /// Its curve, x growing, in SI units.
    pub(super) curve: Vec<[f64; 2]>,
    pub(super) report: CurveReport,
    /// The mean square of the differences over the largest measured value (–), missing points included.
    square: f64,
}

impl Calibration {
    /// Runs the element tests with these values of the parameters.
    pub(super) fn follow(&self, values: &[f64], registry: &Registry) -> Vec<Followed> {
        self.curves.iter().map(|curve| self.follow_one(curve, values, registry)).collect()
    }

    /// The misfit of these values of the parameters.
    ///
    /// ```text
    /// Σ_c w_c · 1/n_c Σ_i ((y(x_i) − y_i) / max|y|)²  /  Σ_c w_c
    /// ```
    pub(super) fn misfit(&self, followed: &[Followed]) -> f64 {
        let weights = || self.curves.iter().map(|curve| curve.measurement.weight);
        weights().zip(followed).map(|(weight, one)| weight * one.square).sum::<f64>() / weights().sum::<f64>()
    }

    fn follow_one(&self, curve: &MeasuredCurve, values: &[f64], registry: &Registry) -> Followed {
        let ended = self.test(curve, values, registry).and_then(|test| Ok((test.specimen(registry)?, test)));
        let (record, problem) = match ended {
            Ok((specimen, test)) => {
                let executed = execute(&test.file, specimen, &|| false);
                let problem = match executed.outcome {
                    Outcome::Failed(reason) => Some(reason),
                    _ => None,
                };
                (executed.record, problem)
            }
            // Values that the law refuses.
            Err(error) => (Record::default(), Some(error.to_string())),
        };
        compare(curve, growing(curve, &record), problem)
    }
}

/// The part of a record that is compared: rows of the stage at which x grows.
fn growing(curve: &MeasuredCurve, record: &Record) -> Vec<[f64; 2]> {
    let column = |name: &str| record.column(name).unwrap_or_default();
    let (x, y) = (column(&curve.measurement.x.quantity), column(&curve.measurement.y.quantity));
    let mut points: Vec<[f64; 2]> = Vec::new();
    for ((x, y), stage) in x.into_iter().zip(y).zip(column("stage")) {
        let is_wanted = curve.measurement.stage.is_none_or(|wanted| wanted as f64 == stage);
        if is_wanted && y.is_finite() && points.last().is_none_or(|[last, _]| x > *last) {
            points.push([x, y]);
        }
    }
    points
}

fn compare(curve: &MeasuredCurve, followed: Vec<[f64; 2]>, problem: Option<String>) -> Followed {
    let scale = curve.points.iter().fold(0.0_f64, |most, [_, y]| most.max(y.abs()));
    let (mut sum, mut missing) = (0.0, 0);
    for [x, y] in &curve.points {
        match interpolated(&followed, *x) {
            Some(value) => sum += ((value - y) / scale).powi(2),
            None => missing += 1,
        }
    }
    let count = curve.points.len();
    let square = (sum + missing as f64 * MISSING * MISSING) / count as f64;
    let relative_rms = (sum / (count - missing) as f64).sqrt();
    let name = curve.measurement.name.clone();
    let report = CurveReport { name, points: count, missing, rms: relative_rms * scale, relative_rms, problem };
    Followed { curve: followed, report, square }
}

/// The value of a curve, linear between its points; nothing beyond them.
pub(super) fn interpolated(curve: &[[f64; 2]], x: f64) -> Option<f64> {
    let [first, last] = [curve.first()?[0], curve.last()?[0]];
    // Data often end where the test does, but for the rounding of a unit.
    let x = if (x - last).abs() <= 1e-9 * last.abs() { last } else { x };
    if !(first..=last).contains(&x) {
        return None;
    }
    let after = curve.partition_point(|[known, _]| *known < x);
    let Some(before) = after.checked_sub(1) else { return Some(curve[0][1]) };
    let ([x0, y0], [x1, y1]) = (curve[before], curve[after]);
    Some(y0 + (y1 - y0) * (x - x0) / (x1 - x0))
}
