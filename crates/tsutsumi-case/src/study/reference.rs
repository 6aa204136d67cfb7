//! What variants are held against, once it is open: exact solutions, tables of numbers, other runs.

use std::collections::BTreeMap;
use std::path::Path;

use super::quantity::Quantity;
use super::schema::{Column, Reference};
use super::series::{History, Series};
use super::solutions::{Course, solutions};
use crate::source::list;
use crate::{CaseError, CaseSource, KeyPath, did_you_mean};

/// A reference, ready to be asked.
pub(super) struct OpenReference {
    pub(super) name: String,
    pub(super) label: String,
    /// The problem whose variants it stands for; all of them if there is none.
    pub(super) problem: Option<String>,
    pub(super) kind: ReferenceKind,
}

/// Where the numbers of a reference come from.
pub(super) enum ReferenceKind {
    /// An exact solution: columns of the variants and what stands for them.
    Solution(BTreeMap<String, Course>),
    /// A file: columns of the variants and the series that stand for them.
    Table(BTreeMap<String, Series>),
    /// The run of this number: columns of the variants and its own that stand for them.
    Run(usize, BTreeMap<String, String>),
}

impl OpenReference {
    /// The columns of the variants that it stands for.
    pub(super) fn columns(&self) -> Vec<&str> {
        match &self.kind {
            ReferenceKind::Solution(courses) => courses.keys().map(String::as_str).collect(),
            ReferenceKind::Table(series) => series.keys().map(String::as_str).collect(),
            ReferenceKind::Run(_, columns) => columns.keys().map(String::as_str).collect(),
        }
    }

    /// A quantity of the variants as the reference has it at these times (s), NaN where it says nothing. A rate is taken
    /// between these times. None if it does not have the quantity at all.
    pub(super) fn sample(&self, quantity: &Quantity, times: &[f64], histories: &[Option<History>]) -> Option<Series> {
        let value: Vec<f64> = match &self.kind {
            ReferenceKind::Solution(courses) => {
                let course = courses.get(&quantity.column)?;
                course(times)
            }
            _ => {
                let series = self.own_series(&quantity.column, histories)?;
                times.iter().map(|&time| series.at(time).unwrap_or(f64::NAN)).collect()
            }
        };
        let series = Series { time: times.to_vec(), value };
        Some(if quantity.is_rate { series.rate() } else { series })
    }

    /// A quantity at the reference's own times; an exact solution, which has none, is asked at the given ones (s).
    pub(super) fn draw(&self, quantity: &Quantity, times: &[f64], histories: &[Option<History>]) -> Option<Series> {
        if matches!(self.kind, ReferenceKind::Solution(_)) {
            return self.sample(quantity, times, histories);
        }
        let series = self.own_series(&quantity.column, histories)?;
        Some(if quantity.is_rate { series.rate() } else { series })
    }

    fn own_series(&self, column: &str, histories: &[Option<History>]) -> Option<Series> {
        match &self.kind {
            ReferenceKind::Solution(_) => None,
            ReferenceKind::Table(series) => series.get(column).cloned(),
            ReferenceKind::Run(run, columns) => histories[*run].as_ref()?.series(columns.get(column)?),
        }
    }
}

/// Opens a reference that is an exact solution.
pub(super) fn open_solution(
    source: &CaseSource,
    place: &KeyPath,
    name: &str,
    reference: &Reference,
) -> Result<ReferenceKind, CaseError> {
    let known = solutions();
    let Some(solution) = known.iter().find(|solution| solution.name == name) else {
        let names: Vec<&str> = known.iter().map(|solution| solution.name).collect();
        let help = match did_you_mean(name, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("known: {}", list(&names)),
        };
        return Err(source.invalid(place.clone().key("solution"), format!("unknown exact solution `{name}`"), help));
    };
    let open = solution.open(source, place)?;
    let quantities = place.clone().key("quantities");
    let course = |column: &String| Ok((column.clone(), open.course(source, &quantities.clone().key(column))?));
    Ok(ReferenceKind::Solution(reference.quantities.keys().map(course).collect::<Result<_, CaseError>>()?))
}

