//! Studies from file to folder, with a column that runs in milliseconds.

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use tsutsumi_reference::consolidation::{Layer, Ramp};

use super::*;
use crate::{CaseError, Outcome, Progress, Registry, Silent, Wish};

const STUDY: &str = include_str!("tests/study.toml");
const COLUMN: &str = include_str!("tests/column.toml");
/// In minutes and kilopascals: 0 Pa at 0 s, 30 Pa at 60 s, 40 Pa at 240 s, and a gap.
const ELSEWHERE: &str = "# by hand\nt (min), p (kPa)\n0, 0.0\n1, 0.03\n2,\n4, 0.04\n";

/// Theory for the column, in its own words.
const LAYER: Layer = Layer {
    height: 8.0,
    modulus: 16.5e6,
    conductivity: 5.52e-5,
    unit_weight: 9800.0,
    fluid_compressibility: 0.4 / 2.2e9,
};
const RAMP: Ramp = Ramp { load: 50.0, duration: 100.0 };

/// A folder of its own for a test, with the study and its files below `study`; removed at the end.
struct Desk(PathBuf);

impl Desk {
    fn new(test: &str, study: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("tsutsumi-study-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("study")).unwrap();
        let desk = Desk(folder);
        fs::write(desk.path("study/study.toml"), study).unwrap();
        fs::write(desk.path("study/column.toml"), COLUMN).unwrap();
        fs::write(desk.path("study/elsewhere.csv"), ELSEWHERE).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn read(&self) -> Result<Study, CaseError> {
        Study::read(self.path("study/study.toml"), &Registry::built_in(), &[])
    }

    fn options(&self) -> StudyOptions {
        StudyOptions { out: Some(self.path("out")), ..Default::default() }
    }

    fn run(&self) -> StudySummary {
        run_study(&self.read().unwrap(), &Registry::built_in(), &self.options(), &Silent).unwrap()
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// The columns of a CSV file by name; empty cells are NaN.
    fn columns(&self, name: &str) -> Vec<(String, Vec<f64>)> {
        let mut reader = csv::Reader::from_path(self.path(name)).unwrap();
        let mut columns: Vec<_> = reader.headers().unwrap().iter().map(|name| (name.to_owned(), Vec::new())).collect();
        for row in reader.records() {
            for (column, cell) in columns.iter_mut().zip(&row.unwrap()) {
                column.1.push(if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() });
            }
        }
        columns
    }

    fn column(&self, file: &str, name: &str) -> Vec<f64> {
        let columns = self.columns(file);
        let found = columns.iter().find(|(known, _)| known == name);
        found.unwrap_or_else(|| panic!("{file} has no {name}: {columns:?}")).1.clone()
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The study without its figures, which take most of the time.
fn without_figures() -> String {
    STUDY.split("[[figures]]").next().unwrap().to_owned()
}

fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the sample does not hold {from:?}");
        text.replacen(from, to, 1)
    })
}

fn row<'a>(summary: &'a StudySummary, variant: &str, reference: &str, quantity: &str) -> &'a Row {
    let wanted = |row: &&Row| {
        row.variant == variant
            && row.reference.as_deref() == Some(reference)
            && row.quantity.as_deref() == Some(quantity)
    };
    summary.rows.iter().find(wanted).unwrap()
}

/// The same sums of products in another order: a few units of the last digit.
fn assert_close(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-12 * expected.abs(), "{value:e} is not {expected:e}");
}

