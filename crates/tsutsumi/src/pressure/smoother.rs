//! A polynomial in the matrix that damps the short waves of an error.

use std::ops::Range;

use super::lattice::Lattice;
use super::stencil_matrix::{GRAIN, StencilMatrix};
use crate::parallel;

/// The lowest and the highest degree of the polynomial 1 − λ S(λ). By experiment: two need more iterations than they save products, and the powers
/// of six still add up in single precision.
const LEAST_DEGREES: usize = 3;
const MOST_DEGREES: usize = 6;

/// Every wave that is meant is damped at least to this part, as far as the degree allows. By experiment; from a third to a half the time differs little.
const DAMPED_TO: f64 = 0.4;

/// S r = Σ_k c_k Âᵏ r, by Chebyshev.
///
/// # Equation
///
/// ```text
/// 1 − λ S(λ) = T_n((θ − λ)/δ) / T_n(θ/δ)      θ, δ: middle and half of the interval
/// ```
///
/// is smallest on the interval of all polynomials that are 1 at zero.
#[derive(Debug, Clone, Default)]
pub(super) struct Smoother {
    coefficients: [f32; MOST_DEGREES],
    degree: usize,
}

impl Smoother {
    /// For eigenvalues `least..=largest`, positive.
    pub(super) fn new(least: f64, largest: f64) -> Self {
        let (middle, half) = (0.5 * (largest + least), 0.5 * (largest - least));
        // T_n(y) = cosh(n arcosh y) beyond 1.
        let degree = ((1.0 / DAMPED_TO).acosh() / (middle / half).acosh()).ceil();
        let degree = (degree as usize).clamp(LEAST_DEGREES, MOST_DEGREES);
        Smoother { coefficients: chebyshev(degree, middle, half).map(|coefficient| coefficient as f32), degree }
    }

    /// x = S b. `work` is another array of this length.
    pub(super) fn apply(
        &self,
        matrix: &StencilMatrix<f32>,
        lattice: &Lattice,
        b: &[f32],
        x: &mut [f32],
        work: &mut [f32],
    ) {
        let last = self.coefficients[0];
        let y = self.approach(matrix, lattice, b, work, x);
        let piece = |(x, sites): (&mut [f32], Range<usize>)| {
            matrix.multiply(lattice, sites.clone(), y, x);
            combine(x, 1.0, &b[sites], last);
        };
        parallel::for_each((x, 0..b.len()), GRAIN, &piece);
    }

    /// x += S b. The values of `work`, two more arrays of this length, are lost.
    pub(super) fn add(
        &self,
        matrix: &StencilMatrix<f32>,
        lattice: &Lattice,
        b: &[f32],
        x: &mut [f32],
        [work, other]: [&mut [f32]; 2],
    ) {
        let last = self.coefficients[0];
        let y = self.approach(matrix, lattice, b, work, other);
        let piece = |(x, product, sites): (&mut [f32], &mut [f32], Range<usize>)| {
            matrix.multiply(lattice, sites.clone(), y, product);
            combine(product, 1.0, &b[sites], last);
            parallel::vectorized(|| x.iter_mut().zip(product).for_each(|(x, correction)| *x += *correction));
        };
        parallel::for_each((x, other, 0..b.len()), GRAIN, &piece);
    }

    /// Horner's steps y ← Â y + c_k b but the last one, from y = c_{n−1} b; y ends in `end`.
    fn approach<'a>(
        &self,
        matrix: &StencilMatrix<f32>,
        lattice: &Lattice,
        b: &[f32],
        end: &'a mut [f32],
        other: &mut [f32],
    ) -> &'a [f32] {
        let steps = self.degree - 2;
        for step in 1..=steps {
            let (from, to): (&[f32], &mut [f32]) = match ((steps - step) % 2, step) {
                (0, 1) => (b, &mut *end),
                (0, _) => (&*other, &mut *end),
                (_, 1) => (b, &mut *other),
                (..) => (&*end, &mut *other),
            };
            let factor = if step == 1 { self.coefficients[self.degree - 1] } else { 1.0 };
            let coefficient = self.coefficients[self.degree - 1 - step];
            let piece = |(y, sites): (&mut [f32], Range<usize>)| {
                matrix.multiply(lattice, sites.clone(), from, y);
                combine(y, factor, &b[sites], coefficient);
            };
            parallel::for_each((to, 0..b.len()), GRAIN, &piece);
        }
        end
    }
}

/// y ← factor y + coefficient b.
fn combine(y: &mut [f32], factor: f32, b: &[f32], coefficient: f32) {
    parallel::vectorized(|| y.iter_mut().zip(b).for_each(|(y, b)| *y = factor * *y + coefficient * b));
}

/// The coefficients c_k of the polynomial of this degree.
fn chebyshev(degree: usize, middle: f64, half: f64) -> [f64; MOST_DEGREES] {
    // T_k((θ − λ)/δ) by powers of λ, and the one before: T_{k+1} = 2 y T_k − T_{k−1}.
    let mut before = [0.0; MOST_DEGREES + 1];
    let mut values = [0.0; MOST_DEGREES + 1];
    before[0] = 1.0;
    (values[0], values[1]) = (middle / half, -1.0 / half);
    for _ in 1..degree {
        let next = std::array::from_fn(|power| {
            let risen = if power > 0 { values[power - 1] } else { 0.0 };
            2.0 * (middle * values[power] - risen) / half - before[power]
        });
        (before, values) = (values, next);
    }
    std::array::from_fn(|power| -values[power + 1] / values[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the ends of the interval the polynomial is ±1/T_n(θ/δ): for 1..=9 with θ/δ = 5/4, T₃ = 4 (5/4)³ − 15/4 = 65/16, and
    /// T_n = (2ⁿ + 2⁻ⁿ)/2 in general, as arcosh(5/4) = ln 2.
    #[test]
    fn the_polynomial_is_chebyshevs() {
        for degree in LEAST_DEGREES..=MOST_DEGREES {
            let coefficients = chebyshev(degree, 5.0, 4.0);
            let rest = |x: f64| 1.0 - x * coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
            let height = 2.0 / (2_f64.powi(degree as i32) + 0.5_f64.powi(degree as i32));
            let sign = if degree % 2 == 0 { 1.0 } else { -1.0 };
            for (x, expected) in [(0.0, 1.0), (1.0, height), (9.0, sign * height)] {
                // Powers of 9 up to the sixth, with coefficients that nearly cancel.
                assert!((rest(x) - expected).abs() < 1e-11, "{degree}, {x}: {}", rest(x));
            }
            // Extrema in between: θ − δ cos(jπ/n).
            for j in 0..=degree {
                let x = 5.0 - 4.0 * (j as f64 * std::f64::consts::PI / degree as f64).cos();
                assert!((rest(x).abs() - height).abs() < 1e-11, "{degree}, {x}: {}", rest(x));
            }
        }
    }
}
