//! Vectors of four numbers, as wide as the processor at hand can take them.
//!
//! A [`Kernel`] is compiled for every processor, for those with vectors of four numbers (AVX2), and, if it says so, for those that keep 32 of them
//! in registers (AVX-512); [`run`] finds out. Where lanes are particles, it takes as many as a register holds ([`Lanes`]).
//!
//! All give the same bits: nothing is summed in another order, and a product that [`AddProduct`] adds is rounded only with its sum, which processors
//! with AVX2, and those of ARM with 64 bits, do in one operation. Others, of x86 those from before 2013, would need a hundred: they round twice, and
//! their results differ in the last bits.

use std::ops::{Add, AddAssign, Mul, MulAssign};

/// How four numbers are kept and calculated with.
pub(crate) trait Vectors: Copy {
    /// The four numbers.
    type Four: Copy;
    /// As many numbers as a register holds, where lanes are particles.
    type Widest: Lanes<Self>;

    /// Four numbers from an array.
    fn pack(self, values: [f64; 4]) -> Self::Four;
    /// Four numbers as an array.
    fn unpack(self, four: Self::Four) -> [f64; 4];
    /// Sums, one by one.
    fn add(self, a: Self::Four, b: Self::Four) -> Self::Four;
    /// Products, one by one.
    fn mul(self, a: Self::Four, b: Self::Four) -> Self::Four;
    /// sum + a b, one by one, rounded once.
    fn fuse(self, a: Self::Four, b: Self::Four, sum: Self::Four) -> Self::Four;
    /// sum + a b, rounded once.
    fn fuse_one(self, a: f64, b: f64, sum: f64) -> f64;
}

/// Sums of products, each product rounded only with its sum.
pub(crate) trait AddProduct<B> {
    /// Adds a b.
    fn add_product(&mut self, a: Self, b: B);
}

/// Work for which vectors matter. All that it calls must be inlined.
pub(crate) trait Kernel {
    /// Whether the work needs more numbers at hand than sixteen registers hold.
    const MANY_NUMBERS: bool;

    /// Does the work.
    fn run<V: Vectors>(self, vectors: V);
}

/// Runs a kernel with the widest vectors of this processor.
#[inline(always)]
pub(crate) fn run<K: Kernel>(kernel: K) {
    #[cfg(target_arch = "x86_64")]
    if K::MANY_NUMBERS
        && let Some(avx512) = pulp::x86::V4::try_new()
    {
        return pulp::Simd::vectorize(
            avx512,
            #[inline(always)]
            || kernel.run(avx512),
        );
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(
            avx2,
            #[inline(always)]
            || kernel.run(avx2),
        );
    }
    kernel.run(Portable);
}

/// Numbers side by side, as many as the type says.
pub(crate) trait Lanes<V>: Copy + Add<Output = Self> + Mul<Output = Self> + AddProduct<Self> {
    /// How many: at most [`MOST_LANES`].
    const COUNT: usize;

    /// All the same.
    fn splat(vectors: V, value: f64) -> Self;
    /// The first of these.
    fn first_of(vectors: V, values: &[f64; MOST_LANES]) -> Self;
    /// Stores the numbers, or as many as there is room for.
    fn store(self, to: &mut [f64]);
}

/// The most numbers side by side.
pub(crate) const MOST_LANES: usize = 8;

/// Vectors that every processor has.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl Vectors for Portable {
    type Four = wide::f64x4;
    type Widest = Four<Portable>;

    #[inline(always)]
    fn pack(self, values: [f64; 4]) -> Self::Four {
        wide::f64x4::new(values)
    }

    #[inline(always)]
    fn unpack(self, four: Self::Four) -> [f64; 4] {
        four.to_array()
    }

    #[inline(always)]
    fn add(self, a: Self::Four, b: Self::Four) -> Self::Four {
        a + b
    }

    #[inline(always)]
    fn mul(self, a: Self::Four, b: Self::Four) -> Self::Four {
        a * b
    }

    #[inline(always)]
    fn fuse(self, a: Self::Four, b: Self::Four, sum: Self::Four) -> Self::Four {
        let (a, b, sum) = (a.to_array(), b.to_array(), sum.to_array());
        wide::f64x4::new(std::array::from_fn(|i| self.fuse_one(a[i], b[i], sum[i])))
    }

    #[inline(always)]
    fn fuse_one(self, a: f64, b: f64, sum: f64) -> f64 {
        if FUSES { a.mul_add(b, sum) } else { a * b + sum }
    }
}