/// The table against the same numbers worked out here from the histories on disk and the solution itself.
#[test]
fn the_table_holds_the_differences() {
    let desk = Desk::new("table", STUDY);
    let summary = desk.run();
    assert_eq!(summary.outcome, Outcome::Finished);
    let history = "out/runs/mpm2/history.csv";
    let (time, settlement) = (desk.column(history, "time"), desk.column(history, "settlement.surface"));
    assert_eq!(time.len(), 21, "the study's `set` is in the case");
    let theory: Vec<f64> = time.iter().map(|time| LAYER.settlement(RAMP, *time)).collect();
    // The window begins at 10 s, the second row.
    let differences: Vec<f64> = (1..21).map(|i| (settlement[i] - theory[i]).abs()).collect();
    let errors = row(&summary, "mpm2", "theory", "settlement.surface").errors.unwrap();
    assert_close(errors.max, differences.iter().copied().fold(0.0, f64::max));
    assert_close(errors.rms, (differences.iter().map(|d| d * d).sum::<f64>() / 20.0).sqrt());
    assert_close(errors.largest_reference, theory[20]);
    assert_eq!(errors.points, 20);

    // Rates stand at the middles: 15, 25, … 195 s.
    let rate = |values: &[f64], i: usize| (values[i + 1] - values[i]) / (time[i + 1] - time[i]);
    let largest = (1..20).map(|i| (rate(&settlement, i) - rate(&theory, i)).abs()).fold(0.0, f64::max);
    let errors = row(&summary, "mpm2", "theory", "rate(settlement.surface)").errors.unwrap();
    assert_close(errors.max, largest);
    assert_eq!(errors.points, 19);

    // The file: linear between its points in time, in seconds and pascals; its gap is no point.
    let pressure = desk.column(history, "base.pressure");
    let measured = |t: f64| if t <= 60.0 { 0.5 * t } else { 30.0 + (t - 60.0) / 18.0 };
    let largest = (1..21).map(|i| (pressure[i] - measured(time[i])).abs()).fold(0.0, f64::max);
    let errors = row(&summary, "mpm2", "elsewhere", "base.pressure").errors.unwrap();
    assert_close(errors.max, largest);

    let names: Vec<_> = summary.rows.iter().map(|row| row.reference.clone().unwrap()).collect();
    assert_eq!(names.iter().filter(|name| *name == "fine").count(), 4, "a quantity that is not given is not compared");
    let csv = desk.text("out/table.csv");
    assert_eq!(csv.lines().count(), 1 + summary.rows.len());
    assert!(desk.text("out/table.md").contains("| mpm2    | theory    | settlement.surface "));
}

/// A run held against itself differs in nothing, and one held against other columns by what those differ.
#[test]
fn a_reference_can_be_a_run() {
    let reference = "[[references]]\nname = \"same\"\nset = {}\n\n[[references]]\nname = \"other\"\nset = {}\n\
                     quantities = { \"settlement.surface\" = \"settlement.particles\" }\n";
    let text = format!("title = \"t\"\ncase = \"column.toml\"\n[[variants]]\nname = \"mpm1\"\n{reference}");
    let desk = Desk::new("run", &text);
    let summary = desk.run();
    let zero = summary.rows.iter().filter(|row| row.reference.as_deref() == Some("same"));
    let zero: Vec<_> = zero.map(|row| (row.quantity.clone().unwrap(), row.errors.unwrap().max)).collect();
    let quantities = [
        "base.pressure",
        "energy.kinetic",
        "energy.potential",
        "energy.strain",
        "energy.total",
        "noise.velocity",
        "outflow",
        "settlement.particles",
        "settlement.surface",
    ];
    assert_eq!(zero, quantities.map(|name| (name.to_owned(), 0.0)));
    let history = "out/runs/mpm1/history.csv";
    let (surface, particles) =
        (desk.column(history, "settlement.surface"), desk.column(history, "settlement.particles"));
    let largest = surface.iter().zip(&particles).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert_eq!(row(&summary, "mpm1", "other", "settlement.surface").errors.unwrap().max, largest);
}

