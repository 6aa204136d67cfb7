use super::chunk::{ChunkWeights, ChunkWork, Layer};
use super::corners::SpreadCorners;
use super::rows::Row;
use crate::lanes::{self, AddProduct, Four, Kernel, Vectors};
use crate::particles::{LocalMotion, Particles};
use crate::shape::MAX_WIDTH;

/// Adds the sums of Eqs. (5) and (10) over a chunk of particles to the nodes, a row of nodes at a time.
///
/// Weights are products over the axes: what they are along x is the same in every row of a particle.
///
/// It knows no shape function, only weights, and fields as plain numbers: so it is compiled once, for every dimension and width, and not again
/// wherever a shape function is used.
pub(super) struct SpreadChunk<'a> {
    pub(super) weights: &'a ChunkWeights,
    /// The numbers of the particles.
    pub(super) numbers: &'a [u32],
    pub(super) sources: Sources<'a>,
    pub(super) nodes: NodeNumbers<'a>,
}

/// What is summed, of all particles.
#[derive(Clone, Copy)]
pub(super) struct Sources<'a> {
    mass: &'a [f64],
    velocity: &'a [f64],
    volume: &'a [f64],
    /// Components xx, yy, zz and xy, and yz and zx.
    in_plane: &'a [[f64; 4]],
    out_of_plane: &'a [[f64; 2]],
    /// What goes to the nodes besides the velocities, matrices column by column.
    local_motion: LocalMotion,
    motion: &'a [f64],
}

impl<'a> Sources<'a> {
    pub(super) fn new<const D: usize>(particles: &'a Particles<D>, local_motion: LocalMotion) -> Self {
        Sources {
            mass: &particles.mass,
            velocity: bytemuck::cast_slice(&particles.velocity),
            volume: &particles.volume,
            in_plane: particles.stress.in_plane(),
            out_of_plane: particles.stress.out_of_plane(),
            local_motion,
            motion: bytemuck::cast_slice(&particles.local_motion),
        }
    }
}

/// The fields of the nodes from number `first` on, as plain numbers.
pub(super) struct NodeNumbers<'a> {
    pub(super) first: usize,
    pub(super) mass: &'a mut [f64],
    pub(super) momentum: &'a mut [f64],
    pub(super) force: &'a mut [f64],
}

impl SpreadChunk<'_> {
    /// Makes the sums.
    pub(super) fn run(self) {
        self.weights.choose(self);
    }

    fn run_with_rows<const D: usize, const WIDTH: usize>(self) {
        match self.sources.local_motion {
            LocalMotion::Nothing => lanes::run(Spread::<D, WIDTH, false>(self)),
            LocalMotion::Moments | LocalMotion::Gradient => lanes::run(Spread::<D, WIDTH, true>(self)),
        }
    }
}

impl ChunkWork for SpreadChunk<'_> {
    fn run_with_corners<const D: usize>(self) {
        match self.sources.local_motion {
            LocalMotion::Nothing => lanes::run(SpreadCorners::<D, false>(self)),
            LocalMotion::Moments | LocalMotion::Gradient => lanes::run(SpreadCorners::<D, true>(self)),
        }
    }

    fn run_near_nodes<const D: usize>(self) {
        self.run_with_rows::<D, 3>();
    }

    fn run_around_cells<const D: usize>(self) {
        self.run_with_rows::<D, 4>();
    }
}

/// The same, with or without the motion around the particles.
pub(super) struct Spread<'a, const D: usize, const WIDTH: usize, const AROUND: bool>(pub(super) SpreadChunk<'a>);

impl<const D: usize, const WIDTH: usize, const AROUND: bool> Kernel for Spread<'_, D, WIDTH, AROUND> {
    const MANY_NUMBERS: bool = true;

    #[inline(always)]
    fn run<X: Vectors>(self, vectors: X) {
        // The compiler knows which one it is, and so the length of every loop.
        match (WIDTH * D).div_ceil(4) {
            1 => self.add::<X, 1>(vectors),
            2 => self.add::<X, 2>(vectors),
            _ => self.add::<X, 3>(vectors),
        }
    }
}

