//! Numerical inversion of the Laplace transform F(s) = ∫₀^∞ f(t) e^(−st) dt.
//!
//! | way | for | accuracy, of the largest f |
//! |---|---|---|
//! | [`talbot`] | diffusion: all singularities of F on the negative real axis | 1e-13 |
//! | [`FourierSeries`] | waves: singularities anywhere left of the imaginary axis; curves | by where it is cut off |

use std::f64::consts::PI;

pub use num_complex::Complex64;

/// Nodes on the upper half of Talbot's contour. The error falls like 3.89^(−2·14) = 3e-17 and the weights grow like
/// e^(0.17·2·14) = 120, so that more nodes would only add round-off.
const UPPER_NODES: usize = 14;

/// The value f(t) at a time (s) above zero, by the midpoint rule on a cotangent contour that opens to the left.
///
/// # Equation
///
/// ```text
/// f(t) = 1/(2πi) ∫ F(s) e^(st) ds        s = z(θ)/t,  −π < θ < π
/// z(θ) = N [0.5017 θ cot(0.6407 θ) − 0.6122 + 0.2645 i θ]        N = 28
/// ```
///
/// # Validity
///
/// F(s*) = F(s)*, and all singularities of F lie inside the contour: those on the negative real axis always do. A pair
/// at ±iω nears the contour as ωt grows: the error is 2e-11 at ωt = 1, 2e-9 at 2, 2e-5 at 5, and of order one at 10. A
/// transform with a delay e^(−sτ) grows on the left: subtract delayed responses instead. Fourteen evaluations of F.
///
/// # Reference
///
/// J.A.C. Weideman, Optimizing Talbot's contours for the inversion of the Laplace transform, SIAM J. Numer. Anal. 44
/// (2006) 2342–2362; L.N. Trefethen, J.A.C. Weideman, T. Schmelzer, Talbot quadratures and rational approximations, BIT
/// 46 (2006) 653–670.
pub fn talbot(transform: impl Fn(Complex64) -> Complex64, time: f64) -> f64 {
    let count = 2.0 * UPPER_NODES as f64;
    let term = |index: usize| {
        let theta = (2 * index + 1) as f64 * PI / count;
        let (sine, cosine) = (0.6407 * theta).sin_cos();
        let cotangent = cosine / sine;
        let point = Complex64::new(0.5017 * theta * cotangent - 0.6122, 0.2645 * theta) * count;
        let slope = Complex64::new(0.5017 * (cotangent - 0.6407 * theta / (sine * sine)), 0.2645);
        (transform(point / time) * point.exp() * slope).im
    };
    (0..UPPER_NODES).map(term).sum::<f64>() * 2.0 / time
}

/// The inversion by a Fourier series on a line right of all singularities, for a whole curve at once.
///
/// # Equation
///
/// ```text
/// f(t) = e^(at)/T Re [½ F(a) + Σ_k c_k F(a + ikπ/T) e^(ikπt/T)]        T = 4 end        2 a T = 28
/// ```
///
/// `c_k` is one in the first half of the terms and falls like a squared cosine in the second, which keeps what is cut
/// off from spreading away from the places where f is not smooth.
///
/// # Validity
///
/// For 0 ≤ t ≤ `end`, F(s*) = F(s)* and no singularity right of the imaginary axis. The series repeats f with a weight
/// of e^(−28) = 7e-13. What is cut off above Ω = `terms` π/T is of the order of |F(iΩ)| Ω times e^(at) ≤ 33, near the
/// times where f is not smooth, and much less elsewhere.
///
/// # Reference
///
/// H. Dubner, J. Abate, Numerical inversion of Laplace transforms by relating them to the finite Fourier cosine
/// transform, J. ACM 15 (1968) 115–123; F. Durbin, Comput. J. 17 (1974) 371–376.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourierSeries {
    /// The last time that is asked for (s).
    pub end: f64,
    /// The number of terms, which is the number of times that F is evaluated.
    pub terms: usize,
}

impl FourierSeries {
    /// Half the period of the series over the last time.
    const HALF_PERIOD: f64 = 4.0;
    /// The natural logarithm of the weight of the repetitions, negative.
    const DAMPING: f64 = 28.0;

    /// A series for the times up to `end` (s) that holds all angular frequencies up to one (rad/s).
    pub fn up_to_frequency(end: f64, angular_frequency: f64) -> Self {
        let terms = (angular_frequency * Self::HALF_PERIOD * end / PI).ceil() as usize + 1;
        Self { end, terms }
    }

