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

    /// The sums of the rows of some cells of a run, with the signs of each pattern, into `sums`; returns the largest sum of magnitudes over the
    /// diagonal: no eigenvalue of D⁻¹ A is larger (Gershgorin).
    #[inline(always)]
    pub(super) fn sum_rows<const P: usize>(
        &self,
        lattice: &Lattice,
        run: usize,
        sites: Range<usize>,
        patterns: [u8; P],
        sums: &mut [[T; STRIP]; P],
    ) -> T {
        let rows = Rows { matrix: self, lattice, run, patterns };
        let (mut bounds, mut bound) = ([T::zero(); ROWS], [T::zero()]);
        let wide = sites.len() / ROWS * ROWS;
        for from in (0..wide).step_by(ROWS) {
            rows.sum(sites.start + from, from, sums, &mut bounds);
        }
        for from in wide..sites.len() {
            rows.sum(sites.start + from, from, sums, &mut bound);
        }
        bounds.into_iter().fold(bound[0], T::max)
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

/// The rows of a run, to be summed with the signs of `P` patterns.
struct Rows<'a, T, const P: usize> {
    matrix: &'a StencilMatrix<T>,
    lattice: &'a Lattice,
    run: usize,
    patterns: [u8; P],
}

impl<T: RealField + Copy, const P: usize> Rows<'_, T, P> {
    /// The sums of `L` rows from a site on, into `row_sums` from a place on, and the sums of their magnitudes over the diagonal where they are larger
    /// than `bounds`.
    #[inline(always)]
    fn sum<const L: usize>(&self, site: usize, place: usize, row_sums: &mut [[T; STRIP]; P], bounds: &mut [T; L]) {
        let Rows { matrix, lattice, run, patterns } = self;
        let mut diagonal = [T::zero(); L];
        diagonal.copy_from_slice(&matrix.diagonal[site..][..L]);
        let (mut sums, mut magnitudes) = ([diagonal; P], diagonal);
        for (offset, entries) in lattice.offsets().iter().zip(&matrix.upper) {
            let [_, below] = lattice.shift(*run, offset);
            let (upper, lower) = (&entries[site..][..L], &entries[site.wrapping_add_signed(below)..][..L]);
            for (sums, &pattern) in sums.iter_mut().zip(patterns) {
                let sign = if offset.flips(pattern) { -T::one() } else { T::one() };
                for lane in 0..L {
                    sums[lane] += sign * (upper[lane] + lower[lane]);
                }
            }
            for lane in 0..L {
                magnitudes[lane] += upper[lane].abs() + lower[lane].abs();
            }
        }
        for (row_sums, sums) in row_sums.iter_mut().zip(&sums) {
            row_sums[place..][..L].copy_from_slice(sums);
        }
        for lane in 0..L {
            let bound = magnitudes[lane] / diagonal[lane];
            bounds[lane] = if bound > bounds[lane] { bound } else { bounds[lane] };
        }
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

/// Rows that are summed side by side.
const ROWS: usize = 8;

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
            (true, 4..) => add_four::<T, true>(four(0), own, product),
            (true, _) => product.copy_from_slice(own),
            (false, _) => {
                let diagonal = matrix.diagonal[from..][..len].iter();
                product.iter_mut().zip(diagonal).zip(own).for_each(|((product, &d), &x)| *product = d * x);
                if fours > 0 {
                    add_four::<T, false>(four(0), own, product);
                }
            }
        }
        for number in (4..fours).step_by(4) {
            add_four::<T, false>(four(number), own, product);
        }
        for number in fours..matrix.upper.len() {
            add_one(couple(number), own, product);
        }
    }
}

/// Adds the products of four offsets to `product`, or sets it to their sum with `own` if they are the `FIRST`, for some sites at a time.
#[inline(always)]
fn add_four<T: RealField + Copy, const FIRST: bool>(couples: [Couple<T>; 4], own: &[T], product: &mut [T]) {
    let [a, b, c, d] = couples;
    let (wide, few) = lengths(product.len());
    let (first, rest) = product.split_at_mut(wide);
    let (second, last) = rest.split_at_mut(few - wide);
    // Written out: with arrays of unknown content the compiler would check sixteen lengths for every part.
    let len = first.len() / LANES;
    add_parts::<T, 4, LANES, FIRST>([a.parts(0, len), b.parts(0, len), c.parts(0, len), d.parts(0, len)], own, first);
    let len = second.len() / FEW_LANES;
    let parts = [a.parts(wide, len), b.parts(wide, len), c.parts(wide, len), d.parts(wide, len)];
    add_parts::<T, 4, FEW_LANES, FIRST>(parts, &own[wide..], second);
    let len = last.len();
    add_parts::<T, 4, 1, FIRST>(
        [a.parts(few, len), b.parts(few, len), c.parts(few, len), d.parts(few, len)],
        &own[few..],
        last,
    );
}

/// Adds the product of one offset to `product`.
#[inline(always)]
fn add_one<T: RealField + Copy>(couple: Couple<T>, own: &[T], product: &mut [T]) {
    let (wide, few) = lengths(product.len());
    let (first, rest) = product.split_at_mut(wide);
    let (second, last) = rest.split_at_mut(few - wide);
    add_parts::<T, 1, LANES, false>([couple.parts(0, first.len() / LANES)], own, first);
    add_parts::<T, 1, FEW_LANES, false>([couple.parts(wide, second.len() / FEW_LANES)], &own[wide..], second);
    add_parts::<T, 1, 1, false>([couple.parts(few, last.len())], &own[few..], last);
}

/// How many sites are worked on with the most lanes, and with at least a few.
fn lengths(sites: usize) -> (usize, usize) {
    (sites / LANES * LANES, sites / FEW_LANES * FEW_LANES)
}

/// The same, `L` sites at a time, for a multiple of as many sites.
#[inline(always)]
fn add_parts<T: RealField + Copy, const N: usize, const L: usize, const FIRST: bool>(
    couples: [Couple<[T; L]>; N],
    own: &[T],
    product: &mut [T],
) {
    let (product, _) = product.as_chunks_mut::<L>();
    let own = own.as_chunks::<L>().0.split_at(product.len()).0;
    for i in 0..product.len() {
        let mut sums = if FIRST { own[i] } else { product[i] };
        for Couple { upper, x_upper, lower, x_lower } in &couples {
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

    /// `len` times as many sites as stand side by side, from one on: all of one length, which the compiler knows to be the same.
    #[inline(always)]
    fn parts<const L: usize>(&self, from: usize, len: usize) -> Couple<'a, [T; L]> {
        let part = |values: &'a [T]| values[from..].as_chunks::<L>().0.split_at(len).0;
        let Couple { upper, x_upper, lower, x_lower } = self;
        Couple { upper: part(upper), x_upper: part(x_upper), lower: part(lower), x_lower: part(x_lower) }
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
