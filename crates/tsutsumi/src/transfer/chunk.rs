use std::cell::RefCell;
use std::ops::Range;

use super::stencil::inverse_of_spread;
use super::sums::AxisWeights;
use crate::grid::{Grid, index_among_in_vectors};
use crate::lanes::MOST_LANES;
use crate::parallel::vectorized;
use crate::particles::Places;
use crate::shape::{CellOnAxis, MAX_WIDTH, ShapeFunction};

/// Particles whose weights are found at a time.
pub(super) const CHUNK: usize = 32;

/// Room for them and for what stands in a vector with the last of them: whole lines of the cache, which no vector that is stored then crosses.
const ROOM: usize = CHUNK + MOST_LANES;

/// The weights of some particles by rows of nodes along x; each axis for all particles at a time, in loops that become vectors.
pub(super) struct ChunkWeights {
    /// The dimensions of space, and the nodes per axis that a particle reaches.
    dimension: usize,
    width: usize,
    /// The particles.
    len: usize,
    /// The first node that each particle reaches.
    first_node: [u32; CHUNK],
    /// From a node to the next one along each axis.
    strides: [u32; 3],
    /// The same way (m).
    spacing: [f64; 3],
    /// Those beyond the dimensions of space mean nothing.
    along: [AlongAxis; 3],
}

/// Work on a chunk of particles whose weights are known, in `D` dimensions.
pub(super) trait ChunkWork {
    /// Does it where a particle reaches two nodes along an axis: the corners of its cell.
    fn run_with_corners<const D: usize>(self);

    /// Does it where a particle reaches three nodes along an axis: those near one, which need not be the same for all in a cell.
    fn run_near_nodes<const D: usize>(self);

    /// Does it where a particle reaches four nodes along an axis, the same for all in a cell.
    fn run_around_cells<const D: usize>(self);
}

/// What is found besides values and gradients.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Further {
    Nothing,
    /// The ways to the nodes.
    Arms,
    /// These, and what the matrix of moments is divided by.
    ArmsAndSpreads,
}

/// Weights along an axis: node by node, and for each particle.
#[repr(align(64))]
struct AlongAxis {
    /// N (–) and its gradient (1/m).
    value: [[f64; ROOM]; MAX_WIDTH],
    gradient: [[f64; ROOM]; MAX_WIDTH],
    /// x_I − X_p of the first node (m).
    arm: [f64; ROOM],
    /// One over Σ_I N (x_I − X_p)² (1/m²), or 0; 1 where it is not asked for.
    inverse_spread: [f64; CHUNK],
}

impl AlongAxis {
    const ZEROS: Self = AlongAxis {
        value: [[0.0; ROOM]; MAX_WIDTH],
        gradient: [[0.0; ROOM]; MAX_WIDTH],
        arm: [0.0; ROOM],
        inverse_spread: [0.0; CHUNK],
    };
}

thread_local! {
    /// Kept by each thread: to clear them anew would cost a small body more than its sums.
    static WEIGHTS: RefCell<ChunkWeights> = const { RefCell::new(ChunkWeights::new()) };
}

/// Lends the weights of this thread to `work`, which must not ask for them again.
#[inline(always)]
pub(super) fn with_weights(work: impl FnOnce(&mut ChunkWeights)) {
    WEIGHTS.with_borrow_mut(work);
}

impl ChunkWeights {
    const fn new() -> Self {
        let along = [AlongAxis::ZEROS; 3];
        ChunkWeights {
            dimension: 0,
            width: 0,
            len: 0,
            first_node: [0; CHUNK],
            strides: [0; 3],
            spacing: [0.0; 3],
            along,
        }
    }

    /// Does work that is compiled for every dimension of space and width of a stencil.
    pub(super) fn choose(&self, work: impl ChunkWork) {
        match (self.dimension, self.width) {
            (1, 2) => work.run_with_corners::<1>(),
            (1, 3) => work.run_near_nodes::<1>(),
            (1, _) => work.run_around_cells::<1>(),
            (2, 2) => work.run_with_corners::<2>(),
            (2, 3) => work.run_near_nodes::<2>(),
            (2, _) => work.run_around_cells::<2>(),
            (_, 2) => work.run_with_corners::<3>(),
            (_, 3) => work.run_near_nodes::<3>(),
            (_, _) => work.run_around_cells::<3>(),
        }
    }

