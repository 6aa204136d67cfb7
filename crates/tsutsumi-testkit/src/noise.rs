//! Numbers without a pattern, the same in every run.

use tsutsumi::tensor::{Sym3, Vector};

/// A sequence of numbers without a pattern. Equal seeds give equal sequences.
///
/// # Reference
///
/// SplitMix64: Steele, Lea and Flood (2014), Fast splittable pseudorandom number generators, OOPSLA '14.
#[derive(Debug, Clone)]
pub struct Noise(u64);

impl Noise {
    /// The sequence with this seed.
    pub fn new(seed: u64) -> Self {
        Noise(seed)
    }

    /// The next number, between −1 and 1.
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        // The upper 53 bits fill the mantissa.
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A vector of such numbers.
    pub fn vector<const D: usize>(&mut self) -> Vector<D> {
        Vector::from_fn(|_, _| self.number())
    }

    /// A symmetric tensor of such numbers.
    pub fn tensor(&mut self) -> Sym3 {
        let [xx, yy, zz, xy, yz, zx] = std::array::from_fn(|_| self.number());
        Sym3 { xx, yy, zz, xy, yz, zx }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_fill_their_range_evenly() {
        let mut noise = Noise::new(1);
        let numbers: Vec<f64> = (0..10_000).map(|_| noise.number()).collect();
        assert!(numbers.iter().all(|x| x.abs() <= 1.0));
        // Mean 0 and variance 1/3, within four standard deviations of the mean of 10 000.
        let mean = |power: i32| numbers.iter().map(|x| x.powi(power)).sum::<f64>() / 1e4;
        assert!(mean(1).abs() < 0.024, "{}", mean(1));
        assert!((mean(2) - 1.0 / 3.0).abs() < 0.012, "{}", mean(2));
    }
}
