//! Element tests from file to folder.

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tsutsumi::law::{ConstitutiveLaw, LawError};
use tsutsumi::tensor::Sym3;

use super::*;
use crate::{CaseError, Outcome, Registry, ResultsError};

const CYCLIC: &str = include_str!("tests/cyclic.toml");

/// A spring beside a slider in shear on horizontal planes; whenever it slips the grains settle. Elastic otherwise, with K = 20 MPa and
/// G = 12 MPa.
#[derive(Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Slider {
    /// Stiffness of the spring (Pa).
    spring: f64,
    /// Stiffness of the slider before it slips (Pa).
    stiffness: f64,
    /// Stress at which it slips (Pa).
    strength: f64,
    /// Volume lost per slip (–).
    settling: f64,
    /// Shear strain at which the law fails (–).
    #[serde(default)]
    breaks: Option<f64>,
}

/// What a [`Slider`] remembers.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Memory {
    stress: f64,
    strain: f64,
    slipped: f64,
}

impl ConstitutiveLaw for Slider {
    type State = Memory;

    fn update(&self, stress: Sym3, memory: Memory, strain: Sym3) -> Result<(Sym3, Memory), LawError> {
        let increment = 2.0 * strain.zx;
        let total = memory.strain + increment;
        if self.breaks.is_some_and(|breaks| total.abs() > breaks) {
            return Err(LawError::NotConverged { iterations: 7, residual: 0.5 });
        }
        let trial = memory.stress + self.stiffness * increment;
        let held = trial.clamp(-self.strength, self.strength);
        let slip = (trial - held).abs() / self.stiffness;
        let normal = 20e6 * (strain.trace() + self.settling * slip);
        let off_plane = Sym3 { zx: 0.0, ..strain.deviator() } * 24e6;
        let shear_stress = Sym3 { zx: self.spring * increment + held - memory.stress, ..Sym3::ZERO };
        let memory = Memory { stress: held, strain: total, slipped: memory.slipped + slip };
        Ok((stress + Sym3::IDENTITY * normal + off_plane + shear_stress, memory))
    }

    fn p_wave_modulus(&self, _: Sym3, _: &Memory) -> f64 {
        36e6
    }

    fn outputs(&self) -> &'static [&'static str] {
        &["slipped"]
    }

    fn write_outputs(&self, _: Sym3, memory: &Memory, values: &mut [f64]) {
        values[0] = memory.slipped;
    }
}

fn registry() -> Registry {
    Registry::built_in().law::<Slider>("slider")
}

/// A folder of its own for a test; removed at the end.
struct Desk(PathBuf);

impl Desk {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("tsutsumi-element-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Desk(folder)
    }

    fn options(&self, name: &str) -> TestOptions {
        TestOptions { out: Some(self.0.join(name)), ..Default::default() }
    }

    fn run(&self, text: &str) -> TestSummary {
        let test = ElementTest::from_text("test.toml", text, &registry()).unwrap();
        run_element_test(&test, &registry(), &self.options("out"), &|| false).unwrap()
    }

    /// The result of an example of the repository, which must end well.
    fn example(&self, name: &str) -> TestSummary {
        let path = examples().join(name);
        let test = ElementTest::read(path, &Registry::built_in(), &[]).unwrap();
        let summary = run_element_test(&test, &Registry::built_in(), &self.options(name), &|| false).unwrap();
        assert_eq!(summary.outcome, Outcome::Finished, "{name}");
        summary
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../element-tests")
}

/// The last value of a column.
fn end(summary: &TestSummary, column: &str) -> f64 {
    *summary.record.column(column).unwrap().last().unwrap()
}

/// The specimen's tolerance is 1e-9.
fn close(value: f64, expected: f64, size: f64) {
    assert!((value - expected).abs() < 1e-8 * size, "{value} is not {expected}");
}

fn edited(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(CYCLIC.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the test does not hold {from:?}");
        text.replacen(from, to, 1)
    })
}

