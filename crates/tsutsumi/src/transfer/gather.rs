use super::stencil::Stencil;
use super::{Gathered, GatheredBlock};
use crate::grid::{Grid, NodeFields};
use crate::lanes::{Four, Kernel, Vectors};
use crate::law::BLOCK;
use crate::particles::Places;
use crate::shape::{CellOnAxis, MAX_WIDTH, ShapeFunction, Weights};
use crate::tensor::{Matrix, Vector};

/// Particles side by side in one vector.
const LANES: usize = 4;

/// What one particle finds on the grid: the plain sums, which [`GatherBlock`] makes for several particles at a time.
#[inline(always)]
pub(super) fn gather_plainly<S: ShapeFunction, const D: usize>(
    shape: &S,
    grid: &Grid<D>,
    nodes: &NodeFields<D>,
    places: Places<D>,
    p: usize,
) -> Gathered<D> {
    let (mut velocity, mut acceleration) = (Vector::zeros(), Vector::zeros());
    let mut velocity_gradient = Matrix::zeros();
    Stencil::of_particle(shape, grid, places, p).visit::<S>(|_, node, value, gradient| {
        for i in 0..D {
            velocity[i] += nodes.velocity[node][i] * value;
            acceleration[i] += nodes.acceleration[node][i] * value;
            for j in 0..D {
                velocity_gradient[(i, j)] += nodes.velocity[node][i] * gradient[j];
            }
        }
    });
    Gathered { velocity, acceleration, velocity_gradient }
}

/// What a block of particles finds on the grid: the same sums as [`gather_plainly`], bit by bit, for four particles at a time.
pub(super) struct GatherBlock<'a, S, const D: usize> {
    pub(super) shape: &'a S,
    pub(super) grid: &'a Grid<D>,
    pub(super) nodes: &'a NodeFields<D>,
    pub(super) places: Places<'a, D>,
    pub(super) block: &'a mut GatheredBlock<D>,
}

impl<S: ShapeFunction, const D: usize> Kernel for GatherBlock<'_, S, D> {
    #[inline(always)]
    fn run<V: Vectors>(self, vectors: V) {
        let GatherBlock { shape, grid, nodes, places, block } = self;
        let len = places.position.len();
        debug_assert!(len <= BLOCK);
        for start in (0..len).step_by(LANES) {
            let stencils = Stencils::new(vectors, shape, grid, places, start);
            let (velocity, acceleration, gradient) = stencils.sum::<S>(vectors, nodes);
            for i in 0..D {
                block.velocity[i][start..start + LANES].copy_from_slice(&velocity[i].to_array());
                block.acceleration[i][start..start + LANES].copy_from_slice(&acceleration[i].to_array());
                for (to, from) in block.velocity_gradient[i].iter_mut().zip(gradient[i]) {
                    to[start..start + LANES].copy_from_slice(&from.to_array());
                }
            }
        }
    }
}

/// The stencils of four particles.
struct Stencils<V: Vectors, const D: usize> {
    first_node: [usize; LANES],
    strides: [usize; D],
    /// N (–) and dN/dx (1/m) along each axis, node by node.
    value: [[Four<V>; MAX_WIDTH]; D],
    gradient: [[Four<V>; MAX_WIDTH]; D],
}

