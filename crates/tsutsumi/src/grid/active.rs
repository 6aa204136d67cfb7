use super::vec_bytes;
use crate::parallel::{self, Pieces};

/// Nodes that one thread takes at a time.
const GRAIN: usize = 2048;

/// The cells that hold particles and the nodes they touch, in ascending order, and the particles of each cell.
///
/// An active cell also has a *slot*, its place among the active cells, for dense work arrays.
#[derive(Debug, Clone)]
pub struct ActiveSet {
    cells: Vec<u32>,
    nodes: Vec<u32>,
    slot_of_cell: Vec<u32>,
    node_is_active: Vec<bool>,
    generation: u64,
    /// The particles, cell after cell, those of a cell in ascending order.
    particles: Vec<u32>,
    /// Where in `particles` each slot begins, and the end.
    first_particle: Vec<u32>,
}

const NO_SLOT: u32 = u32::MAX;

impl ActiveSet {
    /// An empty set for a grid with so many cells and nodes. All memory that depends on the grid is set aside here.
    pub fn new<const D: usize>(grid: &super::Grid<D>) -> Self {
        let (num_cells, num_nodes) = (grid.num_cells(), grid.num_nodes());
        ActiveSet {
            cells: Vec::with_capacity(num_cells),
            nodes: Vec::with_capacity(num_nodes),
            slot_of_cell: vec![NO_SLOT; num_cells],
            node_is_active: vec![false; num_nodes],
            generation: 0,
            particles: Vec::new(),
            first_particle: Vec::with_capacity(num_cells + 1),
        }
    }

    /// Brings the set up to date with the cells of the particles.
    ///
    /// `touch_nodes(cells, touched)` marks the nodes of cells in a list of one mark per node of the grid. The generation changes only if the
    /// set of cells does.
    pub fn update(&mut self, cell_of_particle: &[u32], touch_nodes: impl FnOnce(&[u32], &mut [bool])) {
        if !self.count_particles(cell_of_particle) {
            self.rebuild(cell_of_particle, touch_nodes);
            self.count_particles(cell_of_particle);
        }
        self.list_particles(cell_of_particle);
    }

    /// Counts the particles of each slot. False if one has no slot, or a slot has none: then the set is another.
    fn count_particles(&mut self, cell_of_particle: &[u32]) -> bool {
        self.first_particle.clear();
        self.first_particle.resize(self.cells.len() + 1, 0);
        for &cell in cell_of_particle {
            let slot = self.slot_of_cell[cell as usize];
            if slot == NO_SLOT {
                return false;
            }
            self.first_particle[slot as usize] += 1;
        }
        !self.first_particle[..self.cells.len()].contains(&0)
    }

    /// Lists the particles by slot, from their counts.
    fn list_particles(&mut self, cell_of_particle: &[u32]) {
        let mut end = 0;
        for first in &mut self.first_particle {
            end += *first;
            *first = end;
        }
        self.particles.resize(cell_of_particle.len(), 0);
        // From the last to the first: the ends become the beginnings.
        for (p, &cell) in cell_of_particle.iter().enumerate().rev() {
            let place = &mut self.first_particle[self.slot_of_cell[cell as usize] as usize];
            *place -= 1;
            self.particles[*place as usize] = p as u32;
        }
    }

    fn rebuild(&mut self, occupied: &[u32], touch_nodes: impl FnOnce(&[u32], &mut [bool])) {
        for &cell in &self.cells {
            self.slot_of_cell[cell as usize] = NO_SLOT;
        }
        for &node in &self.nodes {
            self.node_is_active[node as usize] = false;
        }
        for &cell in occupied {
            self.slot_of_cell[cell as usize] = 0;
        }
        let range = |numbers: &[u32]| match (numbers.iter().min(), numbers.iter().max()) {
            (Some(&lowest), Some(&highest)) => lowest..highest + 1,
            _ => 0..0,
        };
        self.cells.clear();
        self.cells.extend(range(occupied).filter(|&cell| self.slot_of_cell[cell as usize] != NO_SLOT));
        for (slot, &cell) in self.cells.iter().enumerate() {
            self.slot_of_cell[cell as usize] = slot as u32;
        }
        touch_nodes(&self.cells, &mut self.node_is_active);
        self.nodes.clear();
        let touched = self.node_is_active.iter().enumerate().filter(|(_, is_active)| **is_active);
        self.nodes.extend(touched.map(|(node, _)| node as u32));
        self.generation += 1;
    }

    /// The active cells.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// The nodes of the active cells.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Changes the values of a field at the active nodes, on all threads: `change(place among the active nodes, node, value)`.
    pub(crate) fn change_nodes<T: Send>(&self, values: &mut [T], change: impl Fn(usize, usize, &mut T) + Sync) {
        let work = |piece: ActiveValues<T>| {
            for (number, &node) in piece.numbers.iter().enumerate() {
                change(piece.place + number, node as usize, &mut piece.values[node as usize - piece.first]);
            }
        };
        parallel::for_each(ActiveValues { numbers: &self.nodes, place: 0, first: 0, values }, GRAIN, &work);
    }

