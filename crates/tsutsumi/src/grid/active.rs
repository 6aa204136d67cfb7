use std::ops::Range;

use super::lists;
use super::movers::{Lists, Movers};
use super::vec_bytes;
use crate::parallel::{self, Pieces, vectorized};

/// Nodes or cells that one thread takes at a time.
const GRAIN: usize = 2048;
/// Particles that one thread looks at at a time.
const PLACES: usize = 16_384;
/// Nodes by which the list of them is changed at a time, more than those of a cell.
const NODES: usize = 1024;
/// So many places further on or back in memory are reached as if they were next.
const NEAR: u32 = 8;

/// The cells that hold particles and the nodes they touch, in ascending order, and the particles of each cell.
///
/// An active cell also has a *slot*, its place among the active cells, for dense work arrays.
#[derive(Debug, Clone)]
pub struct ActiveSet {
    cells: Vec<u32>,
    nodes: Vec<u32>,
    slot_of_cell: Vec<u32>,
    /// How many active cells touch each node of the grid.
    touches: Vec<u16>,
    generation: u64,
    /// The places of the particles, cell after cell, those of a cell in ascending order of their numbers.
    particles: Vec<u32>,
    /// Where in `particles` each slot begins, and the end.
    first_particle: Vec<u32>,
    movers: Movers,
    /// Room for cells or slots that join or part, and for some of their nodes.
    changed: Vec<u32>,
    changed_nodes: Vec<u32>,
}

/// What stands for the slot of a cell without particles.
pub(super) const NO_SLOT: u32 = u32::MAX;

/// The particles as the set sees them, by place.
#[derive(Debug, Clone, Copy)]
pub struct Located<'a> {
    /// The cells that they are in.
    pub cells: &'a [u32],
    /// Their numbers; empty where these are the places.
    pub numbers: &'a [u32],
}

impl Located<'_> {
    fn number(&self, place: u32) -> u32 {
        self.numbers.get(place as usize).copied().unwrap_or(place)
    }
}

impl ActiveSet {
    /// An empty set for a grid with so many cells and nodes. All memory that depends on the grid is set aside here.
    pub fn new<const D: usize>(grid: &super::Grid<D>) -> Self {
        let (num_cells, num_nodes) = (grid.num_cells(), grid.num_nodes());
        let movers = Movers::new(num_cells);
        ActiveSet {
            cells: Vec::with_capacity(num_cells),
            nodes: Vec::with_capacity(num_nodes),
            slot_of_cell: vec![NO_SLOT; num_cells],
            touches: vec![0; num_nodes],
            generation: 0,
            particles: Vec::new(),
            first_particle: Vec::with_capacity(num_cells + 1),
            changed: Vec::with_capacity(num_cells.min(movers.most())),
            changed_nodes: Vec::with_capacity(num_nodes.min(2 * NODES)),
            movers,
        }
    }

    /// Brings the set up to date with the cells of the particles.
    ///
    /// `visit_nodes(cell, visit)` calls `visit` with each node that a cell touches. The generation changes only if the set of cells does.
    pub fn update(&mut self, located: Located, visit_nodes: impl Fn(usize, &mut dyn FnMut(usize))) {
        if self.mend(located, &visit_nodes) {
            return;
        }
        if !self.count_particles(located.cells) {
            self.rebuild(located.cells, &visit_nodes);
            self.count_particles(located.cells);
        }
        self.list_particles(located);
    }

    /// Mends the set and its lists where few particles have moved. False if that cannot be: then they have to be made anew.
    fn mend(&mut self, located: Located, visit_nodes: &impl Fn(usize, &mut dyn FnMut(usize))) -> bool {
        if self.particles.len() != located.cells.len() || self.cells.is_empty() {
            return false;
        }
        let ActiveSet { cells, particles, first_particle: first, movers, .. } = self;
        if !movers.find(&Lists { cells, particles, first }, located.cells) {
            return false;
        }
        let mut changed = std::mem::take(&mut self.changed);
        self.movers.list_entered(&self.slot_of_cell, &mut changed);
        let any_joined = !changed.is_empty();
        if any_joined {
            self.join_cells(&changed, visit_nodes);
        }
        let ActiveSet { cells, particles, first_particle: first, slot_of_cell, movers, .. } = self;
        movers.name_slots(slot_of_cell);
        movers.mend(&mut Lists { cells, particles, first }, |place| located.number(place));
        self.movers.list_emptied(&self.first_particle, &mut changed);
        let any_parted = !changed.is_empty();
        if any_parted {
            self.part_slots(&mut changed, visit_nodes);
        }
        self.changed = changed;
        self.generation += u64::from(any_joined || any_parted);
        true
    }

