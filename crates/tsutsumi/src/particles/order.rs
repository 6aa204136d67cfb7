//! The order of the particles in memory: the numbers by which they are known, and how they change places.

use super::Particles;
use crate::large_pages;
use crate::parallel;

/// Marks the last place of a cycle.
const LAST: u32 = 1 << 31;

/// The most particles whose order can be changed: their places leave a bit free.
pub(crate) const MOST: usize = LAST as usize;

/// Particles that change places within ranges of places, which none leaves.
///
/// It is made of cycles of places: the particle of each place comes from the next one, that of the last from the first.
#[derive(Debug, Clone, Default)]
pub struct Moves {
    /// Cycle after cycle, range after range.
    places: Vec<u32>,
    /// The ranges, one after the other: the first place beyond each, and where in `places` its cycles end.
    ends: Vec<(usize, usize)>,
}

/// The moves within some of the ranges, places counted from the beginning of the first.
#[derive(Debug, Clone, Copy)]
pub struct MovesWithin<'a> {
    cycles: &'a [u32],
    first: usize,
}

/// Values that stand at places, one for each particle.
pub trait AtPlaces {
    /// What stands there.
    type Value: Copy;

    /// The value at a place.
    fn at(&mut self, place: usize) -> &mut Self::Value;
}

impl<T: Copy> AtPlaces for [T] {
    type Value = T;

    #[inline(always)]
    fn at(&mut self, place: usize) -> &mut T {
        &mut self[place]
    }
}

impl MovesWithin<'_> {
    /// Brings values to the new places of their particles.
    pub fn carry<V: AtPlaces + ?Sized>(&self, values: &mut V) {
        let place = |entry: u32| (entry & !LAST) as usize - self.first;
        for cycle in self.cycles.split_inclusive(|entry| entry & LAST != 0) {
            let mut to = place(cycle[0]);
            let held = *values.at(to);
            for &entry in &cycle[1..] {
                let from = place(entry);
                *values.at(to) = *values.at(from);
                to = from;
            }
            *values.at(to) = held;
        }
    }
}

impl Moves {
    /// No moves, within ranges of which these are the first places beyond, in ascending order.
    pub(crate) fn within_ranges(range_ends: impl IntoIterator<Item = usize>) -> Self {
        Moves { places: Vec::new(), ends: range_ends.into_iter().map(|end| (end, 0)).collect() }
    }

    /// Finds the moves that bring particles into an order within the ranges: `listed` are all places in that order, ranges mixed.
    ///
    /// `room` is for as many places.
    pub(crate) fn find(&mut self, listed: Vec<u32>, room: &mut [u32]) {
        self.split(&listed, room);
        self.places = listed;
        self.places.clear();
        let mut start = 0;
        for (end, end_of_cycles) in &mut self.ends {
            for first in start..*end {
                push_cycle(first, room, &mut self.places);
            }
            start = *end;
            *end_of_cycles = self.places.len();
        }
    }

    /// Lists places range by range, in each in the order in which they are listed.
    fn split(&mut self, listed: &[u32], to: &mut [u32]) {
        let mut start = 0;
        for (end, next) in &mut self.ends {
            *next = start;
            start = *end;
        }
        for &place in listed {
            let range = self.ends.partition_point(|(end, _)| *end <= place as usize);
            let next = &mut self.ends[range].1;
            to[*next] = place;
            *next += 1;
        }
    }

    /// The moves within places from `start` up to `end`, where ranges begin and end.
    pub(crate) fn within(&self, start: usize, end: usize) -> MovesWithin<'_> {
        let cycles_up_to = |place: usize| {
            let ranges = self.ends.partition_point(|(end, _)| *end <= place);
            ranges.checked_sub(1).map_or(0, |last| self.ends[last].1)
        };
        MovesWithin { cycles: &self.places[cycles_up_to(start)..cycles_up_to(end)], first: start }
    }

    /// All moves.
    pub(crate) fn all(&self) -> MovesWithin<'_> {
        MovesWithin { cycles: &self.places, first: 0 }
    }

    /// Forgets the moves, and gives the array back that was their list.
    pub(crate) fn take_room(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.places)
    }
}

/// Adds the cycle that begins at a place. Every place comes from `source`; those of the cycle come from themselves afterwards.
fn push_cycle(first: usize, source: &mut [u32], places: &mut Vec<u32>) {
    if source[first] as usize == first {
        return;
    }
    let mut place = first;
    loop {
        let from = std::mem::replace(&mut source[place], place as u32);
        let is_last = from as usize == first;
        places.push(place as u32 | if is_last { LAST } else { 0 });
        if is_last {
            return;
        }
        place = from as usize;
    }
}

/// An array of one value per particle, which goes along when particles change places.
pub(crate) trait Follows: Send {
    /// Follows its particles.
    fn follow(&mut self, moves: &Moves);

    /// Moves to large pages of memory.
    fn settle(&mut self);
}

impl<T: Copy + Send> Follows for Vec<T> {
    fn follow(&mut self, moves: &Moves) {
        if !self.is_empty() {
            moves.all().carry(&mut self[..]);
        }
    }

    fn settle(&mut self) {
        large_pages::settle(self);
    }
}

