use super::Gathered;
use super::chunk::{ChunkWeights, ChunkWork};
use super::rows::{Row, first_lanes};
use super::side_by_side::GatherSideBySide;
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
    pub(super) gradients_only: bool,
    /// Where in the block the chunk begins.
    pub(super) start: usize,
    pub(super) found: Found<'a>,
}

/// The components of [`GatheredBlock`](super::GatheredBlock), each for a whole block, and the moments, matrices column by column, for all particles or,
/// where they are not asked for, none.
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
    pub(super) moments: &'a mut [[[f64; D]; D]],
}

impl<'a, const D: usize> FoundIn<'a, D> {
    /// None if something has another length than a block has in so many dimensions.
    #[inline(always)]
    pub(super) fn new(found: Found<'a>) -> Option<Self> {
        Some(FoundIn {
            velocity: found.velocity.first_chunk_mut()?,
            acceleration: found.acceleration.first_chunk_mut()?,
            velocity_gradient: found.velocity_gradient.as_chunks_mut().0.first_chunk_mut()?,
            moments: found.moments.as_chunks_mut().0.as_chunks_mut().0,
        })
    }
}

impl GatherChunk<'_> {
    /// Makes the sums.
    pub(super) fn run(self) {
        self.weights.choose(self);
    }

    /// Where all particles of a cell reach the same nodes.
    fn run_side_by_side<const D: usize, const WIDTH: usize>(self) {
        match (self.acceleration.is_empty(), !self.found.moments.is_empty()) {
            (true, false) => lanes::run(GatherSideBySide::<D, WIDTH, false, false>(self)),
            (false, false) => lanes::run(GatherSideBySide::<D, WIDTH, true, false>(self)),
            (true, true) => lanes::run(GatherSideBySide::<D, WIDTH, false, true>(self)),
            (false, true) => lanes::run(GatherSideBySide::<D, WIDTH, true, true>(self)),
        }
    }
}

impl ChunkWork for GatherChunk<'_> {
    fn run_with_corners<const D: usize>(self) {
        self.run_side_by_side::<D, 2>();
    }

    fn run_near_nodes<const D: usize>(self) {
        match (self.acceleration.is_empty(), !self.found.moments.is_empty()) {
            (true, false) => lanes::run(Gather::<D, false, false>(self)),
            (false, false) => lanes::run(Gather::<D, true, false>(self)),
            (true, true) => lanes::run(Gather::<D, false, true>(self)),
            (false, true) => lanes::run(Gather::<D, true, true>(self)),
        }
    }

    fn run_around_cells<const D: usize>(self) {
        self.run_side_by_side::<D, 4>();
    }
}

/// The same, with or without accelerations and moments, particle by particle.
pub(super) struct Gather<'a, const D: usize, const A: bool, const M: bool>(pub(super) GatherChunk<'a>);

/// Nodes along an axis that a particle reaches.
const WIDTH: usize = 3;

impl<const D: usize, const A: bool, const M: bool> Kernel for Gather<'_, D, A, M> {
    const MANY_NUMBERS: bool = true;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        let GatherChunk { weights, velocity, acceleration, gradients_only, start, found, .. } = self.0;
        let Some(mut found) = FoundIn::<D>::new(found) else { return };
        let (velocity, acceleration) = (velocity.as_chunks().0, acceleration.as_chunks().0);
        // One length, known to be the same: one check per row.
        let acceleration = if A { &acceleration[..velocity.len()] } else { acceleration };
        for (i, p) in (start..BLOCK).enumerate().take(weights.len()) {
            let nodes = Nodes { first: weights.first_node(i), velocity, acceleration };
            let sums = nodes.sum::<X, A, M>(vectors, weights, i);
            sums.give_variation::<M>(p, &mut found);
            if !gradients_only {
                sums.give_velocity::<A>(p, &mut found);
            }
        }
    }
}

/// Whole nodes in a vector of four numbers: in 3-D the last number is that of another node, and means nothing.
const fn nodes_per_vector(dimensions: usize) -> usize {
    4 / dimensions
}

/// The fields of the nodes, and the first one that a particle reaches.
struct Nodes<'a, const D: usize> {
    first: u32,
    velocity: &'a [[f64; D]],
    acceleration: &'a [[f64; D]],
}

impl<const D: usize> Nodes<'_, D> {
    /// The sums of a particle.
    #[inline(always)]
    fn sum<X: Vectors, const A: bool, const M: bool>(
        &self,
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
    ) -> Sums<Four<X>, D> {
        // The compiler knows which one it is, and so the length of every loop.
        let mut sums = match D {
            1 => self.sum_columns::<X, 1, A, M>(vectors, weights, i),
            2 => self.sum_columns::<X, 2, A, M>(vectors, weights, i),
            _ => self.sum_layers::<X, A, M>(vectors, weights, i),
        };
        if M {
            // In the plane that along x is there.
            for axis in if D > 2 { 0 } else { 1 }..D {
                sums.finish_moment(axis, weights.arm(axis, WIDTH - 1, i), -weights.spacing(axis));
            }
        }
        sums
    }

    /// In space: the nodes of a row, each in a vector of its own, the rows of a layer, the layers.
    #[inline(always)]
    fn sum_layers<X: Vectors, const A: bool, const M: bool>(
        &self,
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
    ) -> Sums<Four<X>, D> {
        let along_x: [AxisWeights<f64>; WIDTH] = std::array::from_fn(|k| weights.of_node(0, k, i));
        let along_y = weights.layers::<D, WIDTH>(1, i);
        let zero = Four::splat(vectors, -0.0);
        let mut sums = Sums::zeros(zero);
        for z in weights.layers::<D, WIDTH>(2, i) {
            let mut layer = Sums::zeros(zero);
            for y in along_y.clone() {
                let first = (self.first + z.offset + y.offset) as usize;
                let velocity = &self.velocity[first..first + WIDTH];
                let acceleration = if A { &self.acceleration[first..first + WIDTH] } else { self.acceleration };
                let mut row = Sums::zeros(zero);
                for (k, x) in along_x.iter().enumerate() {
                    let velocity = vector_of_row(vectors, velocity, k);
                    let acceleration = if A { vector_of_row(vectors, acceleration, k) } else { zero };
                    row.add::<_, A, M>(&Sums { velocity, acceleration, ..Sums::zeros(zero) }, 0, x);
                }
                layer.add::<_, A, M>(&row, 1, &y.weights);
            }
            sums.add::<_, A, M>(&layer, 2, &z.weights);
        }
        sums
    }

    /// In the plane: the rows as they lie in memory, `V` vectors each, with the weights along y; then the nodes of their sum, of which several
    /// are in a vector.
    #[inline(always)]
    fn sum_columns<X: Vectors, const V: usize, const A: bool, const M: bool>(
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
        let value = along_x::<X, V, D>(vectors, |k| weights.value(0, k, i));
        let gradient = along_x::<X, V, D>(vectors, |k| weights.gradient(0, k, i));
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
            let arm = along_x::<X, V, D>(vectors, |k| weights.arm(0, k, i));
            sums.moment[0] = columns.velocity.dot(vectors, value * arm);
        }
        sums
    }
}

/// One number for each node of a row, and zeros for what the vectors are longer.
#[inline(always)]
fn along_x<X: Vectors, const V: usize, const D: usize>(vectors: X, of_node: impl Fn(usize) -> f64) -> Row<X, V> {
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
        }
        if M {
            block.moments[p] = self.moment.map(components::<X, D>);
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