    /// The number of particles.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len.min(CHUNK)
    }

    /// Finds the weights of at most [`CHUNK`] particles, in this order.
    #[inline(always)]
    pub(super) fn find<S: ShapeFunction, const D: usize>(
        &mut self,
        shape: &S,
        grid: &Grid<D>,
        places: Places<D>,
        further: Further,
        particles: impl Iterator<Item = usize>,
    ) {
        const {
            assert!(S::WIDTH > 1 && S::WIDTH <= MAX_WIDTH, "a stencil has 2 to MAX_WIDTH nodes along an axis");
            assert!(S::REACHED > 1 && S::REACHED <= S::WIDTH, "a point reaches at least two nodes of its stencil");
        };
        vectorized(
            #[inline(always)]
            || match further {
                Further::Nothing => self.find_in_vectors::<S, D, false, false>(shape, grid, places, particles),
                Further::Arms => self.find_in_vectors::<S, D, true, false>(shape, grid, places, particles),
                Further::ArmsAndSpreads => self.find_in_vectors::<S, D, true, true>(shape, grid, places, particles),
            },
        );
    }

    #[inline(always)]
    fn find_in_vectors<S: ShapeFunction, const D: usize, const ARMS: bool, const SPREADS: bool>(
        &mut self,
        shape: &S,
        grid: &Grid<D>,
        places: Places<D>,
        particles: impl Iterator<Item = usize>,
    ) {
        let half_sizes = if S::BOX_STRETCHES { places.half_size } else { places.half_size_at_start };
        let mut len = 0;
        let mut place = [[0.0; CHUNK]; D];
        let mut half_size = [[0.0; CHUNK]; D];
        let (origin, inverse_spacing) = (grid.origin(), grid.inverse_spacing());
        for (i, p) in particles.take(CHUNK).enumerate() {
            len = i + 1;
            let position = &places.position[p];
            for axis in 0..D {
                place[axis][i] = (position[axis] - origin[axis]) * inverse_spacing[axis];
                if S::REACH > 0.0 {
                    half_size[axis][i] = half_sizes[p][axis] * inverse_spacing[axis];
                }
            }
        }
        (self.dimension, self.width, self.len) = (D, S::REACHED, len);
        // Apart from the weights, or the compiler sees no vectors in the loop.
        let mut first_node = [0; CHUNK];
        for axis in 0..D {
            let (place, half_size) = (&place[axis], &half_size[axis]);
            self.find_along::<S, D, ARMS, SPREADS>(shape, grid, axis, place, half_size, &mut first_node);
        }
        self.first_node = first_node;
    }

    #[inline(always)]
    fn find_along<S: ShapeFunction, const D: usize, const ARMS: bool, const SPREADS: bool>(
        &mut self,
        shape: &S,
        grid: &Grid<D>,
        axis: usize,
        place: &[f64; CHUNK],
        half_size: &[f64; CHUNK],
        first_node: &mut [u32; CHUNK],
    ) {
        let num_cells = grid.cells()[axis];
        let stride = grid.node_strides()[axis] as u32;
        let (spacing, inverse_spacing) = (grid.spacing()[axis], grid.inverse_spacing()[axis]);
        (self.strides[axis], self.spacing[axis]) = (stride, spacing);
        let along = &mut self.along[axis];
        if ARMS && !SPREADS {
            along.inverse_spread = [1.0; CHUNK];
        }
        for i in 0..CHUNK {
            let at = CellOnAxis { cell: index_among_in_vectors(num_cells, place[i]), num_cells };
            let (first, weights) = shape.reached_weights(at, place[i], half_size[i]);
            first_node[i] += first as u32 * stride;
            for k in 0..S::REACHED {
                along.value[k][i] = weights.value[k];
                along.gradient[k][i] = weights.gradient[k] * inverse_spacing;
            }
            if ARMS {
                // Fewer than 2³⁰ nodes: numbers of 31 bits are converted in vectors.
                let arm = (f64::from(first as i32) - place[i]) * spacing;
                along.arm[i] = arm;
                if SPREADS {
                    let spread = (0..S::REACHED).map(|k| weights.value[k] * square(arm + k as f64 * spacing)).sum();
                    along.inverse_spread[i] = inverse_of_spread(spread, spacing);
                }
            }
        }
    }

    /// The first node that a particle reaches.
    #[inline(always)]
    pub(super) fn first_node(&self, i: usize) -> u32 {
        self.first_node[i]
    }

    /// N (–) of node `k` along an axis.
    #[inline(always)]
    pub(super) fn value(&self, axis: usize, k: usize, i: usize) -> f64 {
        self.along[axis].value[k][i]
    }

    /// The gradient of N along the axis (1/m).
    #[inline(always)]
    pub(super) fn gradient(&self, axis: usize, k: usize, i: usize) -> f64 {
        self.along[axis].gradient[k][i]
    }

    /// The weights of node `k` along an axis.
    #[inline(always)]
    pub(super) fn of_node(&self, axis: usize, k: usize, i: usize) -> AxisWeights<f64> {
        AxisWeights { value: self.value(axis, k, i), gradient: self.gradient(axis, k, i) }
    }

    /// The way from the point to node `k` along the axis (m).
    #[inline(always)]
    pub(super) fn arm(&self, axis: usize, k: usize, i: usize) -> f64 {
        let to_first = self.along[axis].arm[i];
        // The compiler knows k, but would still multiply by 0.
        if k == 0 { to_first } else { to_first + k as f64 * self.spacing[axis] }
    }

    /// From a node to the next one along the axis (m).
    #[inline(always)]
    pub(super) fn spacing(&self, axis: usize) -> f64 {
        self.spacing[axis]
    }

    /// N (–) of node `k` along an axis for some particles from number `i` on. After the last particle stands anything.
    #[inline(always)]
    pub(super) fn values(&self, axis: usize, k: usize, i: usize) -> &[f64; MOST_LANES] {
        some_from(&self.along[axis].value[k], i)
    }

    /// The gradients along the axis (1/m).
    #[inline(always)]
    pub(super) fn gradients(&self, axis: usize, k: usize, i: usize) -> &[f64; MOST_LANES] {
        some_from(&self.along[axis].gradient[k], i)
    }

    /// The ways from the particles to the first node that they reach along the axis (m).
    #[inline(always)]
    pub(super) fn arms(&self, axis: usize, i: usize) -> &[f64; MOST_LANES] {
        some_from(&self.along[axis].arm, i)
    }

    /// The node where a row of a stencil begins, from that where the stencil does; its place along y and z does not count where there are no such
    /// axes.
    #[inline(always)]
    pub(super) fn first_of_row<const D: usize>(&self, first_node: u32, y: u32, z: u32) -> usize {
        let along_y = if D > 1 { y * self.strides[1] } else { 0 };
        let along_z = if D > 2 { z * self.strides[2] } else { 0 };
        (first_node + along_y + along_z) as usize
    }

    /// One over the diagonal of D_p = Σ_I N_I (x_I − X_p) ⊗ (x_I − X_p) (1/m²): shape functions are products over the axes whose values sum
    /// to 1. Zero along an axis where the particle lies on a grid line, with nodes on neither side.
    #[inline(always)]
    pub(super) fn inverse_spread(&self, axis: usize, i: usize) -> f64 {
        self.along[axis].inverse_spread[i]
    }

    /// Those among the nodes along an axis whose weights are not zero.
    ///
    /// Boxes no longer than a cell leave out the first or the last of four. Where both are left out only one is: always the same number of
    /// turns is faster.
    #[inline(always)]
    pub(super) fn reached<const WIDTH: usize>(&self, axis: usize, i: usize) -> Range<usize> {
        let is_left_out = |k: usize| WIDTH > 3 && self.value(axis, k, i) == 0.0 && self.gradient(axis, k, i) == 0.0;
        let (first, last) = (is_left_out(0), is_left_out(WIDTH - 1));
        let start = usize::from(first);
        start..start + WIDTH - usize::from(first | last)
    }

    /// The layers of rows along an axis other than x that a particle reaches; one that holds everything where space has no such axis.
    #[inline(always)]
    pub(super) fn layers<const D: usize, const WIDTH: usize>(
        &self,
        axis: usize,
        i: usize,
    ) -> impl Iterator<Item = Layer> + Clone {
        let is_there = axis < D;
        let reached = if is_there { self.reached::<WIDTH>(axis, i) } else { 0..1 };
        let stride = self.strides[axis];
        reached.map(move |k| match is_there {
            true => Layer { offset: k as u32 * stride, weights: self.of_node(axis, k, i) },
            false => Layer { offset: 0, weights: AxisWeights { value: 1.0, gradient: 0.0 } },
        })
    }
}

#[inline(always)]
fn square(x: f64) -> f64 {
    x * x
}

/// Numbers from that of particle number `i` on.
#[inline(always)]
fn some_from(numbers: &[f64; ROOM], i: usize) -> &[f64; MOST_LANES] {
    // Known to be within the room: no check is left.
    numbers[i.min(CHUNK - 1)..].first_chunk().unwrap_or(&[0.0; MOST_LANES])
}

/// Rows with the same place along an axis other than x.
#[derive(Clone, Copy)]
pub(super) struct Layer {
    /// From the first node of the stencil to the same one in this layer.
    pub(super) offset: u32,
    /// The weights along the axis.
    pub(super) weights: AxisWeights<f64>,
}