impl<V: Vectors, const D: usize> Stencils<V, D> {
    /// Those of the particles from number `start` on; the last one fills up the lanes.
    #[inline(always)]
    fn new<S: ShapeFunction>(vectors: V, shape: &S, grid: &Grid<D>, places: Places<D>, start: usize) -> Self {
        let strides = grid.node_strides();
        let mut first_node = [0; LANES];
        let zeros = [[Four::splat(vectors, 0.0); MAX_WIDTH]; D];
        let (mut value, mut gradient) = (zeros, zeros);
        let half_sizes = if S::BOX_STRETCHES { places.half_size } else { places.half_size_at_start };
        let last = places.position.len() - 1;
        for axis in 0..D {
            let (origin, inverse_spacing) = (grid.origin()[axis], grid.inverse_spacing()[axis]);
            let num_cells = grid.cells()[axis];
            let mut weights = [Weights::default(); LANES];
            for l in 0..LANES {
                let p = (start + l).min(last);
                let place = (places.position[p][axis] - origin) * inverse_spacing;
                let at = CellOnAxis { cell: grid.index_on(axis, place), num_cells };
                let half_size = if S::REACH > 0.0 { half_sizes[p][axis] * inverse_spacing } else { 0.0 };
                weights[l] = shape.weights(at, place, half_size);
                first_node[l] += shape.first_node(at) * strides[axis];
            }
            let [a, b, c, d] = weights;
            for k in 0..S::WIDTH {
                value[axis][k] = Four::new(vectors, [a.value[k], b.value[k], c.value[k], d.value[k]]);
                let along = Four::new(vectors, [a.gradient[k], b.gradient[k], c.gradient[k], d.gradient[k]]);
                gradient[axis][k] = along * inverse_spacing;
            }
        }
        Stencils { first_node, strides, value, gradient }
    }

    /// Velocity, acceleration and velocity gradient (component, axis).
    #[inline(always)]
    fn sum<S: ShapeFunction>(&self, vectors: V, nodes: &NodeFields<D>) -> Found<V, D> {
        let zeros = [Four::splat(vectors, 0.0); D];
        let (mut velocity, mut acceleration, mut gradient) = (zeros, zeros, [zeros; D]);
        let [first, others @ ..] = self.first_node;
        let in_one_cell = others.iter().all(|&node| node == first);
        for row in 0..S::WIDTH.pow(D as u32 - 1) {
            let (offset, row_value, row_gradient) = self.row(vectors, S::WIDTH, row);
            for k in 0..S::WIDTH {
                let value = row_value * self.value[0][k];
                let mut along = [row_value * self.gradient[0][k]; D];
                for j in 1..D {
                    along[j] = row_gradient[j] * self.value[0][k];
                }
                let places = self.first_node.map(|first| first + offset + k);
                for i in 0..D {
                    let v = take(vectors, &nodes.velocity, i, places, in_one_cell);
                    velocity[i] += v * value;
                    acceleration[i] += take(vectors, &nodes.acceleration, i, places, in_one_cell) * value;
                    for j in 0..D {
                        gradient[i][j] += v * along[j];
                    }
                }
            }
        }
        (velocity, acceleration, gradient)
    }

    /// The first node of a row along x, counted from that of the stencil, and what the other axes make of its values and gradients.
    #[inline(always)]
    fn row(&self, vectors: V, width: usize, number: usize) -> (usize, Four<V>, [Four<V>; D]) {
        let (mut offset, mut value, mut gradient) = (0, Four::splat(vectors, 1.0), [Four::splat(vectors, 1.0); D]);
        let mut rest = number;
        for axis in 1..D {
            let k = rest % width;
            rest /= width;
            offset += k * self.strides[axis];
            value *= self.value[axis][k];
            for (other, gradient) in gradient.iter_mut().enumerate().skip(1) {
                *gradient *= if other == axis { self.gradient[axis][k] } else { self.value[axis][k] };
            }
        }
        (offset, value, gradient)
    }
}

/// Velocity, acceleration and velocity gradient of four particles.
type Found<V, const D: usize> = ([Four<V>; D], [Four<V>; D], [[Four<V>; D]; D]);

/// A component of a field at the nodes of four particles, which may be the same one.
#[inline(always)]
fn take<V: Vectors, const D: usize>(
    vectors: V,
    field: &[Vector<D>],
    component: usize,
    nodes: [usize; LANES],
    is_one: bool,
) -> Four<V> {
    let [a, b, c, d] = nodes;
    match is_one {
        true => Four::splat(vectors, field[a][component]),
        false => {
            let values = [field[a][component], field[b][component], field[c][component], field[d][component]];
            Four::new(vectors, values)
        }
    }
}
