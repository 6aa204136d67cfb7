//! The background grid: a box of equal cells, its node fields and cell fields, and the part of it that holds particles.
//!
//! Nodes and cells are numbered with x fastest. The grid never moves; the body does.

mod active;
mod lists;
mod movers;

pub use active::{ActiveSet, Located};

use crate::large_pages;
use crate::tensor::Vector;

/// A uniform grid with a spacing per axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid<const D: usize> {
    origin: Vector<D>,
    spacing: Vector<D>,
    inverse_spacing: Vector<D>,
    cells: [usize; D],
    node_strides: [usize; D],
}

/// Why a grid cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridError {
    /// A spacing is zero, negative or not a number.
    #[error("the grid spacing along axis {axis} is {spacing} m, but must be positive")]
    Spacing {
        /// The axis, 0 = x.
        axis: usize,
        /// The spacing given (m).
        spacing: f64,
    },
    /// An axis has no cell, or the grid has more cells than can be numbered.
    #[error("a grid of {cells:?} cells cannot be made: at least 1 per axis, at most {MAX_CELLS} in all")]
    Cells {
        /// The numbers of cells given, per axis.
        cells: Vec<usize>,
    },
}

/// The largest number of cells of a grid: cell and node numbers are 32 bits wide.
pub const MAX_CELLS: usize = 1 << 30;

/// A side of a cell or of a box: an axis and a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    /// The axis normal to the side, 0 = x.
    pub axis: usize,
    /// True for the side at the larger coordinate.
    pub upper: bool,
}

impl Side {
    /// The sides of a cell: x lower, x upper, y lower, …
    pub fn all<const D: usize>() -> impl Iterator<Item = Side> {
        (0..D).flat_map(|axis| [Side { axis, upper: false }, Side { axis, upper: true }])
    }

    /// The component of the outward normal along the axis: −1 or +1.
    pub fn sign(self) -> f64 {
        if self.upper { 1.0 } else { -1.0 }
    }

    fn bit(self) -> u8 {
        1 << (2 * self.axis + usize::from(self.upper))
    }
}

/// A set of sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SideSet(u8);

impl SideSet {
    /// No side.
    pub const EMPTY: SideSet = SideSet(0);

    /// Adds a side.
    pub fn insert(&mut self, side: Side) {
        self.0 |= side.bit();
    }

    /// True when the side is in the set.
    pub fn contains(self, side: Side) -> bool {
        self.0 & side.bit() != 0
    }

    /// The sides in either set.
    pub fn union(self, other: SideSet) -> SideSet {
        SideSet(self.0 | other.0)
    }

    /// True when no side is in the set.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl<const D: usize> Grid<D> {
    /// A grid of `cells` cells of size `spacing` (m), its lowest corner at `origin` (m).
    ///
    /// # Errors
    /// A spacing that is not positive, an axis without cells, more than [`MAX_CELLS`] cells.
    pub fn new(origin: Vector<D>, spacing: Vector<D>, cells: [usize; D]) -> Result<Self, GridError> {
        for axis in 0..D {
            if !(spacing[axis] > 0.0 && spacing[axis].is_finite()) {
                return Err(GridError::Spacing { axis, spacing: spacing[axis] });
            }
        }
        let nodes = cells.iter().try_fold(1_usize, |count, &n| count.checked_mul(n.checked_add(1)?));
        if cells.contains(&0) || nodes.is_none_or(|count| count > MAX_CELLS) {
            return Err(GridError::Cells { cells: cells.to_vec() });
        }
        let mut stride = 1;
        let node_strides = std::array::from_fn(|axis| {
            let this = stride;
            stride *= cells[axis] + 1;
            this
        });
        Ok(Grid { origin, spacing, inverse_spacing: spacing.map(|h| 1.0 / h), cells, node_strides })
    }

    /// The lowest corner (m).
    pub fn origin(&self) -> Vector<D> {
        self.origin
    }

