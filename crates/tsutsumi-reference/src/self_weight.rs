//! Consolidation of a layer under its own weight, put on at once.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::modes::Sum;

/// A saturated layer on an impermeable rigid base, drained at its top, whose gravity is switched on at time zero.
///
/// Small strains, linear elastic skeleton, no inertia.
///
/// # Equation
///
/// ```text
/// p_w(z,t) = p_end(z) + (P H − p_end(0)) Σ_n 2/M_n² cos(M_n z/H) e^(−M_n² T)    M_n = (n + ½) π    T = c_v t/H²
/// P = ρ g (K^f/n) / (K^f/n + E_oed)        c_v = (k/γ_w) / (1/E_oed + n/K^f)        γ_w = ρ_f g
/// s(z,t) = 1/E_oed ∫_0^z (ρ g (H − ζ) − p_w) dζ
/// ```
///
/// `z` is the elevation above the base, here and in the source; `p_end` is zero or ρ_f g (H − z).
///
/// # Reference
///
/// Del Castillo, Borja & Fávero Neto, "A coupled u–p_w SPH formulation for hydromechanical modeling of retrogressive
/// landslides", supporting information, section II, eqs. (4)–(8), whose integral (7) is done here: A_n = 2 P H/M_n².
/// The hydrostatic end follows by superposition. Valid from t > 0 on.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelfWeight {
    /// Thickness H (m).
    pub height: f64,
    /// Oedometric modulus of the skeleton E_oed = K + 4G/3 (Pa).
    pub modulus: f64,
    /// Hydraulic conductivity k (m/s).
    pub conductivity: f64,
    /// Density of the saturated ground ρ (kg/m³).
    pub density: f64,
    /// Density of the fluid ρ_f (kg/m³).
    pub fluid_density: f64,
    /// Porosity over bulk modulus of the fluid, n/K^f (1/Pa); zero for an incompressible fluid.
    pub fluid_compressibility: f64,
    /// Gravity g (m/s²).
    pub gravity: f64,
    /// What the pore pressure ends at.
    #[serde(default)]
    pub end: EndState,
}

/// What the pore pressure of a layer under its own weight ends at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EndState {
    /// Zero (scenario 1): the ground keeps its weight, but Darcy's law has no gravity, and the skeleton ends carrying
    /// the whole weight. The source says that gravity is no longer imposed once the pressure is there; were the weight
    /// itself taken away, the pressure would go with it at once.
    Zero,
    /// Hydrostatic, with the water table at the top (scenario 2): the skeleton ends carrying the buoyant weight.
    #[default]
    Hydrostatic,
}

impl SelfWeight {
    /// The coefficient of consolidation c_v (m²/s).
    pub fn consolidation_coefficient(&self) -> f64 {
        let unit_weight = self.fluid_density * self.gravity;
        self.conductivity / unit_weight / (1.0 / self.modulus + self.fluid_compressibility)
    }

    /// The pore pressure p_w (Pa) at an elevation (m) above the base, at a time (s); zero before gravity is there.
    pub fn pressure(&self, elevation: f64, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        let height = elevation / self.height;
        // Σ 2/M² cos(M z/H) e^(−M² T) is also what a uniform pressure integrates to.
        let excess = self.height * self.excess_gradient() * Sum::Below(height).decaying(self.time_factor(time));
        self.end_gradient() * (self.height - elevation) + excess
    }

    /// The settlement (m, positive downwards) of the point at an elevation (m) above the base, at a time (s).
    pub fn settlement(&self, elevation: f64, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        let height = elevation / self.height;
        let drained = (self.density * self.gravity - self.end_gradient()) * Sum::Pressure(height).steady();
        let excess = self.excess_gradient() * Sum::Pressure(height).decaying_cubed(self.time_factor(time));
        self.height * self.height / self.modulus * (drained - excess)
    }

    /// The pressure gradient P that the weight leaves in the fluid at once, downwards (Pa/m).
    pub fn undrained_gradient(&self) -> f64 {
        self.density * self.gravity / (1.0 + self.modulus * self.fluid_compressibility)
    }

    /// The pressure gradient that remains, downwards (Pa/m).
    fn end_gradient(&self) -> f64 {
        match self.end {
            EndState::Zero => 0.0,
            EndState::Hydrostatic => self.fluid_density * self.gravity,
        }
    }

    /// The pressure gradient that dissipates, downwards (Pa/m).
    fn excess_gradient(&self) -> f64 {
        self.undrained_gradient() - self.end_gradient()
    }

