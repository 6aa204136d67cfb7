//! A bar that swings through many cells: smooth shape functions converge with the square of the spacing, linear ones stop.
//!
//! ```text
//!    ▏━━━━━━━━━━━━━━━━━━━▕        u(X, t), 0.08 m at its largest: 5 cells of the finest grid
//!    held             held
//! ```
//!
//! # Reference
//!
//! Problem after Steffen, Kirby and Berzins (2008), Int. J. Numer. Methods Eng. 76, 922–948. There is no closed form at this
//! amplitude: the reference is the Lagrangian equation of the same bar, on a mesh of its own.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::law::LinearElastic;
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline};
use tsutsumi::tensor::Vector;
use tsutsumi::transfer::Transfer;
use tsutsumi_testkit::body::Body;
use tsutsumi_testkit::compare::{observed_order, root_mean_square};
use tsutsumi_testkit::reading::run;

/// Stiffness (Pa) and density (kg/m³) of a bar 1 m long: waves of 1 m/s.
const BAR: LinearElastic = LinearElastic { young: 1000.0, poisson: 0.0 };
const DENSITY: f64 = 1000.0;

/// The largest velocity at the start (m/s): v = v₀ sin πX, so that u reaches about v₀/π.
const SPEED: f64 = 0.25;

/// The end (s): the middle has gone to its farthest, come back and swung to the other side.
const END: f64 = 1.4;

/// Displacements (m) of the points X = (i + ½)/points at the end, by central differences in X and leapfrog in t:
///
/// ```text
/// ρ ü = ∂σ/∂X      σ = E ln(1 + ∂u/∂X)      the sum of Δσ = E Δε over the steps
/// ```
fn reference(points: usize) -> Vec<f64> {
    let elements = 1600;
    let dx = 1.0 / elements as f64;
    let dt = 0.25 * dx;
    let mut displacement = vec![0.0; elements + 1];
    let mut velocity: Vec<f64> = (0..=elements).map(|i| SPEED * (std::f64::consts::PI * i as f64 * dx).sin()).collect();
    // The first velocity stands at t = 0 where nothing pulls, so it is that of ½ Δt too, up to Δt².
    for _ in 0..(END / dt).round() as usize {
        // The ends have the velocity sin π = 1e-16 or none.
        for (displacement, velocity) in displacement.iter_mut().zip(&velocity) {
            *displacement += dt * velocity;
        }
        let stress = |i: usize| BAR.young * ((displacement[i + 1] - displacement[i]) / dx).ln_1p();
        for (i, velocity) in velocity.iter_mut().enumerate().take(elements).skip(1) {
            *velocity += dt / DENSITY * (stress(i) - stress(i - 1)) / dx;
        }
    }
    let at = |x: f64| {
        let place = x / dx;
        let i = place as usize;
        displacement[i] + (place - i as f64) * (displacement[i + 1] - displacement[i])
    };
    (0..points).map(|p| at((p as f64 + 0.5) / points as f64)).collect()
}

/// Root mean square of the error of the displacements (m) on a grid of so many cells.
fn error(shape: impl Transfer<1> + 'static, cells: usize, per_cell: usize) -> f64 {
    let mut solver = Body::<1>::free(Vector::zeros(), Vector::repeat(1.0), 1.0 / cells as f64, [cells])
        .in_a_box()
        .dry()
        .law(BAR)
        .density(DENSITY)
        .particles_per_cell([per_cell])
        .shape(shape)
        .velocity(|x| Vector::repeat(SPEED * (std::f64::consts::PI * x[0]).sin()))
        .build();
    let before = solver.particles().position.clone();
    // The step falls with h², as the scheme is of first order in time.
    let steps = (END * 0.5 * (cells * cells) as f64).round() as usize;
    run(&mut solver, END / steps as f64, steps).unwrap();
    let expected = reference(before.len());
    let differences: Vec<f64> = solver
        .particles()
        .position
        .iter()
        .zip(&before)
        .zip(expected)
        .map(|((now, before), expected)| now[0] - before[0] - expected)
        .collect();
    root_mean_square(&differences)
}

