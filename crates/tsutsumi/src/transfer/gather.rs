use super::chunk::{CHUNK, ChunkWeights};
use super::rows::Row;
use super::stencil::Stencil;
use super::{Gathered, GatheredBlock};
use crate::grid::{Grid, NodeFields};
use crate::lanes::{Kernel, Vectors};
use crate::law::BLOCK;
use crate::particles::Places;
use crate::shape::ShapeFunction;
use crate::tensor::{Matrix, Vector};

/// What one particle finds on the grid: the plain sums, which [`GatherBlock`] makes for a row of nodes at a time.
#[inline(always)]
pub(super) fn gather_plainly<S: ShapeFunction, const D: usize>(
    shape: &S,
    grid: &Grid<D>,
    nodes: &NodeFields<D>,
    places: Places<D>,
    p: usize,
) -> Gathered<D> {
    let (mut velocity, mut acceleration) = (Vector::zeros(), Vector::zeros());
    let (mut velocity_gradient, mut moments) = (Matrix::zeros(), Matrix::zeros());
    let stencil = Stencil::of_particle(shape, grid, places, p);
    stencil.visit::<S>(|local, node, value, gradient| {
        let arm = stencil.arm::<S>(&grid.spacing(), local);
        for i in 0..D {
            velocity[i] += nodes.velocity[node][i] * value;
            acceleration[i] += nodes.acceleration[node][i] * value;
            for j in 0..D {
                velocity_gradient[(i, j)] += nodes.velocity[node][i] * gradient[j];
                moments[(i, j)] += nodes.velocity[node][i] * value * arm[j];
            }
        }
    });
    Gathered { velocity, acceleration, velocity_gradient, moments }
}

/// What a block of particles finds on the grid: the sums of [`gather_plainly`], a row of nodes at a time.
///
/// Weights are products over the axes: along x they are the same in every row, and multiply the sum over the rows.
pub(super) struct GatherBlock<'a, S, const D: usize, const ACCELERATION: bool, const MOMENTS: bool> {
    pub(super) shape: &'a S,
    pub(super) grid: &'a Grid<D>,
    /// The fields of the nodes; accelerations may be missing where they are not asked for.
    pub(super) velocity: &'a [Vector<D>],
    pub(super) acceleration: &'a [Vector<D>],
    pub(super) places: Places<'a, D>,
    pub(super) gradients_only: bool,
    pub(super) block: &'a mut GatheredBlock<D>,
}

impl<S: ShapeFunction, const D: usize, const A: bool, const M: bool> Kernel for GatherBlock<'_, S, D, A, M> {
    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        // The compiler knows which one it is, and so the length of every loop.
        match (S::WIDTH * D).div_ceil(4) {
            1 => self.gather::<X, 1>(vectors),
            2 => self.gather::<X, 2>(vectors),
            _ => self.gather::<X, 3>(vectors),
        }
    }
}

impl<S: ShapeFunction, const D: usize, const A: bool, const M: bool> GatherBlock<'_, S, D, A, M> {
    #[inline(always)]
    fn gather<X: Vectors, const V: usize>(self, vectors: X) {
        let GatherBlock { shape, grid, velocity, acceleration, places, gradients_only, block } = self;
        // One length, known to be the same: one check per row.
        let acceleration = if A { &acceleration[..velocity.len()] } else { acceleration };
        let len = places.position.len().min(BLOCK);
        for start in (0..len).step_by(CHUNK) {
            let chunk = start..len.min(start + CHUNK);
            block.weights.find::<S, M>(shape, grid, places, chunk.clone());
            for (i, p) in chunk.enumerate() {
                let point = Point { weights: &block.weights, grid, i };
                let sums = RowSums::<X, V, D>::of::<S, A, M>(vectors, &point, velocity, acceleration);
                if !gradients_only {
                    sums.give_velocity::<A>(vectors, i, p, block);
                }
                sums.give_variation::<M>(vectors, i, p, block);
            }
        }
    }
}

/// A particle of a chunk.
struct Point<'a, const D: usize> {
    weights: &'a ChunkWeights<D>,
    grid: &'a Grid<D>,
    i: usize,
}

