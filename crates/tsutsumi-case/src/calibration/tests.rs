//! Calibrations from file to folder, with data from closed forms.

use std::fs;
use std::path::PathBuf;

use super::*;
use crate::{Outcome, Registry, ResultsError};

const TEST: &str = r#"
title = "Drained compression"
[material]
law = "linear-elastic"
parameters = { young = 1.0e6, poisson = 0.1 }
[initial]
mean_stress = 100.0e3
[[stages]]
kind = "triaxial"
to = { axial_strain = 0.01 }
increments = 20
"#;

const CALIBRATION: &str = r#"
title = "Young and Poisson"

[[parameters]]
name = "young"
bounds = [1.0e6, 1.0e9]
logarithmic = true

[[parameters]]
name = "poisson"
bounds = [0.0, 0.49]
start = 0.1

[[measurements]]
name = "stress"
test = "test.toml"
data = "data.csv"
x = { quantity = "axial_strain", column = "strain (%)", factor = 0.01 }
y = { quantity = "stress_difference", column = "q (kPa)", factor = 1000.0 }

[[measurements]]
name = "volume"
test = "test.toml"
data = "data.csv"
stage = 1
x = { quantity = "axial_strain", column = "strain (%)", factor = 0.01 }
y = { quantity = "volumetric_strain", column = "volume (%)", factor = 0.01 }
"#;

/// A folder of its own for a test, with the files; removed at the end.
struct Desk(PathBuf);

impl Desk {
    fn new(test: &str, calibration: &str, data: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("tsutsumi-calibration-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        for (name, text) in [("calibration.toml", calibration), ("test.toml", TEST), ("data.csv", data)] {
            fs::write(folder.join(name), text).unwrap();
        }
        Desk(folder)
    }

    fn read(&self) -> Result<Calibration, crate::CaseError> {
        Calibration::read(self.0.join("calibration.toml"), &Registry::built_in())
    }

    fn run(&self, stop: &(dyn Fn() -> bool + Sync)) -> Result<CalibrationSummary, CalibrationError> {
        let options = CalibrationOptions { out: Some(self.0.join("out")), force: false };
        calibrate(&self.read().unwrap(), &Registry::built_in(), &options, stop)
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// q = E ε and ε_v = (1 − 2ν) ε for E = 20 MPa and ν = 0.3, and strain beyond the test's if wanted.
fn data(last: usize) -> String {
    let rows = (0..=last).map(|i| {
        let percent = 0.2 * i as f64;
        format!("{percent},{},{}\n", 200.0 * percent, 0.4 * percent)
    });
    format!("# closed form\nstrain (%),q (kPa),volume (%)\n{}", rows.collect::<String>())
}

#[test]
fn the_parameters_behind_a_closed_form_are_found() {
    let desk = Desk::new("found", CALIBRATION, &data(5));
    let summary = desk.run(&|| false).unwrap();
    assert_eq!(summary.outcome, Outcome::Finished);
    let value = |name: &str| summary.parameters.iter().find(|one| one.name == name).unwrap().value;
    // The search ends where the misfits, squares of relative errors, differ by 1e-10: errors of 1e-5 times a few.
    assert!((value("young") / 20e6 - 1.0).abs() < 1e-4, "{}", summary.table());
    assert!((value("poisson") - 0.3).abs() < 1e-4, "{}", summary.table());
    assert!(summary.misfit[1] < 1e-8 && summary.misfit[0] > 0.01, "{:?}", summary.misfit);
    assert!(summary.curves.iter().all(|curve| curve.relative_rms < 1e-4 && (curve.points, curve.missing) == (6, 0)));
    // The parameters as they were written serve the next element test.
    let text = fs::read_to_string(desk.0.join("out/parameters.toml")).unwrap();
    let written: toml::Table = text.parse().unwrap();
    assert_eq!(written["material"]["law"].as_str(), Some("linear-elastic"));
    assert_eq!(written["material"]["parameters"]["young"].as_float(), Some(value("young")));
    for name in ["stress.svg", "stress.png", "stress.csv", "volume.svg", "volume.png", "volume.csv"] {
        assert!(desk.0.join("out/figures").join(name).exists(), "{name}");
    }
    assert!(matches!(desk.run(&|| false), Err(CalibrationError::Results(ResultsError::Occupied { .. }))));
}

#[test]
fn a_range_that_is_too_narrow_and_data_that_are_not_reached_are_told() {
    let narrow = CALIBRATION.replace("bounds = [1.0e6, 1.0e9]", "bounds = [1.0e6, 1.5e7]");
    let summary = Desk::new("narrow", &narrow, &data(6)).run(&|| false).unwrap();
    assert!(summary.parameters[0].at_bound && !summary.parameters[1].at_bound, "{}", summary.table());
    assert!(summary.table().contains("at a bound") && summary.table().contains("1 of them not reached"));
    assert!(summary.curves.iter().all(|curve| curve.missing == 1));
}

#[test]
fn a_stop_keeps_the_best_so_far() {
    let asked = std::sync::atomic::AtomicUsize::new(0);
    let stop = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= 10;
    let summary = Desk::new("stop", CALIBRATION, &data(5)).run(&stop).unwrap();
    assert_eq!((summary.outcome, summary.evaluations), (Outcome::Interrupted, 11));
    assert!(summary.misfit[1] <= summary.misfit[0]);
}

const MISTAKES: &[(&str, &str, &str)] = &[
    ("name = \"young\"", "name = \"yuong\"", "unknown key `yuong` in `material.parameters`"),
    ("bounds = [0.0, 0.49]", "bounds = [0.49, 0.0]", "the bounds must be finite, the lower one first"),
    ("bounds = [1.0e6, 1.0e9]", "bounds = [0.0, 1.0e9]", "a logarithmic range must be positive"),
    ("start = 0.1", "start = 0.6", "the search must begin between the bounds"),
    ("name = \"poisson\"", "name = \"young\"", "`young` is sought twice"),
    ("name = \"volume\"", "name = \"stress\"", "two measurements are called `stress`"),
    ("data = \"data.csv\"", "data = \"dta.csv\"", "cannot read"),
    ("test = \"test.toml\"", "test = \"tst.toml\"", "there is no element test file"),
    ("column = \"q (kPa)\"", "column = \"q\"", "the file has no column `q`"),
    ("\"stress_difference\"", "\"stress_diference\"", "did you mean `stress_difference`?"),
    ("stage = 1", "stage = 2", "there is no stage 2"),
    ("stage = 1", "stgae = 1", "unknown key `stgae` in `measurements[1]`"),
];

#[test]
fn mistakes_are_told_before_anything_runs() {
    for (from, to, expected) in MISTAKES {
        assert!(CALIBRATION.contains(from), "{from}");
        let desk = Desk::new("mistakes", &CALIBRATION.replacen(from, to, 1), &data(5));
        let error = desk.read().err().unwrap_or_else(|| panic!("{to} was accepted")).render(false);
        assert!(error.contains(expected), "{to}: {error}");
    }
}

#[test]
fn the_schema_accepts_the_calibration() {
    let schema = schema();
    jsonschema::meta::validate(&schema).unwrap();
    let value = serde_json::to_value(CALIBRATION.parse::<toml::Table>().unwrap()).unwrap();
    assert!(jsonschema::validator_for(&schema).unwrap().is_valid(&value));
}
