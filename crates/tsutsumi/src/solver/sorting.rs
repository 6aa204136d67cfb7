use super::{Parts, Solver, StepError};
use crate::law::MaterialGroup;
use crate::parallel;
use crate::particles::{MOST, Moves, Particles, follow_all};

/// Bodies of fewer particles are not sorted: the caches hold them in any order. An order by chance costs 5 % with 5,000 particles, a quarter with
/// 50,000, and twice to three times the time from 100,000 on.
const LEAST: usize = 50_000;

/// Particles are sorted when one in so many has changed its cell since the last look at their order, and as many more than after the last sort
/// stand far from the one before them in the lists by cell: a body that moves as one along x stays in order, and along other axes it is sorted
/// once or twice for every cell that it moves.
///
/// A sort takes as long as one step, or three where the order is one by chance. In a fast flow, where 1 % of the particles change their cells in a
/// step, there are some dozen steps between two of them.
const PART: usize = 8;

/// When the particles are brought into the order of their cells. Holds the work arrays.
pub(super) struct Sorting {
    /// Within ranges of places that no particle leaves: those of the groups, and of bodies in a fluid.
    moves: Moves,
    /// How many particles have changed their cells since the order was looked at.
    moved: usize,
    /// The jumps in memory along the lists by cell that the last sort has left: cells that ranges share have some.
    jumps_left: usize,
    /// Whether they shall be sorted in the next step in any case.
    is_asked_for: bool,
}

impl Sorting {
    pub(super) fn new<const D: usize>(parts: &Parts<D>) -> Self {
        let of_groups = parts.groups.iter().map(|group| group.particles());
        let of_fluids = parts.boundary.fluid_loads().iter().map(|load| load.particles.clone());
        let mut ends: Vec<usize> = of_groups.chain(of_fluids).flat_map(|range| [range.start, range.end]).collect();
        ends.push(parts.particles.len());
        ends.sort_unstable();
        ends.dedup();
        ends.retain(|&end| end > 0);
        Sorting { moves: Moves::within_ranges(ends), moved: 0, jumps_left: 0, is_asked_for: false }
    }

    /// Takes note of particles that have changed their cells.
    pub(super) fn note(&mut self, moved: usize) {
        self.moved += moved;
    }
}

/// The memory that sorting particles for the first time will set aside (bytes).
pub(super) fn bytes_to_come<const D: usize>(particles: &Particles<D>) -> usize {
    let is_to_come = particles.len() >= LEAST && particles.numbers().is_empty();
    if is_to_come { particles.len() * size_of::<u32>() } else { 0 }
}

impl<const D: usize> Solver<D> {
    /// Brings the particles into the order of their cells at the start of the next step, those of a cell into that of their numbers, each
    /// group by itself.
    ///
    /// A solver does so by itself where many particles of a large body are out of order: in an order by chance a step takes several times as
    /// long. Particles change their places in memory then, not their numbers ([`Particles::number`]). Sums at nodes and cells run in the
    /// order of numbers in any case, so that nodes, cells and particles carry on with the same bits; sums over all particles, such as
    /// energies, may differ in the last ones.
    ///
    /// [`Particles::number`]: crate::particles::Particles::number
    pub fn sort_in_next_step(&mut self) {
        self.sorting.is_asked_for = true;
    }

    /// Takes note of particles that have changed their cells, and sorts the particles where many are out of order.
    pub(super) fn keep_order(&mut self, moved: usize) -> Result<(), StepError> {
        self.sorting.note(moved);
        if std::mem::take(&mut self.sorting.is_asked_for) || self.is_out_of_order() {
            self.sort()?;
        }
        Ok(())
    }

    /// Looks at the order where enough particles have moved to disturb it.
    fn is_out_of_order(&mut self) -> bool {
        let count = self.parts.particles.len();
        if count < LEAST || self.sorting.moved < count / PART {
            return false;
        }
        self.sorting.moved = 0;
        self.active.count_jumps() > self.sorting.jumps_left + count / PART
    }

    /// Sorts particles whose cells and lists are up to date.
    fn sort(&mut self) -> Result<(), StepError> {
        let Solver { parts, active, motion, sorting, .. } = self;
        let Parts { particles, groups, boundary, .. } = parts;
        if particles.len() > MOST {
            return Ok(());
        }
        particles.carry_numbers();
        // Two arrays of one number per particle are there: the list by cell becomes that of the moves, the cells are found again afterwards.
        let mut room = std::mem::take(&mut particles.cell);
        sorting.moves.find(active.lend_particles(), &mut room);
        let moves = &sorting.moves;
        particles.change_places(moves);
        follow_all(&mut [motion.of_particles()], moves);
        parallel::for_each(&mut groups[..], 1, &|groups: &mut [Box<dyn MaterialGroup>]| {
            for group in groups {
                let of_group = group.particles();
                group.carry(moves.within(of_group.start, of_group.end));
            }
        });
        particles.list_places(&mut room);
        boundary.follow(&room);
        particles.cell = room;
        let list = sorting.moves.take_room();
        self.find_cells()?;
        self.active.list_again(self.parts.particles.located(), list);
        self.sorting.jumps_left = self.active.count_jumps();
        Ok(())
    }
}
