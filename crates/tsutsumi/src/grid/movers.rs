//! The particles that have changed their cells since the last step: where they are few, the lists by cell are mended, not made anew.

use std::ops::Range;

use super::active::NO_SLOT;
use super::vec_bytes;
use crate::parallel;

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

/// The movers from some neighbouring cells.
#[derive(Debug, Clone, Copy)]
struct Found {
    movers: [Mover; MOST],
    count: usize,
}

/// Room for movers.
///
/// The set of cells may change with them: cells that they enter join before they move, cells that they leave empty part afterwards.
#[derive(Debug, Clone)]
pub(super) struct Movers {
    found: Vec<Found>,
    movers: Vec<Mover>,
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
        let none = Found { movers: [Mover::default(); MOST], count: 0 };
        Movers { found: vec![none; pieces], movers: Vec::with_capacity(pieces * MOST) }
    }

    /// The most that there is room for.
    pub(super) fn most(&self) -> usize {
        self.movers.capacity()
    }

    /// The memory of the room (bytes).
    pub(super) fn bytes(&self) -> usize {
        vec_bytes(&self.found) + vec_bytes(&self.movers)
    }

    /// Finds the movers: particles that stand in the list of another cell than they are in. False if they are too many.
    pub(super) fn find(&mut self, lists: &Lists, cell_of_particle: &[u32]) -> bool {
        let num_slots = lists.cells.len();
        let pieces = num_slots.div_ceil(SLOTS);
        let find = |(found, pieces): (&mut [Found], Range<usize>)| {
            let of_piece = |(found, piece): (&mut Found, usize)| {
                found.look_through(piece * SLOTS..num_slots.min((piece + 1) * SLOTS), lists, cell_of_particle)
            };
            found.iter_mut().zip(pieces).all(of_piece)
        };
        let all_found =
            parallel::fold((&mut self.found[..pieces], 0..pieces), 1, &find, &|before, after| before && after);
        self.movers.clear();
        if all_found {
            self.movers.extend(self.found[..pieces].iter().flat_map(|found| &found.movers[..found.count]));
        }
        all_found
    }

    /// Lists the cells without a slot that movers enter, in ascending order.
    pub(super) fn list_entered(&self, slot_of_cell: &[u32], entered: &mut Vec<u32>) {
        let cells = self.movers.iter().map(|mover| mover.to);
        list_distinct(cells.filter(|&cell| slot_of_cell[cell as usize] == NO_SLOT), entered);
    }

    /// Puts the slots of their cells in the places of the movers' cells.
    pub(super) fn name_slots(&mut self, slot_of_cell: &[u32]) {
        for Mover { from, to, .. } in &mut self.movers {
            (*from, *to) = (slot_of_cell[*from as usize], slot_of_cell[*to as usize]);
        }
    }

    /// Lists the slots that the movers have left empty, in ascending order.
    pub(super) fn list_emptied(&self, first: &[u32], emptied: &mut Vec<u32>) {
        let slots = self.movers.iter().map(|mover| mover.from);
        list_distinct(slots.filter(|&slot| first[slot as usize] == first[slot as usize + 1]), emptied);
    }

    /// Moves the movers to their new slots. Particles stand in the order of `number`.
    pub(super) fn mend(&mut self, lists: &mut Lists, number: impl Fn(u32) -> u32) {
        let Lists { particles, first, .. } = lists;
        self.take_out(particles, first);
        self.movers.sort_unstable_by_key(|mover| (mover.to, number(mover.particle)));
        self.put_in(particles, first, number);
    }

    /// Closes the gaps that the movers leave, which stand in the order of their places. The end of the list is free then.
    fn take_out(&self, particles: &mut [u32], first: &mut [u32]) {
        let (len, end) = (particles.len(), first.len());
        for (number, mover) in self.movers.iter().enumerate() {
            let (next_place, next_from) =
                self.movers.get(number + 1).map_or((len, end - 1), |next| (next.place as usize, next.from as usize));
            let place = mover.place as usize;
            particles.copy_within(place + 1..next_place, place - number);
            first[mover.from as usize + 1..=next_from].iter_mut().for_each(|first| *first -= number as u32 + 1);
        }
    }

    /// Opens gaps for the movers, which stand in the order of their new slots, from the last to the first.
    fn put_in(&self, particles: &mut [u32], first: &mut [u32], number_of: impl Fn(u32) -> u32) {
        let mut end = particles.len() - self.movers.len();
        let mut next_to = first.len() - 1;
        for (number, mover) in self.movers.iter().enumerate().rev() {
            let to = mover.to as usize;
            // What stands beyond `end` has moved already, and belongs behind the mover.
            let of_slot = first[to] as usize..end.min(first[to + 1] as usize);
            let place = of_slot.start + particles[of_slot].partition_point(|&known| number_of(known) < number_of(mover.particle));
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

impl Found {
    /// The movers from a range of slots. False if they are too many.
    fn look_through(&mut self, slots: Range<usize>, lists: &Lists, cell_of_particle: &[u32]) -> bool {
        self.count = 0;
        for slot in slots {
            let places = lists.first[slot]..lists.first[slot + 1];
            for (place, &particle) in places.clone().zip(&lists.particles[places.start as usize..places.end as usize]) {
                let (from, to) = (lists.cells[slot], cell_of_particle[particle as usize]);
                if from == to {
                    continue;
                }
                if self.count == MOST {
                    return false;
                }
                self.movers[self.count] = Mover { particle, place, from, to };
                self.count += 1;
            }
        }
        true
    }
}