/// The sums over the rows of a stencil, for each of the nodes along x.
#[derive(Clone, Copy)]
struct RowSums<X: Vectors, const V: usize, const D: usize> {
    velocity: Row<X, V>,
    acceleration: Row<X, V>,
    /// With the gradient along an axis in place of the value; that along x is not used.
    gradient: [Row<X, V>; D],
    /// Times the arm along an axis; that along x is not used.
    moment: [Row<X, V>; D],
}

impl<X: Vectors, const V: usize, const D: usize> RowSums<X, V, D> {
    #[inline(always)]
    fn zeros(vectors: X) -> Self {
        let zeros = Row::zeros(vectors);
        RowSums { velocity: zeros, acceleration: zeros, gradient: [zeros; D], moment: [zeros; D] }
    }

    #[inline(always)]
    fn of<S: ShapeFunction, const A: bool, const M: bool>(
        vectors: X,
        point: &Point<D>,
        velocity: &[Vector<D>],
        acceleration: &[Vector<D>],
    ) -> Self {
        let &Point { weights, grid, i } = point;
        let first_node = weights.first_node(i);
        let mut sums = RowSums::zeros(vectors);
        for z in weights.layers::<S>(grid, 2, i) {
            let mut layer = RowSums::zeros(vectors);
            for y in weights.layers::<S>(grid, 1, i) {
                let first = (first_node + z.offset + y.offset) as usize;
                let row = first..first + S::WIDTH;
                let v = Row::read(vectors, bytemuck::cast_slice(&velocity[row.clone()]));
                layer.velocity += v * y.value;
                if D > 1 {
                    layer.gradient[1] += v * y.gradient;
                }
                if M && D > 1 {
                    layer.moment[1] += v * y.moment;
                }
                if A {
                    layer.acceleration += Row::read(vectors, bytemuck::cast_slice(&acceleration[row])) * y.value;
                }
            }
            if D < 3 {
                return layer;
            }
            sums.velocity += layer.velocity * z.value;
            sums.gradient[1] += layer.gradient[1] * z.value;
            sums.gradient[2] += layer.velocity * z.gradient;
            if M {
                sums.moment[1] += layer.moment[1] * z.value;
                sums.moment[2] += layer.velocity * z.moment;
            }
            if A {
                sums.acceleration += layer.acceleration * z.value;
            }
        }
        sums
    }

    /// Velocity and acceleration of particle number `p` of a block: sums over the nodes along x.
    #[inline(always)]
    fn give_velocity<const A: bool>(self, vectors: X, number: usize, p: usize, block: &mut GatheredBlock<D>) {
        let value = Row::of_nodes(vectors, D, block.weights.value(number));
        let velocity: [f64; D] = (self.velocity * value).sum_over_nodes();
        for i in 0..D {
            block.velocity[i][p] = velocity[i];
        }
        if A {
            let acceleration: [f64; D] = (self.acceleration * value).sum_over_nodes();
            for i in 0..D {
                block.acceleration[i][p] = acceleration[i];
            }
        }
    }

    /// How the velocity varies around it.
    #[inline(always)]
    fn give_variation<const M: bool>(self, vectors: X, number: usize, p: usize, block: &mut GatheredBlock<D>) {
        let value = Row::of_nodes(vectors, D, block.weights.value(number));
        let gradient = Row::of_nodes(vectors, D, block.weights.gradient(number));
        let moment = Row::of_nodes(vectors, D, block.weights.moment(number));
        for j in 0..D {
            let gradient = if j == 0 { self.velocity * gradient } else { self.gradient[j] * value };
            let gradient: [f64; D] = gradient.sum_over_nodes();
            for i in 0..D {
                block.velocity_gradient[i][j][p] = gradient[i];
            }
            if M {
                let moments = if j == 0 { self.velocity * moment } else { self.moment[j] * value };
                let moments: [f64; D] = moments.sum_over_nodes();
                for i in 0..D {
                    block.moments[p][(i, j)] = moments[i];
                }
            }
        }
    }
}
