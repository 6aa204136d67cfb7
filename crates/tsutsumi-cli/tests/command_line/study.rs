//! `study`: exit codes, what is printed, where results go. What is in them has its tests in `tsutsumi-case`.

use std::fs;

use crate::desk::{COLUMN_1D, Desk};

const STUDY: &str = r#"
title = "Two updates"
case = "column.toml"
set = { "output.figures" = false }

[[variants]]
name = "mpm1"

[[variants]]
name = "mpm2"
set = { "method.velocity_update" = "mpm2" }

[[references]]
name = "fine step"
set = { "time.step" = 0.01 }

[comparison]
quantities = ["base.pressure", "settlement.surface"]

[[figures]]
name = "pressure"
kind = "lines"
quantities = ["base.pressure"]
"#;

/// A desk with a study and its case in a folder below.
fn desk(study: &str) -> Desk {
    let desk = Desk::new();
    fs::create_dir(desk.path("below")).unwrap();
    fs::write(desk.path("below/study.toml"), study).unwrap();
    fs::write(desk.path("below/column.toml"), COLUMN_1D).unwrap();
    desk
}

#[test]
fn a_study_prints_its_table_and_goes_to_the_same_folder_every_time() {
    let desk = desk(STUDY);
    let ended = desk.succeeds(&["study", "below/study.toml"]);
    let lines: Vec<&str> = ended.stdout.lines().collect();
    assert!(lines[0].starts_with("variant  reference  quantity") && lines.len() == 5, "{}", ended.stdout);
    assert!(lines[3].starts_with("mpm2     fine step  base.pressure"), "{}", ended.stdout);
    assert!(ended.stderr.contains("3 runs, writing to results/below-study"), "{}", ended.stderr);
    assert!(ended.stderr.ends_with("results in results/below-study\n"), "{}", ended.stderr);
    let results = desk.results("results/below-study");
    assert_eq!(results.names(""), ["figures", "runs", "study.json", "study.toml", "table.csv", "table.md"]);
    assert_eq!(results.names("runs"), ["fine step", "mpm1", "mpm2"]);
    assert_eq!(results.names("figures"), ["pressure.csv", "pressure.png", "pressure.svg"]);

    let again = desk.succeeds(&["study", "below/study.toml"]);
    assert_eq!(again.stdout, ended.stdout, "the wall times too: nothing was run again");
    assert_eq!(again.stderr.matches("taken over").count(), 3, "{}", again.stderr);
    let set = desk.succeeds(&["study", "below/study.toml", "--set", "time.end=30", "--quiet"]);
    assert_eq!(set.stderr, "");
    let history = desk.results("results/below-study/runs/mpm1").history();
    assert_eq!(history.rows.len(), 4, "the setting holds for every run");
    assert_eq!(desk.names(), ["below", "results"]);
}

#[test]
fn a_study_with_a_mistake_runs_nothing() {
    let desk = desk(&STUDY.replace("\"mpm2\" }", "\"mpm3\" }"));
    let ended = desk.tsutsumi(&["study", "below/study.toml"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(2), ""));
    assert!(ended.stderr.contains("below/study.toml:11:36"), "{}", ended.stderr);
    assert_eq!(desk.names(), ["below"]);
    assert_eq!(desk.tsutsumi(&["study", "nothing.toml"]).code, Some(2));
    let file = desk.tsutsumi(&["study", "below/study.toml", "--set", "method.velocity_update=mpm2", "--out", "below"]);
    assert_eq!(file.code, Some(2), "the folder holds something else: {}", file.stderr);
}

#[test]
fn a_failed_run_is_in_the_table_and_in_the_exit_code() {
    let unstable = "allow_unstable = true\nset = { \"time.step\" = 20.0, \"time.end\" = 2.0e5 }";
    let desk = desk(&STUDY.replace("set = { \"method.velocity_update\" = \"mpm2\" }", unstable));
    let ended = desk.tsutsumi(&["study", "below/study.toml", "--quiet"]);
    assert_eq!(ended.code, Some(1));
    let failed = ended.stdout.lines().filter(|line| line.starts_with("mpm2") && line.contains(" failed "));
    assert_eq!(failed.count(), 2, "{}", ended.stdout);
    assert!(ended.stderr.starts_with("error: mpm2: at t = "), "{}", ended.stderr);
    assert!(ended.stderr.contains("warning: figure pressure: drawn without `mpm2`"), "{}", ended.stderr);
    assert_eq!(desk.results("results/below-study/runs/mpm1").manifest()["outcome"]["kind"], "finished");
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_all_runs_and_keeps_what_has_finished() {
    use std::process::Command;
    use std::time::{Duration, Instant};

    // The first variant ends at once; the other two would take years of ground time.
    let text = STUDY.replace("case = \"column.toml\"", "case = \"long.toml\"");
    let text = text.replace("name = \"mpm1\"\n", "name = \"mpm1\"\ncase = \"column.toml\"\n");
    let desk = desk(&text);
    fs::write(desk.path("below/long.toml"), COLUMN_1D.replace("end = 50.0", "end = 1e9")).unwrap();
    let mut child = desk.command(&["study", "below/study.toml", "--threads", "2"]).spawn().unwrap();
    let started = Instant::now();
    let rows = |run: &str| {
        let text = fs::read_to_string(desk.path(&format!("results/below-study/runs/{run}/history.csv")));
        text.unwrap_or_default().lines().count()
    };
    while !(desk.path("results/below-study/runs/mpm1/study-run.json").exists()
        && rows("mpm2") > 3
        && rows("fine step") > 3)
    {
        // Longer than anything here takes on a busy machine.
        let is_patient = started.elapsed() < Duration::from_secs(30);
        if !is_patient {
            child.kill().unwrap();
        }
        assert!(is_patient, "waited in vain for rows");
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.lines().any(|line| line.starts_with("mpm2") && line.contains(" interrupted ")), "{table}");
    let outcome = |run: &str| {
        let manifest = desk.results(&format!("results/below-study/runs/{run}")).manifest();
        manifest["outcome"]["kind"].as_str().unwrap().to_owned()
    };
    assert_eq!(["mpm1", "mpm2", "fine step"].map(outcome), ["finished", "interrupted", "interrupted"]);
}

#[test]
fn the_schema_of_studies_accepts_the_study() {
    let schema = serde_json::from_str(&Desk::new().succeeds(&["schema", "--study"]).stdout).unwrap();
    let study = serde_json::to_value(STUDY.parse::<toml::Table>().unwrap()).unwrap();
    assert!(jsonschema::validator_for(&schema).unwrap().is_valid(&study));
}
