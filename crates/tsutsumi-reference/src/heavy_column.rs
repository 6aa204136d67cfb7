//! An elastic column that is pressed together by its own weight, at large strains.

use schemars::JsonSchema;
use serde::Deserialize;

/// A laterally confined column on a rigid base, at rest under its own weight, in logarithmic strain.
///
/// # Equation
///
/// ```text
/// ∂σ/∂X = ρ_0 g      σ(H) = 0      σ = M ln λ      λ = 1 + ∂u/∂X
/// u(X) = H/w (e^(−w (1 − X/H)) − e^(−w)) − X      w = ρ_0 g H / M
/// ```
///
/// `X` is the elevation above the base before gravity. The law is that of a linear elastic law in rate form,
/// σ̇ = M ε̇ with ε̇ = λ̇/λ.
///
/// # Reference
///
/// Equilibrium in the material's own coordinate, integrated here.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeavyColumn {
    /// Height H without weight (m).
    pub height: f64,
    /// Oedometric modulus M (Pa).
    pub modulus: f64,
    /// Density ρ_0 without strain (kg/m³).
    pub density: f64,
    /// Gravity g (m/s²).
    pub gravity: f64,
}

impl HeavyColumn {
    /// The displacement u (m, positive upwards) of the material at an elevation X (m) before gravity.
    pub fn displacement(&self, elevation: f64) -> f64 {
        let weight = self.weight();
        let length = |elevation: f64| self.height / weight * (-weight * (1.0 - elevation / self.height)).exp();
        length(elevation) - length(0.0) - elevation
    }

    /// The stress σ (Pa, positive in tension) of the material at an elevation X (m) before gravity.
    pub fn stress(&self, elevation: f64) -> f64 {
        -self.density * self.gravity * (self.height - elevation)
    }

    /// The weight of the column over its modulus, w (–).
    fn weight(&self) -> f64 {
        self.density * self.gravity * self.height / self.modulus
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stress from the law, with the strain by central differences: (w Δ/H)²/24 of it, 1e-9.
    #[test]
    fn the_column_is_in_equilibrium() {
        let column = HeavyColumn { height: 10.0, modulus: 100e3, density: 1000.0, gravity: 6.0 };
        for elevation in [0.5, 4.0, 9.5] {
            let step = 1e-3;
            let difference = column.displacement(elevation + step) - column.displacement(elevation - step);
            let stress = column.modulus * (difference / (2.0 * step)).ln_1p();
            assert!((stress - column.stress(elevation)).abs() < 1e-4, "{elevation} m");
        }
        assert_eq!(column.displacement(0.0), 0.0);
        // H (1 − (1 − e^(−0.6))/0.6), by hand.
        assert!((column.displacement(10.0) + 2.480193934).abs() < 1e-8, "{}", column.displacement(10.0));
    }
}