/// E = 30 MPa, ν = ¼: G = 12 MPa, K = 20 MPa, E_oed = 36 MPa.
#[test]
fn the_elastic_examples_end_where_theory_does() {
    let desk = Desk::new("elastic");
    let drained = desk.example("triaxial-drained.toml");
    close(end(&drained, "stress_difference"), 30e6 * 0.01, 3e5);
    close(end(&drained, "volumetric_strain"), (1.0 - 2.0 * 0.25) * 0.01, 0.01);
    close(end(&drained, "mean_stress"), 100e3 + 300e3 / 3.0, 3e5);
    let undrained = desk.example("triaxial-undrained.toml");
    close(end(&undrained, "stress_difference"), 3.0 * 12e6 * 0.004, 1e5);
    close(end(&undrained, "excess_pressure"), 12e6 * 0.004, 1e5);
    close(end(&undrained, "pore_pressure_ratio"), 0.48, 1.0);
    let path = desk.example("path-constant-ratio.toml");
    close(end(&path, "stress.xx"), -100e3, 2e5);
    // Plane strain: σ_y = ν (σ_x + σ_z) for the changes of 75 and 150 kPa.
    close(end(&path, "stress.yy"), -25e3 - 0.25 * 225e3, 2e5);
}

/// The undrained path of Modified Cam-Clay ends at p' = p'₀ 2^−Λ, Λ = (λ − κ)/λ = ¾, and q = M p'.
#[test]
fn the_cam_clay_example_ends_at_the_critical_state() {
    let summary = Desk::new("clay").example("cam-clay-undrained.toml");
    let pressure = 200e3 * 0.5_f64.powf(0.75);
    // It comes near to the critical state exponentially with strain; at 30 % a part in a thousand is left at most.
    assert!((end(&summary, "mean_stress") / pressure - 1.0).abs() < 1e-3, "{}", end(&summary, "mean_stress"));
    assert!((end(&summary, "stress_difference") / (1.2 * pressure) - 1.0).abs() < 1e-3);
    // What the total mean stress gains, less what the effective one does: the radial total stress stays.
    let [q, p, u] = ["stress_difference", "mean_stress", "excess_pressure"].map(|name| end(&summary, name));
    close(u, 200e3 + q / 3.0 - p, 2e5);
    let normal = summary.record.column("stage").unwrap().iter().rposition(|stage| *stage == 1.0).unwrap();
    // Normal compression from 100 to 200 kPa: the specific volume falls by λ ln 2.
    close(summary.record.column("void_ratio").unwrap()[normal], 1.0 - 0.2 * 2.0_f64.ln(), 1.0);
}

/// The half cycles in which double amplitudes of 1 % and 7.5 % are reached, from the integration of the law reduced to two scalar equations
/// that its page of the book reports: 35, 14, 5 and 35.5, 14.5, 5.5 cycles, counted in halves that end where the load turns. Here a turn ends
/// ¼, ¾, … cycles: a quarter less, and half a cycle before that is where the half cycle has begun.
#[test]
fn the_resistance_of_the_cyclic_law_is_that_of_another_integration() {
    let summary = Desk::new("oka").example("oka-cyclic-shear.toml");
    let counted = [(0.01, [35.0, 14.0, 5.0]), (0.075, [35.5, 14.5, 5.5])];
    for (value, cycles) in counted {
        let points: Vec<_> = summary.resistance.iter().filter(|point| point.value == value).collect();
        for (point, turns) in points.iter().zip(cycles) {
            let (from, to) = (turns - 0.75, turns - 0.25);
            assert!(point.reached && (from..=to).contains(&point.cycles), "{point:?}: {from} to {to}");
        }
        assert_eq!(points.len(), 3);
    }
}

