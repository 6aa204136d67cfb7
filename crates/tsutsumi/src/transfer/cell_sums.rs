use std::ops::Range;

use super::bands::NodeSums;
use super::stencil::Stencil;
use crate::grid::{ActiveSet, Grid};
use crate::lanes::{Four, Kernel, Vectors};
use crate::particles::Particles;
use crate::shape::{MAX_WIDTH, ShapeFunction};

/// Adds the sums of Eqs. (5) and (10) over the particles of a cell to its nodes: they touch the grid once per cell, not once per particle.
#[inline(always)]
pub(super) fn add_cell<S: ShapeFunction, X: Vectors, const D: usize>(
    vectors: X,
    shape: &S,
    grid: &Grid<D>,
    particles: &Particles<D>,
    of_cell: &[u32],
    nodes: &mut NodeSums<D>,
) {
    // The compiler knows which one it is, and so the length of every loop.
    match S::WIDTH.pow(D as u32) {
        2 | 4 => add::<S, X, D, 1>(vectors, shape, grid, particles, of_cell, nodes),
        8 => add::<S, X, D, 2>(vectors, shape, grid, particles, of_cell, nodes),
        16 => add::<S, X, D, 4>(vectors, shape, grid, particles, of_cell, nodes),
        _ => add::<S, X, D, 16>(vectors, shape, grid, particles, of_cell, nodes),
    }
}

/// Four nodes to a vector, `V` vectors to a stencil.
#[inline(always)]
fn add<S: ShapeFunction, X: Vectors, const D: usize, const V: usize>(
    vectors: X,
    shape: &S,
    grid: &Grid<D>,
    particles: &Particles<D>,
    of_cell: &[u32],
    nodes: &mut NodeSums<D>,
) {
    let Some(&first) = of_cell.first() else { return };
    let places = particles.places();
    let index = grid.index_of(&grid.in_spacings(&places.position[first as usize]));
    let zeros = [Four::splat(vectors, 0.0); V];
    let (mut mass_sum, mut momentum_sum) = (zeros, [zeros; D]);
    let mut force_sum = momentum_sum;
    for &p in of_cell {
        let p = p as usize;
        let mass = particles.mass[p];
        let velocity = particles.velocity[p];
        let stress = particles.stress[p].block::<D>(-particles.volume[p]);
        let (value, gradient) = weights::<S, X, D, V>(vectors, &Stencil::of_particle_in(shape, grid, index, places, p));
        for v in 0..V {
            mass_sum[v] += value[v] * mass;
        }
        for i in 0..D {
            let momentum = velocity[i] * mass;
            for v in 0..V {
                momentum_sum[i][v] += value[v] * momentum;
                let mut force = gradient[0][v] * stress[i][0];
                for j in 1..D {
                    force += gradient[j][v] * stress[i][j];
                }
                force_sum[i][v] += force;
            }
        }
    }
    let mass_sum = mass_sum.map(Four::to_array);
    let momentum_sum = momentum_sum.map(|component| component.map(Four::to_array));
    let force_sum = force_sum.map(|component| component.map(Four::to_array));
    let stencil = Stencil::of_particle_in(shape, grid, index, places, first as usize);
    for row in 0..S::WIDTH.pow(D as u32 - 1) {
        let first_node = stencil.first_node_of_row(S::WIDTH, row) - nodes.first;
        let range = first_node..first_node + S::WIDTH;
        let (mass, momentum, force) =
            (&mut nodes.mass[range.clone()], &mut nodes.momentum[range.clone()], &mut nodes.force[range]);
        for k in 0..S::WIDTH {
            let (v, lane) = ((row * S::WIDTH + k) / 4, (row * S::WIDTH + k) % 4);
            mass[k] += mass_sum[v][lane];
            for axis in 0..D {
                momentum[k][axis] += momentum_sum[axis][v][lane];
                force[k][axis] += force_sum[axis][v][lane];
            }
        }
    }
}

/// N (–) and ∇N (1/m), component by component, of all nodes of a stencil, x fastest; zeros in lanes beyond the last one.
#[inline(always)]
fn weights<S: ShapeFunction, X: Vectors, const D: usize, const V: usize>(
    vectors: X,
    stencil: &Stencil<D>,
) -> ([Four<X>; V], [[Four<X>; V]; D]) {
    let ones = [Four::splat(vectors, 1.0); V];
    let (mut value, mut gradient) = (ones, [ones; D]);
    for v in 0..V {
        let mut stride = 1;
        for axis in 0..D {
            let along = &stencil.weights[axis];
            let value_along = lanes::<S, X, D>(vectors, &along.value, v, stride);
            let gradient_along = lanes::<S, X, D>(vectors, &along.gradient, v, stride) * stencil.inverse_spacing[axis];
            value[v] *= value_along;
            for (component, gradient) in gradient.iter_mut().enumerate() {
                gradient[v] *= if component == axis { gradient_along } else { value_along };
            }
            stride *= S::WIDTH;
        }
    }
    (value, gradient)
}

/// The weights along an axis at the four nodes of vector number `v`; `stride` nodes on, the next one along the axis follows.
#[inline(always)]
fn lanes<S: ShapeFunction, X: Vectors, const D: usize>(
    vectors: X,
    along: &[f64; MAX_WIDTH],
    v: usize,
    stride: usize,
) -> Four<X> {
    let at = |node: usize| if node < S::WIDTH.pow(D as u32) { along[node / stride % S::WIDTH] } else { 0.0 };
    Four::new(vectors, [at(4 * v), at(4 * v + 1), at(4 * v + 2), at(4 * v + 3)])
}

/// The cells of a band, one after the other.
pub(super) struct BandSums<'a, S, const D: usize> {
    pub(super) shape: &'a S,
    pub(super) grid: &'a Grid<D>,
    pub(super) active: &'a ActiveSet,
    pub(super) particles: &'a Particles<D>,
    pub(super) slots: Range<usize>,
    pub(super) nodes: NodeSums<'a, D>,
}

impl<S: ShapeFunction, const D: usize> Kernel for BandSums<'_, S, D> {
    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        let BandSums { shape, grid, active, particles, slots, mut nodes } = self;
        for slot in slots {
            add_cell(vectors, shape, grid, particles, active.particles_of(slot), &mut nodes);
        }
    }
}