    /// Adds cells without particles so far, in ascending order.
    fn join_cells(&mut self, new: &[u32], visit_nodes: &impl Fn(usize, &mut dyn FnMut(usize))) {
        let ActiveSet { cells, first_particle: first, .. } = self;
        let mut end = first.len();
        first.resize(end + new.len(), 0);
        for (count, cell) in new.iter().enumerate().rev() {
            let slot = cells.partition_point(|known| known < cell);
            first.copy_within(slot..end, slot + count + 1);
            first[slot + count] = first[slot + count + 1];
            end = slot;
        }
        lists::insert(cells, new);
        self.number_slots(end);

        let ActiveSet { nodes, changed_nodes, touches, .. } = self;
        let touch = |cell: u32, touched: &mut Vec<u32>| {
            visit_nodes(cell as usize, &mut |node| {
                if touches[node] == 0 {
                    touched.push(node as u32);
                }
                touches[node] += 1;
            });
        };
        change_by_parts(new, changed_nodes, touch, |touched| lists::insert(nodes, touched));
    }

    /// Takes slots without particles out, in ascending order; their cells stand in their stead afterwards.
    fn part_slots(&mut self, gone: &mut [u32], visit_nodes: &impl Fn(usize, &mut dyn FnMut(usize))) {
        let ActiveSet { cells, first_particle: first, slot_of_cell, .. } = self;
        let lowest = gone[0] as usize;
        for (count, &slot) in gone.iter().enumerate() {
            let next = gone.get(count + 1).map_or(first.len(), |&next| next as usize);
            first.copy_within(slot as usize + 1..next, slot as usize - count);
        }
        first.truncate(first.len() - gone.len());
        for slot in gone.iter_mut() {
            *slot = cells[*slot as usize];
            slot_of_cell[*slot as usize] = NO_SLOT;
        }
        lists::remove(cells, gone);
        self.number_slots(lowest);

        let ActiveSet { nodes, changed_nodes, touches, .. } = self;
        let leave = |cell: u32, left: &mut Vec<u32>| {
            visit_nodes(cell as usize, &mut |node| {
                touches[node] -= 1;
                if touches[node] == 0 {
                    left.push(node as u32);
                }
            });
        };
        change_by_parts(gone, changed_nodes, leave, |left| lists::remove(nodes, left));
    }

    /// Tells the cells their slots, from one on.
    fn number_slots(&mut self, first: usize) {
        for (slot, &cell) in self.cells.iter().enumerate().skip(first) {
            self.slot_of_cell[cell as usize] = slot as u32;
        }
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
    fn list_particles(&mut self, located: Located) {
        let mut end = 0;
        for first in &mut self.first_particle {
            end += *first;
            *first = end;
        }
        self.particles.resize(located.cells.len(), 0);
        // From the last to the first: the ends become the beginnings.
        for (p, &cell) in located.cells.iter().enumerate().rev() {
            let place = &mut self.first_particle[self.slot_of_cell[cell as usize] as usize];
            *place -= 1;
            self.particles[*place as usize] = p as u32;
        }
        if !located.numbers.is_empty() {
            for range in self.first_particle.windows(2) {
                let of_slot = &mut self.particles[range[0] as usize..range[1] as usize];
                if !of_slot.is_sorted_by_key(|&place| located.number(place)) {
                    of_slot.sort_unstable_by_key(|&place| located.number(place));
                }
            }
        }
    }

    /// Lends the array of the particles, which has to be given back by [`Self::list_again`].
    pub(crate) fn lend_particles(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.particles)
    }