/// J σ = E_oed ln J along the first stage, each row; E_oed = 1 MPa · 0.7 / (1.3 · 0.4).
#[test]
fn the_oedometer_of_henckys_solid_follows_its_closed_form() {
    let summary = Desk::new("hencky").example("oedometer-hencky.toml");
    let modulus = 1e6 * 0.7 / (1.3 * 0.4);
    let ratio_at = |stress: f64| {
        // σ = −E ln J / J by Newton's method, in ln J.
        (0..50).fold(-0.1_f64, |l, _| l - (stress * l.exp() + modulus * l) / (stress * l.exp() + modulus))
    };
    // Stress at the start is met by a stretch, isotropic: all of this is after it.
    let [start, stress] = [5e3, 400e3];
    let first = summary.record.column("stage").unwrap().iter().rposition(|stage| *stage == 1.0).unwrap();
    let strain = summary.record.column("axial_strain").unwrap()[first];
    let closed = ratio_at(start) - ratio_at(stress);
    // The isotropic stretch at the start has strains of start/3K on all sides rather than start/E_oed on one: below 5 kPa/E of
    // difference. Steps of 1/200 add half their size, relatively.
    assert!((strain - closed).abs() < 5e3 / 1e6 + 0.5 * closed / 200.0, "{strain} {closed}");
    let void_ratio = summary.record.column("void_ratio").unwrap()[first];
    close(void_ratio, 1.9 * (-strain).exp() - 1.0, 1.0);
    // Elastic: on the way back it meets its own way there, to the same order.
    let back = end(&summary, "axial_strain");
    assert!((back - (ratio_at(start) - ratio_at(10e3))).abs() < 5e3 / 1e6 + 0.5 * closed / 50.0, "{back}");
}

/// Neo-Hookean shear under constant vertical stress is σ_zx = μ γ / J; the increments of strain are spin-free here, so that it holds
/// for small strains only: at the smallest amplitude the stiffness is G.
#[test]
fn the_neo_hookean_example_turns_at_its_amplitude() {
    let summary = Desk::new("rubber").example("simple-shear-neo-hookean.toml");
    let strain = summary.record.column("shear_strain").unwrap();
    let stress = summary.record.column("shear_stress").unwrap();
    close(strain.iter().copied().fold(0.0, f64::max), 0.2, 0.2);
    close(end(&summary, "axial_stress"), 20e3, 2e4);
    assert_eq!(summary.stages[0].cycles, Some(2.0));
    // The first increment, γ = 0.005: b = I + O(γ²), and the vertical stress at the start is 2 % of E.
    assert!((stress[1] / (strain[1] * 1e6 / 2.6) - 1.0).abs() < 0.06, "{}", stress[1] / strain[1]);
}

/// Slip and cycles by hand. γ_a = (τ_a − 8 kPa)/2 MPa, γ_y = 1e-3. r_u = K β Σ slip / σ'_v0 = 20 Σ slip = 0.95 needs Σ slip = 0.0475:
/// γ_a − γ_y in the first quarter, 2 (γ_a − γ_y) in each half cycle after.
fn cycles_to_ratio(stress_ratio: f64) -> f64 {
    let amplitude = stress_ratio * 100e3;
    let slip = (amplitude - 8e3) / 2e6 - 1e-3;
    let left = 0.0475 - slip;
    let halves = (left / (2.0 * slip)).floor();
    let slips_in_last = left - halves * 2.0 * slip;
    // It slips on the last part of a leg, where the stress changes by the spring alone.
    let stress_left = (2.0 * slip - slips_in_last) * 2e6;
    0.25 + 0.5 * halves + 0.5 * (1.0 - stress_left / (2.0 * amplitude))
}

