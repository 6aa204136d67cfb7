//! Pressures that travel with the ground: what is lost when particles change cells.
//!
//! ```text
//!      p │  ╱‾╲                ╱‾╲  increment, gradient
//!        │ ╱   ╲    →    ___╱‾‾‾‾‾╲___  cell
//!        └──────────────────────────── x
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::f64::consts::PI;

use tsutsumi::boundary::History;
use tsutsumi::pressure::{CellPressure, Fluid, ParticlePressure, PressureGradient, PressureIncrement};
use tsutsumi::shape::CubicBSpline;
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi_testkit::body::{Body, PAPER_DENSITY, WATER, down};
use tsutsumi_testkit::compare::{assert_all_close, observed_order, root_mean_square};
use tsutsumi_testkit::reading::{cell_pressures, run, top};

/// Length of the body and how far it is carried (m), speed (m/s), pressure (Pa).
const LENGTH: f64 = 8.0;
const WAY: f64 = 8.0;
const SPEED: f64 = 2.0;
const PRESSURE: f64 = 1e3;

/// A body that is carried along, with a hill of pore pressure that the effective stress balances: nothing acts on anything, every particle
/// keeps its pressure. The water holds gas, so that its stiffness is that of the skeleton; stiff water would find its pressure again from the
/// balance alone. Root mean square of the error over the height of the hill.
fn error(particle_pressure: impl ParticlePressure<1> + 'static, spacing: f64) -> f64 {
    let hill = |x: f64| PRESSURE * (PI * (x - 1.0) / LENGTH).sin().powi(2);
    let cells = ((LENGTH + WAY + 3.0) / spacing).round() as usize;
    let mut solver = Body::<1>::free(Vector::repeat(1.0), Vector::repeat(1.0 + LENGTH), spacing, [cells])
        .fluid(Fluid { bulk_modulus: 6.6e6, ..WATER })
        .conductivity(|_| 1e-12)
        .particles_per_cell([4])
        .shape(CubicBSpline)
        .particle_pressure(particle_pressure)
        .velocity(|_| Vector::repeat(SPEED))
        .pressure(move |x| hill(x[0]))
        .stress(move |x| Sym3::diagonal(hill(x[0]), 0.0, 0.0))
        .build();
    let before = solver.particles().pressure.clone();
    let steps = (WAY / SPEED / (1e-3 * spacing)).round() as usize;
    run(&mut solver, 1e-3 * spacing, steps).unwrap();
    let particles = solver.particles();
    let errors: Vec<f64> = particles.pressure.iter().zip(&before).map(|(now, was)| (now - was) / PRESSURE).collect();
    root_mean_square(&errors)
}

#[test]
fn hills_of_pressure_travel_whole_with_increments_and_gradients() {
    fn errors_and_order(one: fn(f64) -> f64) -> ([(f64, f64); 2], f64) {
        let errors = [0.5, 0.25].map(|spacing| (spacing, one(spacing)));
        (errors, observed_order(&errors))
    }
    // The mean of the cell spreads with ½ |v| h: first order, and a seventh of the hill after 16 cells.
    let (cell, order) = errors_and_order(|spacing| error(CellPressure, spacing));
    assert!(cell[0].1 > 0.1 && order < 1.2, "cell: order {order} from {cell:?}");
    // The rest is the balance of stress and pressure, of second order.
    let (increment, order) = errors_and_order(|spacing| error(PressureIncrement, spacing));
    assert!(increment[0].1 < 0.005 && order > 1.8, "increment: order {order} from {increment:?}");
    let (gradient, order) = errors_and_order(|spacing| error(PressureGradient::default(), spacing));
    assert!(gradient[0].1 < 0.02 && order > 1.8, "gradient: order {order} from {gradient:?}");
}

/// While no particle changes its cell, the cells do not notice what the particles do with their pressures.
#[test]
fn nothing_changes_where_no_particle_changes_its_cell() {
    fn pressures(particle_pressure: impl ParticlePressure<2> + 'static) -> Vec<f64> {
        let ramp = History::new(vec![[0.0, 0.0], [10.0, 1.0]]);
        let mut solver = Body::<2>::column(10.0, 1.0)
            .drained(top::<2>())
            .load_on_surface(top::<2>(), down(50e3), ramp)
            .particle_pressure(particle_pressure)
            .build();
        run(&mut solver, 5e-3, 400).unwrap();
        cell_pressures(&solver)
    }
    let cell = pressures(CellPressure);
    for other in [pressures(PressureIncrement), pressures(PressureGradient::default())] {
        // The mean is by volume, which changes by the strain of a step.
        assert_all_close("pressure", &other, &cell, 1e-6 * cell[0]);
    }
}

/// Hydrostatic pressure is linear: with gradients every particle has that of its own depth, with cells that of the cell's centre.
#[test]
fn gradients_give_every_particle_the_pressure_of_its_depth() {
    fn largest_error(particle_pressure: impl ParticlePressure<2> + 'static) -> f64 {
        let depth = |x: &Vector<2>| WATER.unit_weight * (4.0 - x[1]);
        let mut solver = Body::<2>::column(4.0, 1.0)
            .gravity(9.8)
            .drained(top::<2>())
            .pressure(move |x| depth(&x))
            .stress(|x| {
                let effective = (PAPER_DENSITY - WATER.density) * 9.8 * (4.0 - x[1]);
                Sym3::diagonal(-effective, -effective, -effective)
            })
            .particle_pressure(particle_pressure)
            .build();
        run(&mut solver, 1e-3, 10).unwrap();
        let particles = solver.particles();
        let errors = particles.pressure.iter().zip(&particles.position).map(|(p, x)| (p - depth(x)).abs());
        errors.fold(0.0, f64::max)
    }
    assert!(largest_error(PressureGradient::default()) < 1.0);
    // A quarter of a cell is 2450 Pa.
    assert!((largest_error(CellPressure) - 2450.0).abs() < 1.0);
}
