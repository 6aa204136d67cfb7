use std::ops::Range;

use super::chunk::{CHUNK, ChunkWeights, Layer};
use super::rows::first_lanes;
use super::stencil::Stencil;
use super::{Gathered, GatheredBlock};
use crate::grid::{Grid, NodeFields};
use crate::lanes::{Four, Kernel, Vectors};
use crate::law::BLOCK;
use crate::particles::Places;
use crate::shape::{MAX_WIDTH, ShapeFunction};
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

/// What a block of particles finds on the grid: the sums of [`gather_plainly`], a row of nodes along x at a time.
///
/// Weights are products over the axes: a row is summed with the weights along x, rows with those along y, layers with those along z.
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
    const MANY_NUMBERS: bool = S::WIDTH > 2;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        // The compiler knows which one it is, and so the length of every loop.
        match S::WIDTH.div_ceil(nodes_per_vector(D)) {
            1 => self.gather::<X, 1, 1>(vectors),
            2 => self.gather::<X, 2, 1>(vectors),
            3 => self.gather::<X, 3, 2>(vectors),
            _ => self.gather::<X, 4, 3>(vectors),
        }
    }
}

/// Whole nodes in a vector of four numbers: in 3-D the last number is that of another node, and means nothing.
const fn nodes_per_vector(dimensions: usize) -> usize {
    4 / dimensions
}