/// The numbers of the figures are the histories and the solution, in the units of the axes.
#[test]
fn figures_come_with_their_numbers() {
    let desk = Desk::new("figures", STUDY);
    let summary = desk.run();
    assert!(summary.figures.iter().all(|figure| figure.problem.is_none() && figure.note.is_none()), "{summary:?}");
    for name in ["pressure", "both", "particles"] {
        let svg = desk.text(&format!("out/figures/{name}.svg"));
        roxmltree::Document::parse(&svg).unwrap();
        assert!(fs::read(desk.path(&format!("out/figures/{name}.png"))).unwrap().starts_with(b"\x89PNG"));
    }
    let (file, history) = ("out/figures/pressure.csv", "out/runs/mpm1/history.csv");
    let time = desk.column(file, "time (s)");
    // Rows every 10 s, rates at the middles between them, and the file's last point at 240 s.
    let middles = (0..41).map(|i| 5.0 * f64::from(i));
    assert!(time.iter().zip(middles.chain([240.0])).all(|(time, expected)| (time - expected).abs() < 1e-9), "{time:?}");
    let drawn = desk.column(file, "mpm1: base.pressure (kPa)");
    let pressure = desk.column(history, "base.pressure");
    for (i, value) in pressure.iter().enumerate() {
        assert_close(drawn[2 * i], 1e-3 * value);
        assert!(2 * i + 1 >= 41 || drawn[2 * i + 1].is_nan());
    }
    let theory = desk.column(file, "theory: base.pressure (kPa)");
    assert_close(theory[20], 1e-3 * LAYER.pressure(RAMP, 7.5, 100.0));
    let labels: Vec<String> = words(&desk.text("out/figures/pressure.svg"));
    for label in ["MPM①", "MPM②", "theory", "elsewhere", "fine", "pressure at the base (kPa)", "time (s)"] {
        assert!(labels.iter().filter(|known| *known == label).count() == 1, "{label}: {labels:?}");
    }
    let labels = words(&desk.text("out/figures/both.svg"));
    for label in ["MPM②, pressure at the base", "MPM②, surface", "theory, surface", "settlement (mm)"] {
        assert!(labels.contains(&label.to_owned()), "{label}: {labels:?}");
    }
}

/// The words of an SVG.
fn words(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    document.descendants().filter_map(|node| node.attribute("aria-label").map(String::from)).collect()
}

/// The place of the drawn top particles is their place at the start less their settlement times the magnification, and the
/// boxes still touch.
#[test]
fn particles_are_drawn_where_the_magnification_puts_them() {
    let desk = Desk::new("particles", STUDY);
    desk.run();
    let file = "out/figures/particles.csv";
    let (up, half) = (desk.column(file, "up (m)"), desk.column(file, "half height (m)"));
    let settlement = desk.column("out/runs/mpm1/history.csv", "settlement.particles")[10];
    // A displacement is a difference of positions of 8 m: it has 1e-15 of these, times the magnification.
    assert!((up[15] - (7.75 - 1e4 * settlement)).abs() < 1e-10, "{up:?}");
    for i in 0..15 {
        let gap = (up[i + 1] - half[i + 1]) - (up[i] + half[i]);
        // Linear shape functions move particles as they strain them: boxes that touch stay so, but for the square of strains
        // of 3e-6, magnified. Sizes that are not magnified leave gaps of up to 1e-2.
        assert!(gap.abs() < 1e-6, "{i}: {gap}");
    }
    let pressure = desk.column(file, "pore pressure (kPa)");
    assert_close(pressure[0], 1e-3 * desk.column("out/runs/mpm1/history.csv", "base.pressure")[10]);
    assert!(words(&desk.text("out/figures/particles.svg")).contains(&"t = 100 s, displacements × 10000".to_owned()));
}

#[test]
fn another_time_than_the_one_asked_for_is_told() {
    let desk = Desk::new("time", &edited(STUDY, &[("time = 100.0", "time = 130.0")]));
    let figures = desk.run().figures;
    let note = figures[2].note.clone().unwrap();
    assert!(note.starts_with("shows 150 s, the nearest to 130 s"), "{note}");
}

/// What happened to each run: whether it was reused.
fn reused(summary: &StudySummary) -> Vec<bool> {
    summary.runs.iter().map(|run| run.reused).collect()
}

