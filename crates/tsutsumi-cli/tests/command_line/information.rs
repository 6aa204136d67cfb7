//! `check`, `laws`, `schema`, and help: what the command tells without running anything.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use serde_json::Value;

use crate::desk::{COLUMN, COLUMN_1D, Desk, edited, snapshot};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_owned()
}

#[test]
fn check_tells_what_follows_from_the_numbers_of_the_paper() {
    let desk = Desk::new();
    let case = repository().join("paper-cases/poroelastic-column/case.toml");
    let ended = desk.succeeds(&["check", case.to_str().unwrap()]);
    assert_eq!(ended.stderr, "");
    // k/γ_w / (1/E_oed + n/K^f), worked out by hand.
    assert!(ended.stdout.contains("c_v   0.09266 m²/s"), "{}", ended.stdout);
    assert_eq!(desk.names(), Vec::<String>::new(), "checking writes nothing");
    snapshot("check_of_the_paper", &ended.stdout);
}

#[test]
fn check_of_dry_ground_speaks_of_no_water() {
    let fluid = "[fluid]\ndensity = 1000.0\nbulk_modulus = 2.2e9\nunit_weight = 9800.0\n";
    let drainage = "[[drainage]]\non = { surface = \"y-max\", of = \"soil\" }\n";
    let text = edited(COLUMN, &[(fluid, ""), (drainage, ""), ("pressure_at", "displacement_at")]);
    let desk = Desk::with("dry.toml", text);
    let report = desk.succeeds(&["check", "dry.toml"]).stdout;
    assert!(report.contains("drained wave speed") && report.contains("compression wave"), "{report}");
    for word in ["undrained", "c_v", "NaN", "inf"] {
        assert!(!report.contains(word), "{word}: {report}");
    }
    desk.succeeds(&["run", "dry.toml", "--set", "time.end=10"]);
}

#[test]
fn check_counts_with_the_overrides() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    let report = desk.succeeds(&["check", "column.toml", "--set", "bodies.0.particles_per_cell=[5]"]).stdout;
    let particles = report.lines().find(|line| line.trim_start().starts_with("particles")).unwrap();
    assert_eq!(particles.split_whitespace().last(), Some("20"));
}

#[test]
fn laws_are_listed_with_their_parameters() {
    let desk = Desk::new();
    snapshot("laws", &desk.succeeds(&["laws"]).stdout);
}

/// The schema that the command prints.
fn schema() -> Value {
    serde_json::from_str(&Desk::new().succeeds(&["schema"]).stdout).unwrap()
}

/// Where a case is against the schema.
fn complaints(schema: &Value, text: &str) -> Vec<String> {
    let case = serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
    let validator = jsonschema::validator_for(schema).unwrap();
    validator.iter_errors(&case).map(|error| error.instance_path().to_string()).collect()
}

/// The case files in a folder and those below it: TOML files with a grid.
fn cases(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(cases(&path));
        } else if path.extension().is_some_and(|extension| extension == "toml") {
            let text = fs::read_to_string(&path).unwrap();
            if text.contains("[grid]") {
                found.push((path, text));
            }
        }
    }
    found
}

#[test]
fn the_schema_is_one_and_accepts_the_cases_of_the_repository() {
    let schema = schema();
    jsonschema::meta::validate(&schema).unwrap();
    let cases = cases(&repository().join("paper-cases"));
    assert!(!cases.is_empty());
    for (path, text) in cases {
        assert_eq!(complaints(&schema, &text), Vec::<String>::new(), "{}", path.display());
    }
    for text in [COLUMN, COLUMN_1D] {
        assert_eq!(complaints(&schema, text), Vec::<String>::new());
    }
}

#[test]
fn the_schema_knows_the_laws_of_the_program() {
    // The law of the example is its own: the schema of this program refuses the name, and nothing else.
    let text = fs::read_to_string(repository().join("examples/my-law/case.toml")).unwrap();
    let complaints = complaints(&schema(), &text);
    assert_eq!(complaints, ["/materials/soil/law"]);
}

#[test]
fn the_schema_refuses_what_the_command_refuses() {
    let schema = schema();
    for edit in
        [("porosity", "porosty"), ("\"linear-elastic\"", "\"cam-clay\""), ("young", "yuong"), ("\"mpm1\"", "\"mpm3\"")]
    {
        let text = edited(COLUMN, &[edit]);
        assert!(!complaints(&schema, &text).is_empty(), "{edit:?}");
        assert_eq!(Desk::with("case.toml", text).tsutsumi(&["check", "case.toml"]).code, Some(2));
    }
}

#[test]
fn help_and_version_are_no_errors() {
    let desk = Desk::new();
    for arguments in [&["--help"][..], &["help", "run"], &["run", "--help"], &["check", "--help"]] {
        let ended = desk.succeeds(arguments);
        assert!(ended.stdout.contains("Usage: tsutsumi") && ended.stderr.is_empty(), "{ended:?}");
    }
    let version = desk.succeeds(&["--version"]).stdout;
    assert_eq!(version, format!("tsutsumi {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let mut child = Desk::new().command(&["schema"]).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &[][..]));
}
