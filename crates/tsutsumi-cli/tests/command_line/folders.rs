//! Where results go: never over something that is not theirs.

use std::collections::BTreeSet;
use std::fs;
use std::process::Child;

use crate::desk::{COLUMN_1D, Desk};

#[test]
fn runs_without_a_folder_are_numbered() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    for expected in ["results/column", "results/column-2", "results/column-3"] {
        let ended = desk.succeeds(&["run", "column.toml"]);
        assert!(ended.stderr.ends_with(&format!("results in {expected}\n")), "{}", ended.stderr);
        assert_eq!(desk.results(expected).manifest()["outcome"]["kind"], "finished");
    }
}

#[test]
fn runs_at_the_same_time_have_folders_of_their_own() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    let start = |_| desk.command(&["run", "column.toml", "--quiet"]).spawn().unwrap();
    let runs: Vec<Child> = (0..8).map(start).collect();
    for run in runs {
        let output = run.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let folders: BTreeSet<String> = desk.results("results").names("").into_iter().collect();
    assert_eq!(folders.len(), 8, "{folders:?}");
}

#[test]
fn force_replaces_the_results_and_nothing_else() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    desk.succeeds(&["run", "column.toml", "--out", "mine"]);
    fs::write(desk.path("mine/notes.txt"), "mine").unwrap();
    desk.succeeds(&["run", "column.toml", "--out", "mine", "--force", "--set", "time.end=20"]);
    let results = desk.results("mine");
    assert_eq!(results.history().column("time"), [0.0, 10.0, 20.0]);
    assert_eq!(results.names("fields").len(), 6, "fields of the run before are gone");
    assert_eq!(results.text("notes.txt"), "mine");
    // The same with results of its own in the numbered series: the first is replaced.
    desk.succeeds(&["run", "column.toml"]);
    desk.succeeds(&["run", "column.toml", "--force"]);
    assert_eq!(desk.results("results").names(""), ["column"]);
}

#[test]
fn force_keeps_a_figure_that_somebody_added() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    desk.succeeds(&["run", "column.toml", "--out", "mine"]);
    fs::write(desk.path("mine/figures/comparison.pdf"), "mine").unwrap();
    desk.succeeds(&["run", "column.toml", "--out", "mine", "--force"]);
    assert_eq!(fs::read_to_string(desk.path("mine/figures/comparison.pdf")).unwrap(), "mine");
}

#[test]
fn a_run_never_changes_its_case_file() {
    for arguments in [&["--out", "."][..], &["--out", ".", "--force"], &["--out", "../case"]] {
        let desk = Desk::new();
        fs::create_dir(desk.path("case")).unwrap();
        fs::write(desk.path("case/case.toml"), COLUMN_1D).unwrap();
        let mut command = desk.command(&[&["run", "case.toml", "--set", "time.end=20"], arguments].concat());
        let output = command.current_dir(desk.path("case")).output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 2)), "{output:?}");
        assert_eq!(fs::read_to_string(desk.path("case/case.toml")).unwrap(), COLUMN_1D, "{arguments:?}");
    }
}

#[test]
fn a_folder_with_other_things_loses_none_of_them() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    fs::create_dir(desk.path("mine")).unwrap();
    fs::write(desk.path("mine/history.csv"), "written by hand").unwrap();
    let ended = desk.tsutsumi(&["run", "column.toml", "--out", "mine"]);
    assert_eq!(fs::read_to_string(desk.path("mine/history.csv")).unwrap(), "written by hand");
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
}
