//! From a run whose law fails to an element test that fails in the same way.

use std::fs;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tsutsumi::law::{ConstitutiveLaw, Increment, LawError, LinearElastic};
use tsutsumi::tensor::{Matrix3, Sym3};

use crate::build::build;
use crate::element::{ElementTest, TestOptions, run_element_test};
use crate::{CaseSource, Outcome, Registry, RunOptions, RunSummary, Silent, run};

const SOIL: LinearElastic = LinearElastic { young: 1e7, poisson: 0.3 };

/// A law that fails at a strain and then tells a number in which every bit of what it was given counts. Of small increments, or of finite
/// strain.
#[derive(Serialize, Deserialize, JsonSchema)]
struct Brittle<const FINITE: bool> {
    /// The strain at which it fails (–).
    limit: f64,
}

/// A history of all that serde may make of one.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Memory {
    phase: Phase,
    strain: Sym3,
    rows: [[f64; 3]; 2],
    steps: u32,
    largest: Option<f64>,
    never: Option<f64>,
    has_moved: bool,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
enum Phase {
    #[default]
    Resting,
    Loaded {
        since: u32,
    },
}

impl<const FINITE: bool> ConstitutiveLaw for Brittle<FINITE> {
    type State = Memory;
    const FINITE_STRAIN: bool = FINITE;

    fn update(&self, stress: Sym3, memory: Memory, strain: Sym3) -> Result<(Sym3, Memory), LawError> {
        self.deform(stress, memory, &Increment { strain, ..Increment::default() })
    }

    fn update_within(
        &self,
        stress: Sym3,
        memory: Memory,
        strain: Sym3,
        duration: f64,
    ) -> Result<(Sym3, Memory), LawError> {
        let mut new = memory;
        new.strain += strain;
        new.rows[1] = [strain.xx, 1.0 / 3.0 + stress.yy, f64::MIN_POSITIVE];
        new.steps += 1;
        new.largest = Some(new.strain.norm().max(memory.largest.unwrap_or(0.0)));
        new.has_moved |= strain != Sym3::ZERO;
        if let (Phase::Resting, true) = (memory.phase, new.has_moved) {
            new.phase = Phase::Loaded { since: new.steps };
        }
        if new.strain.norm() > self.limit {
            let Phase::Loaded { since } = new.phase else { return Err(LawError::Foreign { message: "rests".into() }) };
            let numbers = [memory.strain, stress * 1e-9, strain].map(|a| a.xx + 3.0 * a.yy + 7.0 * a.xy + 11.0 * a.zz);
            let of_history = memory.rows[1][1] * 1e-7 + f64::from(since) + memory.largest.unwrap_or(0.0);
            let residual = numbers.iter().sum::<f64>() + of_history + 1e-3 * duration.min(1.0);
            return Err(LawError::NotConverged { iterations: new.steps as usize, residual });
        }
        let (stress, ()) = SOIL.update(stress, (), strain)?;
        Ok((stress, new))
    }

    /// As laws of finite strain do: stress and history come as they were.
    fn deform(&self, stress: Sym3, memory: Memory, motion: &Increment) -> Result<(Sym3, Memory), LawError> {
        let turn = tsutsumi::tensor::rotation(&motion.spin);
        self.update_within(stress.rotated(&turn), self.rotate_state(memory, &turn), motion.strain, motion.duration)
    }

    fn rotate_state(&self, memory: Memory, rotation: &Matrix3) -> Memory {
        Memory { strain: memory.strain.rotated(rotation), ..memory }
    }

    fn p_wave_modulus(&self, stress: Sym3, _: &Memory) -> f64 {
        SOIL.p_wave_modulus(stress, &())
    }
}

/// A block that is thrown to the side while its base is held: it is sheared and turns.
const BLOCK: &str = r#"
title = "A block \"thrown\""
dimension = 2
grid = { origin = [0.0, 0.0], spacing = [1.0, 1.0], cells = [6, 4] }
time = { end = 1.0, step = 1.0e-3 }

[materials.block]
law = "brittle"
parameters = { limit = 5.0e-3 }
density = 2000.0

[[bodies]]
material = "block"
shape = { box = { min = [2.0, 0.0], max = [4.0, 2.0] } }
particles_per_cell = [2, 2]
initial = { velocity = [1.0, 0.3] }

[[supports]]
face = "y-min"
fix = ["x", "y"]

[output]
every = 0.1
figures = false
"#;

fn registry() -> Registry {
    Registry::built_in().law::<Brittle<false>>("brittle").law::<Brittle<true>>("brittle-finite")
}

/// A folder of its own for a test; removed at the end.
struct Desk(PathBuf);

impl Desk {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("tsutsumi-failed-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        Desk(folder)
    }

    fn run(&self, text: &str, force: bool) -> RunSummary {
        let options = RunOptions { out: Some(self.0.join("run")), force, ..RunOptions::default() };
        run(&CaseSource::from_text("case.toml", text), &registry(), &options, &mut Silent).unwrap()
    }

