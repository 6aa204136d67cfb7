use std::ops::Range;

use super::Gathered;
use super::chunk::{ChunkWeights, ChunkWork};
use super::corners::GatherCorners;
use super::rows::{Row, first_lanes};
use super::stencil::Stencil;
use super::sums::{AxisWeights, Sums};
use crate::grid::{Grid, NodeFields};
use crate::lanes::{self, Four, Kernel, Vectors};
use crate::law::BLOCK;
use crate::particles::Places;
use crate::shape::ShapeFunction;
use crate::tensor::{Matrix, Vector};

/// What one particle finds on the grid: the plain sums, which [`GatherChunk`] makes for a row of nodes at a time.
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

/// What a chunk of particles finds on the grid: the sums of [`gather_plainly`], a row of nodes along x at a time.
///
/// Weights are products over the axes: a row is summed with the weights along x, rows with those along y, layers with those along z.
///
/// It knows no shape function, only weights, and fields as plain numbers: so it is compiled once, for every dimension and width, and not again
/// wherever a shape function is used.
pub(super) struct GatherChunk<'a> {
    pub(super) weights: &'a ChunkWeights,
    /// The fields of the nodes; empty accelerations are not asked for.
    pub(super) velocity: &'a [f64],
    pub(super) acceleration: &'a [f64],
    pub(super) moments: bool,
    pub(super) gradients_only: bool,
    /// Where in the block the chunk begins.
    pub(super) start: usize,
    pub(super) found: Found<'a>,
}

/// The components of [`GatheredBlock`](super::GatheredBlock), each for a whole block; the moments are matrices column by column.
pub(super) struct Found<'a> {
    pub(super) velocity: &'a mut [[f64; BLOCK]],
    pub(super) acceleration: &'a mut [[f64; BLOCK]],
    pub(super) velocity_gradient: &'a mut [[f64; BLOCK]],
    pub(super) moments: &'a mut [f64],
}

/// [`Found`] in so many dimensions.
pub(super) struct FoundIn<'a, const D: usize> {
    pub(super) velocity: &'a mut [[f64; BLOCK]; D],
    pub(super) acceleration: &'a mut [[f64; BLOCK]; D],
    pub(super) velocity_gradient: &'a mut [[[f64; BLOCK]; D]; D],
    pub(super) moments: &'a mut [[[f64; D]; D]; BLOCK],
}

impl<'a, const D: usize> FoundIn<'a, D> {
    /// None if something has another length than a block has in so many dimensions.
    #[inline(always)]
    pub(super) fn new(found: Found<'a>) -> Option<Self> {
        Some(FoundIn {
            velocity: found.velocity.first_chunk_mut()?,
            acceleration: found.acceleration.first_chunk_mut()?,
            velocity_gradient: found.velocity_gradient.as_chunks_mut().0.first_chunk_mut()?,
            moments: found.moments.as_chunks_mut().0.as_chunks_mut().0.first_chunk_mut()?,
        })
    }
}

impl GatherChunk<'_> {
    /// Makes the sums.
    pub(super) fn run(self) {
        self.weights.choose(self);
    }
}

impl ChunkWork for GatherChunk<'_> {
    fn run_with_corners<const D: usize>(self) {
        match (self.acceleration.is_empty(), self.moments) {
            (true, false) => lanes::run(GatherCorners::<D, false, false>(self)),
            (false, false) => lanes::run(GatherCorners::<D, true, false>(self)),
            (true, true) => lanes::run(GatherCorners::<D, false, true>(self)),
            (false, true) => lanes::run(GatherCorners::<D, true, true>(self)),
        }
    }

    fn run_with_rows<const D: usize, const WIDTH: usize>(self) {
        match (self.acceleration.is_empty(), self.moments) {
            (true, false) => lanes::run(Gather::<D, WIDTH, false, false>(self)),
            (false, false) => lanes::run(Gather::<D, WIDTH, true, false>(self)),
            (true, true) => lanes::run(Gather::<D, WIDTH, false, true>(self)),
            (false, true) => lanes::run(Gather::<D, WIDTH, true, true>(self)),
        }
    }
}

