//! Bodies that have turned or sheared, so that the material points stand askew in the cells.
//!
//! ```text
//!      ╱╲            ┌─┬─╱╲┬─┐
//!     ╱  ╲ ↺         │ │╱  ╲ │   boxes stay along the axes,
//!     ╲  ╱           ├─╱────╲┤   with gaps and overlaps between them
//!      ╲╱            │╱│   │╲│
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline, ShapeFunction};
use tsutsumi::tensor::{Matrix, Vector};
use tsutsumi::transfer::Transfer;
use tsutsumi_testkit::body::Body;
use tsutsumi_testkit::compare::{assert_close, root_mean_square};
use tsutsumi_testkit::reading::run;

/// The force out of balance at the inner nodes of a body under a uniform stress, over that on a side of a cell: root mean square of
/// Σ_p Ω_p ∇N_I / h. It should be zero: the integral of ∇N_I over the body is, where N_I does not reach its surface.
fn out_of_balance(shape: impl ShapeFunction + Copy, per_cell: usize, deformation: Matrix<2>) -> f64 {
    let (spacing, center) = (0.5, Vector::repeat(6.0));
    let half = Vector::repeat(3.0);
    let solver = Body::<2>::free(center - half, center + half, spacing, [24; 2])
        .dry()
        .particles_per_cell([per_cell; 2])
        .shape(shape)
        // Somewhere in the cells, as bodies are that have moved.
        .moved(move |x| center + deformation * (x - center) + Vector::from([0.137, 0.071]))
        .build();
    let (grid, particles) = (solver.grid(), solver.particles());
    let mut sums = vec![Vector::<2>::zeros(); grid.num_nodes()];
    for p in 0..particles.len() {
        let transfer: &dyn Transfer<2> = &shape;
        let add = &mut |node: usize, _: f64, gradient| sums[node] += gradient * (particles.volume[p] / spacing);
        transfer.visit_weights(grid, particles, p, add);
    }
    // The square of 1.5 m is inside all the bodies here, with the reach of the shape functions around it.
    let is_inner = |node: usize| (grid.node_position(node) - center).amax() <= 0.75;
    let inner = (0..grid.num_nodes()).filter(|&node| is_inner(node));
    let components: Vec<f64> = inner.flat_map(|node| [sums[node][0], sums[node][1]]).collect();
    root_mean_square(&components)
}

fn turn(angle: f64) -> Matrix<2> {
    Matrix::<2>::new(angle.cos(), -angle.sin(), angle.sin(), angle.cos())
}

/// Points on a lattice along the axes leave nothing out of balance. Turned or sheared they do, as the boxes do not turn with them:
/// with boxes and quadratic splines far less than with linear functions, with cubic splines hardly anything. Boxes that turn and shear would
/// make it zero.
#[test]
fn a_uniform_stress_is_out_of_balance_where_points_stand_askew() {
    for per_cell in [2, 4] {
        let shear = Matrix::<2>::new(1.0, 0.3, 0.2, 1.06);
        let degrees = |angle: f64| turn(angle.to_radians());
        for (askew, deformation) in [(false, degrees(0.0)), (true, degrees(10.0)), (true, degrees(45.0)), (true, shear)]
        {
            let linear = out_of_balance(Linear, per_cell, deformation);
            let boxes = out_of_balance(Gimp, per_cell, deformation);
            let stretching = out_of_balance(CpGimp, per_cell, deformation);
            let quadratic = out_of_balance(QuadraticBSpline, per_cell, deformation);
            let cubic = out_of_balance(CubicBSpline, per_cell, deformation);
            // Shear does not change boxes.
            assert_eq!(boxes, stretching);
            if askew {
                assert!(linear > 0.01 && boxes.max(quadratic) < linear / 5.0 && cubic < boxes / 20.0);
            } else {
                // Sums of some tens of parts of the size of one.
                for sum in [linear, boxes, quadratic, cubic] {
                    assert_close("on a lattice along the axes", sum, 0.0, 1e-14);
                }
            }
        }
    }
}

/// How far a particle of a free square has got from the middle at most, over where it started, turning with 1 rad/s by `angle`.
fn farthest(shape: impl ShapeFunction + Copy, dt: f64, angle: f64) -> f64 {
    let (center, half) = (Vector::from([3.03, 2.98]), Vector::repeat(1.0));
    let mut solver = Body::<2>::free(center - half, center + half, 0.5, [12; 2])
        .dry()
        .shape(shape)
        .velocity(move |x| Vector::from([-(x - center)[1], (x - center)[0]]))
        .build();
    let start = solver.particles().position.clone();
    let steps = (angle / dt) as usize;
    // A particle that is thrown out of the grid counts too.
    let _ = run(&mut solver, dt, steps);
    let pairs = solver.particles().position.iter().zip(&start);
    pairs.map(|(now, then)| (now - center).norm() / (then - center).norm()).fold(0.0, f64::max)
}

/// With linear functions the corner of a free body throws a particle as it enters a cell. The new nodes have the mass M N and carry
/// the force Ω σ ∇N: as N vanishes and ∇N does not, no step is short enough for them. A node is too light, ω² = c²/(h² N) > 4/Δt²,
/// as long as N < c² Δt²/4h², and at speed v that lasts for c² Δt/(4 h v) steps. With c² = 12 000 m²/s² and 1.2 m/s these are 2.5 for
/// 0.5 ms and none for 0.1 ms. With boxes and splines |∇N|²/N is bounded, and the longer step will do.
#[test]
fn a_free_square_that_turns_keeps_its_corners_with_boxes_and_splines() {
    assert!(farthest(Linear, 5e-4, 0.25) > 1.5);
    // A rigid turn. Centrifugal forces stretch it by ρ ω² r²/E < 0.001, noise by some more.
    assert_close("linear, short steps", farthest(Linear, 1e-4, 0.5), 1.0, 0.01);
    assert_close("uniform boxes", farthest(Gimp, 5e-4, 1.6), 1.0, 0.01);
    assert_close("boxes that stretch", farthest(CpGimp, 5e-4, 1.6), 1.0, 0.01);
    assert_close("quadratic splines", farthest(QuadraticBSpline, 5e-4, 1.6), 1.0, 0.01);
    assert_close("cubic splines", farthest(CubicBSpline, 5e-4, 1.6), 1.0, 0.01);
}