impl<const D: usize, const WIDTH: usize, const AROUND: bool> Spread<'_, D, WIDTH, AROUND> {
    #[inline(always)]
    fn add<X: Vectors, const V: usize>(self, vectors: X) {
        let SpreadChunk { weights, numbers, sources, nodes } = self.0;
        let (sources, mut nodes) = (SourcesIn::<D>::new(&sources), NodesIn::<D>::new(nodes));
        for (i, &p) in numbers.iter().enumerate().take(weights.len()) {
            let p = p as usize;
            let gifts = Gifts::<X, V, D>::new::<WIDTH, AROUND>(vectors, weights, i, &sources, p);
            gifts.add::<WIDTH, AROUND>(vectors, weights, i, &mut nodes);
        }
    }
}

/// [`Sources`] in so many dimensions.
pub(super) struct SourcesIn<'a, const D: usize> {
    pub(super) mass: &'a [f64],
    pub(super) velocity: &'a [[f64; D]],
    pub(super) volume: &'a [f64],
    in_plane: &'a [[f64; 4]],
    out_of_plane: &'a [[f64; 2]],
    motion: &'a [[[f64; D]; D]],
}

/// [`NodeNumbers`] in so many dimensions.
pub(super) struct NodesIn<'a, const D: usize> {
    pub(super) first: u32,
    pub(super) mass: &'a mut [f64],
    pub(super) momentum: &'a mut [[f64; D]],
    pub(super) force: &'a mut [[f64; D]],
}

impl<'a, const D: usize> NodesIn<'a, D> {
    #[inline(always)]
    pub(super) fn new(nodes: NodeNumbers<'a>) -> Self {
        let NodeNumbers { first, mass, momentum, force } = nodes;
        // Lengths known to be the same: one check per row.
        let momentum = &mut momentum.as_chunks_mut().0[..mass.len()];
        let force = &mut force.as_chunks_mut().0[..mass.len()];
        NodesIn { first: first as u32, mass, momentum, force }
    }
}

impl<'a, const D: usize> SourcesIn<'a, D> {
    #[inline(always)]
    pub(super) fn new(sources: &Sources<'a>) -> Self {
        // Lengths known to be the same: one check per particle.
        let len = sources.mass.len();
        SourcesIn {
            mass: sources.mass,
            velocity: &sources.velocity.as_chunks().0[..len],
            volume: &sources.volume[..len],
            in_plane: &sources.in_plane[..len],
            out_of_plane: &sources.out_of_plane[..len],
            motion: sources.motion.as_chunks().0.as_chunks().0,
        }
    }

    /// The components in space of the stress of a particle (Pa).
    #[inline(always)]
    pub(super) fn stress(&self, p: usize) -> [[f64; D]; D] {
        let [xx, yy, zz, xy] = self.in_plane[p];
        // Out of the plane only where space is.
        let [yz, zx] = if D > 2 { self.out_of_plane[p] } else { [0.0; 2] };
        let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        std::array::from_fn(|i| std::array::from_fn(|j| rows[i][j]))
    }

    /// M_p times the gradient of the motion around a particle (kg/s), column by column.
    #[inline(always)]
    pub(super) fn momentum_gradient(&self, weights: &ChunkWeights, i: usize, p: usize) -> [[f64; D]; D] {
        let (mass, motion) = (self.mass[p], self.motion[p]);
        std::array::from_fn(|j| {
            let factor = mass * weights.inverse_spread(j, i);
            motion[j].map(|component| component * factor)
        })
    }
}

/// What a particle gives to a row of nodes, but for the weights along the other axes.
struct Gifts<X: Vectors, const V: usize, const D: usize> {
    mass: [f64; MAX_WIDTH],
    /// In the first row of the first layer.
    momentum: Row<X, V>,
    /// From a row to the next one along an axis; along x it is in the momentum.
    momentum_step: [Row<X, V>; D],
    /// To be multiplied by the gradient along an axis in place of the value; that along x by values alone.
    force: [Row<X, V>; D],
}

impl<X: Vectors, const V: usize, const D: usize> Gifts<X, V, D> {
    #[inline(always)]
    fn new<const WIDTH: usize, const AROUND: bool>(
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
        from: &SourcesIn<D>,
        p: usize,
    ) -> Self {
        let mass = from.mass[p];
        let (stress, volume) = (from.stress(p), from.volume[p]);
        let value = Row::of_nodes(vectors, D, |k| weights.value(0, k, i));
        let gradient = Row::of_nodes(vectors, D, |k| weights.gradient(0, k, i));
        let mut force = [Row::zeros(vectors); D];
        for j in 0..D {
            let column = Four::repeat::<D>(vectors, std::array::from_fn(|i| stress[i][j])) * -volume;
            force[j] = Row::of_components::<D>(vectors, column) * if j == 0 { gradient } else { value };
        }
        let (momentum, momentum_step) = Self::momentum::<WIDTH, AROUND>(vectors, weights, i, from, p, value);
        let mass = std::array::from_fn(|k| weights.value(0, k, i) * mass);
        Gifts { mass, momentum, momentum_step, force }
    }