/// The same, with or without accelerations and moments.
pub(super) struct Gather<'a, const D: usize, const WIDTH: usize, const A: bool, const M: bool>(
    pub(super) GatherChunk<'a>,
);

impl<const D: usize, const WIDTH: usize, const A: bool, const M: bool> Kernel for Gather<'_, D, WIDTH, A, M> {
    const MANY_NUMBERS: bool = true;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        // The compiler knows which one it is, and so the length of every loop.
        match WIDTH.div_ceil(nodes_per_vector(D)) {
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

impl<const D: usize, const WIDTH: usize, const A: bool, const M: bool> Gather<'_, D, WIDTH, A, M> {
    /// Rows are `V` vectors long, or `LESS` if a node is left out that has one of its own.
    #[inline(always)]
    fn gather<X: Vectors, const V: usize, const LESS: usize>(self, vectors: X) {
        let GatherChunk { weights, velocity, acceleration, gradients_only, start, found, .. } = self.0;
        let Some(mut found) = FoundIn::<D>::new(found) else { return };
        let (velocity, acceleration) = (velocity.as_chunks().0, acceleration.as_chunks().0);
        // One length, known to be the same: one check per row.
        let acceleration = if A { &acceleration[..velocity.len()] } else { acceleration };
        for (i, p) in (start..BLOCK).enumerate().take(weights.len()) {
            let reached = if D > 2 { weights.reached::<WIDTH>(0, i) } else { 0..WIDTH };
            let sums = match reached.len() == WIDTH {
                true => Self::sums::<X, V>(vectors, weights, i, reached, velocity, acceleration),
                false => Self::sums::<X, LESS>(vectors, weights, i, reached, velocity, acceleration),
            };
            sums.give_variation::<M>(p, &mut found);
            if !gradients_only {
                sums.give_velocity::<A>(p, &mut found);
            }
        }
    }

    /// The sums of a particle over all layers and rows, of the nodes `reached` along x.
    #[inline(always)]
    fn sums<X: Vectors, const V: usize>(
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
        reached: Range<usize>,
        velocity: &[[f64; D]],
        acceleration: &[[f64; D]],
    ) -> Sums<Four<X>, D> {
        let nodes = Nodes { first: weights.first_node(i) + reached.start as u32, velocity, acceleration };
        let mut sums = match D > 2 {
            true => nodes.sum_layers::<X, V, WIDTH, A, M>(vectors, weights, i, reached),
            false => nodes.sum_columns::<X, V, WIDTH, A, M>(vectors, weights, i),
        };
        if M {
            for axis in 1..D {
                let last = weights.reached::<WIDTH>(axis, i).end - 1;
                sums.finish_moment(axis, weights.arm(axis, last, i), -weights.spacing(axis));
            }
        }
        sums
    }
}

/// The fields of the nodes, and the first one that a particle reaches.
struct Nodes<'a, const D: usize> {
    first: u32,
    velocity: &'a [[f64; D]],
    acceleration: &'a [[f64; D]],
}