    /// The highest corner (m).
    pub fn end(&self) -> Vector<D> {
        Vector::from_fn(|axis, _| self.origin[axis] + self.spacing[axis] * self.cells[axis] as f64)
    }

    /// The size of a cell (m).
    pub fn spacing(&self) -> Vector<D> {
        self.spacing
    }

    /// The number of cells per axis.
    pub fn cells(&self) -> [usize; D] {
        self.cells
    }

    /// The number of cells.
    pub fn num_cells(&self) -> usize {
        self.cells.iter().product()
    }

    /// The number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.cells.iter().map(|n| n + 1).product()
    }

    /// The volume of a cell (m³; m² per metre in 2-D).
    pub fn cell_volume(&self) -> f64 {
        self.spacing.product()
    }

    /// The area of the cell sides normal to `axis` (m²; m per metre in 2-D, 1 in 1-D).
    pub fn side_area(&self, axis: usize) -> f64 {
        (0..D).filter(|&other| other != axis).map(|other| self.spacing[other]).product()
    }

    /// One over the size of a cell (1/m).
    #[inline]
    pub fn inverse_spacing(&self) -> Vector<D> {
        self.inverse_spacing
    }

    /// A point in spacings from the origin (–).
    #[inline(always)]
    pub fn in_spacings(&self, point: &Vector<D>) -> Vector<D> {
        let mut place = Vector::zeros();
        for axis in 0..D {
            place[axis] = (point[axis] - self.origin[axis]) * self.inverse_spacing[axis];
        }
        place
    }

    /// The numbers along the axes of the cell that holds a point inside the grid, given in spacings from the origin.
    ///
    /// A point on the upper end of the grid belongs to the last cell.
    #[inline(always)]
    pub fn index_of(&self, in_spacings: &Vector<D>) -> [usize; D] {
        let mut index = [0; D];
        for axis in 0..D {
            index[axis] = self.index_on(axis, in_spacings[axis]);
        }
        index
    }

    /// The same along one axis.
    #[inline(always)]
    pub(crate) fn index_on(&self, axis: usize, in_spacings: f64) -> usize {
        index_among(self.cells[axis], in_spacings)
    }

    /// The cell that holds a point (m); `None` outside the grid or when a coordinate is not a number.
    #[inline]
    pub fn cell_at(&self, point: &Vector<D>) -> Option<usize> {
        let place = self.in_spacings(point);
        // NaN fails the comparison.
        let mut inside = true;
        for axis in 0..D {
            inside &= place[axis] >= 0.0 && place[axis] <= f64::from(self.cells[axis] as u32);
        }
        if !inside {
            return None;
        }
        let index = self.index_of(&place);
        let mut cell = 0;
        for axis in (0..D).rev() {
            cell = cell * self.cells[axis] + index[axis];
        }
        Some(cell)
    }

    /// The cells that hold these points (m), as [`Self::cell_at`] finds them, in a loop for vectors. False if any point has none: then
    /// what stands in `found` means nothing. `found` has room for all of them.
    #[inline(always)]
    pub(crate) fn cells_at(&self, points: &[Vector<D>], found: &mut [u32]) -> bool {
        let counts = self.cells.map(|count| f64::from(count as u32));
        let mut all_inside = true;
        for (point, found) in points.iter().zip(found) {
            let place = self.in_spacings(point);
            // Exact, since it stays below 2⁵³.
            let mut number = 0.0;
            for axis in (0..D).rev() {
                all_inside &= (place[axis] >= 0.0) & (place[axis] <= counts[axis]);
                number = number * counts[axis] + whole_below(counts[axis], place[axis]);
            }
            *found = low_bits(number);
        }
        all_inside
    }

    /// The numbers of a cell along the axes.
    #[inline]
    pub fn cell_index(&self, cell: usize) -> [usize; D] {
        let mut rest = cell;
        std::array::from_fn(|axis| {
            let index = rest % self.cells[axis];
            rest /= self.cells[axis];
            index
        })
    }

    /// The lowest corner of a cell (m).
    pub fn cell_origin(&self, cell: usize) -> Vector<D> {
        let index = self.cell_index(cell);
        Vector::from_fn(|axis, _| self.origin[axis] + self.spacing[axis] * index[axis] as f64)
    }

    /// The centre of a cell (m).
    pub fn cell_center(&self, cell: usize) -> Vector<D> {
        self.cell_origin(cell) + self.spacing * 0.5
    }

    /// The cell beyond a side; `None` at the end of the grid.
    pub fn neighbor(&self, cell: usize, side: Side) -> Option<usize> {
        let index = self.cell_index(cell)[side.axis];
        let stride: usize = self.cells[..side.axis].iter().product();
        match side.upper {
            true => (index + 1 < self.cells[side.axis]).then(|| cell + stride),
            false => (index > 0).then(|| cell - stride),
        }
    }

    /// How far apart neighbouring nodes along each axis are in the numbering.
    #[inline]
    pub fn node_strides(&self) -> [usize; D] {
        self.node_strides
    }

    /// The position of a node (m).
    pub fn node_position(&self, node: usize) -> Vector<D> {
        let mut rest = node;
        Vector::from_fn(|axis, _| {
            let count = self.cells[axis] + 1;
            let index = rest % count;
            rest /= count;
            self.origin[axis] + self.spacing[axis] * index as f64
        })
    }
}

