//! Waves in a saturated column, `paper-cases/saturated-column-waves`: a harmonic load, and a smooth step.
//!
//! ```text
//!      ↓ ↓  q sin ωt, or a smooth step in 0.1 s
//!    |      |  drained         H = 10 m, E_oed = 16.5 MPa, k = 0.01 m/s, n = 0.4, K_f = 2.2 GPa
//!    |      |
//!    |      |  "top" 0.5 m deep, "middle" 4.9 m deep
//!    ‾‾‾‾‾‾‾‾  rigid, impermeable
//! ```
//!
//! Exact values for this continuity equation, with the inertia of the water: complex eigen-solution of the harmonic column,
//! checked by collocation (2e-6); the step by Fourier transform with an exponential window (5e-6 of q).

use tsutsumi_testkit::compare::observed_order;

use crate::curves::Curves;

/// A harmonic column in its steady state, q = 1 kPa: real part (in phase with the load) and imaginary part.
struct Harmonic {
    angular_frequency: f64,
    /// Pressures 0.5 m and 4.9 m deep (Pa).
    top: [f64; 2],
    middle: [f64; 2],
    /// Settlement (m).
    settlement: [f64; 2],
}

const HARMONICS: [Harmonic; 3] = [
    Harmonic {
        angular_frequency: 1.0,
        top: [93.044856, 82.288285],
        middle: [773.957226, 370.192457],
        settlement: [1.840752e-4, -1.895833e-4],
    },
    Harmonic {
        angular_frequency: 10.0,
        top: [269.065359, 201.107866],
        middle: [1060.514702, 14.889843],
        settlement: [5.703322e-5, -5.553238e-5],
    },
    Harmonic {
        angular_frequency: 100.0,
        top: [784.095907, 217.192116],
        middle: [1099.953836, -174.299078],
        settlement: [1.901952e-5, -1.833256e-5],
    },
];

/// Runs a harmonic load for some periods, in steps of a part of a period: the largest error of the three readings over their
/// amplitudes (–). The transients of loading have gone after half of the time.
fn harmonic_error(exact: &Harmonic, cells: usize, periods: f64, steps_per_period: f64) -> f64 {
    let omega = exact.angular_frequency;
    let period = std::f64::consts::TAU / omega;
    let overrides = [
        format!("grid.spacing=[{}]", 10.0 / cells as f64),
        format!("grid.cells=[{}]", cells + 1),
        format!("time.end={}", periods * period),
        format!("time.step={}", period / steps_per_period),
        format!("output.every={}", period / 16.0),
        format!(
            "loads.0.history={{ sine = {{ angular_frequency = {omega:?}, start = {:?} }} }}",
            periods / 2.0 * period
        ),
    ];
    let curves = Curves::of("saturated-column-waves/harmonic.toml", &overrides.each_ref().map(String::as_str));
    let error = |name: &str, [real, imaginary]: [f64; 2]| {
        let [a, b] = amplitudes(&curves, name, omega);
        (a - real).hypot(b - imaginary) / real.hypot(imaginary)
    };
    let errors = [
        error("top.pressure", exact.top),
        error("middle.pressure", exact.middle),
        error("settlement.surface", exact.settlement),
    ];
    errors.into_iter().fold(0.0, f64::max)
}

/// The parts of a reading in phase with sin ωt and cos ωt, over the last period: 16 readings.
fn amplitudes(curves: &Curves, name: &str, omega: f64) -> [f64; 2] {
    let (times, values) = (curves.column("time"), curves.column(name));
    let last = times.len() - 16..times.len();
    let part = |wave: fn(f64) -> f64| last.clone().map(|row| values[row] * wave(omega * times[row])).sum::<f64>() / 8.0;
    [part(f64::sin), part(f64::cos)]
}

/// Slow and middling: the boundary layer at the top, √(2 c_v/ω), is 5.8 and 1.8 m thick, 29 and 9 cells of 0.2 m.
#[test]
fn slow_harmonic_loads() {
    let slow = harmonic_error(&HARMONICS[0], 50, 4.0, 12_000.0);
    assert!(slow < 5e-3, "{slow}");
    let middling = harmonic_error(&HARMONICS[1], 50, 8.0, 6_000.0);
    assert!(middling < 1e-2, "{middling}");
}

/// Fast: a layer of 0.58 m has 3 cells of 0.2 m, or 9 of 0.067 m. Second order.
#[test]
fn a_fast_harmonic_load_needs_cells_in_the_boundary_layer() {
    let [coarse, fine] = [50, 150].map(|cells| harmonic_error(&HARMONICS[2], cells, 16.0, 3_000.0));
    assert!(coarse < 0.04 && fine < 5e-3, "{coarse} {fine}");
    let order = observed_order(&[(3.0, coarse), (1.0, fine)]);
    assert!(order > 1.7, "order {order} of {coarse} and {fine}");
}

/// Time (s), pressure 0.5 m deep (Pa), settlement (m).
const STEP: [[f64; 3]; 5] = [
    [0.047607421875, 262.2204, 1.43554e-5],
    [0.069580078125, 405.4584, 3.62580e-5],
    [0.098876953125, 327.5986, 6.21969e-5],
    [0.19775390625, 178.8712, 1.08898e-4],
    [0.3955078125, 116.6992, 1.65900e-4],
];

/// Within 1 % of the largest value at all times, with cells of 0.2 m.
#[test]
fn a_step_wave() {
    let curves = Curves::of("saturated-column-waves/step.toml", &[]);
    for [time, pressure, settlement] in STEP {
        let off = [curves.at("top.pressure", time) - pressure, curves.at("settlement.surface", time) - settlement];
        assert!(off[0].abs() < 1e-2 * 420.0 && off[1].abs() < 3e-3 * 1.9e-4, "{off:?} at {time} s");
    }
}