/// Lets arrays follow, each on a thread of its own.
pub(crate) fn follow_all(arrays: &mut [&mut dyn Follows], moves: &Moves) {
    parallel::for_each(arrays, 1, &|arrays: &mut [&mut dyn Follows]| {
        arrays.iter_mut().for_each(|array| array.follow(moves));
    });
}

impl<const D: usize> Particles<D> {
    /// The number of the particle at a place: its place when it was added, by which it is known for good.
    ///
    /// Fields are listed by place. A [`Solver`](crate::solver::Solver) brings the particles of a large body into the order of their cells from
    /// time to time, so that what stands together in space stands together in memory; particles then change their places, not their numbers.
    ///
    /// ```
    /// # use tsutsumi::particles::{Particle, Particles};
    /// # use tsutsumi::tensor::{Sym3, Vector};
    /// # let at = |x: f64| Particle {
    /// #     position: Vector::<1>::repeat(x), half_size: Vector::repeat(0.1), velocity: Vector::zeros(), density: 1.0,
    /// #     stress: Sym3::ZERO, pressure: 0.0, porosity: 0.0, conductivity: 0.0,
    /// # };
    /// let mut particles = Particles::default();
    /// [0.3, 0.1, 0.2].into_iter().for_each(|x| particles.push(at(x)));
    /// // Positions in the order in which the particles were added, whatever their places are now.
    /// let by_number: Vec<f64> = particles.places_by_number().map(|place| particles.position[place][0]).collect();
    /// assert_eq!(by_number, [0.3, 0.1, 0.2]);
    /// assert_eq!(particles.number(particles.place_of(2)), 2);
    /// ```
    pub fn number(&self, place: usize) -> usize {
        self.numbers.get(place).map_or(place, |&number| number as usize)
    }

    /// The numbers of the particles by place; empty as long as all of them stand at the places of their numbers.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// The place of the particle with a number, by a search.
    pub fn place_of(&self, number: usize) -> usize {
        self.numbers.iter().position(|&known| known as usize == number).unwrap_or(number)
    }

    /// The places of all particles, in the order of their numbers. It allocates: for outputs, not for steps.
    pub fn places_by_number(&self) -> impl Iterator<Item = usize> + use<D> {
        (0..self.len()).map(self.finder())
    }

    /// Tells the places of many particles by their numbers. It allocates, where particles have changed their places: for outputs, not for steps.
    pub fn finder(&self) -> impl Fn(usize) -> usize + use<D> {
        let mut places = vec![0; self.numbers.len()];
        list_places(&self.numbers, &mut places);
        move |number| places.get(number).map_or(number, |&place: &u32| place as usize)
    }

    /// Lists the places of the particles by number, in an array of one value per particle.
    pub(crate) fn list_places(&self, places: &mut [u32]) {
        list_places(&self.numbers, places);
    }

    /// Gives every particle its number to carry, if they have none yet.
    pub(crate) fn carry_numbers(&mut self) {
        if self.numbers.is_empty() {
            self.numbers = (0..self.len() as u32).collect();
        }
    }

    /// Moves particles to other places, but for their cells, which are to be found anew.
    pub(crate) fn change_places(&mut self, moves: &Moves) {
        follow_all(&mut self.arrays(), moves);
    }

    /// Moves all arrays to large pages of memory.
    pub(crate) fn settle(&mut self) {
        self.cell.settle();
        self.arrays().into_iter().for_each(Follows::settle);
    }

    /// All arrays but that of the cells, the largest first.
    fn arrays(&mut self) -> [&mut dyn Follows; 13] {
        let Particles {
            numbers,
            position,
            velocity,
            mass,
            volume,
            half_size,
            half_size_at_start,
            stress,
            pressure,
            porosity,
            conductivity,
            drained,
            cell: _,
            local_motion,
        } = self;
        [
            stress,
            local_motion,
            position,
            velocity,
            half_size,
            half_size_at_start,
            mass,
            volume,
            pressure,
            porosity,
            conductivity,
            numbers,
            drained,
        ]
    }
}

fn list_places(numbers: &[u32], places: &mut [u32]) {
    for (place, &number) in numbers.iter().enumerate() {
        places[number as usize] = place as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two ranges, {0 … 3} and {4 … 6}, listed together.
    #[test]
    fn values_come_into_the_order_listed_within_their_ranges() {
        let listed = vec![6, 2, 0, 3, 5, 1, 4];
        let mut moves = Moves::within_ranges([4, 7]);
        moves.find(listed, &mut [0; 7]);
        let mut values = ['a', 'b', 'c', 'd', 'e', 'f', 'g'];
        moves.all().carry(&mut values[..]);
        assert_eq!(values, ['c', 'a', 'd', 'b', 'g', 'f', 'e']);
        let mut second = ['e', 'f', 'g'];
        moves.within(4, 7).carry(&mut second[..]);
        assert_eq!(second, ['g', 'f', 'e']);
        let mut first = ['a', 'b', 'c', 'd'];
        moves.within(0, 4).carry(&mut first[..]);
        assert_eq!(first, ['c', 'a', 'd', 'b']);
        assert_eq!(moves.take_room().capacity(), 7);
    }

    #[test]
    fn an_order_that_is_there_moves_nothing() {
        let mut moves = Moves::within_ranges([5]);
        moves.find((0..5).collect(), &mut [0; 5]);
        assert!(moves.all().cycles.is_empty());
    }
}
