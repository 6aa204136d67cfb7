//! The sums where the stencil of a cell is its corners: linear shape functions.
//!
//! Particles follow each other cell by cell. Those of a cell give to and take from the same few nodes, whose numbers stay in registers meanwhile.

use std::ops::{Add, AddAssign, Mul};

use super::chunk::ChunkWeights;
use super::gather::{FoundIn, GatherChunk};
use super::rows::Row;
use super::spread::{NodesIn, SourcesIn, SpreadChunk};
use super::sums::{AxisWeights, Sums};
use crate::lanes::{Four, Kernel, Lanes, MOST_LANES, Vectors};
use crate::law::BLOCK;

/// Adds the sums of Eqs. (5) and (10) over a chunk of particles to the nodes, each corner of a face of the cell in a lane.
pub(super) struct SpreadCorners<'a, const D: usize, const AROUND: bool>(pub(super) SpreadChunk<'a>);

impl<const D: usize, const AROUND: bool> Kernel for SpreadCorners<'_, D, AROUND> {
    const MANY_NUMBERS: bool = D > 2;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        // The compiler knows which one it is, and so the length of every loop.
        match D {
            1 | 2 => self.add::<X, 1, 1>(vectors),
            _ => self.add::<X, 2, 2>(vectors),
        }
    }
}

impl<const D: usize, const AROUND: bool> SpreadCorners<'_, D, AROUND> {
    /// A cell has `FACES` faces across z, or is one; the numbers of two nodes are `V` vectors long.
    #[inline(always)]
    fn add<X: Vectors, const FACES: usize, const V: usize>(self, vectors: X) {
        let SpreadChunk { weights, numbers, sources, nodes } = self.0;
        let (sources, mut nodes) = (SourcesIn::<D>::new(&sources), NodesIn::<D>::new(nodes));
        let mut sums = CornerSums::<X, D, FACES>::zeros(vectors);
        let mut first_node = weights.first_node(0);
        for (i, &p) in numbers.iter().enumerate().take(weights.len()) {
            let next = weights.first_node(i);
            if next != first_node {
                sums.give::<V>(vectors, weights, first_node, &mut nodes);
                (sums, first_node) = (CornerSums::zeros(vectors), next);
            }
            sums.add::<AROUND>(vectors, weights, i, &sources, p as usize);
        }
        sums.give::<V>(vectors, weights, first_node, &mut nodes);
    }
}

/// Sums at the corners of a cell, for each face across z and each component.
struct CornerSums<X: Vectors, const D: usize, const FACES: usize> {
    mass: [Four<X>; FACES],
    momentum: [[Four<X>; D]; FACES],
    force: [[Four<X>; D]; FACES],
}

impl<X: Vectors, const D: usize, const FACES: usize> CornerSums<X, D, FACES> {
    #[inline(always)]
    fn zeros(vectors: X) -> Self {
        let zero = Four::splat(vectors, 0.0);
        CornerSums { mass: [zero; FACES], momentum: [[zero; D]; FACES], force: [[zero; D]; FACES] }
    }

    /// Adds what particle number `p`, which is number `i` of the chunk, gives to the corners.
    #[inline(always)]
    fn add<const AROUND: bool>(&mut self, vectors: X, weights: &ChunkWeights, i: usize, from: &SourcesIn<D>, p: usize) {
        let face = FaceWeights::<X, D>::new(vectors, weights, i);
        let (mass, velocity) = (from.mass[p], from.velocity[p]);
        let stress = from.stress(p);
        let minus_volume = Four::splat(vectors, -from.volume[p]);
        let force = face.gradient.map(|gradient| gradient * minus_volume);
        let force_by_z = face.value * minus_volume;
        let mass_on_face = face.value * mass;
        let momentum_gradient = if AROUND { from.momentum_gradient(weights, i, p) } else { [[0.0; D]; D] };
        for z in 0..FACES {
            let along_z = |value: Four<X>| if D > 2 { value * weights.value(2, z, i) } else { value };
            let mass = along_z(mass_on_face);
            self.mass[z] += mass;
            for component in 0..D {
                self.momentum[z][component] += mass * velocity[component];
                let mut in_plane = force[0] * stress[component][0];
                if D > 1 {
                    in_plane += force[1] * stress[component][1];
                }
                self.force[z][component] += along_z(in_plane);
                if D > 2 {
                    self.force[z][component] += force_by_z * stress[component][2] * weights.gradient(2, z, i);
                }
                if AROUND {
                    let mut around = along_z(face.moment[0] * momentum_gradient[0][component]);
                    if D > 1 {
                        around += along_z(face.moment[1] * momentum_gradient[1][component]);
                    }
                    if D > 2 {
                        around += along_z(face.value * momentum_gradient[2][component]) * weights.arm(2, z, i);
                    }
                    self.momentum[z][component] += around;
                }
            }
        }
    }

