//! How far variants are from references, and at which order errors vanish.

use serde::Serialize;

use super::execute::RunReport;
use super::plan::{PlannedRun, Study};
use super::quantity::Quantity;
use super::schema::ErrorMeasure;
use super::series::{History, Series};
use crate::Outcome;

/// A variant beside a reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The variant.
    pub variant: String,
    /// The reference; none if nothing is known to compare the variant with.
    pub reference: Option<String>,
    /// The quantity.
    pub quantity: Option<String>,
    /// Its unit.
    pub unit: String,
    /// How far the two are apart; none if one of them has no numbers there.
    pub errors: Option<Errors>,
    /// Time steps of the variant.
    pub steps: u64,
    /// Wall time of the variant's step loop (s).
    pub wall_s: f64,
    /// How the variant ended.
    pub outcome: Outcome,
}

/// The difference between two curves, at the outputs of the variant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Largest difference (unit of the quantity).
    pub max: f64,
    /// When it is largest (s).
    pub time_of_max: f64,
    /// Root of the mean square of the differences (unit of the quantity).
    pub rms: f64,
    /// Largest value of the reference (unit of the quantity).
    pub largest_reference: f64,
    /// Number of outputs compared.
    pub points: usize,
}

impl Errors {
    /// The largest difference over the largest value of the reference (–); NaN if that is zero.
    pub fn relative(&self) -> f64 {
        if self.largest_reference > 0.0 { self.max / self.largest_reference } else { f64::NAN }
    }

    /// One of the measures.
    pub fn measure(&self, measure: ErrorMeasure) -> f64 {
        match measure {
            ErrorMeasure::Max => self.max,
            ErrorMeasure::Rms => self.rms,
        }
    }

    /// None if there is no time at which both have a value.
    fn between(variant: &Series, reference: &Series, window: Option<[f64; 2]>) -> Option<Self> {
        let (variant, reference) = (variant.within(window), reference.within(window));
        let pairs = variant.time.iter().zip(&variant.value).zip(&reference.value);
        let pairs = pairs.filter(|((_, value), expected)| value.is_finite() && expected.is_finite());
        let zero = Errors { max: 0.0, time_of_max: f64::NAN, rms: 0.0, largest_reference: 0.0, points: 0 };
        let mut errors = pairs.fold(zero, |errors, ((time, value), expected)| {
            let difference = (value - expected).abs();
            let is_largest = errors.points == 0 || difference > errors.max;
            Errors {
                max: if is_largest { difference } else { errors.max },
                time_of_max: if is_largest { *time } else { errors.time_of_max },
                rms: errors.rms + difference * difference,
                largest_reference: errors.largest_reference.max(expected.abs()),
                points: errors.points + 1,
            }
        });
        errors.rms = (errors.rms / errors.points as f64).sqrt();
        (errors.points > 0).then_some(errors)
    }
}

/// The order at which errors fall between two neighbours of a refinement, error = C · size^order.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Order {
    /// The refinement.
    pub refinement: String,
    /// The reference.
    pub reference: String,
    /// The quantity.
    pub quantity: String,
    /// The coarse and the fine variant.
    pub variants: [String; 2],
    /// Their sizes.
    pub sizes: [f64; 2],
    /// Observed order of the largest difference (–).
    pub max: f64,
    /// Observed order of the root mean square (–).
    pub rms: f64,
}