    /// The values of `K` functions with the same singularities, at each of the times (s, between zero and `end`).
    pub fn invert<const K: usize>(
        &self,
        transform: impl Fn(Complex64) -> [Complex64; K],
        times: &[f64],
    ) -> Vec<[f64; K]> {
        let half_period = Self::HALF_PERIOD * self.end;
        let shift = Self::DAMPING / (2.0 * half_period);
        let step = PI / half_period;
        let turns: Vec<_> = times.iter().map(|&time| Complex64::cis(step * time)).collect();
        let mut sums = vec![[Complex64::ZERO; K]; times.len()];
        // Horner's rule from the small end, for all times at once.
        for index in (0..self.terms).rev() {
            let weight = self.taper(index);
            let coefficients = transform(Complex64::new(shift, step * index as f64)).map(|value| value * weight);
            for (sum, turn) in sums.iter_mut().zip(&turns) {
                for (sum, coefficient) in sum.iter_mut().zip(&coefficients) {
                    *sum = *sum * turn + coefficient;
                }
            }
        }
        let value = |(sum, &time): ([Complex64; K], &f64)| sum.map(|sum| sum.re * (shift * time).exp() / half_period);
        sums.into_iter().zip(times).map(value).collect()
    }

    fn taper(&self, index: usize) -> f64 {
        let fraction = index as f64 / self.terms as f64;
        if index == 0 {
            0.5
        } else if fraction <= 0.5 {
            1.0
        } else {
            (PI * (fraction - 0.5)).cos().powi(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closeness::assert_close;

    /// Poles and branch cuts on the negative real axis; the bound is the stated accuracy.
    #[test]
    fn talbot_inverts_what_diffusion_makes() {
        for time in [1e-9_f64, 1e-3, 0.3, 1.0, 7.0, 1e3] {
            let scale = |power: f64| time.powf(power);
            assert_close(talbot(|s| 1.0 / s, time), 1.0, 1e-13);
            assert_close(talbot(|s| 1.0 / (s * s), time), time, 1e-13 * time);
            assert_close(talbot(|s| 1.0 / (s + 1.0), time), (-time).exp(), 1e-13);
            assert_close(talbot(|s| 1.0 / s.sqrt(), time), scale(-0.5) / PI.sqrt(), 1e-13 * scale(-0.5));
        }
    }

    /// e^(−√s)/s is the transform of erfc(1/(2√t)); erfc(½) and erfc(2) to sixteen digits (Abramowitz and Stegun, table
    /// 7.1, and every library since).
    #[test]
    fn talbot_inverts_the_heating_of_a_half_space() {
        let heating = |s: Complex64| (-s.sqrt()).exp() / s;
        assert_close(talbot(heating, 1.0), 0.479_500_122_186_953_5, 1e-13);
        assert_close(talbot(heating, 1.0 / 16.0), 0.004_677_734_981_047_266, 1e-13);
    }

    /// The limits that the documentation states.
    #[test]
    fn talbot_takes_slow_oscillations() {
        let sine = |s: Complex64| 1.0 / (s * s + 1.0);
        for (time, tolerance) in [(0.1_f64, 1e-13), (1.0, 2e-11), (2.0, 2e-9), (5.0, 2e-5)] {
            assert_close(talbot(sine, time), time.sin(), tolerance);
        }
    }

    /// t³e^(−t)/6 ↔ 1/(s+1)⁴ and a delayed damped oscillation that starts like t³, far beyond Talbot's reach.
    #[test]
    fn the_fourier_series_inverts_delayed_oscillations() {
        let (omega, delay) = (40.0, 1.5);
        let shaken = |s: Complex64| {
            let cube = (s + 1.0).powi(4).inv();
            // e^(−t) sin(ωt) convolved with t³e^(−t)/6 would be 1/(s+1)⁴ ω/((s+1)²+ω²); here the sum of both.
            [cube, (-s * delay).exp() * cube + omega / ((s + 1.0).powi(2) + omega * omega) / (s + 1.0).powi(2)]
        };
        // sin convolved with t, both times e^(−t): (t − sin(ωt)/ω)/ω e^(−t).
        let ramp = |time: f64| (time - (omega * time).sin() / omega) / omega * (-time).exp();
        let cube = |time: f64| if time > 0.0 { time.powi(3) * (-time).exp() / 6.0 } else { 0.0 };
        let times: Vec<f64> = (0..=60).map(|index| 0.1 * index as f64).collect();
        let values = FourierSeries::up_to_frequency(6.0, 4000.0).invert(shaken, &times);
        for (time, [first, second]) in times.iter().zip(values) {
            // What is cut off at Ω = 4000: 33 Ω^(−3) = 5e-10 near the start and the arrival.
            assert_close(first, cube(*time), 5e-10);
            assert_close(second, cube(time - delay) + ramp(*time), 5e-10);
        }
    }
}