/// Errors at each spacing and the order at which they fall.
fn errors_and_order<S: Transfer<1> + Copy + 'static>(
    problem: impl Fn(S, usize) -> f64,
    shape: S,
) -> ([(f64, f64); 3], f64) {
    let errors = [16, 32, 64].map(|cells| (1.0 / cells as f64, problem(shape, cells)));
    (errors, observed_order(&errors))
}

/// The same bar with free ends, carried through the grid at this speed (m/s) while it vibrates a little.
const CARRIED: f64 = 0.3;

/// The largest velocity (m/s) of the vibration: strains of 1e-4, of which finite strain shows a part of 1e-4.
const LITTLE: f64 = 1e-4;

/// Root mean square of the error of the displacements over the amplitude. Closed form, c = 1 m/s:
///
/// ```text
/// u = U t + v₀/π cos πX sin πt
/// ```
fn error_carried(shape: impl Transfer<1> + 'static, cells: usize, per_cell: usize) -> f64 {
    let pi = std::f64::consts::PI;
    let from = 0.3;
    let mut solver = Body::<1>::free(Vector::repeat(from), Vector::repeat(from + 1.0), 1.0 / cells as f64, [2 * cells])
        .dry()
        .law(BAR)
        .density(DENSITY)
        .particles_per_cell([per_cell])
        .shape(shape)
        .velocity(move |x| Vector::repeat(CARRIED + LITTLE * (pi * (x[0] - from)).cos()))
        .build();
    let before = solver.particles().position.clone();
    let steps = (END * 0.5 * (cells * cells) as f64).round() as usize;
    run(&mut solver, END / steps as f64, steps).unwrap();
    let differences: Vec<f64> = solver
        .particles()
        .position
        .iter()
        .zip(&before)
        .map(|(now, before)| {
            let wave = LITTLE / pi * (pi * (before[0] - from)).cos() * (pi * END).sin();
            (now[0] - before[0] - CARRIED * END - wave) / (LITTLE / pi)
        })
        .collect();
    root_mean_square(&differences)
}

/// Large strains, up to 25 %: boxes that stretch and smooth splines follow them, boxes of one size and linear functions do not.
/// The quadratic splines, with their kinks half way between the nodes, need more particles for the same sums.
#[test]
fn a_bar_that_swings_through_cells_converges_with_the_square_of_the_spacing() {
    let (errors, order) = errors_and_order(|shape, cells| error(shape, cells, 4), CpGimp);
    assert!(order >= 1.8, "cpgimp: order {order} from {errors:?}");
    let (errors, order) = errors_and_order(|shape, cells| error(shape, cells, 4), CubicBSpline);
    assert!(order >= 1.8, "bspline3: order {order} from {errors:?}");
    let (errors, order) = errors_and_order(|shape, cells| error(shape, cells, 8), QuadraticBSpline);
    assert!(order >= 1.8, "bspline2: order {order} from {errors:?}");
    // What the others are for: the finer the grid, the more lines are crossed.
    let (errors, order) = errors_and_order(|shape, cells| error(shape, cells, 4), Linear);
    assert!(order < 0.0, "linear: order {order} from {errors:?}");
}

/// Small strains on a body that passes up to 27 grid lines: boxes of one size are enough.
#[test]
fn a_carried_bar_converges_with_the_square_of_the_spacing() {
    fn assert_second_order<S: Transfer<1> + Copy + 'static>(name: &str, shape: S) -> f64 {
        let (errors, order) = errors_and_order(|shape, cells| error_carried(shape, cells, 2), shape);
        assert!(order >= 1.8, "{name}: order {order} from {errors:?}");
        errors[1].1
    }
    let boxes = assert_second_order("gimp", Gimp);
    assert_second_order("cpgimp", CpGimp);
    assert_second_order("bspline2", QuadraticBSpline);
    assert_second_order("bspline3", CubicBSpline);
    let linear = error_carried(Linear, 32, 2);
    assert!(linear > 10.0 * boxes, "linear: {linear} beside {boxes}");
}
