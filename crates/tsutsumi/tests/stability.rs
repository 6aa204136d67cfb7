//! How long may a step be? Noise in the velocities dies out or stays below the limit, and takes over above it.
//!
//! ```text
//!      growth │        ╱
//!             │       ╱
//!           1 ├──────┘
//!             └──────┴────── Δt
//!                  limit
//! ```

use std::cell::RefCell;

use tsutsumi::damping::Damping;
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, QuadraticBSpline};
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::Mpm2;
use tsutsumi_testkit::body::{Body, PAPER_DENSITY, PAPER_SOIL};
use tsutsumi_testkit::noise::Noise;
use tsutsumi_testkit::reading::{largest_speed, run, top};

/// How much speeds of 1e-9 m/s have grown after some steps; infinite when the run ends in an error.
fn growth<const D: usize>(body: Body<D>, dt: f64, steps: usize) -> f64 {
    let noise = RefCell::new(Noise::new(5));
    let mut solver = body.velocity(move |_| noise.borrow_mut().vector() * 1e-9).build();
    let before = largest_speed(solver.particles());
    match run(&mut solver, dt, steps) {
        Ok(()) => largest_speed(solver.particles()) / before,
        Err(_) => f64::INFINITY,
    }
}

/// Asserts that a body, with either velocity update, keeps still with a step of `stable` and not with `unstable` (s).
#[track_caller]
fn assert_limit_between<const D: usize>(make: impl Fn() -> Body<D>, stable: f64, unstable: f64, steps: usize) {
    for mpm2 in [false, true] {
        let body = || if mpm2 { make().velocity_update(Mpm2) } else { make() };
        // Velocities that the grid does not see stay on the particles with MPM①: they neither grow nor fade.
        let grown = growth(body(), stable, steps);
        assert!(grown < 2.0, "{D}-D, MPM② {mpm2}: grown {grown:e} times with a step of {stable} s");
        let grown = growth(body(), unstable, steps);
        assert!(
            grown.is_nan() || grown > 100.0,
            "{D}-D, MPM② {mpm2}: grown {grown:e} times with a step of {unstable} s"
        );
    }
}

/// A saturated layer, drained at its top.
fn wet<const D: usize>(height: f64, width: usize) -> Body<D> {
    Body::layer(height, 1.0, width).drained(top::<D>())
}

/// 1-D, drag-dominated: Δt ≤ (1 + √(1 + 4 τ c_v κ²)) / (c_v κ²) = 5.380 s.
#[test]
fn a_saturated_column_is_stable_up_to_the_consolidation_limit() {
    let limit = wet::<1>(10.0, 1).build().step_limits().longest();
    assert!((limit - 5.380).abs() < 1e-3, "{limit}");
    assert_limit_between::<1>(|| wet(10.0, 1), 0.95 * limit, 1.2 * limit, 2000);
}

/// 2-D and 3-D: hourglass modes. The limit is for particles anywhere in a cell, h/√((E_oed + (D−1) G)/ρ); with 2 per axis
/// at the quarter points it lies some 1.45 (2-D) and 1.54 (3-D) times higher: an independent program found 0.0125 s stable and
/// 0.015 s unstable in 2-D.
#[test]
fn hourglass_modes_limit_the_step_in_2d_and_3d() {
    let plane = wet::<2>(10.0, 1).build().step_limits().longest();
    assert!((plane - 9.13e-3).abs() < 1e-5, "{plane}");
    assert_limit_between::<2>(|| wet(10.0, 1), 0.9 * plane, 0.015, 2000);
    assert_limit_between::<2>(|| wet(10.0, 1), 0.0125, 0.015, 2000);
    assert_limit_between::<2>(|| wet(4.0, 4), 0.9 * plane, 0.015, 2000);
    let space = wet::<3>(10.0, 1).build().step_limits().longest();
    assert!((space - 8.77e-3).abs() < 1e-5, "{space}");
    assert_limit_between::<3>(|| wet(10.0, 1), 0.9 * space, 1.7 * space, 2000);
    assert_limit_between::<3>(|| wet(3.0, 3), 0.9 * space, 1.7 * space, 1000);
}