#[test]
fn finished_runs_are_taken_over_until_something_changes() {
    let desk = Desk::new("reuse", &without_figures());
    let first = desk.run();
    assert_eq!(reused(&first), [false; 3]);
    let second = desk.run();
    assert_eq!(reused(&second), [true; 3]);
    assert_eq!(second.rows, first.rows, "wall times too");

    // One variant is set otherwise.
    let changed = edited(&without_figures(), &[("\"method.velocity_update\" = \"mpm2\"", "\"time.end\" = 150.0")]);
    fs::write(desk.path("study/study.toml"), changed).unwrap();
    assert_eq!(reused(&desk.run()), [true, false, true]);
    // The case changes below all of them.
    fs::write(desk.path("study/column.toml"), edited(COLUMN, &[("porosity = 0.4", "porosity = 0.3")])).unwrap();
    assert_eq!(reused(&desk.run()), [false; 3]);
    // Another program, a history that is gone, a case that somebody changed.
    let inputs = desk.text("out/runs/mpm1/study-run.json");
    fs::write(desk.path("out/runs/mpm1/study-run.json"), inputs.replace("\"size\": ", "\"size\": 1")).unwrap();
    fs::remove_file(desk.path("out/runs/mpm2/history.csv")).unwrap();
    fs::write(desk.path("out/runs/fine/case.toml"), COLUMN).unwrap();
    assert_eq!(reused(&desk.run()), [false; 3]);
    assert_eq!(reused(&desk.run()), [true; 3]);
    let fresh = StudyOptions { fresh: true, ..desk.options() };
    let summary = run_study(&desk.read().unwrap(), &Registry::built_in(), &fresh, &Silent).unwrap();
    assert_eq!(reused(&summary), [false; 3]);
}

#[test]
fn a_run_that_fails_does_not_stop_the_others() {
    // Four times the limit, for a hundred times as long.
    let unstable = "name = \"mpm2\"\nallow_unstable = true\nset = { \"time.step\" = 20.0, \"time.end\" = 2.0e4 }\n";
    let name = "name = \"mpm2\"\nlabel = \"MPM②\"\nset = { \"method.velocity_update\" = \"mpm2\" }\n";
    let desk = Desk::new("failure", &edited(STUDY, &[(name, unstable)]));
    let summary = desk.run();
    let Outcome::Failed(reason) = &summary.outcome else { panic!("{:?}", summary.outcome) };
    assert!(reason.starts_with("mpm2: at t = "), "{reason}");
    let finished: Vec<bool> = summary.runs.iter().map(RunReport::is_finished).collect();
    assert_eq!(finished, [true, false, true]);
    assert!(row(&summary, "mpm1", "theory", "base.pressure").errors.is_some());
    let failed = row(&summary, "mpm2", "theory", "base.pressure");
    assert!(failed.errors.is_none() && matches!(failed.outcome, Outcome::Failed(_)));
    let table = summary.table();
    assert!(table.lines().any(|line| line.starts_with("mpm2") && line.contains(" failed ")), "{table}");
    assert!(desk.text("out/table.md").contains("`mpm2` failed: at t = "));
    assert_eq!(summary.figures[0].note.as_deref(), Some("drawn without `mpm2`, which did not finish"));
    assert!(!desk.text("out/figures/pressure.csv").contains("mpm2"));
    // It is tried again: nobody takes its results for finished ones.
    assert_eq!(reused(&desk.run()), [true, false, true]);
}

/// Stops the study as soon as one run has ended.
#[derive(Default)]
struct StopsAfterOne {
    ended: AtomicUsize,
    outcomes: Mutex<Vec<Outcome>>,
}

impl StudyObserver for StopsAfterOne {
    fn advanced(&self, _run: usize, _progress: &Progress) -> Wish {
        if self.ended.load(Ordering::Relaxed) > 0 { Wish::Stop } else { Wish::Continue }
    }

    fn ended(&self, _run: usize, report: &RunReport) {
        self.ended.fetch_add(1, Ordering::Relaxed);
        self.outcomes.lock().unwrap().push(report.outcome.clone());
    }
}

#[test]
fn an_interrupted_study_keeps_what_has_finished() {
    let desk = Desk::new("interrupt", STUDY);
    let options = StudyOptions { threads: NonZeroUsize::new(1), ..desk.options() };
    let observer = StopsAfterOne::default();
    let summary = run_study(&desk.read().unwrap(), &Registry::built_in(), &options, &observer).unwrap();
    assert_eq!(summary.outcome, Outcome::Interrupted);
    let outcomes = observer.outcomes.into_inner().unwrap();
    assert_eq!(outcomes, [Outcome::Finished, Outcome::Interrupted, Outcome::Interrupted]);
    assert!(row(&summary, "mpm1", "theory", "base.pressure").errors.is_some(), "the table holds what there is");
    assert!(!desk.path("out/runs/fine").exists(), "what had not begun does not begin");
    let manifest: serde_json::Value = serde_json::from_str(&desk.text("out/study.json")).unwrap();
    assert_eq!(manifest["outcome"]["kind"], "interrupted");
    let summary = desk.run();
    assert_eq!((reused(&summary), summary.outcome), (vec![true, false, false], Outcome::Finished));
}

