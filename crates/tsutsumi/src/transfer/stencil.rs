use crate::grid::Grid;
use crate::particles::Places;
use crate::shape::{CellOnAxis, ShapeFunction, Weights};
use crate::tensor::Vector;

/// A point's weights in its cell's stencil.
pub(super) struct Stencil<const D: usize> {
    pub(super) first_node: usize,
    pub(super) strides: [usize; D],
    pub(super) weights: [Weights; D],
    pub(super) inverse_spacing: Vector<D>,
    /// From the point to the first node, in spacings, along each axis.
    to_first: [f64; D],
}

impl<const D: usize> Stencil<D> {
    /// The stencil of a point of the cell with these numbers; the point and half size in spacings.
    #[inline(always)]
    pub(super) fn new<S: ShapeFunction>(
        shape: &S,
        grid: &Grid<D>,
        index: [usize; D],
        place: Vector<D>,
        half_size: Vector<D>,
    ) -> Self {
        let strides = grid.node_strides();
        let on_axis = |axis: usize| CellOnAxis { cell: index[axis], num_cells: grid.cells()[axis] };
        let mut first_node = 0;
        let mut weights = [Weights::default(); D];
        let mut to_first = [0.0; D];
        for axis in 0..D {
            let first = shape.first_node(on_axis(axis));
            first_node += first * strides[axis];
            to_first[axis] = f64::from(first as u32) - place[axis];
            weights[axis] = shape.weights(on_axis(axis), place[axis], half_size[axis]);
        }
        Stencil { first_node, strides, weights, inverse_spacing: grid.inverse_spacing(), to_first }
    }

    /// The stencil of a particle that is inside the grid.
    #[inline(always)]
    pub(super) fn of_particle<S: ShapeFunction>(shape: &S, grid: &Grid<D>, places: Places<D>, p: usize) -> Self {
        let index = grid.index_of(&grid.in_spacings(&places.position[p]));
        Stencil::of_particle_in(shape, grid, index, places, p)
    }

    /// The stencil of a particle that is in the cell with these numbers.
    #[inline(always)]
    pub(super) fn of_particle_in<S: ShapeFunction>(
        shape: &S,
        grid: &Grid<D>,
        index: [usize; D],
        places: Places<D>,
        p: usize,
    ) -> Self {
        let place = grid.in_spacings(&places.position[p]);
        let half_size = if S::BOX_STRETCHES { places.half_size[p] } else { places.half_size_at_start[p] };
        let mut in_spacings = Vector::zeros();
        for axis in 0..D {
            in_spacings[axis] = half_size[axis] * grid.inverse_spacing()[axis];
        }
        Stencil::new(shape, grid, index, place, in_spacings)
    }

    /// The stencil of a point (m) of a cell.
    #[inline(always)]
    pub(super) fn of_point<S: ShapeFunction>(shape: &S, grid: &Grid<D>, cell: usize, point: &Vector<D>) -> Self {
        Stencil::new(shape, grid, grid.cell_index(cell), grid.in_spacings(point), Vector::zeros())
    }

    /// Calls `visit(local, node, N, ∇N)` for each node of the stencil, x fastest.
    #[inline(always)]
    pub(super) fn visit<S: ShapeFunction>(&self, mut visit: impl FnMut(usize, usize, f64, [f64; D])) {
        let along_x = &self.weights[0];
        let inverse_spacing = self.inverse_spacing[0];
        for row in 0..S::WIDTH.pow(D as u32 - 1) {
            let Row { first_node, value, gradient } = self.row(S::WIDTH, row);
            for k in 0..S::WIDTH {
                let value_x = along_x.value[k];
                let mut gradient = gradient;
                gradient[0] = value * (along_x.gradient[k] * inverse_spacing);
                for component in &mut gradient[1..] {
                    *component *= value_x;
                }
                visit(row * S::WIDTH + k, first_node + k, value * value_x, gradient);
            }
        }
    }

    /// From the point to node number `local` of the stencil (m), x_I − X_p.
    #[inline(always)]
    pub(super) fn arm<S: ShapeFunction>(&self, spacing: &Vector<D>, local: usize) -> Vector<D> {
        let mut rest = local;
        let mut arm = *spacing;
        for axis in 0..D {
            let k = rest % S::WIDTH;
            rest /= S::WIDTH;
            arm[axis] *= self.to_first[axis] + f64::from(k as u32);
        }
        arm
    }

    /// One over the diagonal of D_p = Σ_I N_I (x_I − X_p) ⊗ (x_I − X_p) (1/m²), see [`inverse_of_spread`].
    #[inline(always)]
    pub(super) fn inverse_spread<S: ShapeFunction>(&self, spacing: &Vector<D>) -> [f64; D] {
        std::array::from_fn(|axis| {
            let arm = |k: usize| (self.to_first[axis] + f64::from(k as u32)) * spacing[axis];
            let spread = (0..S::WIDTH).map(|k| self.weights[axis].value[k] * arm(k) * arm(k)).sum();
            inverse_of_spread(spread, spacing[axis])
        })
    }

    /// What the other axes make of the nodes along x.
    #[inline(always)]
    fn row(&self, width: usize, number: usize) -> Row<D> {
        let mut rest = number;
        let mut row = Row { first_node: self.first_node, value: 1.0, gradient: [1.0; D] };
        for axis in 1..D {
            let k = rest % width;
            rest /= width;
            row.first_node += k * self.strides[axis];
            let weights = &self.weights[axis];
            row.value *= weights.value[k];
            for other in 1..D {
                row.gradient[other] *= match other == axis {
                    true => weights.gradient[k] * self.inverse_spacing[axis],
                    false => weights.value[k],
                };
            }
        }
        row
    }
}

/// One over Σ_I N_I (x_I − X_p)² along an axis (1/m²). Zero nearer to a grid line than this, with nodes on neither side: the moment is lost in
/// round-off.
#[inline(always)]
pub(super) fn inverse_of_spread(spread: f64, spacing: f64) -> f64 {
    if spread > 1e-12 * spacing * spacing { 1.0 / spread } else { 0.0 }
}

/// Nodes along x that follow each other.
struct Row<const D: usize> {
    first_node: usize,
    /// The product of the values along the other axes (–).
    value: f64,
    /// The same with the gradient along one of them (1/m); the one along x is not used.
    gradient: [f64; D],
}

/// The weights of points, averaged over a cell.
///
/// Two Gauss points in each half of the cell: exact for functions that are cubic there. Quadratic splines have their knots half
/// way between the nodes; two points in the whole cell would be 15 % off in the outer nodes.
pub(super) fn mean_weights<S: ShapeFunction>(shape: &S, at: CellOnAxis) -> Weights {
    let offset = 0.25 / 3.0_f64.sqrt();
    let mut mean = Weights::default();
    for xi in [0.25 - offset, 0.25 + offset, 0.75 - offset, 0.75 + offset] {
        let weights = shape.weights(at, at.cell as f64 + xi, 0.0);
        for k in 0..S::WIDTH {
            mean.value[k] += 0.25 * weights.value[k];
            mean.gradient[k] += 0.25 * weights.gradient[k];
        }
    }
    mean
}