/// With the volume change of the cell, hourglass modes have the stiffness of shear alone: h/√(2G/ρ) = 22.4 ms in 2-D and
/// h/√(10/3 G/ρ) = 17.3 ms in 3-D, 2.4 and 2 times longer.
#[test]
fn averaged_volume_changes_lift_the_hourglass_limit() {
    let plane = wet::<2>(10.0, 1).cell_averaged().build().step_limits().longest();
    assert!((plane - 22.36e-3).abs() < 1e-5, "{plane}");
    assert_limit_between::<2>(|| wet(10.0, 1).cell_averaged(), 0.95 * plane, 2.1 * plane, 2000);
    assert_limit_between::<2>(|| wet(4.0, 4).cell_averaged(), 0.95 * plane, 2.1 * plane, 2000);
    let space = wet::<3>(10.0, 1).cell_averaged().build().step_limits().longest();
    assert!((space - 17.32e-3).abs() < 1e-5, "{space}");
    assert_limit_between::<3>(|| wet(3.0, 3).cell_averaged(), 0.95 * space, 2.1 * space, 1000);
}

/// Dry: the way p → i → p smooths the accelerations that the particles see by a factor 0 ≤ S ≤ 1, while they move with
/// v_I^L. With w = (ω Δt)² a mode is stable for w < 4/(2 − S) (MPM①) and w < 2 (1 + S) (MPM②).
///
/// For the shortest wave, ω = 2/h √(E_oed/ρ), S = ¼ with 2 particles per cell at the quarter points and 0 with one at the
/// centre: Δt ≤ 0.756 h/c (MPM①), 0.791 h/c (MPM②), and h/√2c in any case.
#[test]
fn a_dry_column_is_stable_up_to_the_wave_limit() {
    let courant = 1.0 / (PAPER_SOIL.oedometric_modulus() / PAPER_DENSITY).sqrt();
    let dry = |per_cell: usize| move || Body::<1>::column(10.0, 1.0).dry().particles_per_cell([per_cell]);
    assert_limit_between::<1>(dry(1), 0.69 * courant, 0.73 * courant, 3000);
    assert_limit_between::<1>(dry(2), 0.74 * courant, 0.82 * courant, 3000);
    assert_limit_between::<1>(dry(4), 0.70 * courant, 0.85 * courant, 3000);
    // In 2-D and 3-D G stiffens the shortest waves.
    let shear = |count: f64| {
        let stiffness = PAPER_SOIL.oedometric_modulus() + count * PAPER_SOIL.shear_modulus();
        1.0 / (stiffness / PAPER_DENSITY).sqrt()
    };
    let plane = || Body::<2>::layer(4.0, 1.0, 4).dry();
    assert_limit_between::<2>(plane, 0.7 * shear(1.0), 1.1 * shear(1.0), 2000);
    let space = || Body::<3>::layer(3.0, 1.0, 3).dry();
    assert_limit_between::<3>(space, 0.7 * shear(2.0), 1.3 * shear(2.0), 1000);
}

/// The limits that the solver states are safe for bodies whose surface is on a grid line.
///
/// They take S = 0, see [`a_dry_column_is_stable_up_to_the_wave_limit`].
#[test]
fn the_stated_limits_are_safe_on_grid_lines() {
    fn safe<const D: usize>(make: impl Fn() -> Body<D>, steps: usize) {
        for mpm2 in [false, true] {
            let body = || if mpm2 { make().velocity_update(Mpm2) } else { make() };
            let limits = body().build().step_limits();
            let grown = growth(body(), 0.95 * limits.longest(), steps);
            assert!(grown < 2.0, "{D}-D, MPM② {mpm2}: grown {grown:e} times at 0.95 of {limits:?}");
        }
    }
    safe::<1>(|| Body::<1>::column(10.0, 1.0).dry(), 3000);
    safe::<2>(|| Body::<2>::layer(4.0, 1.0, 4).dry().cell_averaged(), 2000);
    for (local, mass, stiffness) in [(0.8, 0.0, 0.0), (0.0, 100.0, 0.0), (0.0, 0.0, 5e-3), (0.5, 50.0, 2e-3)] {
        let damping = Damping { local, mass, stiffness };
        safe::<1>(move || Body::<1>::column(10.0, 1.0).dry().damping(damping), 3000);
        for conductivity in [1e-9, 5.52e-5, 1e-2, 1e-1, 1.0] {
            let wet = move |height, width| wet::<2>(height, width).damping(damping).conductivity(move |_| conductivity);
            safe::<2>(move || wet(4.0, 2), 2000);
            safe::<2>(move || wet(4.0, 2).cell_averaged(), 2000);
            let column = move || self::wet::<1>(10.0, 1).damping(damping).conductivity(move |_| conductivity);
            safe::<1>(column, 3000);
        }
    }
    safe::<2>(|| Body::<2>::layer(4.0, 1.0, 4).dry(), 2000);
    safe::<3>(|| Body::<3>::layer(3.0, 1.0, 3).dry(), 1000);
    for conductivity in [1e-9, 5.52e-5, 1e-2, 1e-1, 1.0] {
        safe::<1>(|| wet(10.0, 1).conductivity(move |_| conductivity), 3000);
        safe::<2>(|| wet(4.0, 2).conductivity(move |_| conductivity), 2000);
        safe::<3>(|| wet(3.0, 2).conductivity(move |_| conductivity), 500);
        safe::<2>(|| wet(4.0, 2).conductivity(move |_| conductivity).cell_averaged(), 2000);
        safe::<3>(|| wet(3.0, 2).conductivity(move |_| conductivity).cell_averaged(), 500);
    }
}