    fn time_factor(&self, time: f64) -> f64 {
        self.consolidation_coefficient() * time / (self.height * self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(end: EndState) -> SelfWeight {
        SelfWeight {
            height: 4.0,
            modulus: 10e6,
            conductivity: 1e-4,
            density: 2000.0,
            fluid_density: 1000.0,
            fluid_compressibility: 2e-8,
            gravity: 9.81,
            end,
        }
    }

    fn time_at(layer: SelfWeight, time_factor: f64) -> f64 {
        time_factor * layer.height * layer.height / layer.consolidation_coefficient()
    }

    /// Base pressure over P H, evaluated with another program, five digits.
    #[test]
    fn the_base_pressure_dissipates_to_zero() {
        let layer = layer(EndState::Zero);
        let table = [(0.01, 0.88716), (0.05, 0.74769), (0.1, 0.64318), (0.2, 0.49591), (0.5, 0.23605), (1.0, 0.06874)];
        for (time_factor, expected) in table {
            let base = layer.pressure(0.0, time_at(layer, time_factor)) / (layer.undrained_gradient() * layer.height);
            assert!((base - expected).abs() < 5e-6, "{base} is not {expected} at {time_factor}");
        }
    }

    /// Explicit finite differences of p_t = c_v (p_z + g ρ_f)_z from the undrained state, which know nothing of modes.
    /// Second order in the interval: with 100 intervals their error is 1e-5 of the base pressure.
    #[test]
    fn both_scenarios_agree_with_finite_differences() {
        for end in [EndState::Zero, EndState::Hydrostatic] {
            let layer = layer(end);
            let fluid_weight = if end == EndState::Hydrostatic { 9810.0 } else { 0.0 };
            let count = 100;
            let interval = layer.height / count as f64;
            let ratio = 0.25;
            let dt = ratio * interval * interval / layer.consolidation_coefficient();
            let start = 2000.0 * 9.81 / (1.0 + 10e6 * 2e-8);
            let mut pressure: Vec<f64> = (0..=count).map(|i| start * (layer.height - i as f64 * interval)).collect();
            for _ in 0..4000 {
                let old = pressure.clone();
                // The node on the base holds half an interval, through whose lower side nothing flows.
                pressure[0] += 2.0 * ratio * (old[1] - old[0] + fluid_weight * interval);
                for i in 1..count {
                    pressure[i] += ratio * (old[i - 1] - 2.0 * old[i] + old[i + 1]);
                }
            }
            for (i, expected) in pressure.iter().enumerate() {
                let value = layer.pressure(i as f64 * interval, 4000.0 * dt);
                let error = (value - expected).abs() / (start * layer.height);
                assert!(error < 3e-5, "{value} is not {expected} at node {i}, {end:?}");
            }
        }
    }

    /// Undrained and fluid incompressible, nothing settles; in the end the skeleton carries ρ g or (ρ − ρ_f) g, and a
    /// column under its own weight settles by the weight times H²/(2 E_oed).
    #[test]
    fn settlement_between_its_limits() {
        for (end, weight) in [(EndState::Zero, 2000.0 * 9.81), (EndState::Hydrostatic, 1000.0 * 9.81)] {
            let layer = SelfWeight { fluid_compressibility: 0.0, ..layer(end) };
            let last = weight * 16.0 / (2.0 * 10e6);
            // At T = 1e-12 less than 2e-6 of the height has drained, and the settlement goes with T.
            assert!(layer.settlement(4.0, time_at(layer, 1e-12)).abs() < 1e-5 * last);
            assert!((layer.settlement(4.0, time_at(layer, 20.0)) - last).abs() < 1e-12 * last);
            assert!((layer.pressure(1.0, time_at(layer, 20.0)) - (19620.0 - weight) * 3.0).abs() < 1e-6);
        }
    }

    /// Settlement is the integral of the effective stress: midpoint rule on 2000 intervals, error below 1e-7 of the
    /// top's.
    #[test]
    fn settlement_is_the_compression_below_a_point() {
        let layer = layer(EndState::Hydrostatic);
        for (elevation, time_factor) in [(4.0, 0.02), (4.0, 0.3), (1.5, 0.3)] {
            let (count, time) = (2000, time_at(layer, time_factor));
            let interval = elevation / count as f64;
            let stress = |z: f64| 2000.0 * 9.81 * (4.0 - z) - layer.pressure(z, time);
            let compression =
                (0..count).map(|i| stress((i as f64 + 0.5) * interval)).sum::<f64>() * interval / layer.modulus;
            let value = layer.settlement(elevation, time);
            assert!((value - compression).abs() < 1e-7 * layer.settlement(4.0, time), "{value} is not {compression}");
        }
    }
}
