//! What Goto et al. claim of their example, sec. 3, each claim with what was found.

use tsutsumi_reference::consolidation::Layer;

use crate::curves::{Curves, assert_within};
use crate::poroelastic_column::{LAYER, RAMP};

const COLUMN: &str = "poroelastic-column/case.toml";

/// MPM① with the automatic step, within 0.2 % of the paper's step (asserted in `poroelastic_column`).
fn column(overrides: &[&str]) -> Curves {
    Curves::until(2000.0, 10.0, COLUMN, &[&["time.step=auto"], overrides].concat())
}

/// "Compression and pore pressure arise; the pressure is distributed, for the top is drained."
///
/// Found: yes. The pressure grows from the drained top to the base at all times, by a factor of ten.
#[test]
fn claim_a_pore_pressure_is_distributed_because_the_top_is_drained() {
    let curves = column(&[]);
    let [top, middle, base] = ["top", "middle", "base"].map(|probe| curves.column(&format!("{probe}.pressure")));
    for row in 0..curves.len() {
        assert!(0.0 < top[row] && top[row] < middle[row] && middle[row] < base[row], "row {row}");
    }
    let distributed = curves.at("base.pressure", 1000.0) / curves.at("top.pressure", 1000.0);
    // Theory at the centres of the cells: 9.8.
    let theory = LAYER.pressure(RAMP, 9.5, 1000.0) / LAYER.pressure(RAMP, 0.5, 1000.0);
    assert_within("base over top", distributed, theory, 0.05 * theory);
    // Without drainage the load would be carried by the water alone, the same everywhere (what inertia leaves of the ramp's
    // waves is below 1e-4).
    let sealed = ["time.step=auto", "loads.0.applied_to=surface", "drainage=[]"];
    let sealed = Curves::until(1000.0, 1000.0, COLUMN, &sealed);
    let undrained = RAMP.load * LAYER.undrained_share();
    for probe in ["top", "middle", "base"] {
        assert_within(probe, sealed.at(&format!("{probe}.pressure"), 1000.0), undrained, 1e-3 * undrained);
    }
}

/// "The vertical displacement of the masses is slightly smaller than that of FEM and of one-dimensional theory."
///
/// Found: yes, by 6.3 %, with two particles per axis and cell. It is where the load acts and the displacement is read, at
/// particles a quarter of a cell below the surface: with both at the surface, and the filled part of the top cell, 0.3 % is
/// left. A finer body comes closer in the paper's own way too.
#[test]
fn claim_b_the_masses_settle_slightly_less_than_fem_and_theory() {
    let theory = LAYER.settlement(RAMP, 1000.0);
    let fem =
        Curves::until(1000.0, 100.0, COLUMN, &["method.solver=fem", "time.step=1.0"]).at("settlement.surface", 1000.0);
    // The mesh's error, h²: an independent program of the same equations with h = 1 m finds 20.472 mm of 20.508 mm.
    assert_within("FEM", fem, theory, 3e-3 * theory);
    let masses = column(&[]).at("settlement.particles", 1000.0);
    let short = 1.0 - masses / fem;
    assert!((0.055..0.07).contains(&short), "{short}");
    let finer = column(&["grid.spacing=[1.0, 0.5]", "grid.cells=[1, 24]"]).at("settlement.particles", 1000.0);
    assert!((0.4..0.6).contains(&((theory - finer) / (theory - masses))), "{finer}");
    let surface = column(&["loads.0.applied_to=surface", "method.pressure_quadrature=material-points"]);
    assert_within("surface", surface.at("settlement.surface", 1000.0), fem, 3e-3 * fem);
}