impl<S: ShapeFunction, const D: usize, const A: bool, const M: bool> GatherBlock<'_, S, D, A, M> {
    /// Rows are `V` vectors long, or `LESS` if a node is left out that has one of its own.
    #[inline(always)]
    fn gather<X: Vectors, const V: usize, const LESS: usize>(self, vectors: X) {
        let GatherBlock { shape, grid, velocity, acceleration, places, gradients_only, block } = self;
        // One length, known to be the same: one check per row.
        let acceleration = if A { &acceleration[..velocity.len()] } else { acceleration };
        let len = places.position.len().min(BLOCK);
        for start in (0..len).step_by(CHUNK) {
            let chunk = start..len.min(start + CHUNK);
            block.weights.find::<S, M>(shape, grid, places, chunk.clone());
            for (i, p) in chunk.enumerate() {
                let point = Point { weights: &block.weights, grid, i };
                let reached = if D > 2 { block.weights.reached::<S>(0, i) } else { 0..S::WIDTH };
                let sums = match reached.len() == S::WIDTH {
                    true => point.sums::<X, S, A, M, V>(vectors, reached, velocity, acceleration),
                    false => point.sums::<X, S, A, M, LESS>(vectors, reached, velocity, acceleration),
                };
                if !gradients_only {
                    sums.give_velocity::<A>(p, block);
                }
                sums.give_variation::<M>(p, block);
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

impl<const D: usize> Point<'_, D> {
    /// The sums over all layers and rows, of the nodes `reached` along x.
    #[inline(always)]
    fn sums<X: Vectors, S: ShapeFunction, const A: bool, const M: bool, const V: usize>(
        &self,
        vectors: X,
        reached: Range<usize>,
        velocity: &[Vector<D>],
        acceleration: &[Vector<D>],
    ) -> Sums<X, D> {
        let &Point { weights, grid, i } = self;
        let along_x = AlongX::<X, V>::new::<M, D>(vectors, weights, i, reached.start);
        let nodes = if D > 2 { V } else { S::WIDTH };
        let first_node = weights.first_node(i) + reached.start as u32;
        let along_y = weights.layers::<S>(grid, 1, i);
        let mut sums = Sums::zeros(vectors);
        for z in weights.layers::<S>(grid, 2, i) {
            let mut layer = Sums::zeros(vectors);
            for y in along_y.clone() {
                let first = (first_node + z.offset + y.offset) as usize;
                let row = first..first + nodes;
                let acceleration = if A { &acceleration[row.clone()] } else { acceleration };
                let row = along_x.sum::<A, M, D>(vectors, &velocity[row], acceleration);
                row.add_to::<A, M>(&mut layer, 1, &y);
            }
            layer.add_to::<A, M>(&mut sums, 2, &z);
        }
        sums
    }
}

/// A particle's weights along x, spread over the components of the nodes in each vector of a row.
struct AlongX<X: Vectors, const V: usize> {
    value: [Four<X>; V],
    gradient: [Four<X>; V],
    moment: [Four<X>; V],
}

impl<X: Vectors, const V: usize> AlongX<X, V> {
    #[inline(always)]
    fn new<const M: bool, const D: usize>(vectors: X, weights: &ChunkWeights<D>, i: usize, start: usize) -> Self {
        let zeros = [Four::splat(vectors, 0.0); V];
        let mut along = AlongX { value: zeros, gradient: zeros, moment: zeros };
        for v in 0..V {
            let node =
                |lane: usize| (start + v * nodes_per_vector(D) + (lane / D).min(nodes_per_vector(D) - 1)) % MAX_WIDTH;
            let spread =
                |of: &dyn Fn(usize) -> f64| Four::new(vectors, [of(node(0)), of(node(1)), of(node(2)), of(node(3))]);
            along.value[v] = spread(&|k| weights.value(0, k, i));
            along.gradient[v] = spread(&|k| weights.gradient(0, k, i));
            if M {
                along.moment[v] = spread(&|k| weights.moment(0, k, i));
            }
        }
        along
    }

    /// The sums over a row.
    #[inline(always)]
    fn sum<const A: bool, const M: bool, const D: usize>(
        &self,
        vectors: X,
        velocity: &[Vector<D>],
        acceleration: &[Vector<D>],
    ) -> Sums<X, D> {
        let mut sums = Sums::zeros(vectors);
        for v in 0..V {
            let here = vector_of_row(vectors, velocity, v);
            sums.velocity += here * self.value[v];
            sums.gradient[0] += here * self.gradient[v];
            if M {
                sums.moment[0] += here * self.moment[v];
            }
            if A {
                sums.acceleration += vector_of_row(vectors, acceleration, v) * self.value[v];
            }
        }
        sums
    }
}

/// Vector number `v` of a row of nodes.
#[inline(always)]
fn vector_of_row<X: Vectors, const D: usize>(vectors: X, row: &[Vector<D>], v: usize) -> Four<X> {
    let numbers: &[f64] = bytemuck::cast_slice(row);
    let start = v * nodes_per_vector(D) * D;
    if let Some(four) = numbers[start..].first_chunk() {
        return Four::new(vectors, *four);
    }
    if D == 3 {
        // The last node of the row: what stands in the last lane means nothing.
        if let Some(&[x, y, z]) = numbers[start..].first_chunk() {
            return Four::new(vectors, [x, y, z, z]);
        }
    }
    first_lanes(vectors, &numbers[start..])
}

/// Sums over nodes, for each component and each node of a vector.
#[derive(Clone, Copy)]
struct Sums<X: Vectors, const D: usize> {
    velocity: Four<X>,
    acceleration: Four<X>,
    /// With the gradient along an axis in place of the value.
    gradient: [Four<X>; D],
    /// With the value times the arm along an axis.
    moment: [Four<X>; D],
}

impl<X: Vectors, const D: usize> Sums<X, D> {
    /// −0, since only x − 0 is x whatever x is, and costs nothing.
    #[inline(always)]
    fn zeros(vectors: X) -> Self {
        let zeros = Four::splat(vectors, -0.0);
        Sums { velocity: zeros, acceleration: zeros, gradient: [zeros; D], moment: [zeros; D] }
    }

    /// Adds these sums of a row or layer to those over all layers along an axis.
    #[inline(always)]
    fn add_to<const A: bool, const M: bool>(&self, sums: &mut Self, axis: usize, layer: &Layer) {
        if axis >= D {
            *sums = *self;
            return;
        }
        sums.velocity += self.velocity * layer.value;
        if A {
            sums.acceleration += self.acceleration * layer.value;
        }
        for j in 0..axis {
            sums.gradient[j] += self.gradient[j] * layer.value;
            if M {
                sums.moment[j] += self.moment[j] * layer.value;
            }
        }
        sums.gradient[axis] += self.velocity * layer.gradient;
        if M {
            sums.moment[axis] += self.velocity * layer.moment;
        }
    }

    /// Velocity and acceleration of particle number `p` of a block.
    #[inline(always)]
    fn give_velocity<const A: bool>(self, p: usize, block: &mut GatheredBlock<D>) {
        for (to, velocity) in block.velocity.iter_mut().zip(components::<X, D>(self.velocity)) {
            to[p] = velocity;
        }
        if A {
            for (to, acceleration) in block.acceleration.iter_mut().zip(components::<X, D>(self.acceleration)) {
                to[p] = acceleration;
            }
        }
    }

    /// How the velocity varies around it.
    #[inline(always)]
    fn give_variation<const M: bool>(self, p: usize, block: &mut GatheredBlock<D>) {
        for j in 0..D {
            for (to, gradient) in block.velocity_gradient.iter_mut().zip(components::<X, D>(self.gradient[j])) {
                to[j][p] = gradient;
            }
            if M {
                for (i, moment) in components::<X, D>(self.moment[j]).into_iter().enumerate() {
                    block.moments[p][(i, j)] = moment;
                }
            }
        }
    }
}

/// The sum over the nodes in a vector of each component.
#[inline(always)]
fn components<X: Vectors, const D: usize>(sums: Four<X>) -> [f64; D] {
    let lanes = sums.to_array();
    std::array::from_fn(|i| {
        let mut sum = lanes[i];
        for node in 1..nodes_per_vector(D) {
            sum += lanes[D * node + i];
        }
        sum
    })
}
