//! Runs that do not reach their end: by Ctrl-C, or because a step fails. What was computed is kept.

use crate::desk::{COLUMN, Desk, Results, edited};

/// The results of a run that ended early are as whole as those of one that did not.
fn assert_whole(results: &Results) {
    let times = results.history().column("time");
    assert!(times[0] == 0.0 && times.is_sorted_by(|a, b| a < b), "{times:?}");
    for collection in ["particles.pvd", "grid.pvd"] {
        let entries = results.collection(collection);
        let of_fields: Vec<f64> = entries.iter().map(|(time, _)| *time).collect();
        assert_eq!(of_fields, times, "{collection}: the fields of every row, the last included");
    }
    assert_eq!(results.manifest()["time"].as_f64(), times.last().copied());
    let figures = results.figures();
    assert!(["particles", "pressure", "settlement"].iter().all(|name| figures.contains(&(*name).to_owned())));
    assert_eq!(
        results.names(""),
        ["case.toml", "fields", "figures", "grid.pvd", "history.csv", "manifest.json", "particles.pvd"]
    );
}

/// A fixed step of three times the limit: the column flies apart within a second.
fn unstable() -> String {
    edited(COLUMN, &[("step = 5.0e-3", "step = 0.03"), ("every = 10.0", "every = 0.1")])
}

#[test]
fn a_run_that_fails_keeps_its_results_and_says_why() {
    let desk = Desk::with("case.toml", unstable());
    let ended = desk.tsutsumi(&["run", "case.toml", "--allow-unstable", "--out", "failed"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""), "{}", ended.stderr);
    let results = desk.results("failed");
    assert_whole(&results);
    let manifest = results.manifest();
    assert_eq!(manifest["outcome"]["kind"], "failed");
    let reason = manifest["outcome"]["reason"].as_str().unwrap();
    assert!(ended.stderr.contains(&format!("error: {reason}\n")), "{}", ended.stderr);
    assert!(
        reason.contains("t = ") && reason.contains("particle ") && reason.contains("pressed to a porosity of"),
        "{reason}"
    );
    assert!(ended.stderr.trim_end().ends_with("in failed"), "where the results are: {}", ended.stderr);
    // Up to the failure it is the run that would have ended earlier.
    let shorter = ["run", "case.toml", "--allow-unstable", "--set", "time.end=0.5", "--out", "shorter"];
    desk.succeeds(&shorter);
    let (failed, shorter) = (results.history(), desk.results("shorter").history());
    assert!(shorter.rows.len() == 6 && failed.rows.len() > 6, "{failed:?}");
    assert_eq!(failed.rows[..6], shorter.rows);
}

