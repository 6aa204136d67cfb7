//! The sums at nodes where the stencil of a cell is its corners: linear shape functions.
//!
//! Particles follow each other cell by cell. Those of a cell give to the same few nodes, whose numbers stay in registers meanwhile.

use super::chunk::ChunkWeights;
use super::rows::Row;
use super::spread::{NodesIn, SourcesIn, SpreadChunk};
use crate::lanes::{AddProduct, Four, Kernel, Vectors};

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
                self.momentum[z][component].add_product(mass, velocity[component]);
                let mut in_plane = force[0] * stress[component][0];
                if D > 1 {
                    in_plane.add_product(force[1], stress[component][1]);
                }
                if D > 2 {
                    let by_z = stress[component][2] * weights.gradient(2, z, i);
                    self.force[z][component].add_product(in_plane, weights.value(2, z, i));
                    self.force[z][component].add_product(force_by_z, by_z);
                } else {
                    self.force[z][component] += in_plane;
                }
                if AROUND {
                    let mut around = face.moment[0] * momentum_gradient[0][component];
                    if D > 1 {
                        around.add_product(face.moment[1], momentum_gradient[1][component]);
                    }
                    if D > 2 {
                        let along_z = momentum_gradient[2][component] * weights.arm(2, z, i);
                        around.add_product(face.value, along_z);
                        self.momentum[z][component].add_product(around, weights.value(2, z, i));
                    } else {
                        self.momentum[z][component] += around;
                    }
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
                Row::<X, 1>::of_numbers(vectors, &masses).add_to(vectors, &mut nodes.mass[row.clone()]);
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
