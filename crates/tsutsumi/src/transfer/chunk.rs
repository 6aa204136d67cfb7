use std::ops::Range;

use crate::grid::Grid;
use crate::particles::Places;
use crate::shape::{CellOnAxis, MAX_WIDTH, ShapeFunction};

/// Particles whose weights are found at a time.
pub(super) const CHUNK: usize = 16;

/// The weights of some particles by rows of nodes along x; each axis for all particles at a time, in loops that become vectors.
#[derive(Debug, Clone)]
pub(super) struct ChunkWeights<const D: usize> {
    /// The first node of each particle's stencil.
    first_node: [u32; CHUNK],
    along: [AlongAxis; D],
}

/// Weights along an axis: node by node, and for each particle.
#[derive(Debug, Clone)]
struct AlongAxis {
    /// N (–) and its gradient (1/m).
    value: [[f64; CHUNK]; MAX_WIDTH],
    gradient: [[f64; CHUNK]; MAX_WIDTH],
    /// N (x_I − X_p) (m).
    moment: [[f64; CHUNK]; MAX_WIDTH],
    /// Σ_I N (x_I − X_p)² (m²).
    spread: [f64; CHUNK],
}

impl AlongAxis {
    const ZEROS: Self = AlongAxis {
        value: [[0.0; CHUNK]; MAX_WIDTH],
        gradient: [[0.0; CHUNK]; MAX_WIDTH],
        moment: [[0.0; CHUNK]; MAX_WIDTH],
        spread: [0.0; CHUNK],
    };
}

impl<const D: usize> ChunkWeights<D> {
    pub(super) fn new() -> Self {
        ChunkWeights { first_node: [0; CHUNK], along: [AlongAxis::ZEROS; D] }
    }

    /// Finds the weights of at most [`CHUNK`] particles, in this order; `MOMENTS` too.
    #[inline(always)]
    pub(super) fn find<S: ShapeFunction, const MOMENTS: bool>(
        &mut self,
        shape: &S,
        grid: &Grid<D>,
        places: Places<D>,
        particles: impl Iterator<Item = usize>,
    ) {
        let half_sizes = if S::BOX_STRETCHES { places.half_size } else { places.half_size_at_start };
        self.first_node = [0; CHUNK];
        let mut place = [[0.0; CHUNK]; D];
        let mut half_size = [[0.0; CHUNK]; D];
        let (origin, inverse_spacing) = (grid.origin(), grid.inverse_spacing());
        for (i, p) in particles.take(CHUNK).enumerate() {
            let position = &places.position[p];
            for axis in 0..D {
                place[axis][i] = (position[axis] - origin[axis]) * inverse_spacing[axis];
                if S::REACH > 0.0 {
                    half_size[axis][i] = half_sizes[p][axis] * inverse_spacing[axis];
                }
            }
        }
        for axis in 0..D {
            self.find_along::<S, MOMENTS>(shape, grid, axis, &place[axis], &half_size[axis]);
        }
    }

    #[inline(always)]
    fn find_along<S: ShapeFunction, const MOMENTS: bool>(
        &mut self,
        shape: &S,
        grid: &Grid<D>,
        axis: usize,
        place: &[f64; CHUNK],
        half_size: &[f64; CHUNK],
    ) {
        let num_cells = grid.cells()[axis];
        let stride = grid.node_strides()[axis] as u32;
        let (spacing, inverse_spacing) = (grid.spacing()[axis], grid.inverse_spacing()[axis]);
        let along = &mut self.along[axis];
        for i in 0..CHUNK {
            let at = CellOnAxis { cell: grid.index_on(axis, place[i]), num_cells };
            let weights = shape.weights(at, place[i], half_size[i]);
            let first = shape.first_node(at) as u32;
            self.first_node[i] += first * stride;
            let mut spread = 0.0;
            for k in 0..S::WIDTH {
                along.value[k][i] = weights.value[k];
                along.gradient[k][i] = weights.gradient[k] * inverse_spacing;
                if MOMENTS {
                    let arm = (f64::from(first) + k as f64 - place[i]) * spacing;
                    let moment = weights.value[k] * arm;
                    along.moment[k][i] = moment;
                    spread += moment * arm;
                }
            }
            along.spread[i] = spread;
        }
    }

    /// The first node of a particle's stencil.
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

    /// N times the way from the point to the node along the axis (m).
    #[inline(always)]
    pub(super) fn moment(&self, axis: usize, k: usize, i: usize) -> f64 {
        self.along[axis].moment[k][i]
    }

    /// The diagonal of Σ_I N_I (x_I − X_p) ⊗ (x_I − X_p) (m²): shape functions are products over the axes whose values sum to 1.
    #[inline(always)]
    pub(super) fn spread(&self, i: usize) -> [f64; D] {
        std::array::from_fn(|axis| self.along[axis].spread[i])
    }

    /// The nodes along an axis that a particle reaches.
    ///
    /// Quadratic splines, and boxes no longer than a cell, leave out the first or the last of four. Where both are left out only one is: always
    /// the same number of turns is faster.
    #[inline(always)]
    pub(super) fn reached<S: ShapeFunction>(&self, axis: usize, i: usize) -> Range<usize> {
        let is_left_out = |k: usize| S::WIDTH > 2 && self.value(axis, k, i) == 0.0 && self.gradient(axis, k, i) == 0.0;
        let (first, last) = (is_left_out(0), is_left_out(S::WIDTH - 1));
        let start = usize::from(first);
        start..start + S::WIDTH - usize::from(first | last)
    }

    /// The layers of rows along an axis other than x that a particle reaches; one that holds everything where space has no such axis.
    #[inline(always)]
    pub(super) fn layers<S: ShapeFunction>(
        &self,
        grid: &Grid<D>,
        axis: usize,
        i: usize,
    ) -> impl Iterator<Item = Layer> + Clone {
        let is_there = axis < D;
        let reached = if is_there { self.reached::<S>(axis, i) } else { 0..1 };
        let stride = if is_there { grid.node_strides()[axis] as u32 } else { 0 };
        reached.map(move |k| match is_there {
            true => Layer {
                offset: k as u32 * stride,
                value: self.value(axis, k, i),
                gradient: self.gradient(axis, k, i),
                moment: self.moment(axis, k, i),
            },
            false => Layer { offset: 0, value: 1.0, gradient: 0.0, moment: 0.0 },
        })
    }
}

/// Rows with the same place along an axis other than x.
#[derive(Clone, Copy)]
pub(super) struct Layer {
    /// From the first node of the stencil to the same one in this layer.
    pub(super) offset: u32,
    /// N (–) and its gradient (1/m) along the axis, and N times the way from the point to the layer (m).
    pub(super) value: f64,
    pub(super) gradient: f64,
    pub(super) moment: f64,
}
