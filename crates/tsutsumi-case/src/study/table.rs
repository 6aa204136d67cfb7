//! The table of a study: for the terminal, as CSV, as Markdown.

use std::fmt::Write;

use super::compare::{Order, Row};
use super::problems::ProblemLine;
use super::summary::StudySummary;
use crate::Outcome;
use crate::run::significant;

/// What stands where there is nothing to say.
const NOTHING: &str = "–";

/// A table of words, the first columns to the left, the others to the right.
struct Words {
    head: Vec<&'static str>,
    left: usize,
    rows: Vec<Vec<String>>,
}

impl Words {
    fn of_rows(rows: &[Row]) -> Self {
        let head =
            vec!["variant", "reference", "quantity", "max error", "of largest", "rms error", "steps", "wall (s)"];
        Words { head, left: 3, rows: rows.iter().map(words_of_row).collect() }
    }

    fn of_orders(orders: &[Order]) -> Self {
        let head = vec!["refinement", "reference", "quantity", "sizes", "order (max)", "order (rms)"];
        let row = |order: &Order| {
            vec![
                order.refinement.clone(),
                order.reference.clone(),
                order.quantity.clone(),
                format!("{} → {}", significant(order.sizes[0]), significant(order.sizes[1])),
                two_decimals(order.max),
                two_decimals(order.rms),
            ]
        };
        Words { head, left: 3, rows: orders.iter().map(row).collect() }
    }

    fn of_problems(lines: &[ProblemLine]) -> Self {
        let head = vec!["problem", "variant", "error", "order", "energy drift", "noise", "cost"];
        Words { head, left: 2, rows: lines.iter().map(words_of_line).collect() }
    }

    fn widths(&self) -> Vec<usize> {
        let width = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].chars().count());
            cells.fold(self.head[column].chars().count(), usize::max)
        };
        (0..self.head.len()).map(width).collect()
    }

    fn aligned(&self, cells: &[String], between: &str) -> String {
        let cells = cells.iter().zip(self.widths()).enumerate().map(|(column, (cell, width))| {
            if column < self.left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        cells.collect::<Vec<_>>().join(between)
    }

    fn head(&self) -> Vec<String> {
        self.head.iter().map(|&cell| cell.to_owned()).collect()
    }

    fn for_terminal(&self) -> String {
        let rows = std::iter::once(self.head()).chain(self.rows.iter().cloned());
        rows.map(|row| self.aligned(&row, "  ").trim_end().to_owned() + "\n").collect()
    }

    fn as_markdown(&self) -> String {
        let line = |row: &[String]| format!("| {} |\n", self.aligned(row, " | ").replace('\n', " "));
        let rules = self.widths().into_iter().enumerate();
        let rules: String = rules
            .map(|(column, width)| {
                if column < self.left {
                    format!("|{}", "-".repeat(width + 2))
                } else {
                    format!("|{}:", "-".repeat(width + 1))
                }
            })
            .collect();
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}{rules}|\n{rows}", line(&self.head()))
    }
}

fn words_of_row(row: &Row) -> Vec<String> {
    let name = |name: &Option<String>| name.clone().unwrap_or_else(|| NOTHING.to_owned());
    let with_unit = |value: f64| format!("{} {}", significant(value), row.unit).trim_end().to_owned();
    let (max, relative, rms) = match (&row.errors, &row.outcome) {
        (Some(errors), _) => (with_unit(errors.max), percent(errors.relative()), with_unit(errors.rms)),
        (None, Outcome::Failed(_)) => ("failed".to_owned(), NOTHING.to_owned(), NOTHING.to_owned()),
        (None, Outcome::Interrupted) => ("interrupted".to_owned(), NOTHING.to_owned(), NOTHING.to_owned()),
        (None, _) => (NOTHING.to_owned(), NOTHING.to_owned(), NOTHING.to_owned()),
    };
    let (steps, wall) = (row.steps.to_string(), format!("{:.2}", row.wall_s));
    vec![row.variant.clone(), name(&row.reference), name(&row.quantity), max, relative, rms, steps, wall]
}

fn words_of_line(line: &ProblemLine) -> Vec<String> {
    let or_nothing = |words: Option<String>| words.unwrap_or_else(|| NOTHING.to_owned());
    let error = match (line.error, &line.outcome) {
        (Some(error), _) => short_percent(error),
        (None, Outcome::Failed(_)) => "failed".to_owned(),
        (None, Outcome::Interrupted) => "interrupted".to_owned(),
        (None, _) => NOTHING.to_owned(),
    };
    vec![
        line.problem.clone(),
        line.variant.clone(),
        error,
        or_nothing(line.order.map(two_decimals)),
        or_nothing(line.energy_drift.map(short_percent)),
        or_nothing(line.noise.map(short_percent)),
        or_nothing(line.cost.map(|cost| format!("{cost:.1}"))),
    ]
}