/// The fields of the nodes, one value per node of the grid. Only active nodes hold values of this step.
#[derive(Debug, Clone)]
pub struct NodeFields<const D: usize> {
    /// Lumped mass m_I (kg).
    pub mass: Vec<f64>,
    /// One over the mass, per axis; zero where a support holds the node or there is no mass (1/kg). Nodes that move as one
    /// have one over the mass of all of them.
    pub mobility: Vec<Vector<D>>,
    /// Velocity at the start of the step, v_I of Eq. (10) (m/s). Holds the momentum (kg m/s) while sums are made.
    pub velocity_old: Vec<Vector<D>>,
    /// Velocity after the grid update, v_I^L (m/s).
    pub velocity: Vec<Vector<D>>,
    /// Acceleration a_I (m/s²).
    pub acceleration: Vec<Vector<D>>,
    /// Force of Eq. (5) without the pore pressure (N).
    pub force: Vec<Vector<D>>,
    /// The sets of nodes that move as one in this step. No node is in two of the same axis.
    pub ties: Vec<Tie>,
}

/// Nodes that move as one along an axis.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tie {
    axis: usize,
    nodes: Vec<u32>,
}

impl Tie {
    /// A tie along an axis (0 = x) without nodes, with room for `capacity` of them.
    pub fn with_capacity(axis: usize, capacity: usize) -> Self {
        Tie { axis, nodes: Vec::with_capacity(capacity) }
    }

    /// The axis along which the nodes move as one, 0 = x.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// The nodes.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Replaces the nodes.
    pub fn set_nodes(&mut self, nodes: impl Iterator<Item = u32>) {
        self.nodes.clear();
        self.nodes.extend(nodes);
    }

    /// Gives every node of the tie the sum over it, along its axis: of forces or of momenta. The product with the mobility
    /// is then the one motion of all, the same in every bit.
    pub fn gather<const D: usize>(&self, field: &mut [Vector<D>]) {
        let sum: f64 = self.nodes.iter().map(|&node| field[node as usize][self.axis]).sum();
        for &node in &self.nodes {
            field[node as usize][self.axis] = sum;
        }
    }
}

impl<const D: usize> NodeFields<D> {
    /// Fields of zeros for a grid.
    pub fn new(grid: &Grid<D>) -> Self {
        let vectors = || large_pages::filled(Vector::zeros(), grid.num_nodes());
        NodeFields {
            mass: large_pages::filled(0.0, grid.num_nodes()),
            mobility: vectors(),
            velocity_old: vectors(),
            velocity: vectors(),
            acceleration: vectors(),
            force: vectors(),
            ties: Vec::new(),
        }
    }

