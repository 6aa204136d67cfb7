//! The stresses of the particles, as they lie in memory.

use std::iter::Zip;
use std::ops::Range;
use std::slice::Iter;
use std::sync::atomic::{AtomicBool, Ordering};

use super::order::{Follows, Moves};
use crate::grid::vec_bytes;
use crate::parallel::{Pieces, fetch};
use crate::tensor::Sym3;

/// The stresses of many particles (Pa).
///
/// Components xx, yy, zz and xy lie together, yz and zx in a list of their own: in plane strain they are zero, and a step has no need to read them.
#[derive(Debug, Default)]
pub struct Stresses {
    in_plane: Vec<[f64; 4]>,
    out_of_plane: Vec<[f64; 2]>,
    /// False only if yz and zx are zero everywhere. Pieces of the list share it; it decides what is read, never what is found.
    leave_plane: AtomicBool,
}

impl Stresses {
    /// The number of particles.
    pub fn len(&self) -> usize {
        self.in_plane.len()
    }

    /// True when there is no particle.
    pub fn is_empty(&self) -> bool {
        self.in_plane.is_empty()
    }

    /// The stress of the particle at a place.
    #[inline(always)]
    pub fn at(&self, place: usize) -> Sym3 {
        joined(self.in_plane[place], self.out_of_plane[place])
    }

    /// Gives the particle at a place another stress.
    pub fn set(&mut self, place: usize, stress: Sym3) {
        self.all_mut().set(place, stress);
    }

    /// Adds a particle.
    pub fn push(&mut self, stress: Sym3) {
        self.in_plane.push([0.0; 4]);
        self.out_of_plane.push([0.0; 2]);
        self.set(self.len() - 1, stress);
    }

    /// The stresses of all particles.
    pub fn iter(&self) -> StressIter<'_> {
        StressIter(self.in_plane.iter().zip(&self.out_of_plane))
    }

    /// The stresses of the particles at these places.
    pub fn within(&self, places: Range<usize>) -> impl Iterator<Item = Sym3> + '_ {
        places.map(|place| self.at(place))
    }

    /// Asks the memory for some stresses.
    #[inline(always)]
    pub(crate) fn fetch(&self, range: Range<usize>) {
        let Stresses { in_plane, out_of_plane, leave_plane } = self;
        fetch_both(in_plane, out_of_plane, leave_plane, range);
    }

    /// Components xx, yy, zz and xy of all particles.
    pub(crate) fn in_plane(&self) -> &[[f64; 4]] {
        &self.in_plane
    }

    /// Components yz and zx of all particles.
    pub(crate) fn out_of_plane(&self) -> &[[f64; 2]] {
        &self.out_of_plane
    }

    /// All stresses, to be changed.
    pub(crate) fn all_mut(&mut self) -> StressesMut<'_> {
        let Stresses { in_plane, out_of_plane, leave_plane } = self;
        StressesMut { in_plane, out_of_plane, leave_plane }
    }

    pub(super) fn reserve_exact(&mut self, additional: usize) {
        self.in_plane.reserve_exact(additional);
        self.out_of_plane.reserve_exact(additional);
    }

    /// The memory of the list (bytes).
    pub(crate) fn bytes(&self) -> usize {
        vec_bytes(&self.in_plane) + vec_bytes(&self.out_of_plane)
    }
}

impl<'a> IntoIterator for &'a Stresses {
    type Item = Sym3;
    type IntoIter = StressIter<'a>;

    fn into_iter(self) -> StressIter<'a> {
        self.iter()
    }
}

impl Clone for Stresses {
    fn clone(&self) -> Self {
        let Stresses { in_plane, out_of_plane, leave_plane } = self;
        let leave_plane = AtomicBool::new(leave_plane.load(Ordering::Relaxed));
        Stresses { in_plane: in_plane.clone(), out_of_plane: out_of_plane.clone(), leave_plane }
    }
}

impl PartialEq for Stresses {
    fn eq(&self, other: &Self) -> bool {
        (&self.in_plane, &self.out_of_plane) == (&other.in_plane, &other.out_of_plane)
    }
}

impl FromIterator<Sym3> for Stresses {
    fn from_iter<I: IntoIterator<Item = Sym3>>(stresses: I) -> Self {
        let mut list = Stresses::default();
        stresses.into_iter().for_each(|stress| list.push(stress));
        list
    }
}

impl Follows for Stresses {
    fn follow(&mut self, moves: &Moves) {
        self.in_plane.follow(moves);
        if *self.leave_plane.get_mut() {
            self.out_of_plane.follow(moves);
        }
    }

    fn settle(&mut self) {
        self.in_plane.settle();
        self.out_of_plane.settle();
    }
}

/// The stresses (Pa) of all particles, one after the other.
#[derive(Debug, Clone)]
pub struct StressIter<'a>(Zip<Iter<'a, [f64; 4]>, Iter<'a, [f64; 2]>>);

impl Iterator for StressIter<'_> {
    type Item = Sym3;

    fn next(&mut self) -> Option<Sym3> {
        self.0.next().map(|(&in_plane, &out_of_plane)| joined(in_plane, out_of_plane))
    }
}

/// The stresses (Pa) of particles that follow each other, to be changed.
pub struct StressesMut<'a> {
    in_plane: &'a mut [[f64; 4]],
    out_of_plane: &'a mut [[f64; 2]],
    leave_plane: &'a AtomicBool,
}

