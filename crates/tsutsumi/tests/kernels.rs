//! The sums that are made for several particles at a time, against the plain ones.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::cell::RefCell;

use tsutsumi::grid::NodeFields;
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline};
use tsutsumi::solver::Solver;
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi::transfer::{Gathered, GatheredBlock, Transfer};
use tsutsumi_testkit::body::Body;
use tsutsumi_testkit::noise::Noise;

/// A body at odds with the grid, with noise in all that is summed.
fn body<const D: usize>(shape: impl Transfer<D> + 'static) -> Solver<D> {
    let noise = || RefCell::new(Noise::new(11));
    let (velocities, stresses, places) = (noise(), noise(), noise());
    Body::<D>::free(Vector::repeat(0.3), Vector::repeat(4.3), 1.0, [6; D])
        .shape(shape)
        .particles_per_cell([3; D])
        .velocity(move |_| velocities.borrow_mut().vector())
        .stress(move |_| stresses.borrow_mut().tensor() - Sym3::IDENTITY)
        .moved(move |position| position + places.borrow_mut().vector() * 0.1)
        .build()
}

/// In reach of its cell, mass, momentum and force of a node are sums over all particles, in any order: the same but for rounding.
fn nodes_get_the_plain_sums<const D: usize>(shape: impl Transfer<D> + Copy + 'static) {
    let solver = body::<D>(shape);
    let (grid, particles) = (solver.grid(), solver.particles());
    let mut nodes = NodeFields::new(grid);
    shape.particles_to_nodes(grid, solver.active(), particles, &mut nodes);
    let mut plain = NodeFields::new(grid);
    for p in 0..particles.len() {
        shape.visit_weights(grid, particles, p, &mut |node, value, gradient| {
            plain.mass[node] += particles.mass[p] * value;
            plain.velocity_old[node] += particles.velocity[p] * (particles.mass[p] * value);
            plain.force[node] -= particles.stress[p].dot(&gradient) * particles.volume[p];
        });
    }
    let total: f64 = particles.mass.iter().sum();
    for node in 0..grid.num_nodes() {
        // Some hundred terms of the order of the largest.
        assert!((nodes.mass[node] - plain.mass[node]).abs() < 1e-14 * total);
        assert!((nodes.velocity_old[node] - plain.velocity_old[node]).norm() < 1e-13 * total);
        assert!((nodes.force[node] - plain.force[node]).norm() < 1e-13);
    }
}

/// Four particles at a time find, bit by bit, what each finds for itself, whether they are in one cell or not.
fn blocks_find_the_plain_sums<const D: usize>(shape: impl Transfer<D> + Copy + 'static) {
    let solver = body::<D>(shape);
    let (grid, particles) = (solver.grid(), solver.particles());
    let mut noise = Noise::new(13);
    let mut nodes = NodeFields::new(grid);
    for node in 0..grid.num_nodes() {
        nodes.velocity[node] = noise.vector();
        nodes.acceleration[node] = noise.vector();
    }
    let mut plain = vec![Gathered::default(); particles.len()];
    shape.nodes_to_particles(grid, &nodes, particles.places(), &mut plain);
    for (length, start) in [(64, 0), (63, 1), (5, 2), (1, 3)] {
        let range = start..particles.len().min(start + length);
        let mut block = GatheredBlock::new();
        shape.gather_block(grid, &nodes, particles.places().part(range.clone()), &mut block);
        for (p, plain) in range.clone().zip(&plain[range]) {
            assert_eq!(block.at(p - start), *plain, "particle {p}");
        }
    }
}

macro_rules! for_all_shapes {
    ($check:ident) => {
        $check::<1>(Linear);
        $check::<2>(Linear);
        $check::<3>(Linear);
        $check::<1>(Gimp);
        $check::<2>(Gimp);
        $check::<3>(CpGimp);
        $check::<2>(CpGimp);
        $check::<1>(QuadraticBSpline);
        $check::<2>(QuadraticBSpline);
        $check::<3>(QuadraticBSpline);
        $check::<2>(CubicBSpline);
        $check::<3>(CubicBSpline);
    };
}

#[test]
fn nodes_get_the_plain_sums_of_every_shape_function() {
    for_all_shapes!(nodes_get_the_plain_sums);
}

#[test]
fn blocks_find_the_plain_sums_of_every_shape_function() {
    for_all_shapes!(blocks_find_the_plain_sums);
}
