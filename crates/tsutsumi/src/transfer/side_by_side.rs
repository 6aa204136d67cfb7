//! What particles find on the grid where all in a cell reach the same nodes: as many of them at a time as vectors have lanes.

use std::ops::{Add, AddAssign, Mul};

use super::chunk::ChunkWeights;
use super::gather::{FoundIn, GatherChunk};
use super::sums::{AxisWeights, Sums};
use crate::lanes::{AddProduct, Four, Kernel, Lanes, MOST_LANES, Vectors};
use crate::law::BLOCK;

/// What a chunk of particles finds on the grid, as many particles of a cell at a time as vectors have lanes.
///
/// As many numbers are stored where fewer particles of the cell are left, too: those of the next cell are found after them.
pub(super) struct GatherSideBySide<'a, const D: usize, const WIDTH: usize, const A: bool, const M: bool>(
    pub(super) GatherChunk<'a>,
);

impl<const D: usize, const WIDTH: usize, const A: bool, const M: bool> Kernel for GatherSideBySide<'_, D, WIDTH, A, M> {
    const MANY_NUMBERS: bool = D > 2 || WIDTH > 2;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        // In the plane a cell rarely holds more than four.
        match D > 2 {
            true => self.gather::<X, X::Widest>(vectors),
            false => self.gather::<X, Four<X>>(vectors),
        }
    }
}

impl<const D: usize, const WIDTH: usize, const A: bool, const M: bool> GatherSideBySide<'_, D, WIDTH, A, M> {
    #[inline(always)]
    fn gather<X: Vectors, L: Lanes<X>>(self, vectors: X) {
        let GatherChunk { weights, velocity, acceleration, gradients_only, start, found, .. } = self.0;
        let Some(mut found) = FoundIn::<D>::new(found) else { return };
        let (velocity, acceleration) = (velocity.as_chunks().0, acceleration.as_chunks().0);
        // One length, known to be the same: one check per row.
        let acceleration = if A { &acceleration[..velocity.len()] } else { acceleration };
        let nodes = Nodes { weights, velocity, acceleration };
        let len = weights.len().min(BLOCK - start);
        let mut i = 0;
        while i < len {
            let first_node = weights.first_node(i);
            let found_here = nodes.sums::<X, L, WIDTH, A, M>(vectors, first_node, i);
            found_here.give_variation::<X, M>(start + i, &mut found);
            if !gradients_only {
                found_here.give_velocity::<X, A>(start + i, &mut found);
            }
            i += 1;
            let end = len.min(i + L::COUNT - 1);
            while i < end && weights.first_node(i) == first_node {
                i += 1;
            }
        }
    }
}

/// The fields of the nodes, and weights of particles.
struct Nodes<'a, const D: usize> {
    weights: &'a ChunkWeights,
    velocity: &'a [[f64; D]],
    acceleration: &'a [[f64; D]],
}

impl<const D: usize> Nodes<'_, D> {
    /// The sums of some particles from number `i` of the chunk on, over the nodes that they reach.
    #[inline(always)]
    fn sums<X: Vectors, L: Lanes<X>, const WIDTH: usize, const A: bool, const M: bool>(
        &self,
        vectors: X,
        first_node: u32,
        i: usize,
    ) -> Sums<OfSome<L, D>, D> {
        let along = |axis: usize, k: usize| weights_of_some::<X, L>(vectors, self.weights, axis, k, i);
        let x: [_; WIDTH] = std::array::from_fn(|k| along(0, k));
        let zeros = Sums::zeros(OfSome([L::splat(vectors, -0.0); D]));
        let mut sums = zeros;
        for z in 0..if D > 2 { WIDTH as u32 } else { 1 } {
            let mut face = zeros;
            for y in 0..if D > 1 { WIDTH as u32 } else { 1 } {
                let first = self.weights.first_of_row::<D>(first_node, y, z);
                let velocity = &self.velocity[first..first + WIDTH];
                let acceleration = if A { &self.acceleration[first..first + WIDTH] } else { self.acceleration };
                let mut row = zeros;
                for (k, x) in x.iter().enumerate() {
                    let of_all = |vector: [f64; D]| OfSome(vector.map(|component| L::splat(vectors, component)));
                    let acceleration = if A { of_all(acceleration[k]) } else { zeros.acceleration };
                    row.add::<_, A, M>(&Sums { velocity: of_all(velocity[k]), acceleration, ..zeros }, 0, x);
                }
                face.add::<_, A, M>(&row, 1, &along(1, y as usize));
            }
            sums.add::<_, A, M>(&face, 2, &along(2, z as usize));
        }
        if M {
            for axis in 0..D {
                let spacing = self.weights.spacing(axis);
                let to_first = L::first_of(vectors, self.weights.arms(axis, i));
                let to_last = to_first + L::splat(vectors, (WIDTH - 1) as f64 * spacing);
                sums.finish_moment(axis, to_last, L::splat(vectors, -spacing));
            }
        }
        sums
    }
}

/// Weights of some particles at a node along an axis.
#[inline(always)]
fn weights_of_some<X: Vectors, L: Lanes<X>>(
    vectors: X,
    weights: &ChunkWeights,
    axis: usize,
    k: usize,
    i: usize,
) -> AxisWeights<L> {
    AxisWeights {
        value: L::first_of(vectors, weights.values(axis, k, i)),
        gradient: L::first_of(vectors, weights.gradients(axis, k, i)),
    }
}

/// A vector of the grid for each of some particles, component by component.
#[derive(Clone, Copy)]
struct OfSome<L, const D: usize>([L; D]);

impl<L: Copy + Add<Output = L>, const D: usize> AddAssign for OfSome<L, D> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for i in 0..D {
            self.0[i] = self.0[i] + other.0[i];
        }
    }
}

impl<L: Copy + AddProduct<L>, const D: usize> AddProduct<L> for OfSome<L, D> {
    #[inline(always)]
    fn add_product(&mut self, a: Self, b: L) {
        for i in 0..D {
            self.0[i].add_product(a.0[i], b);
        }
    }
}

impl<L: Copy + Mul<Output = L>, const D: usize> Mul<L> for OfSome<L, D> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, factors: L) -> Self {
        for i in 0..D {
            self.0[i] = self.0[i] * factors;
        }
        self
    }
}

impl<L, const D: usize> Sums<OfSome<L, D>, D> {
    /// Velocities and accelerations of the particles of a block from number `p` on.
    #[inline(always)]
    fn give_velocity<X: Vectors, const A: bool>(&self, p: usize, block: &mut FoundIn<D>)
    where
        L: Lanes<X>,
    {
        for i in 0..D {
            self.velocity.0[i].store(&mut block.velocity[i][p..]);
            if A {
                self.acceleration.0[i].store(&mut block.acceleration[i][p..]);
            }
        }
    }

    /// How the velocity varies around them.
    #[inline(always)]
    fn give_variation<X: Vectors, const M: bool>(&self, p: usize, block: &mut FoundIn<D>)
    where
        L: Lanes<X>,
    {
        for j in 0..D {
            for i in 0..D {
                self.gradient[j].0[i].store(&mut block.velocity_gradient[i][j][p..]);
                if M {
                    let mut lanes = [0.0; MOST_LANES];
                    self.moment[j].0[i].store(&mut lanes);
                    for (moments, lane) in block.moments[p..].iter_mut().zip(&lanes[..L::COUNT]) {
                        moments[j][i] = *lane;
                    }
                }
            }
        }
    }
}