    /// Changes the values of a field at the active cells, on all threads: `change(slot, value)`.
    pub(crate) fn change_cells<T: Send>(&self, values: &mut [T], change: impl Fn(usize, &mut T) + Sync) {
        let work = |piece: ActiveValues<T>| {
            for (number, &cell) in piece.numbers.iter().enumerate() {
                change(piece.place + number, &mut piece.values[cell as usize - piece.first]);
            }
        };
        parallel::for_each(ActiveValues { numbers: &self.cells, place: 0, first: 0, values }, GRAIN, &work);
    }

    /// All particles, cell after cell, those of a cell in ascending order.
    pub fn particles(&self) -> &[u32] {
        &self.particles
    }

    /// The particles of the cell in a slot, in ascending order.
    #[inline]
    pub fn particles_of(&self, slot: usize) -> &[u32] {
        &self.particles[self.first_particle[slot] as usize..self.first_particle[slot + 1] as usize]
    }

    /// True when the node touches an active cell.
    #[inline]
    pub fn has_node(&self, node: usize) -> bool {
        self.node_is_active[node]
    }

    /// The place of a cell among the active ones.
    #[inline]
    pub fn slot(&self, cell: usize) -> Option<usize> {
        let slot = self.slot_of_cell[cell];
        (slot != NO_SLOT).then_some(slot as usize)
    }

    /// Counts the rebuilds: work arrays made for one generation hold until the next.
    pub fn generation(&self) -> u64 {
        self.generation
    }
}

/// The values of a field at some active nodes or cells, in ascending order, and around them.
struct ActiveValues<'a, T> {
    numbers: &'a [u32],
    /// The place of the first one among the active ones.
    place: usize,
    /// The one whose value comes first.
    first: usize,
    values: &'a mut [T],
}

impl<T: Send> Pieces for ActiveValues<'_, T> {
    fn count(&self) -> usize {
        self.numbers.len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let (left, right) = self.numbers.split_at(at);
        let first = right.first().map_or(self.first + self.values.len(), |&number| number as usize);
        let (lower, upper) = self.values.split_at_mut(first - self.first);
        (
            ActiveValues { numbers: left, place: self.place, first: self.first, values: lower },
            ActiveValues { numbers: right, place: self.place + at, first, values: upper },
        )
    }
}

impl ActiveSet {
    /// The memory of the lists (bytes).
    pub(crate) fn bytes(&self) -> usize {
        let ActiveSet { cells, nodes, slot_of_cell, node_is_active, generation: _, particles, first_particle } = self;
        let lists: usize = [cells, nodes, slot_of_cell, particles, first_particle].map(vec_bytes).iter().sum();
        lists + vec_bytes(node_is_active)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::tensor::Vector;

    #[test]
    fn active_nodes_are_changed_and_others_left() {
        let grid = Grid::new(Vector::<1>::zeros(), Vector::<1>::repeat(1.0), [19_999]).unwrap();
        let mut active = ActiveSet::new(&grid);
        active
            .update(&[0], |_, touched| (0..20_000).filter(|node| node % 3 != 1).for_each(|node| touched[node] = true));
        let mut values = vec![-1.0; 20_000];
        active.change_nodes(&mut values, |place, node, value| *value = (place + node) as f64);
        for (node, &value) in values.iter().enumerate() {
            let place = active.nodes().binary_search(&(node as u32));
            assert_eq!(value, place.map_or(-1.0, |place| (place + node) as f64));
        }
    }

    #[test]
    fn an_updated_set_forgets_the_old_one() {
        let grid = Grid::new(Vector::<2>::zeros(), Vector::<2>::repeat(1.0), [4, 3]).unwrap();
        let mut active = ActiveSet::new(&grid);
        let corners = |cells: &[u32], touched: &mut [bool]| {
            for &cell in cells {
                let [i, j] = grid.cell_index(cell as usize);
                [0, 1, 5, 6].iter().for_each(|offset| touched[i + 5 * j + offset] = true);
            }
        };
        active.update(&[5, 1, 5], corners);
        assert_eq!((active.cells(), active.nodes().len()), (&[1, 5][..], 6));
        assert_eq!((active.slot(5), active.slot(4)), (Some(1), None));
        assert_eq!((active.particles_of(0), active.particles_of(1)), (&[1][..], &[0, 2][..]));
        // Other particles in the same cells: the same set.
        active.update(&[1, 1, 5], corners);
        assert_eq!((active.generation(), active.particles()), (1, &[0, 1, 2][..]));
        active.update(&[4], corners);
        assert_eq!((active.cells(), active.nodes()), (&[4][..], &[5, 6, 10, 11][..]));
        assert_eq!((active.slot(5), active.generation()), (None, 2));
        // A cell that the others leave.
        active.update(&[4, 5], corners);
        active.update(&[4, 4], corners);
        assert_eq!(active.cells(), [4]);
    }
}
