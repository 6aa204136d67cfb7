//! Wrong input: exit code 2, one clear message on the standard error, nothing on the standard output, no folder.

use std::fs::{self, File};

use crate::desk::{COLUMN, COLUMN_1D, Desk, Ended, edited, snapshot};

/// A mistake: what it is called, the edits of the case that make it, the arguments that make it.
type Mistake<'a> = (&'a str, &'a [(&'a str, &'a str)], &'a [&'a str]);

/// Mistakes in what is asked, one message each.
const MISTAKES: &[Mistake] = &[
    // The text.
    ("syntax error", &[("cells = [1, 6]", "cells = [1, 6")], &[]),
    ("misspelt key", &[("porosity = 0.4", "porosty = 0.4")], &[]),
    ("missing key", &[("end = 100.0", "")], &[]),
    ("wrong length", &[("origin = [0.0, 0.0]", "origin = [0.0, 0.0, 0.0]")], &[]),
    ("not a number", &[("density = 1500.0", "density = nan")], &[]),
    // Numbers.
    ("negative porosity", &[("porosity = 0.4", "porosity = -0.4")], &[]),
    ("gamma of 0.5", &[("gamma = 1.0", "gamma = 0.5")], &[]),
    ("body outside the grid", &[("max = [1.0, 5.0]", "max = [1.0, 7.0]")], &[]),
    ("probe outside the grid", &[("pressure_at = [0.5, 0.5]", "pressure_at = [0.5, -0.5]")], &[]),
    ("too many particles", &[("particles_per_cell = [2, 2]", "particles_per_cell = [100000, 100000]")], &[]),
    ("unstable step", &[("step = 5.0e-3", "step = 2.0e-2")], &[]),
    ("step longer than the run", &[("step = 5.0e-3", "step = 200.0")], &["--allow-unstable"]),
    // Names.
    ("unknown law", &[("\"linear-elastic\"", "\"linear-elastc\"")], &[]),
    ("shape function wider than the grid", &[], &["--set", "method.shape=gimp"]),
    ("unknown law of the conductivity", &[("porosity = 0.4", "porosity = 0.4\nconductivity_law = \"kozeny\"")], &[]),
    ("unknown law like nothing", &[("\"linear-elastic\"", "\"play-dough\"")], &[]),
    ("unknown shape function", &[("shape = \"linear\"", "shape = \"gimpy\"")], &[]),
    ("unknown velocity update", &[("\"mpm1\"", "\"mpm3\"")], &[]),
    ("unknown material", &[("material = \"soil\"", "material = \"sand\"")], &[]),
    (
        "load on an unknown body",
        &[(
            "on = { surface = \"y-max\", of = \"soil\" }\ntraction",
            "on = { surface = \"y-max\", of = \"slope\" }\ntraction",
        )],
        &[],
    ),
    // Laws.
    ("law parameter out of range", &[("poisson = 0.45", "poisson = 0.5")], &[]),
    ("law parameter misspelt", &[("young =", "yuong =")], &[]),
    ("law parameter missing", &[(", poisson = 0.45", "")], &[]),
    // Together.
    (
        "drainage in dry ground",
        &[
            ("[fluid]\ndensity = 1000.0\nbulk_modulus = 2.2e9\nunit_weight = 9800.0\n", ""),
            ("pressure_at", "displacement_at"),
        ],
        &[],
    ),
    ("water table without gravity", &[("[[supports]]", "initial = { water_table = 5.0 }\n\n[[supports]]")], &[]),
    // The command line.
    ("--set of an unknown key", &[], &["--set", "materials.soil.porosty=0.3"]),
    ("--set of a bad value", &[], &["--set", "time.step=fast"]),
    ("--set out of range", &[], &["--set", "materials.soil.porosity=1.3"]),
    ("--set of a law parameter out of range", &[], &["--set", "materials.soil.parameters.poisson=0.7"]),
    ("--set of an unstable step", &[], &["--set", "time.step=0.02"]),
    ("--set without =", &[], &["--set", "time.step"]),
    ("--set beyond a list", &[], &["--set", "loads.1.applied_to=surface"]),
];

/// Several mistakes at once: all of them told, in the order of the file.
const SEVERAL: &[(&str, &str)] = &[
    ("spacing = [1.0, 1.0]", "spacing = [1.0, 0.0]"),
    ("porosity = 0.4", "porosity = 40"),
    ("face = \"x-max\"", "face = \"z-max\""),
    ("every = 10.0", "every = -10.0"),
];

/// Demands a refusal that leaves no trace, the same by `check` and `run`, and gives its message.
fn refused(desk: &Desk, case: &str, arguments: &[&str]) -> String {
    let before = desk.names();
    let [by_run, by_check] = ["run", "check"].map(|command| desk.tsutsumi(&[&[command, case], arguments].concat()));
    assert_eq!(by_run, by_check);
    assert_eq!(desk.names(), before, "a refused case leaves no folder");
    let Ended { code, stdout, stderr } = by_run;
    assert_eq!((code, stdout.as_str()), (Some(2), ""), "{stderr}");
    stderr
}

fn num_messages(stderr: &str) -> usize {
    stderr.lines().filter(|line| line.starts_with("error")).count()
}

fn gallery(messages: impl IntoIterator<Item = (String, String)>) -> String {
    let show = |(name, message): (String, String)| {
        assert_eq!(num_messages(&message), 1, "{name}: {message}");
        format!("## {name}\n{message}\n")
    };
    messages.into_iter().map(show).collect()
}

#[test]
fn wrong_cases_are_refused_with_one_message() {
    let desk = Desk::new();
    let messages = MISTAKES.iter().map(|(name, edits, arguments)| {
        fs::write(desk.path("case.toml"), edited(COLUMN, edits)).unwrap();
        ((*name).to_owned(), refused(&desk, "case.toml", arguments))
    });
    snapshot("wrong_cases", &gallery(messages));
}

#[test]
fn several_mistakes_are_told_at_once() {
    let desk = Desk::with("case.toml", edited(COLUMN, SEVERAL));
    let message = refused(&desk, "case.toml", &[]);
    // One each, and the count.
    assert_eq!(num_messages(&message), SEVERAL.len() + 1);
    snapshot("several_mistakes", &message);
}

#[test]
fn files_that_are_no_cases_are_refused() {
    let desk = Desk::new();
    fs::create_dir(desk.path("folder")).unwrap();
    // The beginning of a picture.
    fs::write(desk.path("picture.toml"), b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x03\x20").unwrap();
    fs::write(desk.path("zeros.toml"), [0; 4096]).unwrap();
    fs::write(desk.path("empty.toml"), "").unwrap();
    fs::write(desk.path("comments.toml"), "# to be written\n").unwrap();
    // A sparse file: read to its end it would take a gigabyte of memory.
    File::create(desk.path("huge.toml")).unwrap().set_len(1 << 30).unwrap();
    let mut cases =
        vec!["none.toml", "folder", "picture.toml", "zeros.toml", "empty.toml", "comments.toml", "huge.toml"];
    if cfg!(unix) {
        cases.push("/dev/zero");
    }
    snapshot("no_cases", &gallery(cases.into_iter().map(|case| (case.to_owned(), refused(&desk, case, &[])))));
}

#[test]
fn an_unstable_step_runs_if_that_is_wanted() {
    let text = edited(
        COLUMN,
        &[("step = 5.0e-3", "step = 2.0e-2"), ("end = 100.0", "end = 0.04"), ("every = 10.0", "every = 0.04")],
    );
    let desk = Desk::with("case.toml", text);
    refused(&desk, "case.toml", &[]);
    desk.succeeds(&["run", "case.toml", "--allow-unstable"]);
    let report = desk.succeeds(&["check", "case.toml", "--allow-unstable"]).stdout;
    assert!(report.contains("runs only with --allow-unstable"), "{report}");
}

#[test]
fn wrong_arguments_are_refused() {
    let desk = Desk::with("case.toml", COLUMN);
    let wrong: &[&[&str]] = &[
        &[],
        &["run"],
        &["runn", "case.toml"],
        &["run", "case.toml", "other.toml"],
        &["run", "case.toml", "--threads", "0"],
        &["run", "case.toml", "--threads", "many"],
        &["run", "case.toml", "--set"],
        &["run", "case.toml", "--out"],
        &["run", "case.toml", "--outt", "x"],
        &["check", "case.toml", "--out", "x"],
    ];
    for arguments in wrong {
        let Ended { code, stdout, stderr } = desk.tsutsumi(arguments);
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{arguments:?}: {stderr}");
        assert!(stderr.contains("Usage:") || stderr.contains("--help"), "{arguments:?}: {stderr}");
    }
    assert_eq!(desk.names(), ["case.toml"]);
}

#[test]
fn a_folder_with_results_is_not_written_into() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    desk.succeeds(&["run", "column.toml", "--out", "mine"]);
    let before = (desk.results("mine").contents(), desk.results("mine").manifest());
    let Ended { code, stdout, stderr } =
        desk.tsutsumi(&["run", "column.toml", "--out", "mine", "--set", "time.end=30"]);
    assert_eq!((code, stdout.as_str()), (Some(2), ""), "{stderr}");
    assert_eq!(num_messages(&stderr), 1);
    assert_eq!((desk.results("mine").contents(), desk.results("mine").manifest()), before);
    snapshot("occupied_folder", &stderr);
}

#[test]
fn a_folder_that_cannot_be_is_refused() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    for out in ["column.toml", "column.toml/results"] {
        let Ended { code, stdout, stderr } = desk.tsutsumi(&["run", "column.toml", "--out", out]);
        assert!(matches!(code, Some(1 | 2)), "{code:?}");
        assert_eq!(stdout, "");
        assert!(num_messages(&stderr) == 1 && stderr.contains(out), "{stderr}");
    }
    assert_eq!(desk.names(), ["column.toml"]);
    assert_eq!(fs::read_to_string(desk.path("column.toml")).unwrap(), COLUMN_1D);
}
