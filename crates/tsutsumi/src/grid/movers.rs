//! The particles that have changed their cells since the last step: where they are few, the lists by cell are mended, not made anew.

use std::ops::Range;

use super::active::NO_SLOT;
use super::vec_bytes;
use crate::parallel::{self, Rows};

/// Active cells that one thread looks through at a time.
const SLOTS: usize = 512;
/// The most movers from so many cells. Where more move, making the lists anew costs no more.
const MOST: usize = 64;

/// A particle that has changed its cell.
#[derive(Debug, Clone, Copy, Default)]
struct Mover {
    particle: u32,
    /// Its place in the list before.
    place: u32,
    /// Its cells; from [`Movers::name_slots`] on their slots.
    from: u32,
    to: u32,
}

/// Room for movers.
///
/// The set of cells may change with them: cells that they enter join before they move, cells that they leave empty part afterwards.
#[derive(Debug, Clone)]
pub(super) struct Movers {
    /// Those of every piece in a row of [`MOST`]; once all are found, one after the other.
    movers: Vec<Mover>,
    /// How many each piece has.
    counts: Vec<u32>,
    /// How many there are.
    count: usize,
}

/// Particles by slot, the place of a cell among the active ones: those of slot s stand from `first[s]` up to `first[s + 1]`, in ascending
/// order of their numbers.
pub(super) struct Lists<'a> {
    pub(super) cells: &'a [u32],
    pub(super) particles: &'a mut [u32],
    pub(super) first: &'a mut [u32],
}

impl Movers {
    /// Room for those of a grid with so many cells.
    pub(super) fn new(num_cells: usize) -> Self {
        let pieces = num_cells.div_ceil(SLOTS);
        Movers { movers: vec![Mover::default(); pieces * MOST], counts: vec![0; pieces], count: 0 }
    }

    /// The most that there is room for.
    pub(super) fn most(&self) -> usize {
        self.movers.len()
    }

    /// The memory of the room (bytes).
    pub(super) fn bytes(&self) -> usize {
        vec_bytes(&self.movers) + vec_bytes(&self.counts)
    }

    /// Finds the movers: particles that stand in the list of another cell than they are in. False if they are too many.
    pub(super) fn find(&mut self, lists: &Lists, cell_of_particle: &[u32]) -> bool {
        let num_slots = lists.cells.len();
        let pieces = num_slots.div_ceil(SLOTS);
        let find = |(rows, counts, pieces): (Rows<Mover>, &mut [u32], Range<usize>)| {
            let of_piece = |((row, count), piece): ((&mut [Mover], &mut u32), usize)| {
                let slots = piece * SLOTS..num_slots.min((piece + 1) * SLOTS);
                look_through(slots, lists, cell_of_particle, row).map(|found| *count = found).is_some()
            };
            rows.iter_mut().zip(counts).zip(pieces).all(of_piece)
        };
        let rows = Rows::new(&mut self.movers[..pieces * MOST], MOST);
        let all_found =
            parallel::fold((rows, &mut self.counts[..pieces], 0..pieces), 1, &find, &|before, after| before && after);
        if all_found {
            self.close_up(pieces);
        }
        all_found
    }

    /// Brings the movers of the pieces together.
    fn close_up(&mut self, pieces: usize) {
        self.count = 0;
        for (piece, &count) in self.counts[..pieces].iter().enumerate() {
            let first = piece * MOST;
            self.movers.copy_within(first..first + count as usize, self.count);
            self.count += count as usize;
        }
    }

    fn found(&self) -> &[Mover] {
        &self.movers[..self.count]
    }

    /// Lists the cells without a slot that movers enter, in ascending order.
    pub(super) fn list_entered(&self, slot_of_cell: &[u32], entered: &mut Vec<u32>) {
        let cells = self.found().iter().map(|mover| mover.to);
        list_distinct(cells.filter(|&cell| slot_of_cell[cell as usize] == NO_SLOT), entered);
    }

    /// Puts the slots of their cells in the places of the movers' cells.
    pub(super) fn name_slots(&mut self, slot_of_cell: &[u32]) {
        for Mover { from, to, .. } in &mut self.movers[..self.count] {
            (*from, *to) = (slot_of_cell[*from as usize], slot_of_cell[*to as usize]);
        }
    }

    /// Lists the slots that the movers have left empty, in ascending order.
    pub(super) fn list_emptied(&self, first: &[u32], emptied: &mut Vec<u32>) {
        let slots = self.found().iter().map(|mover| mover.from);
        list_distinct(slots.filter(|&slot| first[slot as usize] == first[slot as usize + 1]), emptied);
    }

    /// Moves the movers to their new slots. Particles stand in the order of `number`.
    pub(super) fn mend(&mut self, lists: &mut Lists, number: impl Fn(u32) -> u32) {
        let Lists { particles, first, .. } = lists;
        self.take_out(particles, first);
        self.movers[..self.count].sort_unstable_by_key(|mover| (mover.to, number(mover.particle)));
        self.put_in(particles, first, number);
    }

    /// Closes the gaps that the movers leave, which stand in the order of their places. The end of the list is free then.
    fn take_out(&self, particles: &mut [u32], first: &mut [u32]) {
        let (len, end) = (particles.len(), first.len());
        for (number, mover) in self.found().iter().enumerate() {
            let (next_place, next_from) =
                self.found().get(number + 1).map_or((len, end - 1), |next| (next.place as usize, next.from as usize));
            let place = mover.place as usize;
            particles.copy_within(place + 1..next_place, place - number);
            first[mover.from as usize + 1..=next_from].iter_mut().for_each(|first| *first -= number as u32 + 1);
        }
    }

    /// Opens gaps for the movers, which stand in the order of their new slots, from the last to the first.
    fn put_in(&self, particles: &mut [u32], first: &mut [u32], number_of: impl Fn(u32) -> u32) {
        let mut end = particles.len() - self.count;
        let mut next_to = first.len() - 1;
        for (number, mover) in self.found().iter().enumerate().rev() {
            let to = mover.to as usize;
            // What stands beyond `end` has moved already, and belongs behind the mover.
            let of_slot = first[to] as usize..end.min(first[to + 1] as usize);
            let place = of_slot.start
                + particles[of_slot].partition_point(|&known| number_of(known) < number_of(mover.particle));
            particles.copy_within(place..end, place + number + 1);
            particles[place + number] = mover.particle;
            end = place;
            first[to + 1..=next_to].iter_mut().for_each(|first| *first += number as u32 + 1);
            next_to = to;
        }
    }
}

/// Lists numbers once each, in ascending order.
fn list_distinct(numbers: impl Iterator<Item = u32>, list: &mut Vec<u32>) {
    list.clear();
    list.extend(numbers);
    list.sort_unstable();
    list.dedup();
}

/// Finds the movers from a range of slots, and their number; none if there is no room for them.
fn look_through(slots: Range<usize>, lists: &Lists, cell_of_particle: &[u32], movers: &mut [Mover]) -> Option<u32> {
    let mut count = 0;
    for slot in slots {
        let places = lists.first[slot]..lists.first[slot + 1];
        for (place, &particle) in places.clone().zip(&lists.particles[places.start as usize..places.end as usize]) {
            let (from, to) = (lists.cells[slot], cell_of_particle[particle as usize]);
            if from != to {
                *movers.get_mut(count)? = Mover { particle, place, from, to };
                count += 1;
            }
        }
    }
    Some(count as u32)
}
