//! The modified Bessel function of order zero.

use std::f64::consts::TAU;

/// From here on the asymptotic series has terms below the rounding of its sum.
const LARGE: f64 = 25.0;

/// e^(−x) I₀(x) for x ≥ 0, to a few units in the last place.
///
/// # Equation
///
/// ```text
/// I₀(x) = Σ (x²/4)^k / k!²                        for small x
/// I₀(x) ~ e^x/√(2πx) Σ [(2k − 1)!!]² / (k! (8x)^k)      for large x
/// ```
///
/// # Reference
///
/// Abramowitz & Stegun, 9.6.12 and 9.7.1.
pub(crate) fn i0_scaled(x: f64) -> f64 {
    if x < LARGE {
        let mut term = (-x).exp();
        let mut sum = term;
        for k in 1.. {
            let factor = 0.5 * x / f64::from(k);
            term *= factor * factor;
            sum += term;
            if term <= 1e-17 * sum {
                break;
            }
        }
        sum
    } else {
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..=30 {
            let odd = f64::from(2 * k - 1);
            term *= odd * odd / (8.0 * f64::from(k) * x);
            sum += term;
            if term < 1e-17 {
                break;
            }
        }
        sum / (TAU * x).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of mpmath with 40 digits.
    #[test]
    fn values_of_another_program() {
        for (x, expected) in [
            (0.0, 1.0),
            (0.001, 0.9990007495835156),
            (0.5, 0.6450352704491501),
            (1.0, 0.46575960759364043),
            (10.0, 0.12783333716342862),
            (19.9, 0.0900085888643896),
            (24.9, 0.0803593326115322),
            (25.1, 0.08003519725429624),
            (50.0, 0.05656162664745419),
            (700.0, 0.015081295651531358),
            (5000.0, 0.005642036898744589),
        ] {
            let value = i0_scaled(x);
            assert!((value - expected).abs() < 2e-15 * expected, "{value} is not {expected} at {x}");
        }
    }
}