/// "The pore pressure follows the rate of the displacement and dissipates when the rate tends to zero."
///
/// Found: yes, and after the load has come to rest the two are proportional: theory's first mode has
/// p_base/ṡ = E_oed H M/(c_v M²) with M = π/2.
#[test]
fn claim_c_the_pore_pressure_follows_the_displacement_rate() {
    let curves = column(&["loads.0.applied_to=surface", "method.pressure_quadrature=material-points"]);
    let (time, base) = (curves.column("time"), curves.column("base.pressure"));
    let settlement = curves.column("settlement.surface");
    let rate = |row: usize| (settlement[row + 1] - settlement[row - 1]) / (time[row + 1] - time[row - 1]);
    let row_at = |wanted: f64| time.iter().position(|time| (time - wanted).abs() < 1e-6).unwrap();
    // Both grow while the load does, and fall when it rests.
    for row in 1..row_at(980.0) {
        assert!(rate(row + 1) > rate(row) && base[row + 1] > base[row], "{} s", time[row]);
    }
    for row in row_at(1020.0)..row_at(1980.0) {
        assert!(rate(row + 1) < rate(row) && base[row + 1] < base[row], "{} s", time[row]);
    }
    // p and ṡ of the first mode; the second has gone to e^(−8·0.46) = 2 % of its share of 4 % by 1500 s.
    let m = std::f64::consts::FRAC_PI_2;
    let Layer { height, modulus, .. } = LAYER;
    let ratio = modulus * height / (LAYER.consolidation_coefficient() * m) * (m * 9.5 / height).sin();
    for wanted in [1500.0, 1700.0, 1900.0] {
        let row = row_at(wanted);
        assert_within("pressure over rate", base[row] / rate(row), ratio, 0.01 * ratio);
    }
    assert!(base[row_at(2000.0)] < 0.11 * base[row_at(1000.0)]);
}

/// "The update by the acceleration (MPM①) is closer to FEM than the update by the velocity (MPM②)."
///
/// Found: yes where a load moves fast. Under a strip load that grows within a second MPM② is off by 4 to 35 times the error
/// of MPM①, by 3 of 34 kPa at the loaded top. When the load rests the two meet; and under a load that grows ten times slower
/// the order is mixed, with both within 1 % of the load. In the paper's column the two differ in the fifth digit.
#[test]
fn claim_d_mpm1_is_closer_to_fem_than_mpm2_while_a_load_moves_fast() {
    let surface = "loads.0.applied_to=surface";
    let errors = |overrides: &[&str], end: f64, every: f64| {
        let of = |more: &[&str]| Curves::until(end, every, "strip-load/case.toml", &[overrides, more].concat());
        let fem = of(&["method.solver=fem", "time.step=5e-3"]);
        let variants = ["mpm1", "mpm2"].map(|update| of(&[surface, &format!("method.velocity_update={update}")]));
        let compare = move |time: f64, probe: &str| {
            let name = format!("{probe}.pressure");
            [0, 1].map(|variant: usize| (variants[variant].at(&name, time) - fem.at(&name, time)) / 1e3)
        };
        Box::new(compare)
    };
    // Loaded within a second.
    let fast = errors(&[], 2.0, 0.2);
    for probe in ["top-left", "mid-left", "mid-right"] {
        for time in [0.4, 0.8] {
            let [one, two] = fast(time, probe);
            assert!(two.abs() > 3.0 * one.abs(), "{probe} at {time} s: {one} {two} kPa");
        }
        // At rest the two meet, within 1 % of the load.
        let [one, two] = fast(2.0, probe);
        assert!(one.abs().max(two.abs()) < 0.5 && two.abs() < one.abs() + 0.1, "{probe} at rest: {one} {two} kPa");
    }
    let [one, two] = fast(0.4, "top-left");
    assert!(two.abs() > 20.0 * one.abs(), "{one} {two} kPa");
    // Loaded within ten seconds.
    let slow = errors(&["loads.0.history=[[0.0, 0.0], [10.0, 1.0]]"], 20.0, 2.0);
    let at_8_s = ["top-left", "mid-left", "mid-right"].map(|probe| slow(8.0, probe));
    assert!(at_8_s.iter().flatten().all(|error| error.abs() < 0.5), "{at_8_s:?}");
    let closer = at_8_s.map(|[one, two]| one.abs() < two.abs());
    assert_eq!(closer, [true, false, true], "{at_8_s:?}");
}

/// The strip load with the load on particles, as in the paper: pressure of the top left cell at 1.2 s, from an independent
/// program of the same equations, 32.8 kPa on a fixed grid, MPM① 0.53 and MPM② 3.88 kPa below it (to the digits given).
#[test]
fn the_strip_load_agrees_with_an_independent_program() {
    for (update, expected) in [("mpm1", 32.8 - 0.53), ("mpm2", 32.8 - 3.88)] {
        let curves = Curves::until(1.2, 0.4, "strip-load/case.toml", &[&format!("method.velocity_update={update}")]);
        assert_within(update, curves.at("top-left.pressure", 1.2) / 1e3, expected, 0.05);
    }
}
