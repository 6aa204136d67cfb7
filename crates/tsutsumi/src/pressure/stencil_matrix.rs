//! A symmetric matrix between cells that are near each other, on a [`Lattice`].

use std::ops::Range;

use nalgebra::RealField;

use super::lattice::Lattice;
use crate::parallel::vectorized;

/// Sites in a piece of a loop: the work on one piece fills some microseconds, its values fit the nearest caches.
pub(super) const GRAIN: usize = 4096;

/// Sites worked on at a time, so that sums stay in the nearest cache.
pub(super) const STRIP: usize = 512;

/// The diagonal and, for every offset, the entry between each site and its neighbour there; the other half follows by symmetry.
///
/// One array per offset: a product runs through all of them side by side, without an index. An empty diagonal is one of ones.
#[derive(Debug, Clone, Default)]
pub(super) struct StencilMatrix<T> {
    diagonal: Vec<T>,
    upper: Vec<Vec<T>>,
}

impl<T: RealField + Copy> StencilMatrix<T> {
    /// Zeros on all sites of a lattice. Reuses memory.
    pub(super) fn resize(&mut self, lattice: &Lattice) {
        self.upper.resize_with(lattice.offsets().len(), Vec::new);
        for entries in self.upper.iter_mut().chain([&mut self.diagonal]) {
            entries.clear();
            entries.resize(lattice.num_sites(), T::zero());
        }
    }

    /// Drops the diagonal: it is one of ones then.
    pub(super) fn forget_diagonal(&mut self) {
        self.diagonal.clear();
    }

    /// The diagonal, by site.
    pub(super) fn diagonal(&self) -> &[T] {
        &self.diagonal
    }

    /// The entries at the offset with this number, by site.
    pub(super) fn upper(&self, offset: usize) -> &[T] {
        &self.upper[offset]
    }

    /// The diagonal and the entries at all offsets, to be filled. Where there is no cell they stay zero.
    pub(super) fn entries_mut(&mut self) -> (&mut [T], &mut [Vec<T>]) {
        (&mut self.diagonal, &mut self.upper)
    }

    /// The rows `sites` of A x, into `product` (of that length), for `x` that is zero at sites without a cell. Those between cells get a zero, the
    /// others are left as they are.
    pub(super) fn multiply(&self, lattice: &Lattice, sites: Range<usize>, x: &[T], product: &mut [T]) {
        self.visit_strips(lattice, &sites, |run, from, len| {
            let product = &mut product[from - sites.start..][..len];
            let strip = Strip { matrix: self, lattice, run, from, x, product };
            vectorized(
                #[inline(always)]
                || strip.multiply(),
            );
        });
    }

    /// The sums of the rows of some cells of a run, with the signs of a pattern, into `sums`; returns the largest sum of magnitudes over the
    /// diagonal: no eigenvalue of D⁻¹ A is larger (Gershgorin).
    #[inline(always)]
    pub(super) fn sum_rows(
        &self,
        lattice: &Lattice,
        run: usize,
        sites: Range<usize>,
        pattern: u8,
        sums: &mut [T],
    ) -> T {
        let mut bound = T::zero();
        let mut from = 0;
        while from + LANES <= sites.len() {
            let rows = self.sum_some_rows::<LANES>(lattice, run, sites.start + from, pattern, &mut sums[from..]);
            bound = bound.max(rows);
            from += LANES;
        }
        for from in from..sites.len() {
            bound = bound.max(self.sum_some_rows::<1>(lattice, run, sites.start + from, pattern, &mut sums[from..]));
        }
        bound
    }

    #[inline(always)]
    fn sum_some_rows<const L: usize>(
        &self,
        lattice: &Lattice,
        run: usize,
        site: usize,
        pattern: u8,
        row_sums: &mut [T],
    ) -> T {
        let diagonal: [T; L] = std::array::from_fn(|lane| self.diagonal[site..][..L][lane]);
        let (mut sums, mut magnitudes) = (diagonal, diagonal);
        for (offset, entries) in lattice.offsets().iter().zip(&self.upper) {
            let sign = if offset.flips(pattern) { -T::one() } else { T::one() };
            let [_, below] = lattice.shift(run, offset);
            let (upper, lower) = (&entries[site..][..L], &entries[site.wrapping_add_signed(below)..][..L]);
            for lane in 0..L {
                sums[lane] += sign * (upper[lane] + lower[lane]);
                magnitudes[lane] += upper[lane].abs() + lower[lane].abs();
            }
        }
        row_sums[..L].copy_from_slice(&sums);
        magnitudes.iter().zip(&diagonal).fold(T::zero(), |bound, (&sum, &d)| bound.max(sum / d))
    }

    /// Calls `visit(run, first site, number of sites)` for strips of active cells.
    #[inline(always)]
    fn visit_strips(&self, lattice: &Lattice, sites: &Range<usize>, mut visit: impl FnMut(usize, usize, usize)) {
        lattice.visit_stretches(sites, |run, from, len| {
            for start in (from..from + len).step_by(STRIP) {
                visit(run, start, STRIP.min(from + len - start));
            }
        });
    }
}

/// A product on sites side by side, to be compiled for wide registers too. The bits are the same whatever their width: nothing is
/// contracted or summed in another order.
struct Strip<'a, T> {
    matrix: &'a StencilMatrix<T>,
    lattice: &'a Lattice,
    run: usize,
    from: usize,
    x: &'a [T],
    product: &'a mut [T],
}