/// The number of threads changes nothing but the time.
#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let desk = Desk::new("threads", STUDY);
    let tables = [1, 3].map(|threads| {
        let options = StudyOptions { threads: NonZeroUsize::new(threads), fresh: true, ..desk.options() };
        let summary = run_study(&desk.read().unwrap(), &Registry::built_in(), &options, &Silent).unwrap();
        let errors: Vec<_> = summary.rows.iter().map(|row| (row.variant.clone(), row.errors)).collect();
        (errors, desk.text("out/figures/pressure.csv"))
    });
    assert_eq!(tables[0], tables[1]);
}

/// Linear shape functions and cell-centred pressures are of second order, book "Verification".
#[test]
fn the_order_of_a_refinement_is_that_of_the_method() {
    let study = edited(
        STUDY,
        &[(
            "[[references]]",
            r#"[[sweeps]]
name = "h={grid.spacing}"
lists = [{ "grid.spacing" = [[2.0], [1.0], [0.5]], "grid.cells" = [[5], [10], [20]] }]
set = { "time.step" = 0.01 }

[[refinements]]
name = "spacing"
variants = ["h=2", "h=1", "h=0.5"]
sizes = [2.0, 1.0, 0.5]
size_label = "spacing (m)"

[[figures]]
name = "convergence"
kind = "convergence"
references = ["theory"]
quantities = ["settlement.surface"]

[[references]]"#,
        )],
    );
    let desk = Desk::new("orders", &study);
    let summary = desk.run();
    let wanted = |order: &&Order| order.reference == "theory" && order.quantity == "settlement.surface";
    let orders: Vec<&Order> = summary.orders.iter().filter(wanted).collect();
    assert_eq!(orders.len(), 2);
    for order in &orders {
        // Pre-asymptotic on four to sixteen cells: the error where the load begins to act still falls towards its order.
        assert!((1.8..2.1).contains(&order.rms), "{order:?}");
    }
    assert_eq!((&orders[1].variants, orders[1].sizes), (&["h=1".to_owned(), "h=0.5".to_owned()], [1.0, 0.5]));
    let errors = |name: &str| row(&summary, name, "theory", "settlement.surface").errors.unwrap();
    assert_close(orders[0].max, (errors("h=2").max / errors("h=1").max).log2());
    assert!(summary.table().contains("2 → 1"));
    assert_eq!(desk.text("out/orders.csv").lines().count(), 1 + summary.orders.len());
    let file = fs::read_to_string(desk.path("out/figures/convergence.csv")).unwrap();
    assert_eq!(file.lines().count(), 4, "{file}");
    let label = words(&desk.text("out/figures/convergence.svg")).into_iter().find(|word| word.contains("order"));
    // One line through the three points: between the two orders observed.
    let slope: f64 = label.unwrap().strip_prefix("surface, theory: order ").unwrap().parse().unwrap();
    let ends = [orders[0].max, orders[1].max];
    assert!(slope > ends[0].min(ends[1]) - 0.01 && slope < ends[0].max(ends[1]) + 0.01, "{slope}: {ends:?}");
}

#[test]
fn lists_of_one_table_advance_together_and_tables_multiply() {
    let sweep = r#"
[[sweeps]]
name = "{method.velocity_update} {grid.spacing}"
lists = [
    { "method.velocity_update" = ["mpm1", "mpm2"] },
    { "grid.spacing" = [[1.0], [0.5]], "grid.cells" = [[10], [20]] },
]
"#;
    let desk = Desk::new("sweep", &(STUDY.to_owned() + sweep));
    let study = desk.read().unwrap();
    let names: Vec<&str> = study.runs().collect();
    assert_eq!(names, ["mpm1", "mpm2", "mpm1 1", "mpm1 0.5", "mpm2 1", "mpm2 0.5", "fine"]);
    let settings: Vec<&str> = study.runs[5].source.overrides().collect();
    let expected = ["output.every=10.0", "method.velocity_update=\"mpm2\"", "grid.cells=[20]", "grid.spacing=[0.5]"];
    assert_eq!(settings, expected);
}