#[test]
fn cycles_to_liquefaction_are_those_counted_by_hand() {
    let desk = Desk::new("resistance");
    let summary = desk.run(CYCLIC);
    assert_eq!(summary.outcome, Outcome::Finished);
    let point = |criterion: &str, ratio: f64| {
        let found = summary.resistance.iter().find(|p| p.criterion == criterion && p.stress_ratio == ratio);
        found.unwrap_or_else(|| panic!("{criterion} {ratio}"))
    };
    // 10 kPa: γ_a = 1e-3 = γ_y. It never slips.
    for ratio in [0.10, 0.07] {
        let never = point("pore_pressure_ratio", ratio);
        assert!(!never.reached && never.cycles == 100.0, "{never:?}");
    }
    for ratio in [0.12, 0.16] {
        let point = point("pore_pressure_ratio", ratio);
        // One increment of strain beyond: spring stiffness × increment, as part of twice the amplitude.
        let beyond = 0.5 * 2e6 * 1e-5 / (2.0 * ratio * 100e3);
        let over = point.cycles - cycles_to_ratio(ratio);
        assert!(point.reached && over > -1e-9 && over < beyond + 1e-9, "{point:?} {over}");
    }
    // Twice γ_a is 4e-3 at 12 kPa, and 8e-3 at 16 kPa: there the second leg passes 5e-3.
    assert!(!point("double_strain", 0.12).reached);
    let double = point("double_strain", 0.16);
    // From the turn on, 2e-3 of strain cost 20 kPa, the rest the spring's 2 MPa: 26 kPa of the 32.
    let expected = 0.25 + 0.5 * 26.0 / 32.0;
    assert!(double.reached && (double.cycles - expected).abs() < 0.5 * 20.0 / 32e3 + 1e-9, "{double:?}");
    assert_eq!(summary.stages[1].ended_by, Some("pore_pressure_ratio"));
    close(end(&summary, "law.slipped") * 20.0, end(&summary, "pore_pressure_ratio"), 1.0);
    for name in ["resistance", "shear-cycles", "shear-stress-path", "shear-stress-strain", "compression", "law"] {
        for kind in ["svg", "png"] {
            assert!(desk.0.join(format!("out/figures/{name}.{kind}")).exists(), "{name}.{kind}");
        }
    }
    let table = fs::read_to_string(desk.0.join("out/resistance.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert!(desk.0.join("out/runs/criterion-2-csr-0.16.csv").exists());
}

/// Everything but the manifest, which tells the time.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        match entry.is_dir() {
            true => found.extend(contents(&entry)),
            false if entry.ends_with("manifest.json") => {}
            false => found.push((entry.clone(), fs::read(&entry).unwrap())),
        }
    }
    found.sort();
    found
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let desk = Desk::new("threads");
    let text = edited(&[("every = 5", "every = 5\nfigures = false")]);
    let test = ElementTest::from_text("test.toml", &text, &registry()).unwrap();
    let [one, four] = [1, 4].map(|threads| {
        let options = TestOptions { threads: NonZeroUsize::new(threads), force: true, ..desk.options("out") };
        run_element_test(&test, &registry(), &options, &|| false).unwrap();
        contents(&desk.0.join("out"))
    });
    assert!(one == four && one.len() == 11);
}

#[test]
fn a_law_that_fails_names_stage_and_increment_and_the_record_is_kept() {
    let desk = Desk::new("fails");
    let text = edited(&[
        ("settling = 0.1", "settling = 0.1, breaks = 1.5005e-3"),
        ("[resistance]", "[[figures]]\nname = \"a\"\nx = \"cycle\"\ny = \"increment\"\n"),
    ]);
    let start = text.find("stress_ratios").unwrap();
    let rest = text[start..].find("[[figures]]").unwrap();
    let summary = desk.run(&format!("{}{}", &text[..start], &text[start + rest..]));
    let Outcome::Failed(reason) = &summary.outcome else { panic!("{:?}", summary.outcome) };
    // 150 increments of 1e-5 lead to the strain at which it breaks; the next one is halved twelve times before it is given up.
    assert!(reason.starts_with("stage 2 (simple-shear), increment 151: the law failed: "), "{reason}");
    assert!(reason.contains("7 iterations") && reason.contains("zx 7.50"), "{reason}");
    let strain = end(&summary, "shear_strain");
    assert!(strain <= 1.5005e-3 && strain > 1.5005e-3 - 2.0 * 1e-5 / 4096.0, "{strain}");
    let csv = fs::read_to_string(desk.0.join("out/element.csv")).unwrap();
    assert_eq!(csv.lines().count(), summary.record.rows.len() + 1);
    let manifest: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(desk.0.join("out/manifest.json")).unwrap()).unwrap();
    assert_eq!(manifest["outcome"]["kind"], "failed");
}

#[test]
fn a_stop_keeps_what_was_recorded() {
    let desk = Desk::new("stop");
    let test = ElementTest::from_text("test.toml", CYCLIC, &registry()).unwrap();
    let asked = std::sync::atomic::AtomicUsize::new(0);
    let stop = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= 12;
    let summary = run_element_test(&test, &registry(), &desk.options("out"), &stop).unwrap();
    assert_eq!((summary.outcome, summary.resistance.len()), (Outcome::Interrupted, 0));
    // Ten increments of the first stage, three of the second.
    assert_eq!((end(&summary_of(&summary.record), "stage"), summary.stages[1].increments), (2.0, 3));
}

/// A record as if it were a test's.
fn summary_of(record: &Record) -> TestSummary {
    let (folder, stages, resistance) = (PathBuf::new(), Vec::new(), Vec::new());
    TestSummary { folder, outcome: Outcome::Finished, stages, record: record.clone(), resistance }
}

