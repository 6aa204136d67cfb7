//! The sums that are made for a row of nodes at a time, against the plain ones.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::cell::RefCell;
use std::ops::Range;

use tsutsumi::grid::{Grid, NodeFields};
use tsutsumi::particles::{LocalMotion, Particles};
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline};
use tsutsumi::solver::Solver;
use tsutsumi::tensor::{Matrix, Sym3, Vector};
use tsutsumi::transfer::{Gathered, GatheredBlock, Transfer, Wanted};
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

/// Mass, momentum and force of a node are sums over all particles, in any order: the same but for rounding.
fn nodes_get_the_plain_sums<const D: usize>(shape: impl Transfer<D> + Copy + 'static) {
    let solver = body::<D>(shape);
    let (grid, active, mut particles) = (solver.grid(), solver.active(), solver.particles().clone());
    let mut noise = Noise::new(17);
    for local_motion in [LocalMotion::Nothing, LocalMotion::Moments, LocalMotion::Gradient] {
        particles.keep(local_motion);
        for motion in &mut particles.local_motion {
            *motion = Matrix::from_fn(|_, _| noise.vector::<1>()[0]);
        }
        let mut nodes = NodeFields::new(grid);
        shape.particles_to_nodes(grid, active, &particles, local_motion, &mut nodes);
        let mut momentum = NodeFields::new(grid).velocity_old;
        shape.spread_momentum(grid, active, &particles, local_motion, &mut momentum);
        let plain = plain_sums(&shape, grid, &particles, local_motion);
        let total: f64 = particles.mass.iter().sum();
        for (node, momentum) in momentum.iter().enumerate() {
            // Some hundred terms of the order of the largest, and moments times the inverse of a small spread.
            assert!((nodes.mass[node] - plain.mass[node]).abs() < 1e-14 * total);
            assert!((nodes.velocity_old[node] - plain.velocity_old[node]).norm() < 1e-13 * total);
            assert!((momentum - plain.velocity_old[node]).norm() < 1e-13 * total);
            assert!((nodes.force[node] - plain.force[node]).norm() < 1e-13);
        }
    }
}

/// Eqs. (5) and (10) as they stand, particle by particle, with the motion around each.
fn plain_sums<const D: usize>(
    shape: &impl Transfer<D>,
    grid: &Grid<D>,
    particles: &Particles<D>,
    local_motion: LocalMotion,
) -> NodeFields<D> {
    let mut nodes = NodeFields::new(grid);
    for p in 0..particles.len() {
        let arm = |node: usize| grid.node_position(node) - particles.position[p];
        let mut spread = Matrix::<D>::zeros();
        shape.visit_weights(grid, particles, p, &mut |node, value, _| {
            spread += arm(node) * arm(node).transpose() * value;
        });
        let around = match local_motion {
            LocalMotion::Nothing => Matrix::zeros(),
            LocalMotion::Gradient => particles.local_motion[p],
            LocalMotion::Moments => {
                particles.local_motion[p] * Matrix::from_diagonal(&spread.diagonal().map(|d| 1.0 / d))
            }
        };
        shape.visit_weights(grid, particles, p, &mut |node, value, gradient| {
            let velocity = particles.velocity[p] + around * arm(node);
            nodes.mass[node] += particles.mass[p] * value;
            nodes.velocity_old[node] += velocity * (particles.mass[p] * value);
            nodes.force[node] -= particles.stress.at(p).dot(&gradient) * particles.volume[p];
        });
    }
    nodes
}

/// Particles find a row at a time what they find node by node, but for rounding, and in any block the same bits.
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
    let find = |range: Range<usize>, acceleration: bool, wants_moments: bool| {
        let (mut block, mut moments) = (GatheredBlock::new(), vec![Matrix::zeros(); range.len()]);
        let wanted = Wanted { acceleration, moments: if wants_moments { &mut moments } else { &mut [] } };
        shape.gather_block(grid, &nodes, particles.places().part(range), wanted, &mut block);
        (block, moments)
    };
    let (whole, moments_of_whole) = find(0..particles.len().min(64), true, true);
    for (length, start) in [(64, 0), (63, 1), (17, 2), (1, 3)] {
        let range = start..particles.len().min(start + length);
        for (acceleration, wants_moments) in [(false, false), (true, false), (false, true), (true, true)] {
            let (block, moments) = find(range.clone(), acceleration, wants_moments);
            for p in range.clone() {
                let (found, moments, mut expected) = (block.at(p - start), moments[p - start], plain[p]);
                if !acceleration {
                    expected.acceleration = Vector::zeros();
                }
                if !wants_moments {
                    expected.moments = Matrix::zeros();
                }
                // Values of order one, gradients of up to a few; 4^D terms.
                assert!((found.velocity - expected.velocity).norm() < 1e-14, "particle {p}");
                assert!((found.acceleration - expected.acceleration).norm() < 1e-14, "particle {p}");
                assert!((found.velocity_gradient - expected.velocity_gradient).norm() < 1e-13, "particle {p}");
                assert!((moments - expected.moments).norm() < 1e-14, "particle {p}");
                if acceleration && wants_moments {
                    assert_eq!((found, moments), (whole.at(p), moments_of_whole[p]), "particle {p}");
                }
            }
        }
        let mut block = GatheredBlock::new();
        shape.gather_gradients(grid, &nodes.velocity, particles.places().part(range.clone()), &mut block);
        for p in range {
            assert_eq!(block.at(p - start).velocity_gradient, whole.at(p).velocity_gradient);
            assert_eq!(block.at(p - start).velocity, Vector::<D>::zeros());
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