/// Whether all processors that the program is compiled for round a product only with its sum in one operation. In tests all do: to be compared.
const FUSES: bool = cfg!(any(test, target_feature = "fma", target_arch = "aarch64"));

/// Four numbers in a register, also where it would hold eight.
#[cfg(target_arch = "x86_64")]
macro_rules! in_registers_of_four {
    ($($machine:ty, $widest:ty);*) => {$(
        impl Vectors for $machine {
            type Four = pulp::f64x4;
            type Widest = $widest;

            #[inline(always)]
            fn pack(self, values: [f64; 4]) -> Self::Four {
                pulp::cast(values)
            }

            #[inline(always)]
            fn unpack(self, four: Self::Four) -> [f64; 4] {
                pulp::cast(four)
            }

            #[inline(always)]
            fn add(self, a: Self::Four, b: Self::Four) -> Self::Four {
                self.add_f64x4(a, b)
            }

            #[inline(always)]
            fn mul(self, a: Self::Four, b: Self::Four) -> Self::Four {
                self.mul_f64x4(a, b)
            }

            #[inline(always)]
            fn fuse(self, a: Self::Four, b: Self::Four, sum: Self::Four) -> Self::Four {
                self.mul_add_f64x4(a, b, sum)
            }

            #[inline(always)]
            fn fuse_one(self, a: f64, b: f64, sum: f64) -> f64 {
                a.mul_add(b, sum)
            }
        }
    )*};
}

#[cfg(target_arch = "x86_64")]
in_registers_of_four!(pulp::x86::V3, Four<pulp::x86::V3>; pulp::x86::V4, Eight);

/// Four numbers side by side.
#[derive(Clone, Copy)]
pub(crate) struct Four<V: Vectors> {
    vectors: V,
    values: V::Four,
}

impl<V: Vectors> Four<V> {
    /// Four numbers.
    #[inline(always)]
    pub(crate) fn new(vectors: V, values: [f64; 4]) -> Self {
        Four { vectors, values: vectors.pack(values) }
    }

    /// The components of a vector; after the last come the first again.
    #[inline(always)]
    pub(crate) fn repeat<const D: usize>(vectors: V, components: [f64; D]) -> Self {
        Four::new(vectors, std::array::from_fn(|lane| components[lane % D]))
    }

    /// Four times the same number.
    #[inline(always)]
    pub(crate) fn splat(vectors: V, value: f64) -> Self {
        Four::new(vectors, [value; 4])
    }

    /// The four numbers.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f64; 4] {
        self.vectors.unpack(self.values)
    }
}

impl<V: Vectors> Lanes<V> for Four<V> {
    const COUNT: usize = 4;

    #[inline(always)]
    fn splat(vectors: V, value: f64) -> Self {
        Four::splat(vectors, value)
    }

    #[inline(always)]
    fn first_of(vectors: V, values: &[f64; MOST_LANES]) -> Self {
        Four::new(vectors, [values[0], values[1], values[2], values[3]])
    }

    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        store(self.to_array(), to);
    }
}

/// Stores some numbers, or as many as there is room for.
#[inline(always)]
fn store<const N: usize>(lanes: [f64; N], to: &mut [f64]) {
    match to.first_chunk_mut() {
        Some(to) => *to = lanes,
        None => to.iter_mut().zip(lanes).for_each(|(to, lane)| *to = lane),
    }
}

/// Eight numbers side by side.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(crate) struct Eight {
    vectors: pulp::x86::V4,
    values: pulp::f64x8,
}