#[test]
fn a_folder_is_replaced_only_when_asked_and_only_what_is_the_tests_own() {
    let desk = Desk::new("folder");
    let text = fs::read_to_string(examples().join("triaxial-undrained.toml")).unwrap();
    desk.run(&text);
    fs::write(desk.0.join("out/notes.txt"), "mine").unwrap();
    let test = ElementTest::from_text("test.toml", CYCLIC, &registry()).unwrap();
    let run = |options: &TestOptions| run_element_test(&test, &registry(), options, &|| false);
    let error = run(&desk.options("out")).unwrap_err();
    assert!(matches!(error, TestError::Results(ResultsError::Occupied { .. })), "{error}");
    run(&TestOptions { force: true, ..desk.options("out") }).unwrap();
    assert!(desk.0.join("out/notes.txt").exists());
    assert!(!desk.0.join("out/figures/stress-path.svg").exists(), "a figure of the test before");
    fs::create_dir(desk.0.join("other")).unwrap();
    fs::write(desk.0.join("other/thesis.tex"), "mine").unwrap();
    let error = run(&TestOptions { force: true, ..desk.options("other") }).unwrap_err();
    assert!(matches!(error, TestError::NotATest { .. }), "{error}");
}

#[test]
fn the_schema_accepts_the_examples_and_refuses_what_the_program_refuses() {
    let schema = Registry::built_in().element_test_schema();
    jsonschema::meta::validate(&schema).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let value = |text: &str| serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
    for entry in fs::read_dir(examples()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        assert!(validator.is_valid(&value(&text)), "{}", path.display());
        let refused = text.replace("kind = ", "knid = ");
        assert!(!validator.is_valid(&value(&refused)));
    }
    assert!(!validator.is_valid(&value(CYCLIC)), "the law is not in the built-in registry");
}

/// A stage of undrained simple shear that takes so long (s).
fn shear_stage(strain: f64, duration: f64) -> String {
    format!(
        "[[stages]]\nkind = \"simple-shear\"\ndrainage = \"undrained\"\nto = {{ shear_strain = {strain:?} }}\nduration = {duration:?}\n"
    )
}

const MUD: &str = "title = \"mud\"\n[material]\nlaw = \"bingham\"\nparameters = { bulk_modulus = 1.0e6, shear_modulus = 1.0e5, \
                   yield_stress = 40.0, viscosity = 5.0 }\n[initial]\nmean_stress = 1.0e3\n[output]\nfigures = false\n";

/// τ = τ_y + η γ̇, less what an implicit step leaves of the start: (1 + G Δt/η)^−200 is 2^−200 in the fastest stage.
#[test]
fn the_bingham_example_ends_every_stage_at_its_rate() {
    let desk = Desk::new("bingham");
    let summary = desk.example("bingham-shear-rates.toml");
    let column = |name: &str| summary.record.column(name).unwrap();
    let (stage, stress, time) = (column("stage"), column("shear_stress"), column("time"));
    let mut start = 0.0;
    for (number, rate) in [(1.0, 0.1), (2.0, 1.0), (3.0, 10.0), (4.0, 100.0)] {
        let end = stage.iter().rposition(|&stage| stage == number).unwrap();
        let expected = 40.0 + 5.0 * rate;
        assert!((stress[end] / expected - 1.0).abs() < 1e-12, "{rate}: {}, not {expected}", stress[end]);
        // A sum of 200 equal parts.
        assert!((time[end] - start - 1.0 / rate).abs() < 1e-12 * time[end]);
        start = time[end];
    }
    assert!(summary.folder.join("figures/shear-stress-over-time.svg").exists());
}

/// Held in all six strains, the overstress falls by 1/(1 + G Δt/η) = 1/1.2 in each of ten increments.
#[test]
fn mud_that_is_held_relaxes_to_its_yield_stress() {
    let held = ["xx", "yy", "zz", "xy", "yz", "zx"].map(|c| format!("{{ strain = {{ {c} = 1.0 }} }}")).join(", ");
    let rest = format!("[[stages]]\nkind = \"path\"\nconditions = [{held}]\nduration = 1.0e-4\nincrements = 10\n");
    let summary = Desk::new("relaxes").run(&format!("{MUD}{}{rest}", shear_stage(1.0, 0.01)));
    assert_eq!(summary.outcome, Outcome::Finished);
    let expected = 40.0 + 500.0 * 1.2_f64.powi(-10);
    assert!((end(&summary, "shear_stress") / expected - 1.0).abs() < 1e-12, "{}", end(&summary, "shear_stress"));
    assert!((end(&summary, "time") - 0.0101).abs() < 1e-14);
}

