//! Steady seepage through layers, and the inertia of the water.
//!
//! ```text
//!       p_w = 0
//!      ┌───────┐ drained
//!      │  k₁   │ ↓ q        dp_w/dz = γ_w (1 − q/k)
//!      ├───────┤
//!      │  k₂   │ ↓ q        q = H / (H₁/k₁ + H₂/k₂)
//!      └───────┘ drained
//!       p_w = 0
//! ```
//!
//! Water that seeps down under gravity between two drained ends: the flow is that of the harmonic mean.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::boundary::History;
use tsutsumi::law::LinearElastic;
use tsutsumi::pressure::Quadrature;
use tsutsumi::tensor::Sym3;
use tsutsumi_testkit::body::{Body, PAPER_DENSITY, PAPER_SOIL, WATER, down};
use tsutsumi_testkit::compare::{assert_all_close, assert_close};
use tsutsumi_testkit::reading::{base, cell_pressures, run, top};

const GRAVITY: f64 = 9.8;
/// The conductivities of the upper and of the lower half of 10 m (m/s).
const UPPER: f64 = 1e-2;
const LOWER: f64 = 1e-4;
const HALF: f64 = 5.0;

/// The flow down q (m/s): H over the resistances in series.
fn flow() -> f64 {
    2.0 * HALF / (HALF / UPPER + HALF / LOWER)
}

/// The steady pressure (Pa) at a height (m) above the base: linear in either half, zero at both ends.
fn steady_pressure(height: f64) -> f64 {
    let slope = |conductivity: f64| WATER.unit_weight * (1.0 - flow() / conductivity);
    let depth = 2.0 * HALF - height;
    slope(UPPER) * depth.min(HALF) + slope(LOWER) * (depth - HALF).max(0.0)
}

fn seepage_settles_to_piecewise_linear_pressure<const D: usize>(quadrature: Quadrature, dt: f64, steps: usize) {
    // A hundred times as stiff as the paper's soil: it consolidates as much faster.
    let stiff = LinearElastic { young: 100.0 * PAPER_SOIL.young, ..PAPER_SOIL };
    let mut solver = Body::<D>::column(2.0 * HALF, 1.0)
        .law(stiff)
        .gravity(GRAVITY)
        .conductivity(|x| if x[D - 1] < HALF { LOWER } else { UPPER })
        .quadrature(quadrature)
        // The skeleton starts with its final stress, the water without pressure: what carries the rest is for it to find.
        .stress(|x| {
            let height = x[D - 1];
            let vertical = steady_pressure(height) - PAPER_DENSITY * GRAVITY * (2.0 * HALF - height);
            let at = |axis: usize| if axis == D - 1 { vertical } else { 0.0 };
            Sym3::diagonal(at(0), at(1), at(2))
        })
        .drained(top::<D>())
        .drained(base::<D>())
        .build();
    // Six and more of the lower layer's H²/c_v = 1.5 s: exp(−16) is left.
    run(&mut solver, dt, steps).unwrap();
    // Finite volumes are exact for it: layers end at cell sides, distances count half cells.
    let expected: Vec<f64> = (0..10).map(|cell| steady_pressure(cell as f64 + 0.5)).collect();
    assert_all_close("pressures", &cell_pressures(&solver), &expected, 1e-5 * expected[HALF as usize]);
    // What enters at the top leaves at the base.
    assert_close("net outflow", solver.step(dt).unwrap().pressure.outflow_rate, 0.0, 1e-5 * flow());
    let into_top = flow_into_top(cell_pressures(&solver)[9]);
    assert_close("flow", into_top, flow(), 1e-5 * flow());
}

/// Darcy's flow down (m/s) from the drained top to the centre of the first cell.
fn flow_into_top(pressure: f64) -> f64 {
    UPPER * (1.0 - pressure / (0.5 * WATER.unit_weight))
}

#[test]
fn seepage_through_two_layers_is_that_of_the_harmonic_mean() {
    for quadrature in [Quadrature::Cell, Quadrature::MaterialPoints] {
        seepage_settles_to_piecewise_linear_pressure::<1>(quadrature, 4e-4, 25_000);
        seepage_settles_to_piecewise_linear_pressure::<2>(quadrature, 4e-4, 25_000);
        seepage_settles_to_piecewise_linear_pressure::<3>(quadrature, 4e-4, 25_000);
    }
}

/// The inertia of the water relative to the soil delays by k/g = 6e-6 s: nothing under a load that takes 100 s.
#[test]
fn the_inertia_of_the_water_does_not_show_under_a_slow_load() {
    let pressures = |body: Body<1>| {
        let ramp = History::new(vec![[0.0, 0.0], [100.0, 1.0]]);
        let mut solver = body.drained(top::<1>()).load_on_surface(top::<1>(), down(50e3), ramp).build();
        run(&mut solver, 0.5, 300).unwrap();
        cell_pressures(&solver)
    };
    let with = pressures(Body::column(10.0, 1.0));
    let without = pressures(Body::column(10.0, 1.0).without_fluid_inertia());
    assert!(with[0] > 10e3);
    assert_all_close("pressures", &without, &with, 1e-6 * with[0]);
}
