//! The active cells in a numbering in which the neighbours of a row of cells are rows too.

use std::ops::Range;

use super::stencil_matrix::GRAIN;
use crate::parallel::{self, Pieces};

/// The numbers of a cell along the axes; 0 along those that there are not.
pub(super) type Place = [i32; 3];

/// Marks a site without a cell.
pub(super) const NO_CELL: u32 = u32::MAX;

/// Cells next to each other along x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    /// The first cell.
    pub(super) place: Place,
    /// How many there are.
    pub(super) len: usize,
    /// The site of the first cell.
    pub(super) site: usize,
    /// How many cells there are in the runs before.
    pub(super) slot: usize,
}

/// A neighbour on the upper side: the last axis along which it is elsewhere, it is higher.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Offset {
    /// Cells along each axis.
    pub(super) to: Place,
    /// The number of the line of cells along x that it lies in, see [`Lattice::shift`].
    line: usize,
}

impl Offset {
    /// True when a cell and this neighbour have opposite signs in a pattern: the parity of the axes in `pattern`, as bits.
    pub(super) fn flips(&self, pattern: u8) -> bool {
        let parity = |axis: usize| self.to[axis] & i32::from(pattern >> axis & 1);
        (parity(0) ^ parity(1) ^ parity(2)) & 1 == 1
    }

    /// The distance, squared (cells²).
    pub(super) fn square(&self) -> i32 {
        self.to.iter().map(|d| d * d).sum()
    }

    /// The largest distance along an axis (cells).
    pub(super) fn distance(&self) -> i32 {
        self.to.iter().map(|d| d.abs()).max().unwrap_or(0)
    }
}

/// Active cells and a margin of empty ones, as wide as the matrix reaches, numbered by *sites* with x fastest.
///
/// Values stand at the sites, zeros at the empty ones. The neighbours of a run of cells then are runs of sites, at a distance that
/// is the same for the whole run: products with the matrix need no list of neighbours and no branch, and empty parts of the grid
/// cost no more than the margin.
#[derive(Debug, Clone, Default)]
pub(super) struct Lattice {
    offsets: Vec<Offset>,
    num_lines: usize,
    runs: Vec<Run>,
    stretches: Vec<Stretch>,
    /// For every run and line the distances, in sites, to the cells beside it in the line above and in that below.
    shifts: Vec<[isize; 2]>,
    segments: Vec<Segment>,
    num_sites: usize,
}

/// Sites whose neighbours are all as far away as those of one run: that run, and the next ones as long as the lines are equally long, with
/// the margins between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stretch {
    /// The number of the first run.
    run: usize,
    /// The first site and that after the last one.
    site: usize,
    end: usize,
}

/// Sites next to each other along x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Segment {
    z: i32,
    y: i32,
    from: i32,
    to: i32,
    site: usize,
}

impl Lattice {
    /// Numbers the cells at `places`, which ascend by z, then y, then x, for a matrix that couples cells up to `reach` apart.
    pub(super) fn rebuild(&mut self, dimension: usize, reach: i32, places: impl Iterator<Item = Place>) {
        self.list_offsets(dimension, reach);
        self.runs.clear();
        for (slot, place) in places.enumerate() {
            match self.runs.last_mut() {
                Some(run) if run.place[1..] == place[1..] && run.place[0] + run.len as i32 == place[0] => run.len += 1,
                _ => self.runs.push(Run { place, len: 1, site: 0, slot }),
            }
        }
        self.number_sites(dimension, reach);
    }

    fn list_offsets(&mut self, dimension: usize, reach: i32) {
        self.offsets.clear();
        let along = |axis: usize| if axis < dimension { -reach..=reach } else { 0..=0 };
        let mut line = 0;
        for (dz, dy) in along(2).flat_map(|dz| along(1).map(move |dy| (dz, dy))) {
            if (dz, dy) < (0, 0) {
                continue;
            }
            let first = if (dz, dy) == (0, 0) { 1 } else { -reach };
            self.offsets.extend((first..=reach).map(|dx| Offset { to: [dx, dy, dz], line }));
            line += 1;
        }
        self.num_lines = line;
    }

    /// Sites wherever a neighbour of a cell can be.
    fn number_sites(&mut self, dimension: usize, reach: i32) {
        let margin = |axis: usize| if axis < dimension { reach } else { 0 };
        self.segments.clear();
        for run in &self.runs {
            let [x, y, z] = run.place;
            let lines =
                (z - margin(2)..=z + margin(2)).flat_map(|z| (y - margin(1)..=y + margin(1)).map(move |y| (z, y)));
            let (from, to) = (x - reach, x + run.len as i32 + reach);
            self.segments.extend(lines.map(|(z, y)| Segment { z, y, from, to, site: 0 }));
        }
        self.segments.sort_unstable();
        self.segments.dedup_by(|next, kept| {
            let joins = (next.z, next.y) == (kept.z, kept.y) && next.from <= kept.to;
            if joins {
                kept.to = kept.to.max(next.to);
            }
            joins
        });
        self.num_sites = 0;
        for segment in &mut self.segments {
            segment.site = self.num_sites;
            self.num_sites += (segment.to - segment.from) as usize;
        }
        self.shifts.clear();
        for number in 0..self.runs.len() {
            let [x, y, z] = self.runs[number].place;
            let site = self.site([x, y, z]).unwrap_or(0);
            self.runs[number].site = site;
            let mut last = usize::MAX;
            for offset in &self.offsets {
                if offset.line != last {
                    last = offset.line;
                    let [_, dy, dz] = offset.to;
                    let above = self.site([x, y + dy, z + dz]).unwrap_or(0) as isize - site as isize;
                    let below = self.site([x, y - dy, z - dz]).unwrap_or(0) as isize - site as isize;
                    self.shifts.push([above, below]);
                }
            }
        }
        self.join_runs(reach as usize);
    }