/// Edits of the good study, and of nothing else.
const BAD_STUDIES: &[(&str, &[(&str, &str)])] = &[
    ("unknown key", &[("set = { \"method", "sett = { \"method")]),
    ("unknown key of a figure", &[("magnification", "magnificaton")]),
    ("case key in a study", &[("title = \"Small", "dimension = 1\ntitle = \"Small")]),
    ("missing case", &[("case = \"column.toml\"\n", "")]),
    (
        "variants in single brackets",
        &[("[[variants]]\nname = \"mpm1\"\nlabel = \"MPM①\"\n", ""), ("[[variants]]", "[variants]")],
    ),
    (
        "no variants",
        &[
            ("[[variants]]\nname = \"mpm1\"\nlabel = \"MPM①\"\n", ""),
            ("[[variants]]\nname = \"mpm2\"\nlabel = \"MPM②\"\nset = { \"method.velocity_update\" = \"mpm2\" }\n", ""),
        ],
    ),
    ("no such case file", &[("column.toml", "colunm.toml")]),
    ("value that the case refuses", &[("\"mpm2\" }", "\"mpm3\" }")]),
    ("key that the case does not know", &[("\"method.velocity_update\"", "\"method.velocity\"")]),
    ("wrong type in the case", &[("\"output.every\" = 10.0", "\"output.every\" = \"often\"")]),
    ("path without quotes", &[("\"method.velocity_update\" =", "method.velocity_update =")]),
    ("unstable step", &[("\"method.velocity_update\" = \"mpm2\"", "\"time.step\" = 9.0")]),
    ("element that the case does not have", &[("\"method.velocity_update\"", "\"loads.3.traction\"")]),
    ("two of the same name", &[("name = \"mpm2\"", "name = \"MPM1\"")]),
    ("name that is no folder", &[("name = \"mpm2\"", "name = \"a/b\"")]),
    ("unknown solution", &[("\"consolidation\"", "\"consolidatoin\"")]),
    ("unknown parameter", &[("modulus = 16.5e6", "young = 16.5e6")]),
    ("parameter out of range", &[("porosity = 0.4", "porosity = 40.0")]),
    ("unknown quantity of a solution", &[("= \"settlement\", \"base", "= \"settlements\", \"base")]),
    ("depth below the layer", &[("pressure_at_depth = 7.5", "pressure_at_depth = 8.5")]),
    ("no such file", &[("elsewhere.csv", "nowhere.csv")]),
    ("no such column", &[("column = \"p (kPa)\"", "column = \"p\"")]),
    ("time column that is none", &[("{ column = \"t (min)\", factor = 60.0 }", "3")]),
    (
        "no such column of a run",
        &[("= \"settlement.surface\" }\n\n[comparison]", "= \"settlement\" }\n\n[comparison]")],
    ),
    ("reference without a source", &[("solution = \"consolidation\"\n", "")]),
    ("reference with two sources", &[("file = \"elsewhere.csv\"", "file = \"elsewhere.csv\"\nset = {}")]),
    ("quantity that nobody has", &[("[\"settlement.surface\", \"base", "[\"settlement\", \"base")]),
    ("window backwards", &[("[10.0, 200.0]", "[200.0, 10.0]")]),
    ("figure of unknown kind", &[("\"particles\"\nvariant", "\"particle\"\nvariant")]),
    ("figure without a time", &[("time = 100.0\n", "")]),
    ("key of another kind of figure", &[("magnification = 1.0e4", "magnification = 1.0e4\nbelow = [\"outflow\"]")]),
    ("figure with an unknown variant", &[("variants = [\"mpm2\"]", "variants = [\"mpm22\"]")]),
    (
        "two units on one axis",
        &[("quantities = [\"base.pressure\"]\nbelow", "quantities = [\"base.pressure\", \"outflow\"]\nbelow")],
    ),
    (
        "lists of different lengths",
        &[(
            "[comparison]",
            "[[sweeps]]\nname = \"{time.end}\"\nlists = [{ \"time.end\" = [1.0, 2.0], \"time.step\" = [0.1] }]\n\n[comparison]",
        )],
    ),
    (
        "pattern without its list",
        &[(
            "[comparison]",
            "[[sweeps]]\nname = \"{time.ent}\"\nlists = [{ \"time.end\" = [1.0, 2.0] }]\n\n[comparison]",
        )],
    ),
    (
        "variants of a sweep of one name",
        &[("[comparison]", "[[sweeps]]\nname = \"all\"\nlists = [{ \"time.end\" = [1.0, 2.0] }]\n\n[comparison]")],
    ),
    (
        "refinement with an unknown variant",
        &[(
            "[comparison]",
            "[[refinements]]\nname = \"h\"\nvariants = [\"mpm1\", \"fine\"]\nsizes = [1.0, 2.0]\n\n[comparison]",
        )],
    ),
    (
        "problem without variants",
        &[("[comparison]", "[[problems]]\nname = \"column\"\nerror = \"error.displacement\"\n\n[comparison]")],
    ),
    (
        "sweep of a problem that is not there",
        &[(
            "[comparison]",
            "[[sweeps]]\nname = \"{time.end}\"\nproblem = \"bar\"\nlists = [{ \"time.end\" = [1.0, 2.0] }]\n\n[comparison]",
        )],
    ),
    (
        "refinement of a sweep by a key without a list",
        &[(
            "[comparison]",
            "[[sweeps]]\nname = \"{time.end}\"\nlists = [{ \"time.end\" = [1.0, 2.0] }]\nrefine = { key = \"grid.spacing\", name = \"h\" }\n\n[comparison]",
        )],
    ),
    (
        "refinement of a sweep by words",
        &[(
            "[comparison]",
            "[[sweeps]]\nname = \"{method.shape}\"\nlists = [{ \"method.shape\" = [\"linear\", \"gimp\"] }]\nrefine = { key = \"method.shape\", name = \"h\" }\n\n[comparison]",
        )],
    ),
];

