//! From a file to a calibration that can begin: element tests and data opened, every name checked.

use std::path::PathBuf;

use super::range::Range;
use super::schema::{CalibrationFile, MeasuredColumn, Measurement, SoughtParameter};
use crate::element::{ElementTest, columns};
use crate::error::{did_you_mean, quoted};
use crate::file_checks::Checks;
use crate::source::list;
use crate::study::{Column, Table};
use crate::{CaseError, CaseSource, FileKind, KeyPath, Registry};

/// A calibration that has been read and checked, with its element tests and data.
pub struct Calibration {
    pub(super) source: CaseSource,
    pub(super) file: CalibrationFile,
    pub(super) ranges: Vec<Range>,
    pub(super) curves: Vec<MeasuredCurve>,
}

/// A measured curve with its element test.
pub(super) struct MeasuredCurve {
    pub(super) measurement: Measurement,
    pub(super) test: CaseSource,
    /// Measured points, x and y in SI units.
    pub(super) points: Vec<[f64; 2]>,
}

impl Calibration {
    /// Reads a calibration with its element tests and data, and checks what can be checked before it begins.
    ///
    /// # Errors
    /// Everything that is wrong with the file, each with its place; then what is wrong with an element test, in its own file.
    pub fn read(path: impl Into<PathBuf>, registry: &Registry) -> Result<Self, CaseError> {
        let source = CaseSource::read_kind(&path.into(), FileKind::Calibration)?;
        let file: CalibrationFile = source.parse_at(&KeyPath::root())?;
        let mut checks = Checks::new(&source, &file);
        checks.all();
        checks.finish()?;
        let ranges = file.parameters.iter().map(Range::of).collect();
        let measurements = file.measurements.iter().enumerate();
        let open = |(index, one): (usize, &Measurement)| {
            let place = KeyPath::from("measurements").index(index);
            MeasuredCurve::open(&source, &place, one)
        };
        let curves = measurements.map(open).collect::<Result<Vec<_>, _>>()?;
        let calibration = Calibration { source, file, ranges, curves };
        calibration.check_tests(registry)?;
        Ok(calibration)
    }

    /// The title of the calibration.
    pub fn title(&self) -> &str {
        &self.file.title
    }

    /// Where the search begins: a value for each parameter.
    pub(super) fn start(&self) -> Vec<f64> {
        let parameters = self.file.parameters.iter().zip(&self.ranges);
        parameters.map(|(parameter, range)| parameter.start.unwrap_or_else(|| range.middle())).collect()
    }

    /// The element test of a curve with these values of the parameters.
    pub(super) fn test(
        &self,
        curve: &MeasuredCurve,
        values: &[f64],
        registry: &Registry,
    ) -> Result<ElementTest, CaseError> {
        let settings = self.file.parameters.iter().zip(values);
        let set = |source: CaseSource, (parameter, value): (&SoughtParameter, &f64)| {
            source.with_override(&format!("material.parameters.{}={value:e}", parameter.name))
        };
        ElementTest::open(settings.into_iter().try_fold(curve.test.clone(), set)?, registry)
    }

    /// The element tests can begin, are of one law, and record what is compared.
    fn check_tests(&self, registry: &Registry) -> Result<(), CaseError> {
        let mut checks = Checks::new(&self.source, &self.file);
        let mut law: Option<String> = None;
        for (index, curve) in self.curves.iter().enumerate() {
            let place = KeyPath::from("measurements").index(index);
            let test = self.test(curve, &self.start(), registry)?;
            let own = &test.file.material.law;
            if law.as_ref().is_some_and(|law| law != own) {
                checks.report(place.clone().key("test"), "the element tests are of different laws", "");
            }
            law = law.or_else(|| Some(own.clone()));
            let known = columns(&test.file, test.specimen(registry)?.outputs());
            for (key, column) in [("x", &curve.measurement.x), ("y", &curve.measurement.y)] {
                checks.quantity(&place.clone().key(key).key("quantity"), column, &known);
            }
            let num_stages = test.file.stages.len();
            if let Some(stage) = curve.measurement.stage.filter(|stage| !(1..=num_stages).contains(stage)) {
                let help = format!("stages count from 1 to {num_stages}");
                checks.report(place.key("stage"), format!("there is no stage {stage}"), help);
            }
        }
        checks.finish()
    }
}

