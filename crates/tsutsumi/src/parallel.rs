//! Loops on all threads whose results do not depend on the number of threads.
//!
//! A loop is halved until its pieces are of one grain. Where it is cut depends on its length alone, and sums are made in the order of the
//! cuts: the same bits with one thread or many. Loops of one grain never leave the thread, so that small bodies pay nothing.
//!
//! The threads are those of the rayon pool in which a step is called.

use std::ops::Range;

/// What can be cut in two: slices, ranges, and tuples of them with the same length.
pub(crate) trait Pieces: Send + Sized {
    /// The number of elements.
    fn count(&self) -> usize;

    /// The first `at` elements and the rest.
    fn cut(self, at: usize) -> (Self, Self);
}

impl Pieces for Range<usize> {
    fn count(&self) -> usize {
        self.len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let middle = self.start + at;
        (self.start..middle, middle..self.end)
    }
}

impl<T: Sync> Pieces for &[T] {
    fn count(&self) -> usize {
        self.len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        self.split_at(at)
    }
}

impl<T: Send> Pieces for &mut [T] {
    fn count(&self) -> usize {
        self.len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        self.split_at_mut(at)
    }
}

impl<A: Pieces, B: Pieces> Pieces for (A, B) {
    fn count(&self) -> usize {
        self.0.count()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let (a, b) = (self.0.cut(at), self.1.cut(at));
        ((a.0, b.0), (a.1, b.1))
    }
}

impl<A: Pieces, B: Pieces, C: Pieces> Pieces for (A, B, C) {
    fn count(&self) -> usize {
        self.0.count()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let (a, b, c) = (self.0.cut(at), self.1.cut(at), self.2.cut(at));
        ((a.0, b.0, c.0), (a.1, b.1, c.1))
    }
}

/// Values of equal rows, one after the other; an element is a row.
pub(crate) struct Rows<'a, T> {
    values: &'a mut [T],
    len: usize,
}

impl<'a, T> Rows<'a, T> {
    /// Rows of `len` values, at least one.
    pub(crate) fn new(values: &'a mut [T], len: usize) -> Self {
        Rows { values, len }
    }

    /// The rows.
    pub(crate) fn iter_mut(self) -> std::slice::ChunksExactMut<'a, T> {
        self.values.chunks_exact_mut(self.len)
    }
}

impl<T: Send> Pieces for Rows<'_, T> {
    fn count(&self) -> usize {
        self.values.len() / self.len
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let (before, after) = self.values.split_at_mut(at * self.len);
        (Rows { values: before, len: self.len }, Rows { values: after, len: self.len })
    }
}

/// Calls `work` with pieces of `grain` elements, the last one shorter.
pub(crate) fn for_each<P: Pieces>(pieces: P, grain: usize, work: &(impl Fn(P) + Sync)) {
    fold(pieces, grain, work, &|(), ()| ());
}

/// Sums what `work` says of pieces of `grain` elements.
pub(crate) fn sum<P: Pieces>(pieces: P, grain: usize, work: &(impl Fn(P) -> f64 + Sync)) -> f64 {
    fold(pieces, grain, work, &|a, b| a + b)
}

/// Joins what `work` says of pieces of `grain` elements, two neighbours at a time.
pub(crate) fn fold<P: Pieces, R: Send>(
    pieces: P,
    grain: usize,
    work: &(impl Fn(P) -> R + Sync),
    join: &(impl Fn(R, R) -> R + Sync),
) -> R {
    let grains = pieces.count().div_ceil(grain);
    if grains <= 1 {
        return work(pieces);
    }
    let (left, right) = pieces.cut(grains.div_ceil(2) * grain);
    let (left, right) = rayon::join(|| fold(left, grain, work, join), || fold(right, grain, work, join));
    join(left, right)
}

/// Runs `work` with the widest vectors that the processor has, as far as `work` and all that it calls is inlined.
///
/// Nothing is rounded differently: products and sums are not fused.
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx512) = pulp::x86::V4::try_new() {
        return pulp::Simd::vectorize(avx512, work);
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(avx2, work);
    }
    work()
}

/// Loops over fewer particles need not ask for anything: caches hold them. With twice as many, asking makes a step a tenth to a seventh faster, with
/// half as many slower by some per cent.
pub(crate) const FAR: usize = 250_000;

/// Asks the memory for some values, as far as there are so many, that will be needed soon: they come while other work is done.
///
/// A thread can wait for some dozen lines of memory at a time. It pays to ask for a few arrays here and a few there, not for all at once.
#[inline(always)]
pub(crate) fn fetch<T: bytemuck::NoUninit>(values: &[T], range: Range<usize>) {
    const LINE: usize = 64;
    let end = range.end.min(values.len());
    let bytes: &[u8] = bytemuck::cast_slice(&values[range.start.min(end)..end]);
    for line in bytes.as_chunks::<LINE>().0 {
        #[cfg(target_arch = "x86_64")]
        safe_arch::prefetch_t1(line);
        #[cfg(not(target_arch = "x86_64"))]
        let _ = line;
    }
}

/// Runs work of many loops on a thread of the pool: from outside, every single loop would change threads there and back.
pub(crate) fn within_pool<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    match rayon::current_thread_index() {
        Some(_) => work(),
        None => rayon::join(work, || ()).0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_element_is_visited_once_and_sums_do_not_depend_on_the_threads() {
        let values: Vec<f64> = (0..1000).map(|i| 1.0 / (1.0 + i as f64)).collect();
        let total = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| sum(&values[..], 7, &|piece: &[f64]| piece.iter().sum()))
        };
        assert_eq!(total(1).to_bits(), total(3).to_bits());
        // The harmonic number of 1000.
        assert!((total(2) - 7.485_470_860_550_345).abs() < 1e-13);

        let mut visits = vec![0; 1000];
        for_each((&mut visits[..], 0..1000), 64, &|(visits, range): (&mut [usize], Range<usize>)| {
            for (visit, i) in visits.iter_mut().zip(range) {
                *visit += i;
            }
        });
        assert!(visits.iter().enumerate().all(|(i, &visit)| visit == i));
    }

    /// A fused product and sum would differ in the last bits.
    #[test]
    fn vectors_round_as_single_numbers_do() {
        let values: Vec<f64> = (1..100).map(|i| 1.0 / f64::from(i)).collect();
        let polynomial = |x: f64| (x * x + x) * 3.0 - x;
        let mut in_vectors = values.clone();
        vectorized(
            #[inline(always)]
            || in_vectors.iter_mut().for_each(|x| *x = polynomial(*x)),
        );
        for (x, value) in values.into_iter().zip(in_vectors) {
            assert_eq!(polynomial(std::hint::black_box(x)).to_bits(), value.to_bits());
        }
    }

    #[test]
    fn what_is_not_there_is_not_fetched() {
        let values = [1.0; 10];
        for range in [0..10, 5..70, 10..20, 20..30] {
            fetch(&values, range);
        }
        fetch::<f64>(&[], 0..64);
    }

    #[test]
    fn nothing_is_one_piece() {
        assert_eq!(fold(0..0, 8, &|range: Range<usize>| range.len(), &|a, b| a + b), 0);
    }
}