/// Sites whose sums stay in registers from the first entry to the last, and at the end of a strip.
const LANES: usize = 16;
const FEW_LANES: usize = 4;

impl<T: RealField + Copy> Strip<'_, T> {
    #[inline(always)]
    fn multiply(self) {
        let Strip { matrix, lattice, run, from, x, product } = self;
        let len = product.len();
        let own = &x[from..][..len];
        let couple = |number: usize| {
            let shift = lattice.shift(run, &lattice.offsets()[number]);
            Couple::new(shift, &matrix.upper[number], x, from, len)
        };
        // Four offsets at a time (all in 2-D with linear functions): fewer loads and stores of sums.
        let fours = matrix.upper.len() / 4 * 4;
        let four = |number: usize| [couple(number), couple(number + 1), couple(number + 2), couple(number + 3)];
        match (matrix.diagonal.is_empty(), fours) {
            (true, 4..) => add_couples::<T, 4, true>(four(0), own, product),
            (true, _) => product.copy_from_slice(own),
            (false, _) => {
                let diagonal = matrix.diagonal[from..][..len].iter();
                product.iter_mut().zip(diagonal).zip(own).for_each(|((product, &d), &x)| *product = d * x);
                if fours > 0 {
                    add_couples::<T, 4, false>(four(0), own, product);
                }
            }
        }
        for number in (4..fours).step_by(4) {
            add_couples::<T, 4, false>(four(number), own, product);
        }
        for number in fours..matrix.upper.len() {
            add_couples::<T, 1, false>([couple(number)], own, product);
        }
    }
}

/// Adds the products of a few offsets to `product`, or sets it to their sum with `own` if they are the `FIRST`, for some sites at a time.
#[inline(always)]
fn add_couples<T: RealField + Copy, const N: usize, const FIRST: bool>(
    couples: [Couple<T>; N],
    own: &[T],
    product: &mut [T],
) {
    let wide = product.len() / LANES * LANES;
    let (first, rest) = product.split_at_mut(wide);
    add_parts::<T, N, LANES, FIRST>(&couples, own, first);
    let few = rest.len() / FEW_LANES * FEW_LANES;
    let (second, last) = rest.split_at_mut(few);
    add_parts::<T, N, FEW_LANES, FIRST>(&couples.each_ref().map(|couple| couple.from(wide)), &own[wide..], second);
    let couples = couples.each_ref().map(|couple| couple.from(wide + few));
    add_parts::<T, N, 1, FIRST>(&couples, &own[wide + few..], last);
}

/// The same, `L` sites at a time, for a multiple of as many sites.
#[inline(always)]
fn add_parts<T: RealField + Copy, const N: usize, const L: usize, const FIRST: bool>(
    couples: &[Couple<T>; N],
    own: &[T],
    product: &mut [T],
) {
    let (product, _) = product.as_chunks_mut::<L>();
    // All of one length, known to the compiler: nothing is checked in the loop.
    let len = product.len();
    let part = |values| <[T]>::as_chunks::<L>(values).0.split_at(len).0;
    let own = part(own);
    let couples = couples
        .each_ref()
        .map(|Couple { upper, x_upper, lower, x_lower }| ([part(upper), part(lower)], [part(x_upper), part(x_lower)]));
    for i in 0..len {
        let mut sums = if FIRST { own[i] } else { product[i] };
        for ([upper, lower], [x_upper, x_lower]) in &couples {
            for lane in 0..L {
                sums[lane] += upper[i][lane] * x_upper[i][lane] + lower[i][lane] * x_lower[i][lane];
            }
        }
        product[i] = sums;
    }
}

/// The entries of one offset and of its opposite, with the values that they multiply.
struct Couple<'a, T> {
    upper: &'a [T],
    x_upper: &'a [T],
    lower: &'a [T],
    x_lower: &'a [T],
}

impl<'a, T: RealField + Copy> Couple<'a, T> {
    #[inline(always)]
    fn new([above, below]: [isize; 2], entries: &'a [T], x: &'a [T], from: usize, len: usize) -> Self {
        let (above, below) = (from.wrapping_add_signed(above), from.wrapping_add_signed(below));
        Couple {
            upper: &entries[from..][..len],
            x_upper: &x[above..][..len],
            // The entry with a neighbour below stands at the neighbour.
            lower: &entries[below..][..len],
            x_lower: &x[below..][..len],
        }
    }

    #[inline(always)]
    fn from(&self, from: usize) -> Self {
        let Couple { upper, x_upper, lower, x_lower } = self;
        Couple { upper: &upper[from..], x_upper: &x_upper[from..], lower: &lower[from..], x_lower: &x_lower[from..] }
    }
}

/// Matrix entries of a few sites, to be filled on several threads: column `N − 1` is the diagonal.
pub(super) struct Columns<'a, const N: usize>(pub(super) [&'a mut [f64]; N]);

impl<const N: usize> crate::parallel::Pieces for Columns<'_, N> {
    fn count(&self) -> usize {
        self.0[N - 1].len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let mut right: [&mut [f64]; N] = std::array::from_fn(|_| Default::default());
        let mut number = 0;
        let left = self.0.map(|column| {
            let (left, rest) = column.split_at_mut(at);
            right[number] = rest;
            number += 1;
            left
        });
        (Columns(left), Columns(right))
    }
}