/// Opens a reference that is a file of numbers.
pub(super) fn open_table(
    source: &CaseSource,
    place: &KeyPath,
    file: &str,
    reference: &Reference,
) -> Result<ReferenceKind, CaseError> {
    let path = source.beside(file);
    let table = Table::read(&path).map_err(|why| {
        let help = "the path is taken from the folder of the study file";
        source.invalid(place.clone().key("file"), format!("cannot read `{}`: {why}", path.display()), help)
    })?;
    let time_place = place.clone().key("time");
    let time_column = match &reference.time {
        Some(value) => column_of(source, &time_place, value)?,
        None => Column { column: "time".to_owned(), factor: 1.0 },
    };
    let time = table.numbers(source, &time_place, &time_column)?;
    let quantities = place.clone().key("quantities");
    let mut series = BTreeMap::new();
    for (quantity, value) in &reference.quantities {
        let place = quantities.clone().key(quantity);
        let values = table.numbers(source, &place, &column_of(source, &place, value)?)?;
        let points = time.iter().zip(values).filter(|(time, value)| time.is_finite() && value.is_finite());
        let (time, value): (Vec<f64>, Vec<f64>) = points.map(|(time, value)| (*time, value)).unzip();
        if time.is_empty() || !time.is_sorted_by(|one, next| one < next) {
            let what = if time.is_empty() { "has no numbers" } else { "must have increasing times" };
            return Err(source.invalid(place, format!("`{}` {what} for `{quantity}`", path.display()), ""));
        }
        series.insert(quantity.clone(), Series { time, value });
    }
    Ok(ReferenceKind::Table(series))
}

/// The columns of its history that a reference run gives: those asked for, or all of them under their own names.
pub(super) fn run_columns(
    source: &CaseSource,
    place: &KeyPath,
    reference: &Reference,
    known: &[String],
) -> Result<BTreeMap<String, String>, CaseError> {
    if reference.quantities.is_empty() {
        let columns = known.iter().filter(|column| !["time", "step"].contains(&column.as_str()));
        return Ok(columns.map(|column| (column.clone(), column.clone())).collect());
    }
    let quantities = place.clone().key("quantities");
    let mut columns = BTreeMap::new();
    for quantity in reference.quantities.keys() {
        let place = quantities.clone().key(quantity);
        let column: String = source.parse_at(&place)?;
        if !known.contains(&column) {
            return Err(no_column(source, &place, "the history of the run", &column, known));
        }
        columns.insert(quantity.clone(), column);
    }
    Ok(columns)
}

/// A column, which is written alone or with its factor.
fn column_of(source: &CaseSource, place: &KeyPath, value: &toml::Value) -> Result<Column, CaseError> {
    match value {
        toml::Value::String(column) => Ok(Column { column: column.clone(), factor: 1.0 }),
        toml::Value::Table(_) => source.parse_at(place),
        _ => Err(source.invalid(
            place,
            format!("`{place}` must be the name of a column, or a table with `column` and `factor`"),
            "",
        )),
    }
}

fn no_column(source: &CaseSource, place: &KeyPath, of: &str, name: &str, known: &[String]) -> CaseError {
    let help = match did_you_mean(name, known.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("it has {}", list(known)),
    };
    source.invalid(place, format!("{of} has no column `{name}`"), help)
}

/// A file of comma-separated values.
pub(crate) struct Table {
    names: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Table {
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let names = reader.headers().map_err(|error| error.to_string())?.iter().map(str::to_owned).collect();
        let rows = reader.records().collect::<Result<_, _>>().map_err(|error| error.to_string())?;
        Ok(Table { names, rows })
    }

    /// The numbers of a column in SI units, NaN where a cell is empty.
    pub(crate) fn numbers(&self, source: &CaseSource, place: &KeyPath, wanted: &Column) -> Result<Vec<f64>, CaseError> {
        let Some(index) = self.names.iter().position(|name| *name == wanted.column) else {
            return Err(no_column(source, place, "the file", &wanted.column, &self.names));
        };
        let number = |row: &csv::StringRecord| {
            let cell = row.get(index).unwrap_or_default();
            let line = row.position().map_or(0, csv::Position::line);
            match cell.parse::<f64>() {
                _ if cell.is_empty() => Ok(f64::NAN),
                Ok(number) => Ok(number * wanted.factor),
                Err(_) => {
                    let message = format!("column `{}` holds `{cell}` in line {line}, no number", wanted.column);
                    Err(source.invalid(place, message, ""))
                }
            }
        };
        self.rows.iter().map(number).collect()
    }
}