    /// Lists the stretches. Two runs are joined where only their own margins lie between them: an entry of the matrix at a site there, or one
    /// from there to a cell, is zero, so that products in passing are zero too.
    fn join_runs(&mut self, reach: usize) {
        self.stretches.clear();
        for (number, run) in self.runs.iter().enumerate() {
            let end = run.site + run.len;
            let shifts = |number: usize| &self.shifts[number * self.num_lines..][..self.num_lines];
            match self.stretches.last_mut() {
                Some(last) if last.end + 2 * reach == run.site && shifts(last.run) == shifts(number) => last.end = end,
                _ => self.stretches.push(Stretch { run: number, site: run.site, end }),
            }
        }
    }

    /// The site at a place, if there is one: at every active cell and wherever one can have a neighbour.
    pub(super) fn site(&self, [x, y, z]: Place) -> Option<usize> {
        let after = self.segments.partition_point(|segment| (segment.z, segment.y, segment.from) <= (z, y, x));
        let segment = self.segments[..after].last()?;
        let inside = (segment.z, segment.y) == (z, y) && x < segment.to;
        inside.then(|| segment.site + (x - segment.from) as usize)
    }

    /// The number of sites.
    pub(super) fn num_sites(&self) -> usize {
        self.num_sites
    }

    /// The number of active cells.
    pub(super) fn num_cells(&self) -> usize {
        self.runs.last().map_or(0, |run| run.slot + run.len)
    }

    /// The runs of active cells, in ascending order.
    pub(super) fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The neighbours on the upper side.
    pub(super) fn offsets(&self) -> &[Offset] {
        &self.offsets
    }

    /// The number of the offset to a place.
    pub(super) fn offset_to(&self, to: Place) -> Option<usize> {
        self.offsets.iter().position(|offset| offset.to == to)
    }

    /// From a cell of a run to its neighbours at `offset` and at the opposite of it (sites).
    pub(super) fn shift(&self, run: usize, offset: &Offset) -> [isize; 2] {
        let [above, below] = self.shifts[run * self.num_lines + offset.line];
        [above + offset.to[0] as isize, below - offset.to[0] as isize]
    }

    /// From a cell of a run to the neighbour at `to`, as far as the matrix reaches (sites).
    pub(super) fn shift_to(&self, run: usize, to: Place) -> isize {
        let [above, below] = [to, to.map(|steps| -steps)].map(|to| self.offset_to(to));
        match (above, below) {
            (Some(number), _) => self.shift(run, &self.offsets[number])[0],
            (_, Some(number)) => self.shift(run, &self.offsets[number])[1],
            (None, None) => 0,
        }
    }

    /// Lists the cell at each site, [`NO_CELL`] where there is none.
    pub(super) fn list_cells(&self, cell_of_site: &mut Vec<u32>) {
        cell_of_site.clear();
        cell_of_site.resize(self.num_sites, NO_CELL);
        for run in &self.runs {
            for number in 0..run.len {
                cell_of_site[run.site + number] = (run.slot + number) as u32;
            }
        }
    }

    /// How many cells there are before that at a site.
    pub(super) fn slot(&self, site: usize) -> usize {
        let run = &self.runs[self.runs.partition_point(|run| run.site <= site).saturating_sub(1)];
        run.slot + (site - run.site).min(run.len - 1)
    }

    /// The site of a cell.
    pub(super) fn site_of(&self, slot: usize) -> usize {
        let run = &self.runs[self.runs.partition_point(|run| run.slot <= slot).saturating_sub(1)];
        run.site + (slot - run.slot).min(run.len - 1)
    }

    /// Values by site from values by cell.
    pub(super) fn spread<T: Copy + Send + Sync>(&self, by_cell: &[T], by_site: &mut [T]) {
        let work = |(piece, sites): (&mut [T], Range<usize>)| {
            self.visit_runs(&sites, |number, from, len| {
                let run = &self.runs[number];
                let values = &by_cell[run.slot + from - run.site..][..len];
                piece[from - sites.start..][..len].copy_from_slice(values);
            });
        };
        parallel::for_each((by_site, 0..self.num_sites), GRAIN, &work);
    }