/// Without a duration time plays no part, and mud is von Mises.
#[test]
fn a_stage_without_a_duration_is_infinitely_slow() {
    let stage = shear_stage(1.0, 1.0).replace("duration = 1.0\n", "");
    let summary = Desk::new("slow").run(&format!("{MUD}{stage}"));
    assert!((end(&summary, "shear_stress") / 40.0 - 1.0).abs() < 1e-12);
    assert!(summary.record.column("time").is_none());
}

/// One cycle of ±0.1 at 10 per second takes 0.04 s, though increments of 0.03 are cut where the load turns.
#[test]
fn cyclic_stages_have_a_rate() {
    let stage = "[[stages]]\nkind = \"simple-shear\"\ndrainage = \"undrained\"\namplitude = { strain = 0.1 }\nincrement = 0.03\n\
                 rate = 10.0\nuntil = { cycles = 1.0 }\n";
    let summary = Desk::new("rate").run(&format!("{MUD}{stage}"));
    assert_eq!(summary.outcome, Outcome::Finished);
    assert!((end(&summary, "time") - 0.04).abs() < 1e-12, "{}", end(&summary, "time"));
    // The law's own equation, τ = ±τ_y + (τ' ∓ τ_y)/(1 + G Δt/η), by hand along 0.1 up, 0.2 down and 0.1 up.
    let mut stress: f64 = 0.0;
    for (sign, parts, rest) in [(1.0, 3, 0.01), (-1.0, 6, 0.02), (1.0, 3, 0.01)] {
        for part in std::iter::repeat_n(0.03, parts).chain([rest]) {
            let beyond = stress + sign * 1e5 * part - sign * 40.0;
            stress = sign * 40.0 + beyond / (1.0 + 1e5 * (part / 10.0) / 5.0);
        }
    }
    // Turns are found to 1e-9 of the increment.
    assert!((end(&summary, "shear_stress") / stress - 1.0).abs() < 1e-9, "{}", end(&summary, "shear_stress"));
}

/// τ = η γ̇ from the first increment on.
#[test]
fn a_newtonian_fluid_has_the_stress_of_its_rate() {
    let water = "title = \"water\"\n[material]\nlaw = \"newtonian\"\nparameters = { bulk_modulus = 2.2e9, viscosity = 1.0e-3 }\n[output]\n\
                 figures = false\n";
    let summary = Desk::new("newtonian").run(&format!("{water}{}", shear_stage(1e-3, 1e-4)));
    let stress = summary.record.column("shear_stress").unwrap();
    assert!(stress.len() == 201 && stress[1..].iter().all(|stress| (stress / 0.01 - 1.0).abs() < 1e-10), "{stress:?}");
}

/// τ/p = μ(I), I = γ̇ d √(ρ_s/p), here I₀ and so half way between the two coefficients; with the vertical stress held, so that Newton's method is asked too.
#[test]
fn grains_have_the_friction_of_their_rate() {
    let beads = "title = \"beads\"\n[material]\nlaw = \"mu-i\"\nparameters = { young = 1.0e8, poisson = 0.3, friction_static = 0.382, \
                 friction_limit = 0.643, inertial_number = 0.279, grain_diameter = 0.53e-3, grain_density = 2450.0 }\n[initial]\n\
                 mean_stress = 1.0e3\n[output]\nfigures = false\n";
    let rate = 0.279 / (0.53e-3 * 2.45_f64.sqrt());
    let stage = shear_stage(0.5, 0.5 / rate).replace("undrained", "drained");
    let summary = Desk::new("mu-i").run(&format!("{beads}{stage}"));
    assert_eq!(summary.outcome, Outcome::Finished);
    let friction = end(&summary, "shear_stress") / end(&summary, "mean_stress");
    // Conditions are met to 1e-9 of the stress.
    assert!((friction / 0.5125 - 1.0).abs() < 1e-8, "{friction}");
}

