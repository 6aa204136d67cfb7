use std::ops::Range;

use super::bands::NodeSums;
use super::chunk::{CHUNK, ChunkWeights, Layer};
use super::rows::Row;

use crate::grid::{ActiveSet, Grid};
use crate::lanes::{Kernel, Vectors};
use crate::particles::{LocalMotion, Particles};
use crate::shape::ShapeFunction;
use crate::tensor::{Sym3, Vector};

/// Adds the sums of Eqs. (5) and (10) over the particles of a band to its nodes, a row of nodes at a time.
///
/// Weights are products over the axes: what they are along x is the same in every row of a particle.
pub(super) struct BandSums<'a, S, const D: usize, const AROUND: bool> {
    pub(super) shape: &'a S,
    pub(super) grid: &'a Grid<D>,
    pub(super) active: &'a ActiveSet,
    pub(super) particles: &'a Particles<D>,
    /// What goes to the nodes besides the velocities; nothing unless `AROUND`.
    pub(super) local_motion: LocalMotion,
    pub(super) slots: Range<usize>,
    pub(super) nodes: NodeSums<'a, D>,
}

impl<S: ShapeFunction, const D: usize, const AROUND: bool> Kernel for BandSums<'_, S, D, AROUND> {
    const MANY_NUMBERS: bool = S::WIDTH > 2;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        // The compiler knows which one it is, and so the length of every loop.
        match (S::WIDTH * D).div_ceil(4) {
            1 => self.add::<X, 1>(vectors),
            2 => self.add::<X, 2>(vectors),
            _ => self.add::<X, 3>(vectors),
        }
    }
}

impl<S: ShapeFunction, const D: usize, const AROUND: bool> BandSums<'_, S, D, AROUND> {
    #[inline(always)]
    fn add<X: Vectors, const V: usize>(self, vectors: X) {
        let BandSums { shape, grid, active, particles, local_motion, slots, nodes } = self;
        let NodeSums { first, mass, momentum, force } = nodes;
        // One length, known to be the same: one check per row.
        let (momentum, force) = (&mut momentum[..mass.len()], &mut force[..mass.len()]);
        let mut nodes = NodeSums { first, mass, momentum, force };
        let places = particles.places();
        let sources = Sources::new(particles);
        let mut weights = ChunkWeights::new();
        for chunk in active.particles_in(slots).chunks(CHUNK) {
            let numbers = chunk.iter().map(|&p| p as usize);
            weights.find::<S, AROUND>(shape, grid, places, numbers.clone());
            for (i, p) in numbers.enumerate() {
                let mut gifts = Gifts::<X, V, D>::new(vectors, &weights, i, &sources, p);
                if AROUND {
                    let spread = weights.spread(i);
                    let columns = momentum_gradient(&spread, &grid.spacing(), particles, local_motion, p);
                    gifts.go_round(vectors, &weights, i, columns);
                }
                gifts.add::<S, AROUND>(vectors, grid, &weights, i, &mut nodes);
            }
        }
    }
}

/// What is summed, of one length known to be the same: one check per particle.
struct Sources<'a, const D: usize> {
    mass: &'a [f64],
    velocity: &'a [Vector<D>],
    volume: &'a [f64],
    stress: &'a [Sym3],
}

impl<'a, const D: usize> Sources<'a, D> {
    #[inline(always)]
    fn new(particles: &'a Particles<D>) -> Self {
        let len = particles.len();
        Sources {
            mass: &particles.mass[..len],
            velocity: &particles.velocity[..len],
            volume: &particles.volume[..len],
            stress: &particles.stress[..len],
        }
    }
}

/// What a particle gives to a row of nodes, but for the weights along the other axes.
struct Gifts<X: Vectors, const V: usize, const D: usize> {
    mass: Row<X, 1>,
    momentum: Row<X, V>,
    /// Per distance of the row along an axis; that along x is in the momentum.
    momentum_gradient: [Row<X, V>; D],
    /// To be multiplied by the gradient along an axis in place of the value; that along x by values alone.
    force: [Row<X, V>; D],
}

impl<X: Vectors, const V: usize, const D: usize> Gifts<X, V, D> {
    #[inline(always)]
    fn new(vectors: X, weights: &ChunkWeights<D>, i: usize, from: &Sources<D>, p: usize) -> Self {
        let (mass, velocity) = (from.mass[p], from.velocity[p]);
        let stress = from.stress[p].block::<D>(-from.volume[p]);
        let value = Row::of_nodes(vectors, D, |k| weights.value(0, k, i));
        let gradient = Row::of_nodes(vectors, D, |k| weights.gradient(0, k, i));
        let momentum = Row::of_components::<D>(vectors, std::array::from_fn(|i| velocity[i] * mass));
        let mut force = [Row::zeros(vectors); D];
        for j in 0..D {
            let column = Row::of_components::<D>(vectors, std::array::from_fn(|i| stress[i][j]));
            force[j] = column * if j == 0 { gradient } else { value };
        }
        let mass = Row::of_nodes(vectors, 1, |k| weights.value(0, k, i)) * mass;
        Gifts { mass, momentum: momentum * value, momentum_gradient: [Row::zeros(vectors); D], force }
    }

