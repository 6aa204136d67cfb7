/// Elasticity whose moduli grow with the square root of the mean pressure, along straight strain paths in closed form.
///
/// # Equation
///
/// ```text
/// dp = κ √p dε_v,  p ≥ p_min      ⇒      √p₁ = max(√p₀ + ½ κ Δε_v, √p_min),      mean √p = ½ (√p₀ + √p₁)
/// ```
///
/// √p is linear in the strain, so that Δs = 2 G Δe with G = g √p takes its mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RootPressure {
    /// p₁ (Pa).
    pub(super) pressure: f64,
    /// The mean of √p over the path (√Pa).
    pub(super) mean_root: f64,
}

impl RootPressure {
    /// From a pressure (Pa, positive in compression) over a volumetric strain (–, positive in compression), with κ (√Pa) and p_min (Pa).
    #[inline(always)]
    pub(super) fn after(pressure: f64, stiffness: f64, volumetric_strain: f64, smallest: f64) -> Self {
        let least = smallest.sqrt();
        let before = pressure.max(smallest).sqrt();
        let after = (before + 0.5 * stiffness * volumetric_strain).max(least);
        RootPressure { pressure: after * after, mean_root: 0.5 * (before + after) }
    }
}