    /// Turns forces (N) that stand in `acceleration` into accelerations: M⁻¹ F, with the tied nodes as one.
    pub fn forces_to_accelerations(&mut self, active: &ActiveSet) {
        for tie in &self.ties {
            tie.gather(&mut self.acceleration);
        }
        let mobility = &self.mobility;
        active.change_runs(&mut self.acceleration, |nodes, values| scale(values, &mobility[nodes]));
    }

    /// Puts the forces (N) where the accelerations will stand.
    pub(crate) fn put_forces_for_accelerations(&mut self, active: &ActiveSet) {
        let force = &self.force;
        active.change_runs(&mut self.acceleration, |nodes, values| values.copy_from_slice(&force[nodes]));
    }

    /// Accelerations from the forces, M⁻¹ F, as [`Self::forces_to_accelerations`] does, in one pass where no nodes are tied.
    pub(crate) fn accelerate(&mut self, active: &ActiveSet) {
        if !self.ties.is_empty() {
            self.put_forces_for_accelerations(active);
            return self.forces_to_accelerations(active);
        }
        let NodeFields { force, mobility, acceleration, .. } = self;
        active.change_runs(acceleration, |nodes, accelerations| {
            let causes = force[nodes.clone()].iter().zip(&mobility[nodes]);
            for (acceleration, (force, mobility)) in accelerations.iter_mut().zip(causes) {
                for axis in 0..D {
                    acceleration[axis] = force[axis] * mobility[axis];
                }
            }
        });
    }

    /// Turns momenta (kg m/s) of the nodes into velocities (m/s), as [`Self::forces_to_accelerations`] does with forces.
    pub fn momenta_to_velocities(&self, active: &ActiveSet, field: &mut [Vector<D>]) {
        for tie in &self.ties {
            tie.gather(field);
        }
        active.change_runs(field, |nodes, values| scale(values, &self.mobility[nodes]));
    }
}

/// A whole number from 0 to 2³² − 1 as an integer, without the care that a conversion takes for others: it is what 2⁵² + `number` has in
/// its lowest bits.
#[inline(always)]
fn low_bits(number: f64) -> u32 {
    const TWO_TO_52: f64 = (1_u64 << 52) as f64;
    (number + TWO_TO_52).to_bits() as u32
}

/// The number of the cell, among so many along an axis, that holds a point of the grid.
#[inline(always)]
pub(crate) fn index_among(cells: usize, in_spacings: f64) -> usize {
    // Fewer than 2³⁰ cells: 32 bits are enough, and faster.
    (in_spacings as i32).clamp(0, cells as i32 - 1) as usize
}

/// The same in loops for vectors, which know no rounding to numbers of 32 bits that saturates.
#[inline(always)]
pub(crate) fn index_among_in_vectors(cells: usize, in_spacings: f64) -> usize {
    let index = whole_below(f64::from(cells as u32), in_spacings);
    // Fewer than 2³⁰ cells: the compiler may convert it as a signed number.
    (low_bits(if index > 0.0 { index } else { 0.0 }) & (u32::MAX >> 2)) as usize
}

/// The whole number at or below a place, or the last one below `count`.
#[inline(always)]
fn whole_below(count: f64, place: f64) -> f64 {
    let (index, last) = (place.floor(), count - 1.0);
    if index < last { index } else { last }
}

/// Component by component.
#[inline(always)]
fn scale<const D: usize>(vectors: &mut [Vector<D>], factors: &[Vector<D>]) {
    for (vector, factors) in vectors.iter_mut().zip(factors) {
        for axis in 0..D {
            vector[axis] *= factors[axis];
        }
    }
}

