//! Damping brings ground to rest without changing where it rests.
//!
//! ```text
//! settlement │   ╱╲    ╱╲    ╱   undamped
//!            │  ╱  ╲  ╱  ╲  ╱
//!          s ├ ╱ ╲_╱‾╲╱──╲╱───   damped
//!            └─────────────────
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::f64::consts::PI;

use tsutsumi::damping::Damping;
use tsutsumi::solver::Solver;
use tsutsumi_reference::elastic_column::ElasticColumn;
use tsutsumi_testkit::body::{Body, PAPER_DENSITY, PAPER_SOIL, WATER};
use tsutsumi_testkit::compare::assert_close;
use tsutsumi_testkit::reading::{cell_pressures, outermost, run, surface, top};

/// A tenth of gravity, so that the strains are below 0.1 % and the closed form of small strains holds.
const COLUMN: ElasticColumn = ElasticColumn {
    height: 10.0,
    young: PAPER_SOIL.young,
    poisson: PAPER_SOIL.poisson,
    density: PAPER_DENSITY,
    fluid_density: 0.0,
    gravity: 0.98,
    load: 0.0,
};

/// A dry column on which gravity is switched on.
fn column<const D: usize>(damping: Damping) -> Solver<D> {
    Body::<D>::column(COLUMN.height, 1.0).dry().gravity(COLUMN.gravity).damping(damping).build()
}

/// The largest deviation of the surface from the closed form, in parts of the settlement, over the last period of `periods`.
fn deviation<const D: usize>(mut solver: Solver<D>, periods: f64) -> f64 {
    let dt = 0.9 * solver.step_limits().longest();
    let steps = (periods / COLUMN.natural_frequency() / dt) as usize;
    let period = (1.0 / COLUMN.natural_frequency() / dt) as usize;
    let carriers = outermost(solver.particles(), top::<D>());
    let mut largest: f64 = 0.0;
    for step in 0..steps {
        solver.step(dt).unwrap();
        if step + period >= steps {
            let settlement = COLUMN.height - surface(solver.particles(), &carriers, top::<D>());
            largest = largest.max((settlement / COLUMN.settlement(0.0) - 1.0).abs());
        }
    }
    largest
}

/// What local damping leaves of the amplitude in a half-period, √((1 − α)/(1 + α)), and how long that lasts in undamped periods,
/// ¼ (1/√(1 − α) + 1/√(1 + α)): the stiffness is 1 − α times its own on the way in and 1 + α times on the way out.
fn local_half_period(local: f64) -> (f64, f64) {
    let left = ((1.0 - local) / (1.0 + local)).sqrt();
    (left, 0.25 * (1.0 / (1.0 - local).sqrt() + 1.0 / (1.0 + local).sqrt()))
}

#[test]
fn a_dry_column_comes_to_rest_at_the_closed_form() {
    let natural = 2.0 * PI * COLUMN.natural_frequency();
    // The column swings from nothing to twice its settlement, and without damping it still does after twenty periods.
    assert!(deviation(column::<1>(Damping::default()), 20.0) > 0.8);
    let local = Damping { local: 0.7, ..Damping::default() };
    let (left, lasts) = local_half_period(local.local);
    // Down to 1e-3, where finite strain (0.1 %) shows; higher modes have shorter periods and are at rest before.
    let periods = lasts * (1e-3_f64).ln() / left.ln() + 1.0;
    assert!(deviation(column::<1>(local), 1.5 * periods) < 2e-3);
    assert!(deviation(column::<2>(local), 1.5 * periods) < 2e-3);
    // Critical for the first mode: (1 + ω t) exp(−ω t) is 1e-3 after 9.2/2π periods.
    let mass = Damping { mass: 2.0 * natural, ..Damping::default() };
    assert!(deviation(column::<1>(mass), 1.5 * (9.2 / (2.0 * PI) + 1.0)) < 2e-3);
}

/// With α_m the first mode swings about its settlement as (cos + …) exp(−α_m t/2).
#[test]
fn mass_damping_has_the_decay_of_a_viscous_resistance() {
    let natural = 2.0 * PI * COLUMN.natural_frequency();
    let at = |ratio: f64| deviation(column::<1>(Damping { mass: 2.0 * ratio * natural, ..Damping::default() }), 5.0);
    // Between the fourth and the fifth period the first mode, 32/π³ = 1.03 of the settlement, has its peak at the fourth:
    // exp(−4 × 2π × 0.05) = 0.285 of it.
    let expected = 32.0 / PI.powi(3) * (-8.0 * PI * 0.05).exp();
    // The window starts within a step (1/70 period) of the peak, and the grid's frequency is 1 % off: some 2 % of decay.
    assert_close("amplitude", at(0.05), expected, 0.05 * expected);
}

