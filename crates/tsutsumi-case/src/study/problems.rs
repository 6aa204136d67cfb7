//! One line for every variant or refinement of a problem: error, order, drift of the energy, noise, cost.

use serde::Serialize;

use super::compare::{Row, slope};
use super::execute::RunReport;
use super::plan::Study;
use super::quantity::Quantity;
use super::schema::{Refinement, StudyProblem};
use super::series::{History, Series};
use crate::Outcome;

/// A variant of a problem, or a refinement of them: then the numbers are those of its finest variant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProblemLine {
    /// The problem.
    pub problem: String,
    /// The variant or refinement, without the name of the problem.
    pub variant: String,
    /// The run that the numbers are from.
    pub run: String,
    /// The error that the problem asks for, over the largest value of the reference (–).
    pub error: Option<f64>,
    /// The observed order of the errors of the refinement (–), by least squares over all of its variants.
    pub order: Option<f64>,
    /// The largest change of `error.energy` since the start (–), with its sign.
    pub energy_drift: Option<f64>,
    /// The median of `noise.velocity` (–) over the outputs.
    pub noise: Option<f64>,
    /// Wall time per particle and step over that of the problem's first line (–).
    pub cost: Option<f64>,
    /// How the run ended.
    pub outcome: Outcome,
}

/// The lines of all problems.
pub(super) fn problem_lines(
    study: &Study,
    reports: &[RunReport],
    histories: &[Option<History>],
    rows: &[Row],
) -> Vec<ProblemLine> {
    let results = Results { study, reports, histories, rows };
    study.file.problems.iter().flat_map(|problem| results.lines(problem)).collect()
}

struct Results<'a> {
    study: &'a Study,
    reports: &'a [RunReport],
    histories: &'a [Option<History>],
    rows: &'a [Row],
}

impl Results<'_> {
    fn lines(&self, problem: &StudyProblem) -> Vec<ProblemLine> {
        let refinements = &self.study.file.refinements;
        let mut lines = Vec::new();
        let mut of_first = None;
        for (number, run) in self.study.variants().filter(|(_, run)| run.problem.as_ref() == Some(&problem.name)) {
            let mut own = refinements.iter().filter(|refinement| refinement.variants.contains(&run.name));
            let refinement = own.next();
            // A refinement has one line, that of its finest variant.
            if refinement.is_some_and(|refinement| refinement.variants.last() != Some(&run.name)) {
                continue;
            }
            let name = refinement.map_or(&run.name, |refinement| &refinement.name);
            let report = &self.reports[number];
            let seconds = Some(1.0 / report.particle_steps_per_s).filter(|seconds| seconds.is_finite());
            of_first = of_first.or(seconds);
            let history = self.histories[number].as_ref();
            let window = self.study.window_of(run);
            lines.push(ProblemLine {
                problem: problem.name.clone(),
                variant: without_prefix(name, &problem.name).to_owned(),
                run: run.name.clone(),
                error: self.error(problem, &run.name),
                order: refinement.and_then(|refinement| self.order(problem, refinement)),
                energy_drift: history.and_then(|history| drift(&column(history, "error.energy")?.within(window))),
                noise: history.and_then(|history| median(column(history, "noise.velocity")?.within(window).value)),
                cost: seconds.zip(of_first).map(|(seconds, first)| seconds / first),
                outcome: report.outcome.clone(),
            });
        }
        lines
    }

    /// The relative error of a variant.
    fn error(&self, problem: &StudyProblem, variant: &str) -> Option<f64> {
        let row = self.rows.iter().find(|row| {
            let is_reference = problem.reference.is_none() || row.reference == problem.reference;
            row.variant == variant && is_reference && row.quantity.as_ref() == Some(&problem.error)
        })?;
        let errors = row.errors.as_ref()?;
        Some(errors.measure(problem.measure) / errors.largest_reference).filter(|error| error.is_finite())
    }

    fn order(&self, problem: &StudyProblem, refinement: &Refinement) -> Option<f64> {
        let points = refinement.variants.iter().zip(&refinement.sizes);
        let points = points.filter_map(|(variant, size)| Some((*size, self.error(problem, variant)?)));
        let (sizes, errors): (Vec<f64>, Vec<f64>) = points.unzip();
        (sizes.len() > 1).then(|| slope(&sizes, &errors)).filter(|order| order.is_finite())
    }
}

fn column(history: &History, name: &str) -> Option<Series> {
    history.quantity(&Quantity { column: name.to_owned(), is_rate: false })
}

/// The change since the first value that is largest in size, with its sign.
fn drift(series: &Series) -> Option<f64> {
    let first = *series.value.first()?;
    let changes = series.value.iter().map(|value| value - first);
    changes.max_by(|one, other| one.abs().total_cmp(&other.abs())).filter(|change| change.is_finite())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let median = match values.len() % 2 {
        1 => *values.get(middle)?,
        _ => 0.5 * (values.get(middle)? + values.get(middle.checked_sub(1)?)?),
    };
    Some(median).filter(|median| median.is_finite())
}

/// A name without that of the problem at its beginning, and what joins the two.
fn without_prefix<'a>(name: &'a str, problem: &str) -> &'a str {
    let rest = name.strip_prefix(problem).map(|rest| rest.trim_start_matches([' ', '-', ',', '_']));
    rest.filter(|rest| !rest.is_empty()).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drifts_and_medians_by_hand() {
        let series = |value: &[f64]| Series { time: vec![0.0; value.len()], value: value.to_vec() };
        assert_eq!(drift(&series(&[1.0, 1.5, -1.0, 2.0])), Some(-2.0));
        assert_eq!(drift(&series(&[])), None);
        assert_eq!([median(vec![3.0, 1.0, 2.0]), median(vec![4.0, 1.0, 2.0, 3.0])], [Some(2.0), Some(2.5)]);
        assert_eq!(median(vec![]), None);
    }

    #[test]
    fn names_lose_that_of_their_problem() {
        assert_eq!(without_prefix("bar, linear mpm1", "bar"), "linear mpm1");
        assert_eq!(without_prefix("bar", "bar"), "bar");
        assert_eq!(without_prefix("linear", "bar"), "linear");
    }
}