    /// The words of the law in a run, and in the element test that it leaves.
    fn told(&self, text: &str) -> [String; 2] {
        let summary = self.run(text, false);
        let path = summary.failed_point.unwrap();
        assert_eq!(path, self.0.join("run/failed-point.toml"));
        let test = ElementTest::read(&path, &registry(), &[]).unwrap();
        let options = TestOptions { out: Some(self.0.join("test")), ..TestOptions::default() };
        let again = run_element_test(&test, &registry(), &options, &|| false).unwrap();
        [summary.outcome, again.outcome].map(|outcome| {
            let Outcome::Failed(reason) = outcome else { panic!("{outcome:?}") };
            let start = reason.find("the return mapping").unwrap_or_else(|| panic!("{reason}"));
            let end = start + reason[start..].find(')').unwrap();
            reason[start..=end].to_owned()
        })
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The residual is written with all its digits: the words agree only if every bit does.
#[test]
fn a_law_of_small_increments_fails_again_in_an_element_test() {
    let [run, test] = Desk::new("small").told(BLOCK);
    assert_eq!(run, test);
}

#[test]
fn a_law_of_finite_strain_fails_again_in_an_element_test() {
    let desk = Desk::new("finite");
    let [run, test] = desk.told(&BLOCK.replace("\"brittle\"", "\"brittle-finite\""));
    assert_eq!(run, test);
    let text = fs::read_to_string(desk.0.join("run/failed-point.toml")).unwrap();
    assert!(text.contains("\nspin = [0.0, 0.0, "), "the spin is the law's own to follow: {text}");
    assert!(text.starts_with("# at t = ") && text.contains("duration = 0.001"), "{text}");
}

/// A block in flight is pulled up: error and file are those of the same particle, whatever its place in memory.
#[test]
fn a_particle_that_has_changed_its_place_is_known_by_its_number() {
    let pull = "[[loads]]\non = { of = \"block\", surface = \"y-max\" }\npressure = -1.0e5\nhistory = [[0.06, 0.0], [0.1, 1.0]]\n";
    let text = BLOCK.replace("[[supports]]\nface = \"y-min\"\nfix = [\"x\", \"y\"]\n", pull);
    let text = text.replace("velocity = [1.0, 0.3]", "velocity = [12.0, 6.0]");
    let source = CaseSource::from_text("case.toml", &text);
    let case = source.parse().unwrap();
    let [plain, sorted] = [false, true].map(|is_sorted| {
        let mut simulation = build::<2>(&source, &case, &registry()).unwrap();
        loop {
            if is_sorted {
                simulation.model_mut().sort_in_next_step();
            }
            // So short that no two particles fail at once.
            if let Err(error) = simulation.model_mut().step(1e-5) {
                assert_eq!(simulation.model().particles().numbers().is_sorted(), !is_sorted);
                return (error.to_string(), super::failed_point(&*error, &case, simulation.model()));
            }
        }
    });
    assert!(plain.0.contains("the law of material `block` failed in particle "), "{}", plain.0);
    assert!(plain.1.as_ref().is_some_and(Result::is_ok));
    assert_eq!(plain, sorted);
}

/// The finite elements try increments: the one that was tried is told, without a duration, as it was asked.
#[test]
fn a_law_fails_again_after_a_run_of_finite_elements() {
    let column = include_str!("../case_tests/column.toml");
    let text = column
        .replace("law = \"linear-elastic\"", "law = \"brittle\"")
        .replace("parameters = { young = 4.35e6, poisson = 0.45 }", "parameters = { limit = 1.0e-6 }")
        .replace("[method]", "[method]\nsolver = \"fem\"")
        .replace("step = 5.0e-4", "step = 1.0");
    let [run, test] = Desk::new("fem").told(&text);
    assert_eq!(run, test);
}

#[test]
fn a_later_run_takes_the_element_test_away() {
    let desk = Desk::new("later");
    desk.run(BLOCK, false);
    let path = desk.0.join("run/failed-point.toml");
    assert!(path.exists());
    let short = desk.run(&BLOCK.replace("end = 1.0", "end = 1.0e-3"), true);
    assert_eq!((short.outcome, short.failed_point), (Outcome::Finished, None));
    assert!(!path.exists());
}

/// A law without a history has none in the file, and one whose history TOML does not know is told.
#[test]
fn histories_are_toml_or_the_reason_is_told() {
    assert_eq!(super::written(&()), Ok(None));
    assert_eq!(super::written(&0.1_f64), Ok(Some(toml::Value::Float(0.1))));
    assert!(matches!(super::written(&f64::NAN), Ok(Some(toml::Value::Float(number))) if number.is_nan()));
    let error = super::written(&u64::MAX).unwrap_err();
    assert!(error.starts_with("its history cannot be written as TOML: "), "{error}");
}