/// The messages for bad studies; read what you accept.
#[test]
fn bad_studies_are_told_with_place_and_cure() {
    let desk = Desk::new("bad", STUDY);
    let mut gallery = String::new();
    for (name, edits) in BAD_STUDIES {
        fs::write(desk.path("study/study.toml"), edited(STUDY, edits)).unwrap();
        let error = desk.read().err().unwrap_or_else(|| panic!("{name} was accepted"));
        let message = error.render(false).replace(desk.0.to_str().unwrap(), "FOLDER");
        gallery += &format!("## {name}\n{message}\n\n");
    }
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path("tests/snapshots");
    settings.bind(|| insta::assert_snapshot!("bad_studies", gallery));
}

#[test]
fn a_study_that_is_not_there_is_called_a_study() {
    let error = |path: &Path| Study::read(path, &Registry::built_in(), &[]).err().unwrap().render(false);
    let desk = Desk::new("missing", "");
    assert!(error(&desk.path("nothing.toml")).contains("there is no study file"));
    assert!(error(&desk.path("study")).contains("study.toml"));
    assert!(error(&desk.path("study/study.toml")).contains("a study needs at least title, case and variants"));
}

/// Settings from the command line come last, and are shown as such where they are wrong.
#[test]
fn settings_from_outside_come_last() {
    let desk = Desk::new("outside", STUDY);
    let read = |setting: &str| Study::read(desk.path("study/study.toml"), &Registry::built_in(), &[setting.to_owned()]);
    let study = read("output.every=50.0").unwrap();
    assert!(study.runs.iter().all(|run| run.case.output.every == 50.0));
    let error = read("output.every=-1").err().unwrap().render(false);
    assert!(error.contains("--set output.every=-1") && error.contains("in the variant `mpm1`"), "{error}");
    assert!(!error.contains("mpm2"), "one problem, one message: {error}");
}