impl MeasuredCurve {
    fn open(source: &CaseSource, place: &KeyPath, measurement: &Measurement) -> Result<Self, CaseError> {
        let path = source.beside(&measurement.data);
        let table = Table::read(&path).map_err(|why| {
            let help = "the path is taken from the folder of the calibration";
            source.invalid(place.clone().key("data"), format!("cannot read `{}`: {why}", path.display()), help)
        })?;
        let numbers = |key: &str, column: &MeasuredColumn| {
            let place = place.clone().key(key).key("column");
            table.numbers(source, &place, &Column { column: column.column.clone(), factor: column.factor })
        };
        let (x, y) = (numbers("x", &measurement.x)?, numbers("y", &measurement.y)?);
        let points = x.into_iter().zip(y).filter(|(x, y)| x.is_finite() && y.is_finite());
        let points: Vec<[f64; 2]> = points.map(|(x, y)| [x, y]).collect();
        if points.iter().all(|[_, y]| *y == 0.0) {
            let message = format!("`{}` measures nothing but zeros, or nothing at all", path.display());
            return Err(source.invalid(place.clone().key("y"), message, ""));
        }
        let test =
            CaseSource::read_kind(&source.beside(&measurement.test), FileKind::ElementTest).map_err(|error| {
                let help = "paths count from the folder of the calibration";
                source.invalid(place.clone().key("test"), error.to_string(), help)
            })?;
        Ok(MeasuredCurve { measurement: measurement.clone(), test, points })
    }
}

impl Checks<'_, CalibrationFile> {
    fn all(&mut self) {
        let file = self.file;
        if file.parameters.is_empty() {
            self.report("parameters", "no parameter is sought", "add `[[parameters]]`");
        }
        if file.measurements.is_empty() {
            self.report("measurements", "nothing is measured", "add `[[measurements]]`");
        }
        if !(file.tolerance > 0.0 && file.tolerance.is_finite()) {
            self.report("tolerance", "`tolerance` must be greater than 0", "");
        }
        for (index, parameter) in file.parameters.iter().enumerate() {
            let is_known = file.parameters[..index].iter().any(|other| other.name == parameter.name);
            self.parameter(&KeyPath::from("parameters").index(index), parameter, is_known);
        }
        for (index, measurement) in file.measurements.iter().enumerate() {
            let is_known = file.measurements[..index].iter().any(|other| other.name == measurement.name);
            self.measurement(&KeyPath::from("measurements").index(index), measurement, is_known);
        }
    }

    fn parameter(&mut self, place: &KeyPath, parameter: &SoughtParameter, is_known: bool) {
        let name = quoted(&parameter.name);
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if parameter.name.is_empty() || !parameter.name.chars().all(is_plain) {
            self.report(place.clone().key("name"), format!("`{name}` is no name of a parameter"), "");
        }
        if is_known {
            self.report(place.clone().key("name"), format!("`{name}` is sought twice"), "");
        }
        let [low, high] = parameter.bounds;
        let key = place.clone().key("bounds");
        if !(low.is_finite() && high.is_finite() && low < high) {
            self.report(key, "the bounds must be finite, the lower one first", "write [from, to]");
        } else if parameter.logarithmic && low <= 0.0 {
            self.report(key, "a logarithmic range must be positive", "");
        } else if parameter.start.is_some_and(|start| !(low..=high).contains(&start)) {
            self.report(place.clone().key("start"), "the search must begin between the bounds", "");
        }
    }

    fn measurement(&mut self, place: &KeyPath, measurement: &Measurement, is_known: bool) {
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let name = quoted(&measurement.name);
        if measurement.name.is_empty() || !measurement.name.chars().all(is_plain) {
            let help = "the name becomes that of a file: lower-case letters, digits, hyphens";
            self.report(place.clone().key("name"), format!("`{name}` is no name"), help);
        }
        if is_known {
            self.report(place.clone().key("name"), format!("two measurements are called `{name}`"), "");
        }
        if !(measurement.weight > 0.0 && measurement.weight.is_finite()) {
            self.report(place.clone().key("weight"), "a weight must be greater than 0", "");
        }
    }

    fn quantity(&mut self, place: &KeyPath, column: &MeasuredColumn, known: &[String]) {
        if !known.contains(&column.quantity) {
            let help = match did_you_mean(&column.quantity, known.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are {}", list(known)),
            };
            let message = format!("the element test records no `{}`", quoted(&column.quantity));
            self.report(place.clone(), message, help);
        }
    }
}