    /// The momentum in the first row, which has these values along x, and the steps to others. What goes round the particle varies linearly from
    /// node to node.
    #[inline(always)]
    fn momentum<const WIDTH: usize, const AROUND: bool>(
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
        from: &SourcesIn<D>,
        p: usize,
        value: Row<X, V>,
    ) -> (Row<X, V>, [Row<X, V>; D]) {
        let mut steps = [Row::zeros(vectors); D];
        let mut momentum = Four::repeat(vectors, from.velocity[p]) * from.mass[p];
        if !AROUND {
            return (value * Row::of_components::<D>(vectors, momentum), steps);
        }
        let columns = from.momentum_gradient(weights, i, p).map(|column| Four::repeat(vectors, column));
        for j in 1..D {
            let arm = weights.arm(j, weights.reached::<WIDTH>(j, i).start, i);
            momentum.add_product(columns[j], arm);
            steps[j] = value * Row::of_components::<D>(vectors, columns[j] * weights.spacing(j));
        }
        let arm = Row::of_nodes(vectors, D, |k| weights.arm(0, k, i));
        let mut along_x = Row::of_components::<D>(vectors, momentum);
        along_x.add_product(arm, Row::of_components::<D>(vectors, columns[0]));
        (value * along_x, steps)
    }

    #[inline(always)]
    fn add<const WIDTH: usize, const AROUND: bool>(
        &self,
        vectors: X,
        weights: &ChunkWeights,
        i: usize,
        nodes: &mut NodesIn<D>,
    ) {
        let first = weights.first_node(i) - nodes.first;
        let along_y = weights.layers::<D, WIDTH>(1, i);
        let mut momentum_of_layer = self.momentum;
        for z in weights.layers::<D, WIDTH>(2, i) {
            let forces = if D > 2 { self.forces_in_layer(&z) } else { ForceRows::of_plane(self, vectors) };
            let mut momentum = momentum_of_layer;
            for y in along_y.clone() {
                let value = y.weights.value * z.weights.value;
                let row = (first + z.offset + y.offset) as usize;
                let row = row..row + WIDTH;
                for (at_node, mass) in nodes.mass[row.clone()].iter_mut().zip(self.mass) {
                    *at_node = vectors.fuse_one(mass, value, *at_node);
                }
                Row::add_products(vectors, [(&momentum, value)], nodes.momentum[row.clone()].as_flattened_mut());
                let by_weight = [(&forces.by_value, y.weights.value), (&forces.by_gradient, y.weights.gradient)];
                Row::add_products(vectors, by_weight, nodes.force[row].as_flattened_mut());
                if AROUND && D > 1 {
                    momentum += self.momentum_step[1];
                }
            }
            if AROUND && D > 2 {
                momentum_of_layer += self.momentum_step[2];
            }
        }
    }

    /// With the weights along z.
    #[inline(always)]
    fn forces_in_layer(&self, z: &Layer) -> ForceRows<X, V> {
        let mut by_value = self.force[0] * z.weights.value;
        by_value.add_product(self.force[2], z.weights.gradient);
        ForceRows { by_value, by_gradient: self.force[1] * z.weights.value }
    }
}

/// The force of a particle on a row of nodes in a layer along z, to be multiplied by the value and by the gradient along y.
struct ForceRows<X: Vectors, const V: usize> {
    by_value: Row<X, V>,
    by_gradient: Row<X, V>,
}

impl<X: Vectors, const V: usize> ForceRows<X, V> {
    /// In the plane there is one layer.
    #[inline(always)]
    fn of_plane<const D: usize>(rows: &Gifts<X, V, D>, vectors: X) -> Self {
        let by_gradient = if D > 1 { rows.force[D.min(2) - 1] } else { Row::zeros(vectors) };
        ForceRows { by_value: rows.force[0], by_gradient }
    }
}