#[test]
fn a_failure_is_told_even_quietly() {
    let desk = Desk::with("case.toml", unstable());
    let ended = desk.tsutsumi(&["run", "case.toml", "--allow-unstable", "--quiet"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.starts_with("error: "), "{}", ended.stderr);
}

/// Grains that bear no tension, thrown up from their base.
const THROWN: &str = r#"
title = "Thrown up"
dimension = 2
gravity = [0.0, -9.81]
grid = { origin = [0.0, 0.0], spacing = [1.0, 1.0], cells = [2, 6] }
time = { end = 1.0, step = 1.0e-3 }

[materials.sand]
law = "pressure-elastic"
parameters = { bulk_modulus = 20.0e6, shear_modulus = 12.0e6 }
density = 2000.0

[[bodies]]
material = "sand"
shape = { box = { min = [0.0, 0.0], max = [2.0, 3.0] } }
particles_per_cell = [2, 2]
initial = { velocity = [0.0, 1.0], geostatic = { surface = 3.0, k0 = 0.5 } }

[[supports]]
face = "y-min"
fix = ["x", "y"]

[output]
every = 0.1
"#;

#[test]
fn a_law_that_fails_leaves_an_element_test_that_fails_alike() {
    let desk = Desk::with("case.toml", THROWN);
    let ended =
        desk.tsutsumi(&["run", "case.toml", "--set", "materials.sand.parameters.exponent=0.6", "--out", "failed"]);
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    let words = "the mean effective pressure is ";
    let told = ended.stderr.lines().find(|line| line.contains(words)).unwrap_or_else(|| panic!("{}", ended.stderr));
    let reason = &told[told.find(words).unwrap()..];
    let path = format!("failed{}failed-point.toml", std::path::MAIN_SEPARATOR);
    assert!(ended.stderr.contains(&format!("the point is kept as an element test: {path}\n")), "{}", ended.stderr);
    let text = std::fs::read_to_string(desk.path(&path)).unwrap();
    assert!(text.contains("exponent = 0.6"), "what was set on the command line counts: {text}");
    let again = desk.tsutsumi(&["element-test", &path, "--quiet"]);
    assert_eq!(again.code, Some(1));
    assert!(again.stderr.starts_with("error: stage 1 (increment), increment 1: the law failed: "), "{}", again.stderr);
    assert!(again.stderr.contains(reason), "{reason}: {}", again.stderr);
}

#[cfg(unix)]
mod interrupted {
    use std::fs;
    use std::io::{BufRead, BufReader};
    use std::process::{Child, Command};
    use std::time::{Duration, Instant};

    use super::*;

    /// Longer than anything here takes on a busy machine.
    const PATIENCE: Duration = Duration::from_secs(30);
    const BETWEEN_LOOKS: Duration = Duration::from_millis(10);

    /// A run that is ended whatever becomes of the test.
    struct Running(Child);

    impl Drop for Running {
        fn drop(&mut self) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    impl Running {
        /// A run for years of ground time, with a row every so often (s).
        fn start(desk: &Desk, every: &str) -> Self {
            let every = format!("output.every={every}");
            let arguments = ["run", "case.toml", "--set", "time.step=auto", "--set", "time.end=1e9", "--set", &every];
            Running(desk.command(&arguments).spawn().unwrap())
        }

        fn signal(&self, name: &str) {
            let status = Command::new("sh").args(["-c", &format!("kill -{name} {}", self.0.id())]).status().unwrap();
            assert!(status.success());
        }

        /// The exit code, once the run has ended.
        fn code(&mut self) -> Option<i32> {
            wait_for("the run to end", || self.0.try_wait().unwrap()).code()
        }
    }

    fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
        let started = Instant::now();
        loop {
            if let Some(found) = look() {
                return found;
            }
            assert!(started.elapsed() < PATIENCE, "waited in vain for {what}");
            std::thread::sleep(BETWEEN_LOOKS);
        }
    }

    /// Waits until the history has some complete rows.
    fn wait_for_rows(desk: &Desk, count: usize) {
        let history = desk.path("results/case/history.csv");
        wait_for("rows in the history", || {
            let text = fs::read_to_string(&history).unwrap_or_default();
            (text.lines().count() > count).then_some(())
        });
    }

    fn a_signal_ends_a_run_with_its_results(signal: &str, every: &str) {
        let desk = Desk::with("case.toml", COLUMN);
        let mut run = Running::start(&desk, every);
        wait_for_rows(&desk, 5);
        run.signal(signal);
        assert_eq!(run.code(), Some(130));
        let results = desk.results("results/case");
        assert_eq!(results.manifest()["outcome"]["kind"], "interrupted");
        assert!(results.history().rows.len() >= 5);
        assert_whole(&results);
    }

    #[test]
    fn ctrl_c_keeps_what_was_computed() {
        a_signal_ends_a_run_with_its_results("INT", "20.0");
    }

    #[test]
    fn ctrl_c_is_heard_between_outputs_that_follow_each_other_closely() {
        a_signal_ends_a_run_with_its_results("INT", "0.1");
    }

    #[test]
    fn a_system_that_goes_down_is_heard_like_ctrl_c() {
        a_signal_ends_a_run_with_its_results("TERM", "20.0");
    }

    /// The first line of progress comes after two seconds.
    #[test]
    fn progress_without_a_terminal_is_plain_lines() {
        let desk = Desk::with("case.toml", COLUMN);
        let mut run = Running::start(&desk, "1000.0");
        let mut lines = BufReader::new(run.0.stderr.take().unwrap()).lines().map(Result::unwrap);
        let first = lines.next().unwrap();
        assert!(first.starts_with("writing to results/case, step "), "{first}");
        let second = lines.next().unwrap();
        assert!(second.starts_with("step ") && second.contains(" s left"), "{second}");
        run.signal("INT");
        let rest: Vec<String> = lines.collect();
        assert_eq!(run.code(), Some(130));
        let all = [vec![first, second], rest].concat().join("\n");
        assert!(!all.contains(['\u{1b}', '\r', '█']), "{all:?}");
        assert!(all.contains("\ninterrupted at t = "), "{all}");
    }
}