/// A share with three digits.
fn percent(share: f64) -> String {
    match share.is_finite() {
        true => format!("{} %", format!("{:.2e}", 100.0 * share).parse().map_or(share, |rounded: f64| rounded)),
        false => NOTHING.to_owned(),
    }
}

/// A share with three digits; what is tiny or huge with its power of ten.
fn short_percent(share: f64) -> String {
    let rounded: f64 = format!("{:.2e}", 100.0 * share).parse().unwrap_or(share);
    format!("{} %", significant(rounded))
}

fn two_decimals(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { NOTHING.to_owned() }
}

/// The lines of the problems for a terminal, or else the table and the observed orders.
pub(super) fn for_terminal(rows: &[Row], orders: &[Order], problems: &[ProblemLine]) -> String {
    if !problems.is_empty() {
        return Words::of_problems(problems).for_terminal();
    }
    let mut text = Words::of_rows(rows).for_terminal();
    if !orders.is_empty() {
        let _ = write!(text, "\n{}", Words::of_orders(orders).for_terminal());
    }
    text
}

/// The lines of the problems as Markdown, or else the table and the observed orders.
pub(super) fn as_markdown(summary: &StudySummary, title: &str) -> String {
    let StudySummary { rows, orders, problems, .. } = summary;
    let words = if problems.is_empty() { Words::of_rows(rows) } else { Words::of_problems(problems) };
    let mut text = format!("# {title}\n\n{}", words.as_markdown());
    if !orders.is_empty() && problems.is_empty() {
        let _ = write!(text, "\nObserved orders:\n\n{}", Words::of_orders(orders).as_markdown());
    }
    for (name, reason) in summary.failures() {
        let _ = write!(text, "\n`{name}` failed: {reason}\n");
    }
    text
}

/// `table.csv`: all digits.
pub(super) fn table_csv(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "variant",
        "reference",
        "quantity",
        "unit",
        "max error",
        "time of max (s)",
        "max over largest",
        "rms error",
        "largest reference",
        "points",
        "steps",
        "wall (s)",
        "outcome",
    ])?;
    for row in rows {
        let number = |read: fn(&super::compare::Errors) -> f64| {
            row.errors.as_ref().map(read).filter(|value| value.is_finite()).map_or_else(String::new, precise)
        };
        writer.write_record([
            row.variant.clone(),
            row.reference.clone().unwrap_or_default(),
            row.quantity.clone().unwrap_or_default(),
            row.unit.clone(),
            number(|errors| errors.max),
            number(|errors| errors.time_of_max),
            number(|errors| errors.relative()),
            number(|errors| errors.rms),
            number(|errors| errors.largest_reference),
            row.errors.map_or_else(String::new, |errors| errors.points.to_string()),
            row.steps.to_string(),
            row.wall_s.to_string(),
            outcome_word(&row.outcome),
        ])?;
    }
    into_bytes(writer)
}

/// `problems.csv`: all digits.
pub(super) fn problems_csv(lines: &[ProblemLine]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["problem", "variant", "run", "error", "order", "energy drift", "noise", "cost", "outcome"])?;
    for line in lines {
        let number = |value: Option<f64>| value.map_or_else(String::new, precise);
        writer.write_record([
            line.problem.clone(),
            line.variant.clone(),
            line.run.clone(),
            number(line.error),
            number(line.order),
            number(line.energy_drift),
            number(line.noise),
            number(line.cost),
            outcome_word(&line.outcome),
        ])?;
    }
    into_bytes(writer)
}

fn outcome_word(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Finished => "finished".to_owned(),
        Outcome::Failed(reason) => format!("failed: {reason}"),
        Outcome::Interrupted | Outcome::Running => "interrupted".to_owned(),
    }
}

/// `orders.csv`.
pub(super) fn orders_csv(orders: &[Order]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = ["refinement", "reference", "quantity", "coarse", "fine", "coarse size", "fine size"];
    writer.write_record(head.iter().copied().chain(["order of max", "order of rms"]))?;
    for order in orders {
        let [coarse, fine] = &order.variants;
        let words = [&order.refinement, &order.reference, &order.quantity, coarse, fine].map(String::clone);
        let numbers = [order.sizes[0], order.sizes[1], order.max, order.rms].map(|value| value.to_string());
        writer.write_record(words.iter().chain(&numbers))?;
    }
    into_bytes(writer)
}

/// All digits of a number.
pub(super) fn precise(value: f64) -> String {
    format!("{value:.16e}")
}

pub(super) fn into_bytes(writer: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, csv::Error> {
    writer.into_inner().map_err(|error| error.into_error().into())
}