    /// Lists the particles again, which have changed their places, not their cells; `room` is the array that was lent.
    pub(crate) fn list_again(&mut self, located: Located, room: Vec<u32>) {
        self.particles = room;
        self.count_particles(located.cells);
        self.list_particles(located);
    }

    /// How many particles stand far from the one before them in the list: where a pass along the cells has to jump in memory.
    pub(crate) fn count_jumps(&self) -> usize {
        let work = |range: Range<usize>| {
            let list = &self.particles[range.start..self.particles.len().min(range.end + 1)];
            list.windows(2).filter(|pair| pair[1].abs_diff(pair[0]) > NEAR).count()
        };
        parallel::fold(0..self.particles.len(), PLACES, &work, &|before, after| before + after)
    }

    /// Makes the set of cells and nodes anew.
    fn rebuild(&mut self, occupied: &[u32], visit_nodes: &impl Fn(usize, &mut dyn FnMut(usize))) {
        for &cell in &self.cells {
            self.slot_of_cell[cell as usize] = NO_SLOT;
        }
        for &node in &self.nodes {
            self.touches[node as usize] = 0;
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
        self.number_slots(0);
        let ActiveSet { cells, nodes, touches, .. } = self;
        for &cell in cells.iter() {
            visit_nodes(cell as usize, &mut |node| touches[node] += 1);
        }
        nodes.clear();
        let touched = touches.iter().enumerate().filter(|(_, touches)| **touches > 0);
        nodes.extend(touched.map(|(node, _)| node as u32));
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
        change_at(&self.nodes, values, &change);
    }

    /// The same for a field at the active cells: `change(slot, cell, value)`.
    pub(crate) fn change_cells<T: Send>(&self, values: &mut [T], change: impl Fn(usize, usize, &mut T) + Sync) {
        change_at(&self.cells, values, &change);
    }

    /// Changes the values of a field at the active nodes, on all threads, in loops for vectors over nodes that follow each other:
    /// `change(nodes, values)`, which must be inlined.
    pub(crate) fn change_runs<T: Send>(&self, values: &mut [T], change: impl Fn(Range<usize>, &mut [T]) + Sync) {
        let work = |piece: ActiveValues<T>| {
            vectorized(
                #[inline(always)]
                || {
                    for nodes in runs(piece.numbers) {
                        change(nodes.clone(), &mut piece.values[nodes.start - piece.first..nodes.end - piece.first]);
                    }
                },
            );
        };
        parallel::for_each(ActiveValues::new(&self.nodes, values), GRAIN, &work);
    }

    /// The active ones among some nodes that follow each other, in pieces without gaps.
    pub(crate) fn runs_in(&self, nodes: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let place = |node: usize| self.nodes.partition_point(|&active| (active as usize) < node);
        runs(&self.nodes[place(nodes.start)..place(nodes.end)])
    }

    /// The places of all particles, cell after cell, those of a cell in ascending order of their numbers.
    pub fn particles(&self) -> &[u32] {
        &self.particles
    }

    /// The places of the particles of the cell in a slot, in ascending order of their numbers.
    #[inline]
    pub fn particles_of(&self, slot: usize) -> &[u32] {
        &self.particles[self.first_particle[slot] as usize..self.first_particle[slot + 1] as usize]
    }

    /// The places of the particles of the cells in some slots that follow each other, cell after cell.
    pub fn particles_in(&self, slots: Range<usize>) -> &[u32] {
        &self.particles[self.first_particle[slots.start] as usize..self.first_particle[slots.end] as usize]
    }

    /// True when the node touches an active cell.
    #[inline]
    pub fn has_node(&self, node: usize) -> bool {
        self.touches[node] > 0
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

/// A list in ascending order, in pieces of numbers that follow each other.
#[inline(always)]
fn runs(mut numbers: &[u32]) -> impl Iterator<Item = Range<usize>> {
    std::iter::from_fn(move || {
        let first = *numbers.first()? as usize;
        let count = run_end(numbers, 0);
        numbers = &numbers[count..];
        Some(first..first + count)
    })
}

/// Where the numbers that follow each other from a place on end, in a list in ascending order.
fn run_end(numbers: &[u32], place: usize) -> usize {
    // As far from the first as their places are: then all in between are there.
    let follow = |other: usize| (numbers[other] - numbers[place]) as usize == other - place;
    let (mut last, mut end, mut stride) = (place, numbers.len(), 1);
    while last + stride < end {
        match follow(last + stride) {
            true => last += stride,
            false => end = last + stride,
        }
        stride *= 2;
    }
    while end - last > 1 {
        let middle = last.midpoint(end);
        match follow(middle) {
            true => last = middle,
            false => end = middle,
        }
    }
    end
}

/// Changes a list of nodes by those that some cells bring or take, some cells at a time.
fn change_by_parts(
    cells: &[u32],
    nodes: &mut Vec<u32>,
    mut find: impl FnMut(u32, &mut Vec<u32>),
    mut change: impl FnMut(&[u32]),
) {
    nodes.clear();
    for (count, &cell) in cells.iter().enumerate() {
        find(cell, nodes);
        if nodes.len() >= NODES || count + 1 == cells.len() {
            nodes.sort_unstable();
            change(nodes);
            nodes.clear();
        }
    }
}

/// Changes the values of a field at these nodes or cells: `change(place, number, value)`.
fn change_at<T: Send>(numbers: &[u32], values: &mut [T], change: &(impl Fn(usize, usize, &mut T) + Sync)) {
    let work = |piece: ActiveValues<T>| {
        for (place, &number) in (piece.place..).zip(piece.numbers) {
            change(place, number as usize, &mut piece.values[number as usize - piece.first]);
        }
    };
    parallel::for_each(ActiveValues::new(numbers, values), GRAIN, &work);
}

/// The values of a field at some active nodes or cells, in ascending order, and around them.
struct ActiveValues<'a, T> {
    numbers: &'a [u32],
    /// The place of the first of them among the active ones.
    place: usize,
    /// The node or cell whose values come first.
    first: usize,
    values: &'a mut [T],
}

impl<'a, T> ActiveValues<'a, T> {
    fn new(numbers: &'a [u32], values: &'a mut [T]) -> Self {
        ActiveValues { numbers, place: 0, first: 0, values }
    }
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
        let ActiveSet {
            cells,
            nodes,
            slot_of_cell,
            touches,
            generation: _,
            particles,
            first_particle,
            movers,
            changed,
            changed_nodes,
        } = self;
        let lists = [cells, nodes, slot_of_cell, particles, first_particle, changed, changed_nodes];
        lists.map(vec_bytes).iter().sum::<usize>() + vec_bytes(touches) + movers.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::tensor::Vector;

    /// Particles at the places of their numbers.
    fn placed(cells: &[u32]) -> Located<'_> {
        Located { cells, numbers: &[] }
    }

    #[test]
    fn active_nodes_are_changed_and_others_left() {
        let grid = Grid::new(Vector::<1>::zeros(), Vector::<1>::repeat(1.0), [19_999]).unwrap();
        let mut active = ActiveSet::new(&grid);
        active.update(placed(&[0]), |_, visit| (0..20_000).filter(|node| node % 3 != 1).for_each(visit));
        let mut values = vec![-1.0; 20_000];
        active.change_nodes(&mut values, |place, node, value| *value = (place + node) as f64);
        for (node, &value) in values.iter().enumerate() {
            let place = active.nodes().binary_search(&(node as u32));
            assert_eq!(value, place.map_or(-1.0, |place| (place + node) as f64));
        }
        // Runs of two nodes; the first piece may end within one.
        let mut values = vec![-1.0; 20_000];
        active.change_runs(&mut values, |nodes, values| {
            for (node, value) in nodes.zip(values) {
                *value = node as f64;
            }
        });
        for (node, &value) in values.iter().enumerate() {
            assert_eq!(value, if node % 3 != 1 { node as f64 } else { -1.0 });
        }
    }

    /// The nodes at the corners of the cells.
    fn corners(grid: &Grid<2>) -> impl Fn(usize, &mut dyn FnMut(usize)) {
        let [across, up] = grid.node_strides();
        move |cell, visit| {
            let [i, j] = grid.cell_index(cell);
            [0, across, up, across + up].iter().for_each(|corner| visit(i * across + j * up + corner));
        }
    }

    /// A set that was mended is that which is made anew, whatever the numbers of the particles.
    fn moved_particles_change_lists(numbers: &[u32], cell_of_particle: &mut [u32], leave_cells: bool) {
        let grid = Grid::new(Vector::<2>::zeros(), Vector::<2>::repeat(1.0), [50, 30]).unwrap();
        let cells = grid.num_cells();
        let mut active = ActiveSet::new(&grid);
        active.update(Located { cells: cell_of_particle, numbers }, corners(&grid));
        let mut generation = 1;
        let mut number = 1_u64;
        // From none to more than there is room for.
        for num_movers in [0, 1, 2, 3, 10, 30, 60, 100, 400, 1500, 20] {
            for _ in 0..num_movers {
                number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let (particle, to) =
                    ((number >> 33) as usize % cell_of_particle.len(), (number >> 20) as usize % cells);
                // One in four stays.
                if leave_cells || particle % 4 > 0 {
                    cell_of_particle[particle] = to as u32;
                }
            }
            let before = active.cells().to_vec();
            let located = Located { cells: cell_of_particle, numbers };
            active.update(located, corners(&grid));
            generation += u64::from(active.cells() != before);
            let mut anew = ActiveSet::new(&grid);
            anew.update(located, corners(&grid));
            assert_eq!(active.generation(), generation, "{num_movers} movers");
            assert_eq!((active.cells(), active.nodes()), (anew.cells(), anew.nodes()));
            assert_eq!((&active.slot_of_cell, &active.touches), (&anew.slot_of_cell, &anew.touches));
            assert_eq!(active.particles(), anew.particles());
            for slot in 0..active.cells().len() {
                let of_slot = active.particles_of(slot);
                assert_eq!(of_slot, anew.particles_of(slot));
                assert!(of_slot.is_sorted_by_key(|&place| located.number(place)) && !of_slot.is_empty());
            }
        }
        assert!(leave_cells == (generation > 1));
    }

    #[test]
    fn particles_that_move_change_lists() {
        let in_all_cells: Vec<u32> = (0..6000).map(|p| p / 4).collect();
        // Two thousand particles in all fourth cells: others are entered, these are left.
        let in_some_cells: Vec<u32> = (0..2000).map(|p| p % 375 * 4).collect();
        moved_particles_change_lists(&[], &mut in_all_cells.clone(), false);
        moved_particles_change_lists(&[], &mut in_some_cells.clone(), true);
        // Neighbours in memory have numbers that are far from each other.
        let numbers: Vec<u32> = (0..6000).map(|place| place * 7 % 6000).collect();
        moved_particles_change_lists(&numbers, &mut in_all_cells.clone(), false);
        let numbers: Vec<u32> = (0..2000).map(|place| place * 7 % 2000).collect();
        moved_particles_change_lists(&numbers, &mut in_some_cells.clone(), true);
    }

    #[test]
    fn an_updated_set_forgets_the_old_one() {
        let grid = Grid::new(Vector::<2>::zeros(), Vector::<2>::repeat(1.0), [4, 3]).unwrap();
        let mut active = ActiveSet::new(&grid);
        active.update(placed(&[5, 1, 5]), corners(&grid));
        assert_eq!((active.cells(), active.nodes().len()), (&[1, 5][..], 6));
        assert_eq!((active.slot(5), active.slot(4)), (Some(1), None));
        assert_eq!((active.particles_of(0), active.particles_of(1)), (&[1][..], &[0, 2][..]));
        // Other particles in the same cells: the same set.
        active.update(placed(&[1, 1, 5]), corners(&grid));
        assert_eq!((active.generation(), active.particles()), (1, &[0, 1, 2][..]));
        active.update(placed(&[4]), corners(&grid));
        assert_eq!((active.cells(), active.nodes()), (&[4][..], &[5, 6, 10, 11][..]));
        assert_eq!((active.slot(5), active.generation()), (None, 2));
        // A cell that the others leave.
        active.update(placed(&[4, 5]), corners(&grid));
        active.update(placed(&[4, 4]), corners(&grid));
        assert_eq!(active.cells(), [4]);
    }
}
