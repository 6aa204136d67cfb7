//! What the stabilisation of the pressure costs: an undrained wave oblique to the grid runs as if the water were softer by a known
//! amount, one along an axis is not touched, and steps stay stable.
//!
//! ```text
//!     ┌───────────┐
//!     │ →   ↑   ← │   p = cos(κ x) cos(κ y) in a closed box, ω = κ √(2 M/ρ)
//!     │ ←   ↓   → │
//!     └───────────┘
//! ```
//!
//! What it cures is held by `tests/paper_cases/pressure_noise.rs`.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::cell::RefCell;
use std::f64::consts::PI;

use tsutsumi::boundary::History;
use tsutsumi::tensor::Vector;
use tsutsumi_testkit::body::{Body, PAPER_SOIL, POROSITY, WATER, down};
use tsutsumi_testkit::compare::assert_close;
use tsutsumi_testkit::noise::Noise;
use tsutsumi_testkit::reading::{cell_pressures, largest_speed, run, top};

/// Wavelength along either axis (m): 20 cells.
const WAVELENGTH: f64 = 20.0;

/// The velocity of the standing wave at a point, as a part of its amplitude.
fn shape(x: Vector<2>) -> Vector<2> {
    let k = 2.0 * PI / WAVELENGTH;
    Vector::<2>::new((k * x[0]).sin() * (k * x[1]).cos(), (k * x[0]).cos() * (k * x[1]).sin())
}

/// A quarter of the period (s) of the standing wave in a closed box of `cells` cells of 1 m along either axis.
fn quarter_period(cells: usize, softening: f64) -> f64 {
    let to = Vector::<2>::repeat(cells as f64);
    let body = Body::<2>::free(Vector::zeros(), to, 1.0, [cells; 2]).in_a_box().conductivity(|_| 1e-9);
    let mut solver = body.velocity(|x| shape(x) * 1e-3).pressure_stabilisation(softening).build();
    // 180 steps in a quarter: the implicit water slows the wave by (ω Δt)²/3 = 2e-5.
    let dt = 1e-5;
    let mut before = 1.0;
    for step in 1.. {
        solver.step(dt).unwrap();
        let particles = solver.particles();
        let moves = particles.velocity.iter().zip(&particles.position);
        let along = moves.map(|(velocity, &position)| velocity.dot(&shape(position))).sum::<f64>();
        if along < 0.0 {
            return dt * (step as f64 + along / (before - along));
        }
        before = along;
    }
    unreachable!("a standing wave turns round")
}

/// Against the water's bulk modulus in the doc of `Coupled::stabilised`, by the direct solver (10 cells) and the iterative one (40).
#[test]
fn an_oblique_undrained_wave_sees_softer_water_by_the_stated_amount() {
    let softening = 30.0;
    let phase = (PI / WAVELENGTH).sin().powi(2);
    let softer = 1.0 + 16.0 * softening * phase * phase;
    let modulus = |softer: f64| PAPER_SOIL.oedometric_modulus() + WATER.bulk_modulus / POROSITY / softer;
    let slower = (modulus(1.0) / modulus(softer)).sqrt();
    assert_close("the stated slowdown at 20 cells a wave", slower, 1.134, 1e-3);
    for cells in [10, 40] {
        let ratio = quarter_period(cells, softening) / quarter_period(cells, 0.0);
        // Steps are interpolated to some 1e-4 of a quarter; the rest of the wave is the same in both runs.
        assert_close("slowdown", ratio, slower, 5e-4);
    }
}

/// A load on the whole top makes waves that know one axis only: there is no twist to stabilise.
#[test]
fn a_wave_along_an_axis_is_the_same() {
    let pressures = |softening: f64| {
        let layer = Body::<2>::layer(6.0, 1.0, 3).drained(top::<2>());
        let loaded = layer.load_on_surface(top::<2>(), down(50e3), History::new(vec![]));
        let mut solver = loaded.pressure_stabilisation(softening).build();
        run(&mut solver, 1e-4, 200).unwrap();
        cell_pressures(&solver)
    };
    for (with, without) in pressures(30.0).into_iter().zip(pressures(0.0)) {
        // Rounding alone, of pressures up to 1e5 Pa, which the explicit skeleton carries on.
        assert_close("pressure", with, without, 1e-6 * 50e3);
    }
}

/// Water that gives way leaves short waves to the explicit skeleton: the limit is that of dry ground then, at any strength.
#[test]
fn the_stated_limit_is_safe_with_the_stabilisation() {
    fn safe<const D: usize>(height: f64, width: usize, softening: f64, steps: usize) {
        let noise = RefCell::new(Noise::new(5));
        let body = Body::<D>::layer(height, 1.0, width).drained(top::<D>()).pressure_stabilisation(softening);
        let mut solver = body.conductivity(|_| 1e-9).velocity(move |_| noise.borrow_mut().vector() * 1e-9).build();
        let before = largest_speed(solver.particles());
        let limit = solver.step_limits().longest();
        run(&mut solver, 0.95 * limit, steps).unwrap();
        let grown = largest_speed(solver.particles()) / before;
        assert!(grown < 2.0, "{D}-D, softening {softening}: grown {grown:e} times");
    }
    for softening in [30.0, 1e3, 1e5] {
        safe::<2>(4.0, 4, softening, 2000);
        safe::<3>(3.0, 3, softening, 1000);
    }
}