    /// Adds the sums to those of the nodes, which lie in rows of two along x.
    #[inline(always)]
    fn give<const V: usize>(&self, vectors: X, weights: &ChunkWeights, first_node: u32, nodes: &mut NodesIn<D>) {
        for z in 0..FACES {
            let mass = self.mass[z].to_array();
            let (momentum, force) = (self.momentum[z].map(Four::to_array), self.force[z].map(Four::to_array));
            for y in 0..if D > 1 { 2 } else { 1 } {
                let first = weights.first_of_row::<D>(first_node - nodes.first, y, z as u32);
                let row = first..first + 2;
                let corner = 2 * y as usize;
                let in_row = |of_axis: &[[f64; 4]; D]| {
                    Row::<X, V>::from_fn(vectors, |place| match place < 2 * D {
                        true => of_axis[place % D][corner + place / D],
                        false => 0.0,
                    })
                };
                let masses = [mass[corner], mass[corner + 1]];
                Row::<X, 1>::of_components(vectors, masses).add_to(vectors, &mut nodes.mass[row.clone()]);
                in_row(&momentum).add_to(vectors, nodes.momentum[row.clone()].as_flattened_mut());
                in_row(&force).add_to(vectors, nodes.force[row].as_flattened_mut());
            }
        }
    }
}

/// A particle's weights at the corners of a face of its cell across z, but for those along z: at the two along x, then at those above them.
struct FaceWeights<X: Vectors, const D: usize> {
    value: Four<X>,
    /// With the gradient, and with the moment, along x or y in place of the value.
    gradient: [Four<X>; 2],
    moment: [Four<X>; 2],
}

impl<X: Vectors, const D: usize> FaceWeights<X, D> {
    #[inline(always)]
    fn new(vectors: X, weights: &ChunkWeights, i: usize) -> Self {
        let along_x = |of: fn(&ChunkWeights, usize, usize, usize) -> f64| {
            let [left, right] = [of(weights, 0, 0, i), of(weights, 0, 1, i)];
            Four::new(vectors, [left, right, left, right])
        };
        let along_y = |of: fn(&ChunkWeights, usize, usize, usize) -> f64| {
            if D == 1 {
                // There is nothing above.
                return Four::new(vectors, [1.0, 1.0, 0.0, 0.0]);
            }
            let [lower, upper] = [of(weights, 1, 0, i), of(weights, 1, 1, i)];
            Four::new(vectors, [lower, lower, upper, upper])
        };
        let (x, y) = (along_x(ChunkWeights::value), along_y(ChunkWeights::value));
        let value = x * y;
        FaceWeights {
            value,
            gradient: [along_x(ChunkWeights::gradient) * y, x * along_y(ChunkWeights::gradient)],
            moment: [value * along_x(ChunkWeights::arm), value * along_y(ChunkWeights::arm)],
        }
    }
}

/// What a chunk of particles finds on the grid, as many particles of a cell at a time as vectors have lanes.
///
/// As many numbers are stored where fewer particles of the cell are left, too: those of the next cell are found after them.
pub(super) struct GatherCorners<'a, const D: usize, const A: bool, const M: bool>(pub(super) GatherChunk<'a>);

impl<const D: usize, const A: bool, const M: bool> Kernel for GatherCorners<'_, D, A, M> {
    const MANY_NUMBERS: bool = D > 2;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        let GatherChunk { weights, velocity, acceleration, gradients_only, start, found, .. } = self.0;
        let Some(mut found) = FoundIn::<D>::new(found) else { return };
        let (velocity, acceleration) = (velocity.as_chunks().0, acceleration.as_chunks().0);
        // One length, known to be the same: one check per row.
        let acceleration = if A { &acceleration[..velocity.len()] } else { acceleration };
        let corners = Corners { weights, velocity, acceleration };
        let len = weights.len().min(BLOCK - start);
        let mut i = 0;
        while i < len {
            let first_node = weights.first_node(i);
            let found_here = corners.sums::<X, X::Widest, A, M>(vectors, first_node, i);
            found_here.give_variation::<X, M>(start + i, &mut found);
            if !gradients_only {
                found_here.give_velocity::<X, A>(start + i, &mut found);
            }
            i += 1;
            let end = len.min(i + X::Widest::COUNT - 1);
            while i < end && weights.first_node(i) == first_node {
                i += 1;
            }
        }
    }
}

/// The fields of the nodes, and weights of particles.
struct Corners<'a, const D: usize> {
    weights: &'a ChunkWeights,
    velocity: &'a [[f64; D]],
    acceleration: &'a [[f64; D]],
}

impl<const D: usize> Corners<'_, D> {
    /// The sums of some particles from number `i` of the chunk on, over the corners of a cell.
    #[inline(always)]
    fn sums<X: Vectors, L: Lanes<X>, const A: bool, const M: bool>(
        &self,
        vectors: X,
        first_node: u32,
        i: usize,
    ) -> Sums<OfSome<L, D>, D> {
        let along = |axis: usize, k: usize| weights_of_some::<X, L>(vectors, self.weights, axis, k, i);
        let x = [along(0, 0), along(0, 1)];
        let zeros = Sums::zeros(OfSome([L::splat(vectors, -0.0); D]));
        let mut sums = zeros;
        for z in 0..if D > 2 { 2 } else { 1 } {
            let mut face = zeros;
            for y in 0..if D > 1 { 2 } else { 1 } {
                let first = self.weights.first_of_row::<D>(first_node, y, z);
                let velocity = &self.velocity[first..first + 2];
                let acceleration = if A { &self.acceleration[first..first + 2] } else { self.acceleration };
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
                let to_last = to_first + L::splat(vectors, spacing);
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
