//! Cases run from their files, read in memory.

use std::path::Path;

use tsutsumi_case::build::build;
use tsutsumi_case::{Case, CaseSource, Registry, Simulation, Step, read_case};

/// The readings of a run, one row every so many seconds.
#[derive(Debug)]
pub(crate) struct Curves {
    names: Vec<String>,
    pub(crate) rows: Vec<Vec<f64>>,
    /// The number of steps made.
    pub(crate) steps: u64,
}

impl Curves {
    /// All values of a column of the history.
    pub(crate) fn column(&self, name: &str) -> Vec<f64> {
        let place = self.names.iter().position(|known| known == name);
        let place = place.unwrap_or_else(|| panic!("no column `{name}` in {:?}", self.names));
        self.rows.iter().map(|row| row[place]).collect()
    }

    /// The value of a column at a time (s).
    pub(crate) fn at(&self, time: f64, name: &str) -> f64 {
        let times = self.column("time");
        let row =
            times.iter().position(|other| (other - time).abs() < 1e-6 * time.max(1.0)).expect("a row at this time");
        self.column(name)[row]
    }
}

/// Runs a file of `paper-cases` with these overrides to a time (s), and reads it every `every` seconds.
pub(crate) fn run(file: &str, overrides: &[&str], end: f64, every: f64) -> Curves {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../paper-cases");
    let source = CaseSource::read(folder.join(file)).unwrap();
    let source = overrides.iter().fold(source, |source, text| source.with_override(text).unwrap());
    let case = read_case(&source).unwrap();
    match case.dimension {
        1 => advance(build::<1>(&source, &case, &Registry::built_in()).unwrap(), &case, end, every),
        2 => advance(build::<2>(&source, &case, &Registry::built_in()).unwrap(), &case, end, every),
        _ => advance(build::<3>(&source, &case, &Registry::built_in()).unwrap(), &case, end, every),
    }
}

fn advance<const D: usize>(mut simulation: Simulation<D>, case: &Case, end: f64, every: f64) -> Curves {
    let mut rows = Vec::new();
    while simulation.model().time() < end * (1.0 - 1e-9) {
        let dt = match case.time.step {
            Step::Seconds(dt) => dt,
            Step::Auto => {
                let longest = case.time.safety * simulation.model().step_limits().unwrap().accurate();
                every / (every / longest).ceil()
            }
        };
        for _ in 0..(every / dt).round() as u64 {
            simulation.model_mut().step(dt).unwrap();
        }
        rows.push(simulation.readings());
    }
    Curves { names: simulation.reading_names(), rows, steps: simulation.model().steps() }
}

/// Fails with names and numbers unless a value is within a tolerance.
pub(crate) fn assert_within(name: &str, value: f64, expected: f64, tolerance: f64) {
    let difference = value - expected;
    assert!(difference.abs() <= tolerance, "{name}: {value} is {difference:e} from {expected}, allowed {tolerance:e}");
}