#[test]
fn a_folder_of_something_else_is_left_alone() {
    let desk = Desk::new("claim", &without_figures());
    fs::create_dir_all(desk.path("out")).unwrap();
    fs::write(desk.path("out/thesis.txt"), "years of work").unwrap();
    let study = desk.read().unwrap();
    let refusal = run_study(&study, &Registry::built_in(), &desk.options(), &Silent).err().unwrap().to_string();
    assert!(refusal.contains("is not empty and holds no study") && refusal.contains("--out"), "{refusal}");
    fs::remove_file(desk.path("out/thesis.txt")).unwrap();
    run_study(&study, &Registry::built_in(), &desk.options(), &Silent).unwrap();
    fs::copy(desk.path("study/study.toml"), desk.path("study/other.toml")).unwrap();
    let other = Study::read(desk.path("study/other.toml"), &Registry::built_in(), &[]).unwrap();
    let refusal = run_study(&other, &Registry::built_in(), &desk.options(), &Silent).err().unwrap().to_string();
    assert!(refusal.contains("results of another study") && refusal.contains("study.toml"), "{refusal}");
}

/// The schema accepts and refuses what the program does, as far as a schema can tell.
#[test]
fn the_schema_is_one_and_knows_the_keys() {
    let schema = schema();
    jsonschema::meta::validate(&schema).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let is_valid =
        |text: &str| validator.is_valid(&serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap());
    assert!(is_valid(STUDY));
    let told_by_a_schema = [
        "unknown key",
        "unknown key of a figure",
        "missing case",
        "unknown solution",
        "unknown parameter",
        "unknown quantity of a solution",
        "reference with two sources",
        "figure of unknown kind",
    ];
    for (name, edits) in BAD_STUDIES.iter().filter(|(name, _)| told_by_a_schema.contains(name)) {
        assert!(!is_valid(&edited(STUDY, edits)), "{name}");
    }
}

/// Two problems in one study: every line is made of the rows and histories, and a reference stands for its own problem alone.
#[test]
fn problems_have_a_line_for_every_variant_or_refinement() {
    let desk = Desk::new("problems", include_str!("tests/problems.toml"));
    fs::write(desk.path("study/bar.toml"), include_str!("tests/bar.toml")).unwrap();
    let summary = desk.run();
    assert_eq!(summary.outcome, Outcome::Finished, "{summary:?}");
    let names: Vec<_> = summary.problems.iter().map(|line| (line.problem.as_str(), line.variant.as_str())).collect();
    assert_eq!(names, [("column", "mpm1"), ("column", "mpm2"), ("bar", "mpm1"), ("bar", "mpm2")]);

    let [column, _, bar, damped] = &summary.problems[..] else { panic!("{names:?}") };
    let errors = row(&summary, "column-mpm1", "theory", "settlement.surface").errors.unwrap();
    assert_eq!(column.error, Some(errors.relative()));
    assert_eq!((column.order, column.energy_drift, column.cost), (None, None, Some(1.0)));
    assert!(
        summary.rows.iter().all(|row| row.variant.starts_with("column") || row.reference.as_deref() != Some("theory"))
    );

    // A refinement shows its finest variant, and the order of its two errors.
    assert_eq!(bar.run, "bar-mpm1-0.125");
    let rms = |variant: &str| row(&summary, variant, "exact motion", "error.displacement").errors.unwrap().rms;
    assert_eq!(bar.error, Some(rms("bar-mpm1-0.125")));
    assert_close(bar.order.unwrap(), (rms("bar-mpm1-0.25") / rms("bar-mpm1-0.125")).log2());
    // The window begins at 0.5 s, with the sixth row.
    let energy = &desk.column("out/runs/bar-mpm2-0.125/history.csv", "error.energy")[5..];
    let lost = energy.iter().map(|later| later - energy[0]).fold(0.0, f64::min);
    assert_close(damped.energy_drift.unwrap(), lost);
    assert!(lost < -0.1, "MPM② loses energy: {lost}");
    assert!(bar.noise.is_some_and(|noise| (0.0..1.0).contains(&noise)), "{bar:?}");

    assert_eq!(desk.text("out/problems.csv").lines().count(), 5);
    let table = summary.table();
    assert!(table.starts_with("problem  variant") && table.lines().count() == 5, "{table}");
    assert!(desk.text("out/table.md").contains("| bar     | mpm1 "));
}