/// The fields of the cells, one value per cell of the grid. Only active cells hold values.
#[derive(Debug, Clone)]
pub struct CellFields {
    /// Pore pressure p_w at the cell's centre at the end of the step (Pa, positive in compression).
    pub pressure: Vec<f64>,
    /// The same at the start of the step, from the particles (Pa).
    pub pressure_old: Vec<f64>,
    /// Volume of the particles inside (m³; m² per metre in 2-D, m in 1-D).
    pub volume: Vec<f64>,
}

impl CellFields {
    /// Fields of zeros for a grid.
    pub fn new<const D: usize>(grid: &Grid<D>) -> Self {
        let zeros = vec![0.0; grid.num_cells()];
        CellFields { pressure: zeros.clone(), pressure_old: zeros.clone(), volume: zeros }
    }
}

/// The memory of an array (bytes).
pub(crate) fn vec_bytes<T>(array: &Vec<T>) -> usize {
    array.capacity() * size_of::<T>()
}

impl<const D: usize> NodeFields<D> {
    /// The memory of the fields (bytes), without the few nodes that move as one.
    pub(crate) fn bytes(&self) -> usize {
        let NodeFields { mass, mobility, velocity_old, velocity, acceleration, force, ties: _ } = self;
        vec_bytes(mass) + [mobility, velocity_old, velocity, acceleration, force].map(vec_bytes).iter().sum::<usize>()
    }
}

impl CellFields {
    /// The memory of the fields (bytes).
    pub(crate) fn bytes(&self) -> usize {
        let CellFields { pressure, pressure_old, volume } = self;
        [pressure, pressure_old, volume].map(vec_bytes).iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid<2> {
        Grid::new(Vector::<2>::new(-1.0, 2.0), Vector::<2>::new(0.5, 0.25), [4, 3]).unwrap()
    }

    #[test]
    fn cells_and_nodes_are_numbered_with_x_fastest() {
        let grid = grid();
        assert_eq!((grid.num_cells(), grid.num_nodes()), (12, 20));
        assert_eq!(grid.cell_at(&Vector::<2>::new(-0.4, 2.3)), Some(5));
        assert_eq!(grid.cell_index(5), [1, 1]);
        assert_eq!(grid.cell_center(5), Vector::<2>::new(-0.25, 2.375));
        assert_eq!(grid.node_strides(), [1, 5]);
        assert_eq!(grid.node_position(6), Vector::<2>::new(-0.5, 2.25));
        assert_eq!(grid.end(), Vector::<2>::new(1.0, 2.75));
        assert_eq!((grid.side_area(0), grid.side_area(1)), (0.25, 0.5));
    }

    #[test]
    fn points_outside_have_no_cell_and_the_upper_end_belongs_to_the_last() {
        let grid = grid();
        assert_eq!(grid.cell_at(&Vector::<2>::new(1.0, 2.75)), Some(11));
        assert_eq!(grid.cell_at(&Vector::<2>::new(1.0 + 1e-9, 2.5)), None);
        assert_eq!(grid.cell_at(&Vector::<2>::new(f64::NAN, 2.5)), None);
    }

    #[test]
    fn neighbors_stop_at_the_ends() {
        let grid = grid();
        assert_eq!(grid.neighbor(5, Side { axis: 0, upper: true }), Some(6));
        assert_eq!(grid.neighbor(5, Side { axis: 1, upper: false }), Some(1));
        assert_eq!(grid.neighbor(4, Side { axis: 0, upper: false }), None);
        assert_eq!(grid.neighbor(11, Side { axis: 1, upper: true }), None);
    }

    #[test]
    fn impossible_grids_are_refused() {
        let origin = Vector::<1>::zeros();
        assert!(matches!(Grid::new(origin, Vector::<1>::new(f64::NAN), [1]), Err(GridError::Spacing { .. })));
        assert!(matches!(Grid::new(origin, Vector::<1>::new(1.0), [0]), Err(GridError::Cells { .. })));
        assert!(matches!(Grid::new(origin, Vector::<1>::new(1.0), [usize::MAX]), Err(GridError::Cells { .. })));
    }
}
