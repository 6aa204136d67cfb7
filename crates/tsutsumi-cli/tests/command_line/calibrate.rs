//! `calibrate`: exit codes, what is printed, where results go. What is in them has its tests in `tsutsumi-case`.

use std::fs;
use std::path::Path;

use crate::desk::Desk;

/// A desk with the example of the repository in a folder below.
fn desk() -> Desk {
    let desk = Desk::new();
    fs::create_dir(desk.path("below")).unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../element-tests/calibration");
    for name in ["calibration.toml", "oedometer.toml", "oedometer.csv"] {
        fs::copy(example.join(name), desk.path("below").join(name)).unwrap();
    }
    desk
}

#[test]
fn the_example_finds_its_modulus_from_anywhere() {
    let desk = desk();
    let ended = desk.succeeds(&["calibrate", "below/calibration.toml"]);
    assert!(ended.stderr.ends_with("results in results/calibration\n"), "{}", ended.stderr);
    let line = ended.stdout.lines().find(|line| line.starts_with("young")).unwrap();
    let fitted: f64 = line.split_whitespace().nth(2).unwrap().parse().unwrap();
    // E_oed = 2 MPa and ν = 0.3. Increments of 1/800 each leave half their size, and the slope of ε/J makes at most twice that of it.
    let expected = 2e6 * 1.3 * 0.4 / 0.7;
    assert!((fitted / expected - 1.0).abs() < 1.0 / 800.0, "{fitted}");
    let results = desk.results("results/calibration");
    assert_eq!(results.names(""), ["calibration.json", "calibration.toml", "figures", "parameters.toml"]);
    assert_eq!(results.names("figures"), ["oedometer.csv", "oedometer.png", "oedometer.svg"]);
}

#[test]
fn a_wrong_file_and_a_taken_folder_are_refused() {
    let desk = desk();
    assert_eq!(desk.tsutsumi(&["calibrate", "nothing.toml"]).code, Some(2));
    assert_eq!(desk.tsutsumi(&["calibrate", "below/calibration.toml", "--out", "below"]).code, Some(2));
    fs::remove_file(desk.path("below/oedometer.csv")).unwrap();
    let ended = desk.tsutsumi(&["calibrate", "below/calibration.toml"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("below/calibration.toml:12:8"), "{}", ended.stderr);
}