    /// Values by cell from values by site.
    pub(super) fn gather<T: Copy + Send + Sync>(&self, by_site: &[T], by_cell: &mut [T]) {
        let work = |(mut piece, cells): (&mut [T], Range<usize>)| {
            let first = self.runs.partition_point(|run| run.slot + run.len <= cells.start);
            let mut slot = cells.start;
            for run in &self.runs[first..] {
                if slot == cells.end {
                    break;
                }
                let within = slot - run.slot;
                let len = (run.len - within).min(cells.end - slot);
                let (values, rest) = piece.split_at_mut(len);
                values.copy_from_slice(&by_site[run.site + within..][..len]);
                (piece, slot) = (rest, slot + len);
            }
        };
        parallel::for_each((by_cell, 0..self.num_cells()), GRAIN, &work);
    }

    /// The place of every site.
    pub(super) fn visit_sites(&self, mut visit: impl FnMut(usize, Place)) {
        for segment in &self.segments {
            for (site, x) in (segment.site..).zip(segment.from..segment.to) {
                visit(site, [x, segment.y, segment.z]);
            }
        }
    }

    /// Calls `visit(number of a run, first site, how many)` for stretches of sites that hold all cells among `sites`, and margins between
    /// cells: the neighbours of all sites of a stretch are as far away as those of the run.
    #[inline(always)]
    pub(super) fn visit_stretches(&self, sites: &Range<usize>, mut visit: impl FnMut(usize, usize, usize)) {
        let first = self.stretches.partition_point(|stretch| stretch.end <= sites.start);
        for stretch in &self.stretches[first..] {
            let (from, to) = (stretch.site.max(sites.start), stretch.end.min(sites.end));
            if from >= to {
                break;
            }
            visit(stretch.run, from, to - from);
        }
    }

    /// Calls `visit(number of the run, its first site inside, how many)` for the runs that have cells among the sites.
    #[inline(always)]
    pub(super) fn visit_runs(&self, sites: &Range<usize>, mut visit: impl FnMut(usize, usize, usize)) {
        let first = self.runs.partition_point(|run| run.site + run.len <= sites.start);
        for (number, run) in self.runs.iter().enumerate().skip(first) {
            let (from, to) = (run.site.max(sites.start), (run.site + run.len).min(sites.end));
            if from >= to {
                break;
            }
            visit(number, from, to - from);
        }
    }
}

/// A slice that is cut only at these places: one part between two neighbours of `bounds` each.
pub(super) struct Parts<'a, T> {
    bounds: &'a [usize],
    values: &'a mut [T],
}

impl<'a, T> Parts<'a, T> {
    /// `bounds` ascend from 0 to the length of `values`.
    pub(super) fn new(bounds: &'a [usize], values: &'a mut [T]) -> Self {
        Parts { bounds, values }
    }

    /// The parts, one after the other.
    pub(super) fn each(self) -> impl Iterator<Item = &'a mut [T]> {
        let mut rest = self.values;
        self.bounds.windows(2).map(move |ends| {
            let (part, others) = std::mem::take(&mut rest).split_at_mut(ends[1] - ends[0]);
            rest = others;
            part
        })
    }
}

impl<T: Send> Pieces for Parts<'_, T> {
    fn count(&self) -> usize {
        self.bounds.len().saturating_sub(1)
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let (left, right) = self.values.split_at_mut(self.bounds[at] - self.bounds[0]);
        (Parts::new(&self.bounds[..=at], left), Parts::new(&self.bounds[at..], right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L of three cells and one apart: sites, runs and shifts by hand.
    #[test]
    fn rows_of_cells_have_rows_of_neighbours() {
        let mut lattice = Lattice::default();
        lattice.rebuild(2, 1, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 1, 0]].into_iter());
        // Lines −1 to 2, of the sites −1 to 2 below the apart one, and 8 to 10 around it; the highest has −1 to 1.
        assert_eq!(lattice.num_sites(), 4 + (4 + 3) + (4 + 3) + (3 + 3));
        assert_eq!(lattice.num_cells(), 4);
        let runs: Vec<_> = lattice.runs().iter().map(|run| (run.place, run.len, run.slot)).collect();
        assert_eq!(runs, [([0, 0, 0], 2, 0), ([0, 1, 0], 1, 2), ([9, 1, 0], 1, 3)]);
        for (number, run) in lattice.runs().iter().enumerate() {
            for offset in lattice.offsets() {
                for (shift, sign) in lattice.shift(number, offset).into_iter().zip([1, -1]) {
                    let neighbor = std::array::from_fn(|axis| run.place[axis] + sign * offset.to[axis]);
                    let expected = lattice.site(neighbor).unwrap();
                    assert_eq!(run.site as isize + shift, expected as isize, "{run:?} {offset:?}");
                }
            }
        }
        assert_eq!(lattice.site([5, 0, 0]), None);
    }

    #[test]
    fn half_of_the_neighbours_are_offsets() {
        for (dimension, reach, expected) in [(1, 1, 1), (2, 1, 4), (2, 3, 24), (3, 1, 13), (3, 2, 62)] {
            let mut lattice = Lattice::default();
            lattice.rebuild(dimension, reach, [[0; 3]].into_iter());
            assert_eq!(lattice.offsets().len(), expected);
            assert_eq!(lattice.num_sites(), (2 * reach as usize + 1).pow(dimension as u32));
        }
    }
}