impl<'a> StressesMut<'a> {
    /// The number of particles.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.in_plane.len()
    }

    /// True when there is no particle.
    pub fn is_empty(&self) -> bool {
        self.in_plane.is_empty()
    }

    /// The stress of particle number `p` of these.
    #[inline(always)]
    pub fn at(&self, p: usize) -> Sym3 {
        joined(self.in_plane[p], self.out_of_plane[p])
    }

    /// Gives it another stress.
    #[inline(always)]
    pub fn set(&mut self, p: usize, stress: Sym3) {
        let Sym3 { xx, yy, zz, xy, yz, zx } = stress;
        (self.in_plane[p], self.out_of_plane[p]) = ([xx, yy, zz, xy], [yz, zx]);
        if yz.to_bits() | zx.to_bits() != 0 {
            self.note_leaving();
        }
    }

    /// The same stresses, for a shorter time.
    pub fn reborrow(&mut self) -> StressesMut<'_> {
        let StressesMut { in_plane, out_of_plane, leave_plane } = self;
        StressesMut { in_plane, out_of_plane, leave_plane }
    }

    /// True when no stress has a component out of the plane.
    #[inline(always)]
    pub(crate) fn are_in_plane(&self) -> bool {
        !self.leave_plane.load(Ordering::Relaxed)
            || self.out_of_plane.iter().fold(0, |bits, [yz, zx]| bits | yz.to_bits() | zx.to_bits()) == 0
    }

    /// Asks the memory for some of these stresses.
    #[inline(always)]
    pub(crate) fn fetch(&self, range: Range<usize>) {
        let StressesMut { in_plane, out_of_plane, leave_plane } = self;
        fetch_both(in_plane, out_of_plane, leave_plane, range);
    }

    /// Components xx, yy, zz and xy, and yz and zx.
    #[inline(always)]
    pub(crate) fn both(&self) -> (&[[f64; 4]], &[[f64; 2]]) {
        (self.in_plane, self.out_of_plane)
    }

    /// Components xx, yy, zz and xy.
    #[inline(always)]
    pub(crate) fn in_plane(&mut self) -> &mut [[f64; 4]] {
        self.in_plane
    }

    /// Components yz and zx, of which some may be other than zero from now on.
    #[inline(always)]
    pub(crate) fn out_of_plane(&mut self) -> &mut [[f64; 2]] {
        self.note_leaving();
        self.out_of_plane
    }

    /// Notes that some stress may leave the plane.
    #[inline(always)]
    fn note_leaving(&self) {
        // All threads would wait for each other's writes.
        if !self.leave_plane.load(Ordering::Relaxed) {
            self.leave_plane.store(true, Ordering::Relaxed);
        }
    }

    /// Those of a range.
    pub(crate) fn part(self, range: Range<usize>) -> StressesMut<'a> {
        let StressesMut { in_plane, out_of_plane, leave_plane } = self;
        let (in_plane, out_of_plane) = (&mut in_plane[range.clone()], &mut out_of_plane[range]);
        StressesMut { in_plane, out_of_plane, leave_plane }
    }
}

impl Pieces for StressesMut<'_> {
    fn count(&self) -> usize {
        self.len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let StressesMut { in_plane, out_of_plane, leave_plane } = self;
        let (in_plane, out_of_plane) = (in_plane.split_at_mut(at), out_of_plane.split_at_mut(at));
        let piece = |in_plane, out_of_plane| StressesMut { in_plane, out_of_plane, leave_plane };
        (piece(in_plane.0, out_of_plane.0), piece(in_plane.1, out_of_plane.1))
    }
}

#[inline(always)]
fn fetch_both(in_plane: &[[f64; 4]], out_of_plane: &[[f64; 2]], leave_plane: &AtomicBool, range: Range<usize>) {
    fetch(in_plane, range.clone());
    if leave_plane.load(Ordering::Relaxed) {
        fetch(out_of_plane, range);
    }
}

#[inline(always)]
fn joined([xx, yy, zz, xy]: [f64; 4], [yz, zx]: [f64; 2]) -> Sym3 {
    Sym3 { xx, yy, zz, xy, yz, zx }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first stress lies in the plane, the second does not.
    fn two() -> [Sym3; 2] {
        [
            Sym3 { xx: 1.0, yy: 2.0, zz: 3.0, xy: 4.0, ..Sym3::ZERO },
            Sym3 { xx: 5.0, yy: 6.0, zz: 7.0, xy: 8.0, yz: 9.0, zx: 10.0 },
        ]
    }

    #[test]
    fn components_out_of_the_plane_are_kept_and_change_places_too() {
        let mut stresses: Stresses = two().into_iter().collect();
        assert_eq!(stresses.iter().collect::<Vec<_>>(), two());
        let mut moves = Moves::within_ranges([2]);
        moves.find(vec![1, 0], &mut [0; 2]);
        stresses.follow(&moves);
        assert_eq!([stresses.at(1), stresses.at(0)], two());
        assert_eq!(stresses.clone(), stresses);
    }

    #[test]
    fn whoever_leaves_the_plane_is_noticed() {
        let mut stresses: Stresses = [two()[0]; 2].into_iter().collect();
        let (mut first, mut second) = stresses.all_mut().cut(1);
        assert!(first.are_in_plane() && second.are_in_plane());
        second.set(0, two()[1]);
        assert!(first.are_in_plane() && !second.are_in_plane());
        first.out_of_plane()[0] = [0.0, -1.0];
        assert!(!first.are_in_plane());
        assert_eq!(stresses.at(0).zx, -1.0);
    }
}
