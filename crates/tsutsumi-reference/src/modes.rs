//! The modes of one-dimensional consolidation: how a uniform pressure leaves a layer of unit thickness.

use std::f64::consts::{FRAC_PI_2, PI};

/// Below this time factor nothing of the impermeable end is felt at the drained one: erfc(1/(2√T)) < 2e-23.
const EARLY: f64 = 0.005;

/// What is summed over the modes M = (m + ½) π, at a depth below the drained end over the thickness (–).
#[derive(Debug, Clone, Copy)]
pub(crate) enum Sum {
    /// Each mode's pressure at this depth, sin(M ζ).
    Pressure(f64),
    /// Each mode's pressure integrated from this depth to the impermeable end, cos(M ζ)/M.
    Below(f64),
}

impl Sum {
    /// Σ 2/M e^(−M² T) times the mode's share, T the time factor c_v t/H².
    ///
    /// Early on, where the series needs too many terms, the layer is a half-space: erf(ζ/(2√T)), and its integral.
    pub(crate) fn decaying(&self, time_factor: f64) -> f64 {
        if time_factor >= EARLY {
            return self.series(time_factor, 1);
        }
        let length = 2.0 * time_factor.sqrt();
        match *self {
            Sum::Pressure(depth) => libm::erf(depth / length),
            Sum::Below(depth) => 1.0 - depth - length * integral_of_erfc(depth / length),
        }
    }

    /// Σ 2/M³ e^(−M² T) times the mode's share: what [`Sum::decaying`] loses from T on, ∫_T^∞ dT.
    pub(crate) fn decaying_cubed(&self, time_factor: f64) -> f64 {
        self.series(time_factor, 3)
    }

    /// Σ 2/M³ times the mode's share: the quasi-steady state under a load that grows for ever.
    pub(crate) fn steady(&self) -> f64 {
        match *self {
            Sum::Pressure(depth) => depth - 0.5 * depth * depth,
            Sum::Below(depth) => 0.5 * (1.0 - depth * depth) - (1.0 - depth.powi(3)) / 6.0,
        }
    }

    /// Σ 2/M^power e^(−M² T) times the mode's share.
    fn series(&self, time_factor: f64, power: i32) -> f64 {
        let mut sum = 0.0;
        for term in 0.. {
            let m = term as f64 * PI + FRAC_PI_2;
            let decay = (-m * m * time_factor).exp();
            let share = match *self {
                Sum::Pressure(depth) => (m * depth).sin(),
                Sum::Below(depth) => (m * depth).cos() / m,
            };
            let term = 2.0 / m.powi(power) * decay;
            sum += term * share;
            if term < 1e-17 {
                break;
            }
        }
        sum
    }
}

/// ∫_x^∞ erfc.
fn integral_of_erfc(x: f64) -> f64 {
    (-x * x).exp() / PI.sqrt() - x * libm::erfc(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Series and half-space are two expansions of one function: near the time factor where they meet they agree.
    #[test]
    fn the_half_space_meets_the_series() {
        for time_factor in [0.002, 0.0049] {
            for depth in [0.0, 0.02, 0.1, 0.4, 1.0] {
                for sum in [Sum::Pressure(depth), Sum::Below(depth)] {
                    let (early, series) = (sum.decaying(time_factor), sum.series(time_factor, 1));
                    assert!((early - series).abs() < 1e-14, "{sum:?} at {time_factor}: {early} and {series}");
                }
            }
        }
    }
}
