//! A symmetric matrix between cells that are near each other, on a [`Lattice`].

use std::ops::Range;

use nalgebra::RealField;

use super::lattice::Lattice;

/// Sites in a piece of a loop: the work on one piece fills some microseconds, its values fit the nearest caches.
pub(super) const GRAIN: usize = 4096;

/// Sites worked on at a time, so that sums stay in the nearest cache.
const STRIP: usize = 512;

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

    /// The rows `sites` of A x, into `product` (of that length). Sites without a cell are left as they are, or zero where they were or `x` is.
    pub(super) fn multiply(&self, lattice: &Lattice, sites: Range<usize>, x: &[T], product: &mut [T]) {
        let machine = pulp::Arch::new();
        self.visit_strips(lattice, &sites, |run, from, len| {
            let product = &mut product[from - sites.start..][..len];
            machine.dispatch(Strip { matrix: self, lattice, run, from, x, product });
        });
    }

    /// The sums of the rows `sites`, with the signs of a pattern, into `sums`; returns the largest sum of magnitudes over the
    /// diagonal: no eigenvalue of D⁻¹ A is larger (Gershgorin).
    #[inline(always)]
    pub(super) fn sum_rows(&self, lattice: &Lattice, sites: Range<usize>, pattern: u8, sums: &mut [T]) -> T {
        let mut bound = T::zero();
        let mut magnitudes = [T::zero(); STRIP];
        self.visit_strips(lattice, &sites, |run, from, len| {
            let diagonal = &self.diagonal[from..][..len];
            let sums = &mut sums[from - sites.start..][..len];
            sums.copy_from_slice(diagonal);
            let magnitudes = &mut magnitudes[..len];
            magnitudes.copy_from_slice(diagonal);
            for (offset, entries) in lattice.offsets().iter().zip(&self.upper) {
                let sign = if offset.flips(pattern) { -T::one() } else { T::one() };
                let [_, below] = lattice.shift(run, offset);
                let lower = &entries[from.wrapping_add_signed(below)..][..len];
                let entries = &entries[from..][..len];
                for i in 0..len {
                    sums[i] += sign * (entries[i] + lower[i]);
                    magnitudes[i] += entries[i].abs() + lower[i].abs();
                }
            }
            bound = magnitudes.iter().zip(diagonal).fold(bound, |bound, (&sum, &d)| bound.max(sum / d));
        });
        bound
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

/// Sites whose sums stay in registers from the first entry to the last.
const LANES: usize = 16;

impl<T: RealField + Copy> pulp::WithSimd for Strip<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Strip { matrix, lattice, run, from, x, product } = self;
        let len = product.len();
        let own = &x[from..][..len];
        match matrix.diagonal.is_empty() {
            true => product.copy_from_slice(own),
            false => {
                let diagonal = matrix.diagonal[from..][..len].iter();
                product.iter_mut().zip(diagonal).zip(own).for_each(|((product, &d), &x)| *product = d * x);
            }
        }
        let couple = |number: usize| {
            let shift = lattice.shift(run, &lattice.offsets()[number]);
            Couple::new(shift, &matrix.upper[number], x, from, len)
        };
        // Four offsets at a time (all in 2-D with linear functions): fewer loads and stores of sums.
        let mut number = 0;
        while number + 4 <= matrix.upper.len() {
            add_couples([couple(number), couple(number + 1), couple(number + 2), couple(number + 3)], product);
            number += 4;
        }
        while number < matrix.upper.len() {
            add_couples([couple(number)], product);
            number += 1;
        }
    }
}

/// Adds the products of a few offsets, for some sites at a time.
#[inline(always)]
fn add_couples<T: RealField + Copy, const N: usize>(couples: [Couple<T>; N], product: &mut [T]) {
    let whole = product.len() / LANES * LANES;
    for from in (0..whole).step_by(LANES) {
        let product = &mut product[from..][..LANES];
        let mut sums: [T; LANES] = std::array::from_fn(|lane| product[lane]);
        for couple in &couples {
            couple.part(from, LANES).add(&mut sums);
        }
        product.copy_from_slice(&sums);
    }
    for couple in &couples {
        couple.part(whole, product.len() - whole).add(&mut product[whole..]);
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
    fn part(&self, from: usize, len: usize) -> Self {
        let Couple { upper, x_upper, lower, x_lower } = self;
        let [upper, x_upper, lower, x_lower] = [upper, x_upper, lower, x_lower].map(|values| &values[from..][..len]);
        Couple { upper, x_upper, lower, x_lower }
    }

    #[inline(always)]
    fn add(&self, sums: &mut [T]) {
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum += self.upper[i] * self.x_upper[i] + self.lower[i] * self.x_lower[i];
        }
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
