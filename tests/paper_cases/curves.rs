//! Running a case file with overrides, and its readings by name.

use std::path::Path;

use tsutsumi_case::build::build;
use tsutsumi_case::{Case, CaseSource, Registry, Simulation, Step, read_case};

/// The readings of a run: a row every so many seconds.
#[derive(Debug)]
pub(crate) struct Curves {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    /// The number of steps made.
    pub(crate) steps: u64,
}

impl Curves {
    /// [`Curves::of`] with another end and time between rows (s).
    pub(crate) fn until(end: f64, every: f64, file: &str, overrides: &[&str]) -> Self {
        let times = [format!("time.end={end}"), format!("output.every={every}")];
        Curves::of(file, &[&times.each_ref().map(String::as_str), overrides].concat())
    }

    /// Runs a case file under `paper-cases/` with these overrides to its end, and reads it every `output.every` seconds.
    pub(crate) fn of(file: &str, overrides: &[&str]) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../paper-cases").join(file);
        let source = CaseSource::read(path).unwrap();
        let source = overrides.iter().fold(source, |source, text| source.with_override(text).unwrap());
        let case = read_case(&source).unwrap_or_else(|error| panic!("{}", error.render(false)));
        let registry = Registry::built_in();
        match case.dimension {
            1 => Curves::record(build::<1>(&source, &case, &registry).unwrap(), &case),
            2 => Curves::record(build::<2>(&source, &case, &registry).unwrap(), &case),
            _ => Curves::record(build::<3>(&source, &case, &registry).unwrap(), &case),
        }
    }

    fn record<const D: usize>(mut simulation: Simulation<D>, case: &Case) -> Self {
        let every = case.output.every;
        let mut rows = Vec::new();
        while simulation.model().time() < case.time.end * (1.0 - 1e-9) {
            let longest = match case.time.step {
                Step::Seconds(step) => step,
                Step::Auto => case.time.safety * simulation.model().step_limits().unwrap().accurate(),
            };
            let count = (every / longest * (1.0 - 1e-9)).ceil();
            for _ in 0..count as u64 {
                simulation.model_mut().step(every / count).unwrap();
            }
            rows.push(simulation.readings());
        }
        Curves { names: simulation.reading_names(), rows, steps: simulation.model().steps() }
    }

    /// A reading in all rows.
    pub(crate) fn column(&self, name: &str) -> Vec<f64> {
        let place = self.names.iter().position(|known| known == name);
        let place = place.unwrap_or_else(|| panic!("no reading {name}: {:?}", self.names));
        self.rows.iter().map(|row| row[place]).collect()
    }

    /// A reading at a time (s) of which there is a row.
    pub(crate) fn at(&self, name: &str, time: f64) -> f64 {
        let times = self.column("time");
        let row = times.iter().position(|t| (t - time).abs() <= 1e-9 * time.abs()).expect("a row at this time");
        self.column(name)[row]
    }

    /// The number of rows.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// The largest value of a reading.
    pub(crate) fn largest(&self, name: &str) -> f64 {
        self.column(name).into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Fails with names and numbers unless a value is within a tolerance.
pub(crate) fn assert_within(name: &str, value: f64, expected: f64, tolerance: f64) {
    let difference = value - expected;
    assert!(difference.abs() <= tolerance, "{name}: {value} is {difference:e} from {expected}, allowed {tolerance:e}");
}