/// One increment as it is, from a history of its own.
#[test]
fn an_increment_is_done_as_it_is() {
    let stage = "[[stages]]\nkind = \"increment\"\nstrain = [0.0, 0.0, 0.0, 0.0, 0.0, 0.5e-3]\n";
    let history = "history = { stress = 1.0e3, strain = 0.25, slipped = 0.5 }\n";
    let start = CYCLIC.find("[[stages]]").unwrap();
    let (head, initial) = CYCLIC[..start].split_once("radial_stress = 50.0e3\n").unwrap();
    let text = format!("{head}radial_stress = 50.0e3\n{history}{initial}{stage}");
    let summary = Desk::new("increment").run(&text);
    assert_eq!(summary.outcome, Outcome::Finished);
    assert_eq!((summary.record.rows.len(), summary.stages[0].increments), (2, 1));
    // By hand from the slider's history: see its law.
    let material: toml::Table = text.parse().unwrap();
    let parameter = |name: &str| material["material"]["parameters"][name].as_float().unwrap();
    let slip = (1.0e3 + parameter("stiffness") * 1e-3 - parameter("strength")).max(0.0) / parameter("stiffness");
    assert!((end(&summary, "law.slipped") - 0.5 - slip).abs() < 1e-15, "{slip}");
}

/// What is wrong, and how it is told.
const BAD_TESTS: &[(&str, &[(&str, &str)])] = &[
    ("unknown key", &[("settling = 0.1", "settling = 0.1, setling = 0.2")]),
    ("unknown key of a stage", &[("drainage = ", "dranage = ")]),
    ("missing parameter", &[("spring = 2.0e6, ", "")]),
    ("unknown kind", &[("\"isotropic\"", "\"isotropc\"")]),
    ("no stages", &[("[[stages]]\nkind = \"isotropic\"", "[[x]]\nkind = \"isotropic\""), ("[[stages]]", "[[x]]")]),
    ("stress in two ways", &[("radial_stress = 50.0e3", "radial_stress = 50.0e3\nmean_stress = 5.0")]),
    ("half a stress", &[("radial_stress = 50.0e3\n", "")]),
    ("nowhere to go", &[("to = { mean_stress = 100.0e3 }\n", "")]),
    ("two ways to go", &[("amplitude = {", "to = { shear_strain = 0.1 }\namplitude = {")]),
    ("target of another kind", &[("to = { mean_stress", "to = { axial_stress")]),
    ("two targets", &[("to = { mean_stress = 100.0e3 }", "to = { mean_stress = 100.0e3, volumetric_strain = 0.1 }")]),
    ("drained and a pore pressure", &[("drainage = \"undrained\"\n", "")]),
    ("cyclic without an end", &[("until = { cycles = 100.0, pore_pressure_ratio = 0.95 }\n", "")]),
    ("cyclic oedometer", &[("kind = \"simple-shear\"", "kind = \"oedometer\"")]),
    ("keys of the other sort", &[("increments = 10", "increment = 10.0"), ("increment = 1.0e-5", "increments = 5")]),
    ("path without conditions", &[("kind = \"isotropic\"", "kind = \"path\"")]),
    (
        "path with a condition too few",
        &[("kind = \"isotropic\"\nto = { mean_stress = 100.0e3 }", "kind = \"path\"\nconditions = [{ by = 1.0 }]")],
    ),
    ("nothing to resist", &[("stress_ratios = [0.10, 0.12, 0.16, 0.07]", "stress_ratios = [0.1, -0.1]")]),
    ("criterion of two", &[("{ double_strain = 0.005 }", "{ double_strain = 0.005, single_strain = 0.1 }")]),
    ("column that is not there", &[("law.slipped", "law.slippd")]),
    ("stage that is not there", &[("stages = [2]", "stages = [3]")]),
    ("duration of a cyclic stage", &[("increment = 1.0e-5", "increment = 1.0e-5\nduration = 2.0")]),
    ("rate of a monotonic stage", &[("increments = 10", "increments = 10\nrate = 0.1")]),
    ("duration below zero", &[("increments = 10", "increments = 10\nduration = -1.0")]),
    ("strain of another kind", &[("increments = 10", "increments = 10\nstrain = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]")]),
    ("increment with a goal and without a strain", &[("kind = \"isotropic\"", "kind = \"increment\"")]),
    (
        "history of another law",
        &[("radial_stress = 50.0e3", "radial_stress = 50.0e3\nhistory = { back_stress = 1.0 }")],
    ),
    ("tolerance out of range", &[("tolerance = 1.0e-9", "tolerance = 0.0")]),
];