    /// With the momentum of a motion around the particle, whose gradient stands column by column (kg/s).
    #[inline(always)]
    fn go_round(&mut self, vectors: X, weights: &ChunkWeights<D>, i: usize, columns: [[f64; D]; D]) {
        let moment = Row::of_nodes(vectors, D, |k| weights.moment(0, k, i));
        let value = Row::of_nodes(vectors, D, |k| weights.value(0, k, i));
        self.momentum += moment * Row::of_components(vectors, columns[0]);
        for (to, column) in self.momentum_gradient.iter_mut().zip(columns).skip(1) {
            *to = value * Row::of_components(vectors, column);
        }
    }

    #[inline(always)]
    fn add<S: ShapeFunction, const AROUND: bool>(
        &self,
        vectors: X,
        grid: &Grid<D>,
        weights: &ChunkWeights<D>,
        i: usize,
        nodes: &mut NodeSums<D>,
    ) {
        let first = weights.first_node(i) - nodes.first as u32;
        let along_y = weights.layers::<S>(grid, 1, i);
        for z in weights.layers::<S>(grid, 2, i) {
            let layer = if D > 2 { self.layer::<AROUND>(&z) } else { LayerRows::of_plane(self, vectors) };
            for y in along_y.clone() {
                let row = (first + z.offset + y.offset) as usize;
                let row = row..row + S::WIDTH;
                (layer.mass * y.value).add_to(vectors, &mut nodes.mass[row.clone()]);
                let mut momentum = layer.momentum * y.value;
                let mut force = layer.force * y.value;
                if D > 1 {
                    force += layer.force_by_gradient * y.gradient;
                }
                if AROUND && D > 1 {
                    momentum += layer.momentum_gradient * y.moment;
                }
                momentum.add_to(vectors, bytemuck::cast_slice_mut(&mut nodes.momentum[row.clone()]));
                force.add_to(vectors, bytemuck::cast_slice_mut(&mut nodes.force[row]));
            }
        }
    }

    /// With the weights along z.
    #[inline(always)]
    fn layer<const AROUND: bool>(&self, z: &Layer) -> LayerRows<X, V> {
        let mut momentum = self.momentum * z.value;
        if AROUND {
            momentum += self.momentum_gradient[2] * z.moment;
        }
        LayerRows {
            mass: self.mass * z.value,
            momentum,
            momentum_gradient: self.momentum_gradient[1] * z.value,
            force: self.force[0] * z.value + self.force[2] * z.gradient,
            force_by_gradient: self.force[1] * z.value,
        }
    }
}

/// What a particle gives to a row of nodes in a layer along z, but for the weights along y.
struct LayerRows<X: Vectors, const V: usize> {
    mass: Row<X, 1>,
    momentum: Row<X, V>,
    /// Per distance of the row along y.
    momentum_gradient: Row<X, V>,
    /// To be multiplied by the value and by the gradient along y.
    force: Row<X, V>,
    force_by_gradient: Row<X, V>,
}

impl<X: Vectors, const V: usize> LayerRows<X, V> {
    /// In the plane there is one layer.
    #[inline(always)]
    fn of_plane<const D: usize>(rows: &Gifts<X, V, D>, vectors: X) -> Self {
        let zeros = Row::zeros(vectors);
        let at = |rows: &[Row<X, V>; D]| if D > 1 { rows[D.min(2) - 1] } else { zeros };
        LayerRows {
            mass: rows.mass,
            momentum: rows.momentum,
            momentum_gradient: at(&rows.momentum_gradient),
            force: rows.force[0],
            force_by_gradient: at(&rows.force),
        }
    }
}

/// M_p times the gradient of the motion around a particle (kg/s), column by column; `spread` is the diagonal of D_p (m²).
#[inline(always)]
pub(super) fn momentum_gradient<const D: usize>(
    spread: &[f64; D],
    spacing: &Vector<D>,
    particles: &Particles<D>,
    local_motion: LocalMotion,
    p: usize,
) -> [[f64; D]; D] {
    let mass = particles.mass[p];
    let factors = match local_motion {
        LocalMotion::Nothing => [0.0; D],
        LocalMotion::Gradient => [mass; D],
        LocalMotion::Moments => {
            // Nearer than this to a grid line (spacings) the moment is lost in round-off.
            let is_there = |j: usize| spread[j] > 1e-12 * spacing[j] * spacing[j];
            std::array::from_fn(|j| if is_there(j) { mass / spread[j] } else { 0.0 })
        }
    };
    let motion = &particles.local_motion[p];
    std::array::from_fn(|j| std::array::from_fn(|i| motion[(i, j)] * factors[j]))
}