impl<const D: usize> Nodes<'_, D> {
    /// In space: the nodes of a row, each in a vector of its own, the rows of a layer, the layers.
    #[inline(always)]
    fn sum_layers<X: Vectors, const V: usize, const WIDTH: usize, const A: bool, const M: bool>(
        &self,
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
        reached: Range<usize>,
    ) -> Sums<Four<X>, D> {
        let along_x: [AxisWeights<f64>; V] = std::array::from_fn(|v| weights.of_node(0, reached.start + v, i));
        let along_y = weights.layers::<D, WIDTH>(1, i);
        let zero = Four::splat(vectors, -0.0);
        let mut sums = Sums::zeros(zero);
        for z in weights.layers::<D, WIDTH>(2, i) {
            let mut layer = Sums::zeros(zero);
            for y in along_y.clone() {
                let first = (self.first + z.offset + y.offset) as usize;
                let velocity = &self.velocity[first..first + V];
                let acceleration = if A { &self.acceleration[first..first + V] } else { self.acceleration };
                let mut row = Sums::zeros(zero);
                for (v, x) in along_x.iter().enumerate() {
                    let velocity = vector_of_row(vectors, velocity, v);
                    let acceleration = if A { vector_of_row(vectors, acceleration, v) } else { zero };
                    row.add::<_, A, M>(&Sums { velocity, acceleration, ..Sums::zeros(zero) }, 0, x);
                }
                layer.add::<_, A, M>(&row, 1, &y.weights);
            }
            sums.add::<_, A, M>(&layer, 2, &z.weights);
        }
        if M {
            sums.finish_moment(0, weights.arm(0, reached.end - 1, i), -weights.spacing(0));
        }
        sums
    }

    /// In the plane: the rows as they lie in memory, with the weights along y; then the nodes of their sum, of which several are in a vector.
    #[inline(always)]
    fn sum_columns<X: Vectors, const V: usize, const WIDTH: usize, const A: bool, const M: bool>(
        &self,
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
    ) -> Sums<Four<X>, D> {
        let zero = Row::<X, V>::zeros(vectors);
        let mut columns = Sums::<_, D>::zeros(zero);
        for y in weights.layers::<D, WIDTH>(1, i) {
            let first = (self.first + y.offset) as usize;
            let row = |field: &[[f64; D]]| Row::of_numbers(vectors, field[first..first + WIDTH].as_flattened());
            let acceleration = if A { row(self.acceleration) } else { zero };
            let row = Sums { velocity: row(self.velocity), acceleration, ..Sums::zeros(zero) };
            columns.add::<_, A, M>(&row, 1, &y.weights);
        }
        let value = along_x::<X, V, D, WIDTH>(vectors, |k| weights.value(0, k, i));
        let gradient = along_x::<X, V, D, WIDTH>(vectors, |k| weights.gradient(0, k, i));
        let mut sums = Sums::zeros(Four::splat(vectors, -0.0));
        sums.velocity = columns.velocity.dot(vectors, value);
        sums.gradient[0] = columns.velocity.dot(vectors, gradient);
        if A {
            sums.acceleration = columns.acceleration.dot(vectors, value);
        }
        for axis in 1..D {
            sums.gradient[axis] = columns.gradient[axis].dot(vectors, value);
            sums.moment[axis] = columns.moment[axis].dot(vectors, value);
        }
        if M {
            let arm = along_x::<X, V, D, WIDTH>(vectors, |k| weights.arm(0, k, i));
            sums.moment[0] = columns.velocity.dot(vectors, value * arm);
        }
        sums
    }
}

/// One number for each of the `WIDTH` nodes of a row, and zeros for what the vectors are longer.
#[inline(always)]
fn along_x<X: Vectors, const V: usize, const D: usize, const WIDTH: usize>(
    vectors: X,
    of_node: impl Fn(usize) -> f64,
) -> Row<X, V> {
    Row::of_nodes(vectors, D, |k| if k < WIDTH { of_node(k) } else { 0.0 })
}

/// Vector number `v` of a row of nodes.
#[inline(always)]
fn vector_of_row<X: Vectors, const D: usize>(vectors: X, row: &[[f64; D]], v: usize) -> Four<X> {
    let numbers = row.as_flattened();
    let start = v * nodes_per_vector(D) * D;
    if let Some(four) = numbers[start..].first_chunk() {
        return Four::new(vectors, *four);
    }
    if D == 3 {
        // The last node of the row, with the number before it: what stands in the last lane means nothing.
        if let Some(&[before, x, y, z]) = numbers[start - 1..].first_chunk() {
            return Four::new(vectors, [x, y, z, before]);
        }
    }
    first_lanes(vectors, &numbers[start..])
}

impl<X: Vectors, const D: usize> Sums<Four<X>, D> {
    /// Velocity and acceleration of particle number `p` of a block.
    #[inline(always)]
    fn give_velocity<const A: bool>(self, p: usize, block: &mut FoundIn<D>) {
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
    fn give_variation<const M: bool>(self, p: usize, block: &mut FoundIn<D>) {
        for j in 0..D {
            for (i, gradient) in components::<X, D>(self.gradient[j]).into_iter().enumerate() {
                block.velocity_gradient[i][j][p] = gradient;
            }
            if M {
                block.moments[p][j] = components::<X, D>(self.moment[j]);
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