/// The messages for bad tests; read what you accept.
#[test]
fn bad_tests_are_told_with_place_and_cure() {
    let mut gallery = String::new();
    for (name, edits) in BAD_TESTS {
        let result = ElementTest::from_text("test.toml", &edited(edits), &registry());
        let error: CaseError = result.err().unwrap_or_else(|| panic!("{name} was accepted"));
        gallery += &format!("## {name}\n{}\n\n", error.render(false));
    }
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path("tests/snapshots");
    settings.bind(|| insta::assert_snapshot!("bad_tests", gallery));
}

/// Apart from the gallery: the list of laws grows.
#[test]
fn an_unknown_law_is_told() {
    let text = edited(&[("law = \"slider\"", "law = \"slidder\"")]);
    let error = ElementTest::from_text("test.toml", &text, &registry()).unwrap_err().render(false);
    assert!(error.contains("test.toml:5:7") && error.contains("did you mean `slider`?"), "{error}");
}

#[test]
fn a_stress_ratio_without_stress_is_told() {
    let text = edited(&[
        ("to = { mean_stress = 100.0e3 }", "to = { mean_stress = -10.0e3 }"),
        ("criteria = [{ pore_pressure_ratio = 0.95 }, ", "criteria = ["),
    ]);
    let summary = Desk::new("no-stress").run(&text);
    let Outcome::Failed(reason) = summary.outcome else { panic!("{:?}", summary.outcome) };
    assert!(reason.contains("needs an effective stress"), "{reason}");
}

/// The examples of the laws' pages end where the formulas in their heads say.
#[test]
fn the_examples_of_the_laws_end_where_theory_does() {
    let desk = Desk::new("laws");
    let softened = desk.example("drucker-prager-softening.toml");
    // K_p − 1 = 2 sin φ/(1 − sin φ): 2 at 30°.
    close(end(&softened, "stress_difference"), 200e3, 3e5);
    let peak = softened.record.column("stress_difference").unwrap().iter().copied().fold(0.0, f64::max);
    let sine = 35.0_f64.to_radians().sin();
    // Read at increments of 4e-4, the first of which beyond the peak has softened by 0.06 % of 5°.
    assert!((peak / (100e3 * 2.0 * sine / (1.0 - sine)) - 1.0).abs() < 1e-2, "{peak}");

    let elastic = desk.example("pressure-elastic-isotropic.toml");
    let (strain, stress) =
        (elastic.record.column("volumetric_strain").unwrap(), elastic.record.column("mean_stress").unwrap());
    for (strain, stress) in strain.iter().zip(stress) {
        // K_ref/(2 p_ref) = 250.
        close((stress / 100e3).sqrt(), 0.1_f64.sqrt() + 250.0 * strain, 10.0);
    }

    let clay = desk.example("cam-clay-isotropic.toml");
    // κ to 100 kPa, λ to 800 kPa: swelling in between leaves no trace.
    let void_ratio = 1.0 - 0.05 * 4.0_f64.ln() - 0.2 * 8.0_f64.ln();
    close(end(&clay, "void_ratio"), void_ratio, 1.0);

    let loops = desk.example("von-mises-cyclic-shear.toml");
    let (gamma, tau) = (loops.record.column("shear_strain").unwrap(), loops.record.column("shear_stress").unwrap());
    let first = gamma.iter().position(|gamma| *gamma >= 0.02 - 1e-12).unwrap();
    // Beyond c_u, dσ_y = H dε^p with γ^p = √3 ε^p: dτ/dγ = G H/(3G + H).
    let (shear_modulus, strength) = (30e6 / 2.98, 86.603e3 / 3.0_f64.sqrt());
    let hardening = shear_modulus * 1e6 / (3.0 * shear_modulus + 1e6);
    close(tau[first], strength + hardening * (0.02 - strength / shear_modulus), 1e5);
}