/// The stated limits are safe too while the surface moves through a cell.
///
/// With a part φ of the top cell filled, its node has the stiffness φ E_oed/h, the force φ p and the resistance
/// γ_w φ h/2k, hence Δt → φ² h²/c_v for small φ. The edge of stability is at 3.82 s (φ = ¾), 1.94 s (½), 0.556 s (¼),
/// 0.0986 s (0.1), 0.0258 s (0.05) for h = 1 m; Gershgorin's bound is a little below.
#[test]
fn the_stated_limits_are_safe_inside_cells() {
    for filled in [0.75, 0.5, 0.25, 0.1] {
        let column = || wet::<1>(9.0 + filled, 1).particles_per_cell([20]);
        let limit = column().build().step_limits().longest();
        let grown = growth(column(), 0.95 * limit, 1000);
        assert!(grown < 2.0, "{filled} of the top cell filled: grown {grown:e} times at 0.95 of {limit} s");
    }
}

/// With smooth shape functions the nodes that a surface barely reaches are light: wherever the surface stands, the limit holds.
fn a_layer_is_stable_wherever_its_surface_is<const D: usize>(
    shape: impl Transfer<D> + Copy + 'static,
    (width, steps): (usize, usize),
    heights: &[f64],
) {
    for &height in heights {
        for (dry, mpm2) in [(false, false), (false, true), (true, false), (true, true)] {
            let body = || {
                let body = Body::<D>::layer(height, 1.0, width).drained(top::<D>()).shape(shape);
                let body = if mpm2 { body.velocity_update(Mpm2) } else { body };
                if dry { body.dry() } else { body }
            };
            let limit = body().build().step_limits().longest();
            let grown = growth(body(), 0.95 * limit, steps);
            let run = format!("{D}-D, {height} m, dry {dry}, MPM② {mpm2}");
            assert!(grown < 2.0, "{run}: grown {grown:e} times with a step of {limit} s");
        }
    }
}

#[test]
fn a_layer_is_stable_wherever_its_surface_is_in_1d() {
    let heights: Vec<f64> = (0..50).map(|step| 5.0 + 0.02 * f64::from(step)).collect();
    a_layer_is_stable_wherever_its_surface_is::<1>(Gimp, (1, 2000), &heights);
    a_layer_is_stable_wherever_its_surface_is::<1>(CpGimp, (1, 2000), &heights);
    a_layer_is_stable_wherever_its_surface_is::<1>(QuadraticBSpline, (1, 2000), &heights);
    a_layer_is_stable_wherever_its_surface_is::<1>(CubicBSpline, (1, 2000), &heights);
}

#[test]
fn a_layer_is_stable_wherever_its_surface_is_in_2d() {
    let heights = [5.0, 5.02, 5.25, 5.77];
    a_layer_is_stable_wherever_its_surface_is::<2>(Gimp, (3, 600), &heights);
    a_layer_is_stable_wherever_its_surface_is::<2>(CpGimp, (3, 600), &heights);
    a_layer_is_stable_wherever_its_surface_is::<2>(QuadraticBSpline, (3, 600), &heights);
    a_layer_is_stable_wherever_its_surface_is::<2>(CubicBSpline, (3, 600), &heights);
}
