//! A run that reaches its end: what lies in its folder.

use std::fs;

use crate::desk::{COLUMN_1D, Desk, edited};

/// The column and its results in the folder `results/column`.
fn run_column(arguments: &[&str]) -> Desk {
    let desk = Desk::with("column.toml", COLUMN_1D);
    desk.succeeds(&[&["run", "column.toml"], arguments].concat());
    desk
}

#[test]
fn a_run_leaves_a_folder_with_everything() {
    let desk = run_column(&["--set", "time.end=40"]);
    let results = desk.results("results/column");
    assert_eq!(
        results.names(""),
        ["case.toml", "fields", "figures", "grid.pvd", "history.csv", "manifest.json", "particles.pvd"]
    );
    // The case as it ran, comments and all.
    assert_eq!(results.text("case.toml"), edited(COLUMN_1D, &[("end = 50.0", "end = 40")]));
    assert_eq!(fs::read_to_string(desk.path("column.toml")).unwrap(), COLUMN_1D);
    // One file of particles and one of cells for every row.
    for (collection, kind) in [("particles.pvd", "particles"), ("grid.pvd", "grid")] {
        let expected: Vec<_> = (0..5).map(|i| (10.0 * f64::from(i), format!("fields/{kind}-{i:06}.vtu"))).collect();
        assert_eq!(results.collection(collection), expected);
    }
    assert_eq!(results.names("fields").len(), 10);
    let figures = results.figures();
    assert!(["particles", "pressure", "settlement"].iter().all(|name| figures.contains(&(*name).to_owned())));
}

#[test]
fn the_manifest_tells_what_ran_and_how_it_ended() {
    let desk = run_column(&["--set", "time.end=40", "--set", "title=\"Forty\""]);
    let results = desk.results("results/column");
    let manifest = results.manifest();
    assert_eq!(manifest["outcome"]["kind"], "finished");
    assert_eq!(manifest["title"], "Forty");
    assert_eq!(manifest["case"], "column.toml");
    assert_eq!(manifest["overrides"], serde_json::json!(["time.end=40", "title=\"Forty\""]));
    assert_eq!((manifest["particles"].as_u64(), manifest["cells"].as_u64()), (Some(8), Some(5)));
    assert_eq!((manifest["dimension"].as_u64(), manifest["time"].as_f64()), (Some(1), Some(40.0)));
    let performance = &manifest["performance"];
    let steps = *results.history().column("step").last().unwrap();
    assert_eq!(performance["steps"].as_u64(), Some(steps as u64));
    let wall = performance["wall_s"].as_f64().unwrap();
    let speed = performance["particle_steps_per_s"].as_f64().unwrap();
    assert!(wall > 0.0 && (speed * wall / (8.0 * steps) - 1.0).abs() < 1e-9, "{performance}");
    assert_eq!(performance["pressure_iterations"].as_u64(), Some(0), "the direct solver does not iterate");
    // 4 m of 1500 kg/m³; the water that left the ground went through its top.
    let balance = |name: &str| manifest["balances"][name].as_f64().unwrap();
    assert_eq!(balance("mass"), 6000.0);
    assert_eq!(balance("outflow"), *results.history().column("outflow").last().unwrap());
    assert!(balance("outflow") > 0.0);
    assert!(balance("water_error").abs() < 0.02 * balance("outflow"), "{manifest}");
    let sum = balance("outflow") + balance("water_compressed") + balance("water_error");
    assert!((sum - balance("volume_lost")).abs() < 1e-12);
}

#[test]
fn the_history_has_a_row_per_output_in_full_precision() {
    let desk = run_column(&["--set", "time.end=45"]);
    let history = desk.results("results/column").history();
    let columns = [
        "time",
        "step",
        "base.pressure",
        "top.displacement.x",
        "top.velocity.x",
        "settlement.particles",
        "settlement.surface",
        "energy.kinetic",
        "energy.strain",
        "outflow",
        "energy.potential",
        "energy.total",
        "noise.velocity",
    ];
    assert_eq!(history.columns, columns);
    // The last interval is shorter than `every`; the end is met exactly.
    assert_eq!(history.column("time"), [0.0, 10.0, 20.0, 30.0, 40.0, 45.0]);
    let steps = history.column("step");
    assert!(steps[0] == 0.0 && steps.is_sorted_by(|a, b| a < b), "{steps:?}");
    for row in &history.rows {
        for (name, text) in columns.iter().zip(row) {
            let value: f64 = text.parse().unwrap();
            let again = if *name == "step" { format!("{value}") } else { format!("{value:.16e}") };
            assert_eq!(&again, text, "{name}: 17 digits give the number back, and are all there");
        }
    }
    // Settlement is down and grows, the outflow with it.
    let settlement = history.column("settlement.surface");
    assert!(settlement.is_sorted() && *settlement.last().unwrap() > 1e-4, "{settlement:?}");
    assert!(history.column("outflow").is_sorted());
    let falls: Vec<f64> = history.column("top.displacement.x").iter().map(|x| 0.0 - x).collect();
    assert_eq!(history.column("settlement.particles"), falls);
}

#[test]
fn the_same_case_gives_the_same_bits() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    for (out, arguments) in [("once", &[][..]), ("again", &[]), ("threads", &["--threads", "4"])] {
        desk.succeeds(&[&["run", "column.toml", "--out", out], arguments].concat());
    }
    let once = desk.results("once").contents();
    assert_eq!(once.keys().filter(|name| name.ends_with(".vtu")).count(), 12);
    for out in ["again", "threads"] {
        let other = desk.results(out).contents();
        assert!(once.keys().eq(other.keys()), "{out}");
        let differing: Vec<_> =
            once.iter().filter(|(name, bytes)| &other[*name] != *bytes).map(|(name, _)| name).collect();
        assert!(differing.is_empty(), "{out}: {differing:?}");
    }
}

#[test]
fn the_case_in_the_results_runs_again() {
    let desk = run_column(&["--set", "time.end=20", "--set", "loads.0.applied_to=surface"]);
    desk.succeeds(&["run", "results/column/case.toml", "--out", "again"]);
    assert_eq!(desk.results("again").contents(), desk.results("results/column").contents());
}

#[test]
fn figures_and_fields_can_be_fewer() {
    let desk = run_column(&["--set", "output.figures=false", "--set", "output.fields_every=25"]);
    let results = desk.results("results/column");
    assert_eq!(results.names("figures"), Vec::<String>::new());
    // Fields go with the first row at or after each multiple of `fields_every`.
    let times: Vec<f64> = results.collection("particles.pvd").iter().map(|(time, _)| *time).collect();
    assert_eq!(times, [0.0, 30.0, 50.0]);
    assert_eq!(results.history().rows.len(), 6);
}

#[test]
fn quiet_is_silent() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    let ended = desk.succeeds(&["run", "column.toml", "--quiet"]);
    assert_eq!((ended.stdout.as_str(), ended.stderr.as_str()), ("", ""));
}

#[test]
fn a_run_says_where_its_results_are() {
    let desk = Desk::with("column.toml", COLUMN_1D);
    let ended = desk.succeeds(&["run", "column.toml", "--out", "a folder"]);
    assert_eq!(ended.stdout, "", "the standard output is for data");
    let lines: Vec<_> = ended.stderr.lines().collect();
    let [first, cost, last] = lines[..] else { panic!("{lines:?}") };
    assert!(first.starts_with("writing to a folder"), "{first}");
    assert!(cost.contains("t = 50 s"), "{cost}");
    assert_eq!(last, "results in a folder");
}