#[cfg(target_arch = "x86_64")]
impl Lanes<pulp::x86::V4> for Eight {
    const COUNT: usize = 8;

    #[inline(always)]
    fn splat(vectors: pulp::x86::V4, value: f64) -> Self {
        Eight { vectors, values: vectors.splat_f64x8(value) }
    }

    #[inline(always)]
    fn first_of(vectors: pulp::x86::V4, values: &[f64; MOST_LANES]) -> Self {
        Eight { vectors, values: pulp::cast(*values) }
    }

    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        store::<8>(pulp::cast(self.values), to);
    }
}

#[cfg(target_arch = "x86_64")]
impl Add for Eight {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Eight { values: self.vectors.add_f64x8(self.values, other.values), ..self }
    }
}

#[cfg(target_arch = "x86_64")]
impl Mul for Eight {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Eight { values: self.vectors.mul_f64x8(self.values, other.values), ..self }
    }
}

#[cfg(target_arch = "x86_64")]
impl AddProduct<Eight> for Eight {
    #[inline(always)]
    fn add_product(&mut self, a: Self, b: Self) {
        self.values = self.vectors.mul_add_f64x8(a.values, b.values, self.values);
    }
}

impl<V: Vectors> AddProduct<Four<V>> for Four<V> {
    #[inline(always)]
    fn add_product(&mut self, a: Self, b: Self) {
        self.values = self.vectors.fuse(a.values, b.values, self.values);
    }
}

impl<V: Vectors> AddProduct<f64> for Four<V> {
    #[inline(always)]
    fn add_product(&mut self, a: Self, b: f64) {
        self.add_product(a, Four::splat(self.vectors, b));
    }
}

impl<V: Vectors> Add for Four<V> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Four { values: self.vectors.add(self.values, other.values), ..self }
    }
}

impl<V: Vectors> AddAssign for Four<V> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<V: Vectors> Mul for Four<V> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Four { values: self.vectors.mul(self.values, other.values), ..self }
    }
}

impl<V: Vectors> MulAssign for Four<V> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<V: Vectors> Mul<f64> for Four<V> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * Four::splat(self.vectors, factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Polynomial<'a>(&'a mut [f64; 4]);

    struct SumOfProduct<'a>(&'a mut [f64; 4]);

    impl Kernel for SumOfProduct<'_> {
        const MANY_NUMBERS: bool = true;

        fn run<V: Vectors>(self, vectors: V) {
            let x = Four::new(vectors, *self.0);
            let mut sum = Four::splat(vectors, -1.0);
            sum.add_product(x, x);
            *self.0 = sum.to_array();
        }
    }

    impl Kernel for Polynomial<'_> {
        const MANY_NUMBERS: bool = true;

        fn run<V: Vectors>(self, vectors: V) {
            let x = Four::new(vectors, *self.0);
            *self.0 = ((x * x + x) * 3.0).to_array();
        }
    }

    /// A fused product and sum would differ in the last bits.
    #[test]
    fn every_processor_gives_the_same_bits() {
        let x = [0.1, 1.0 / 3.0, -7.3e5, 2.0_f64.sqrt()];
        let (mut at_hand, mut portable) = (x, x);
        run(Polynomial(&mut at_hand));
        Polynomial(&mut portable).run(Portable);
        assert_eq!(at_hand.map(f64::to_bits), portable.map(f64::to_bits));
        assert_eq!(at_hand, x.map(|x| (x * x + x) * 3.0));
    }

    /// (1 + ε)² − 1 = 2 ε + ε²: rounded twice, the last term is lost.
    #[test]
    fn products_are_rounded_with_their_sums() {
        let small = 0.5_f64.powi(30);
        let (mut at_hand, mut portable) = ([1.0 + small; 4], [1.0 + small; 4]);
        run(SumOfProduct(&mut at_hand));
        SumOfProduct(&mut portable).run(Portable);
        assert_eq!(at_hand, [2.0 * small + small * small; 4]);
        assert_eq!(at_hand, portable);
    }
}