/// The quantities that are compared: those asked for, or all that references name.
pub(super) fn compared(study: &Study) -> Vec<Quantity> {
    if let Some(names) = &study.file.comparison.quantities {
        return names.iter().map(|name| Quantity::read(name)).collect();
    }
    let mut columns: Vec<&str> = Vec::new();
    for column in study.references.iter().flat_map(|reference| reference.columns()) {
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    columns.into_iter().map(|column| Quantity { column: column.to_owned(), is_rate: false }).collect()
}

/// What rows call the reference that is part of the case.
pub(super) const EXACT_MOTION: &str = "exact motion";

/// The columns of a run that are errors of an exact motion, as far as they are compared.
fn motion_errors(study: &Study, run: &PlannedRun) -> Vec<Quantity> {
    let wanted = study.file.comparison.quantities.as_ref();
    let columns = run.columns.iter().filter(|column| column.starts_with("error."));
    let columns = columns.filter(|column| wanted.is_none_or(|names| names.contains(column)));
    columns.map(|column| Quantity { column: column.clone(), is_rate: false }).collect()
}

/// Every variant beside every reference that has something to say about it.
pub(super) fn rows(study: &Study, reports: &[RunReport], histories: &[Option<History>]) -> Vec<Row> {
    let quantities = compared(study);
    let mut rows = Vec::new();
    for (number, run) in study.variants() {
        let before = rows.len();
        let window = study.window_of(run);
        let is_of_run = |problem: &Option<String>| problem.is_none() || *problem == run.problem;
        for reference in study.references.iter().filter(|reference| is_of_run(&reference.problem)) {
            for quantity in quantities.iter().filter(|quantity| run.columns.contains(&quantity.column)) {
                if !reference.columns().contains(&quantity.column.as_str()) {
                    continue;
                }
                let errors = histories[number].as_ref().and_then(|history| {
                    let expected = reference.sample(quantity, history.times(), histories)?;
                    Errors::between(&history.quantity(quantity)?, &expected, window)
                });
                let row = Row::of(&reports[number], Some((&reference.name, quantity)), errors);
                rows.push(row);
            }
        }
        for quantity in motion_errors(study, run) {
            let errors = histories[number].as_ref().and_then(|history| {
                let error = history.quantity(&quantity)?;
                let none = Series { value: vec![0.0; error.time.len()], time: error.time.clone() };
                // These columns are relative already.
                Some(Errors { largest_reference: 1.0, ..Errors::between(&error, &none, window)? })
            });
            rows.push(Row::of(&reports[number], Some((EXACT_MOTION, &quantity)), errors));
        }
        if rows.len() == before {
            rows.push(Row::of(&reports[number], None, None));
        }
    }
    rows
}

impl Row {
    fn of(report: &RunReport, beside: Option<(&str, &Quantity)>, errors: Option<Errors>) -> Self {
        Row {
            variant: report.name.clone(),
            reference: beside.map(|(reference, _)| reference.to_owned()),
            quantity: beside.map(|(_, quantity)| quantity.to_string()),
            unit: beside.map_or_else(String::new, |(_, quantity)| quantity.measure().unit),
            errors,
            steps: report.steps,
            wall_s: report.wall_s,
            outcome: report.outcome.clone(),
        }
    }
}

/// The errors of a refinement's variants against one reference in one quantity.
pub(super) struct Convergence<'a> {
    pub(super) reference: &'a str,
    pub(super) quantity: &'a str,
    /// Name, size and errors of every variant, coarse to fine; without those that have no errors.
    pub(super) errors: Vec<(&'a str, f64, Errors)>,
}

/// What the rows say about a refinement.
pub(super) fn convergences<'a>(variants: &'a [String], sizes: &[f64], rows: &'a [Row]) -> Vec<Convergence<'a>> {
    let mut found: Vec<Convergence> = Vec::new();
    for (variant, size) in variants.iter().zip(sizes) {
        for row in rows.iter().filter(|row| row.variant == *variant) {
            let (Some(reference), Some(quantity), Some(errors)) = (&row.reference, &row.quantity, row.errors) else {
                continue;
            };
            let point = (variant.as_str(), *size, errors);
            match found.iter_mut().find(|one| one.reference == reference && one.quantity == quantity) {
                Some(one) => one.errors.push(point),
                None => found.push(Convergence { reference, quantity, errors: vec![point] }),
            }
        }
    }
    found
}

/// The observed orders of all refinements.
pub(super) fn orders(study: &Study, rows: &[Row]) -> Vec<Order> {
    let mut orders = Vec::new();
    for refinement in &study.file.refinements {
        for one in convergences(&refinement.variants, &refinement.sizes, rows) {
            for pair in one.errors.windows(2) {
                let [(coarse, coarse_size, before), (fine, fine_size, after)] = [pair[0], pair[1]];
                let order = |before: f64, after: f64| (before / after).ln() / (coarse_size / fine_size).ln();
                orders.push(Order {
                    refinement: refinement.name.clone(),
                    reference: one.reference.to_owned(),
                    quantity: one.quantity.to_owned(),
                    variants: [coarse.to_owned(), fine.to_owned()],
                    sizes: [coarse_size, fine_size],
                    max: order(before.max, after.max),
                    rms: order(before.rms, after.rms),
                });
            }
        }
    }
    orders
}

/// The slope of the line through points in logarithms, by least squares.
pub(super) fn slope(x: &[f64], y: &[f64]) -> f64 {
    let points = || x.iter().zip(y).map(|(x, y)| (x.ln(), y.ln()));
    let count = x.len() as f64;
    let (mean_x, mean_y) = points().fold((0.0, 0.0), |(sum_x, sum_y), (x, y)| (sum_x + x / count, sum_y + y / count));
    let covariance: f64 = points().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let variance: f64 = points().map(|(x, _)| (x - mean_x).powi(2)).sum();
    covariance / variance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_by_hand() {
        let time = vec![0.0, 1.0, 2.0, 3.0];
        let variant = Series { time: time.clone(), value: vec![0.0, 3.0, 5.0, f64::NAN] };
        let reference = Series { time, value: vec![0.0, 0.0, 9.0, 1.0] };
        let errors = Errors::between(&variant, &reference, None).unwrap();
        // Differences 0, 3, 4.
        assert_eq!((errors.max, errors.time_of_max, errors.points), (4.0, 2.0, 3));
        assert!((errors.rms - (25.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(errors.relative(), 4.0 / 9.0);
        let early = Errors::between(&variant, &reference, Some([0.0, 1.0])).unwrap();
        assert_eq!(early.max, 3.0);
        assert!(early.relative().is_nan(), "the reference is zero there");
        assert_eq!(Errors::between(&variant, &reference, Some([2.5, 3.0])), None);
    }
}