/// The standing waves of the dry column, sin((2m+1)πz/2H), lose exp(−2πξ/√(1−ξ²)) from peak to peak with ξ = βω/2: the second
/// mode, three times as fast, has three times the ratio of the first.
#[test]
fn stiffness_damping_grows_with_the_frequency() {
    let speed = (PAPER_SOIL.oedometric_modulus() / PAPER_DENSITY).sqrt();
    let natural = 2.0 * PI * COLUMN.natural_frequency();
    let damping = Damping { stiffness: 2.0 * 0.03 / natural, ..Damping::default() };
    for mode in [1.0, 3.0] {
        let number = 0.5 * PI * mode / COLUMN.height;
        let body = Body::<1>::column(COLUMN.height, 0.5).dry().damping(damping);
        let mut solver = body.velocity(move |x| x.map(|z| 1e-3 * (number * z).sin())).build();
        // A short step: the resistance comes a step late, which takes some Δt/β = 2 % off it.
        let dt = 0.02 * damping.stiffness;
        let period = 2.0 * PI / (number * speed);
        let amplitude = |solver: &Solver<1>| {
            let particles = solver.particles();
            particles.velocity.iter().zip(&particles.position).map(|(v, x)| v[0] * (number * x[0]).sin()).sum::<f64>()
        };
        let first = amplitude(&solver);
        let mut last = 0.0_f64;
        for step in 0..(1.25 * period / dt) as usize {
            solver.step(dt).unwrap();
            if step as f64 * dt > 0.75 * period {
                last = last.max(amplitude(&solver));
            }
        }
        let ratio = 0.5 * damping.stiffness * number * speed;
        let expected = (-2.0 * PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
        // From peak to peak; the first amplitude stands at the start, not at a peak, which is a phase of asin ξ earlier:
        // v = e^(−ξωt) (cos − ξ/√(1−ξ²) sin) peaks before a whole period, with cos(asin ξ) e^(…) in all.
        assert_close("logarithmic decrement", (first / last).ln(), -expected.ln(), -0.04 * expected.ln());
    }
}

/// Saturated ground: the pressure carries two thirds of the weight, so it must count in the force out of balance; the water's
/// balance stays exact since the resistance stands inside the coupled system.
#[test]
fn saturated_ground_keeps_its_water_and_its_state_of_rest() {
    let excess = |damping: Damping| {
        let mut solver = Body::<1>::column(10.0, 1.0).drained(top::<1>()).gravity(9.8).damping(damping).build();
        let volume = |solver: &Solver<1>| solver.particles().volume.iter().sum::<f64>();
        let before = volume(&solver);
        run(&mut solver, 0.5, 400).unwrap();
        let stored = 0.4 / WATER.bulk_modulus * cell_pressures(&solver).iter().sum::<f64>();
        let lost = before - volume(&solver);
        // The stored water, 2e-4 m, is taken with the porosity and the volume of the start, which change by some 0.3 %.
        assert_close("water", solver.outflow() + stored, lost, 1e-6);
        cell_pressures(&solver)[0]
    };
    let free = excess(Damping::default());
    // Consolidation is slow: the force out of balance is a small part of the weight, and damping it changes little.
    assert_close("base pressure", excess(Damping { local: 0.7, mass: 1.0, stiffness: 0.0 }), free, 1e-3 * free);
}

/// Steps of 0.9 of the limit until the surface stays within 1 % of the closed form; `None` when it does not in 2000.
fn steps_to_rest(damping: Damping) -> Option<usize> {
    let mut solver = column::<1>(damping);
    let dt = 0.9 * solver.step_limits().longest();
    let carriers = outermost(solver.particles(), top::<1>());
    let mut last = 0;
    for step in 1..=2000 {
        solver.step(dt).unwrap();
        let settlement = COLUMN.height - surface(solver.particles(), &carriers, top::<1>());
        if (settlement / COLUMN.settlement(0.0) - 1.0).abs() > 0.01 {
            last = step;
        }
    }
    (last < 2000).then_some(last + 1)
}

#[test]
fn a_column_rests_in_fewer_steps_than_an_oscillator_of_its_first_mode() {
    assert_eq!(steps_to_rest(Damping::default()), None);
    // An oscillator needs ln(1/100)/ln(left) half-periods, 282 steps for 0.7; the higher modes, which hold 3 % of the settlement,
    // are at rest sooner.
    let damping = Damping { local: 0.7, ..Damping::default() };
    let dt = 0.9 * column::<1>(damping).step_limits().longest();
    let (left, lasts) = local_half_period(damping.local);
    let bound = (0.01_f64.ln() / left.ln()) * lasts / COLUMN.natural_frequency() / dt;
    assert!(steps_to_rest(damping).is_some_and(|steps| (steps as f64) < bound));
}
