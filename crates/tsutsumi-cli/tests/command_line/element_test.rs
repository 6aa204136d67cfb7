//! `element-test`: exit codes, what is printed, where results go. What is in them has its tests in `tsutsumi-case`.

use std::fs;

use crate::desk::{Desk, edited};

const TEST: &str = r#"
title = "Cyclic shear of an elastic soil"

[material]
law = "linear-elastic"
parameters = { young = 30.0e6, poisson = 0.25 }

[initial]
mean_stress = 100.0e3

[[stages]]
kind = "simple-shear"
drainage = "undrained"
amplitude = { stress_ratio = 0.12 }
increment = 1.0e-4
until = { cycles = 2.0, double_strain = 0.1 }
"#;

/// A desk with a test in a folder below.
fn desk(test: &str) -> Desk {
    let desk = Desk::new();
    fs::create_dir(desk.path("below")).unwrap();
    fs::write(desk.path("below/shear.toml"), test).unwrap();
    desk
}

#[test]
fn a_test_leaves_a_folder_where_it_was_called() {
    let desk = desk(TEST);
    let ended = desk.succeeds(&["element-test", "below/shear.toml"]);
    assert_eq!(ended.stdout, "");
    // τ = 12 kPa is γ = 1e-3 of G = 12 MPa: ten increments, the last of which may be two, per quarter of a cycle.
    assert!(ended.stderr.starts_with("stage 1: 80 increments, 2.00 cycles, ended by `cycles`\n"), "{}", ended.stderr);
    assert!(ended.stderr.ends_with("results in results/shear\n"), "{}", ended.stderr);
    assert_eq!(desk.names(), ["below", "results"]);
    let results = desk.results("results/shear");
    assert_eq!(results.names(""), ["element.csv", "figures", "manifest.json", "test.toml"]);
    assert_eq!(results.figures(), ["shear-cycles", "shear-stress-path", "shear-stress-strain"]);
    assert_eq!(results.manifest()["outcome"]["kind"], "finished");
    let quiet = desk.succeeds(&["element-test", "below/shear.toml", "--quiet", "--set", "output.figures=false"]);
    assert_eq!(quiet.stderr, "");
    assert_eq!(
        desk.names().len() + desk.results("results").names("").len(),
        4,
        "the second test has a folder of its own"
    );
}

#[test]
fn a_wrong_file_and_a_taken_folder_are_refused() {
    let desk = desk(&edited(TEST, &[("poisson", "poison")]));
    let ended = desk.tsutsumi(&["element-test", "below/shear.toml"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(2), ""));
    assert!(
        ended.stderr.contains("below/shear.toml:6:32") && ended.stderr.contains("did you mean `poisson`?"),
        "{}",
        ended.stderr
    );
    assert_eq!(desk.tsutsumi(&["element-test", "nothing.toml"]).code, Some(2));
    fs::write(desk.path("below/shear.toml"), TEST).unwrap();
    let taken = desk.tsutsumi(&["element-test", "below/shear.toml", "--out", "below"]);
    assert_eq!(taken.code, Some(2), "{}", taken.stderr);
    let arguments = ["element-test", "below/shear.toml", "--out", "out", "--quiet"];
    desk.succeeds(&arguments);
    assert_eq!(desk.tsutsumi(&arguments).code, Some(2));
    desk.succeeds(&["element-test", "below/shear.toml", "--out", "out", "--quiet", "--force"]);
}

#[test]
fn a_test_that_cannot_go_on_keeps_its_record() {
    let desk = desk(&edited(TEST, &[("mean_stress = 100.0e3", "mean_stress = 0.0")]));
    let ended = desk.tsutsumi(&["element-test", "below/shear.toml", "--quiet"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.starts_with("error: stage 1 (simple-shear), increment 1: "), "{}", ended.stderr);
    assert_eq!(desk.results("results/shear").text("element.csv").lines().count(), 2);
}

#[test]
fn a_resistance_curve_is_printed_as_a_table() {
    let curve = "[resistance]\nstress_ratios = [0.12, 7.0]\ncriteria = [{ double_strain = 0.1 }]\n";
    let desk = desk(&format!("{TEST}\n{curve}"));
    let ended = desk.succeeds(&["element-test", "below/shear.toml", "--quiet", "--threads", "2"]);
    let lines: Vec<&str> = ended.stdout.lines().collect();
    assert_eq!(lines.len(), 3);
    assert!(lines[1].ends_with("0.12  not reached in 2.00"), "{}", ended.stdout);
    // τ = 700 kPa is γ = 5.83 %: from the first turn at ¼ on, 10 % of the 11.67 % to the next one, and one increment at most.
    assert!(lines[2].ends_with("7  0.68"), "{}", ended.stdout);
}

#[test]
fn the_schema_of_element_tests_accepts_the_test() {
    let schema = serde_json::from_str(&Desk::new().succeeds(&["schema", "--element-test"]).stdout).unwrap();
    let test = serde_json::to_value(TEST.parse::<toml::Table>().unwrap()).unwrap();
    assert!(jsonschema::validator_for(&schema).unwrap().is_valid(&test));
}
