//! One-dimensional consolidation at large strain (Xie and Leo).

use schemars::JsonSchema;
use serde::Deserialize;

use crate::consolidation::{Consolidation, Drainage, Layer, Ramp};
use crate::gauss_legendre::integrate_graded;

/// A layer that is compressed by a large part of its thickness, under a load put on at once.
///
/// The skeleton is elastic in logarithmic strain, its conductivity falls with the square of its stretch, fluid and
/// grains are incompressible, and there is no inertia.
///
/// # Equation
///
/// ```text
/// σ' = σ'_0 + M_0 ln J        k = k_0 J²        M_0 = 1/m_vl        c_v0 = k_0 M_0/γ_w        T = c_v0 t/H²
///
/// u(a,t) = M_0 ln{1 + (e^(q/M_0) − 1) F(a,T)}              J(a,t) = e^(−(q − u)/M_0) = 1 − (1 − e^(−q/M_0)) (1 − F)
/// s(a,t) = H (1 − e^(−q/M_0)) [1 − a/H − ∫_a^H F da/H]
/// F = Σ 2/M sin(M a/H) e^(−M² T)                           M = (m + ½) π        drained at the top
/// ```
///
/// `a` is the depth that a point had before loading, `J` the stretch since then, `F` Terzaghi's p_w/q (drained at both
/// ends: with a/H → 2a/H and T → 4T). With k = k_0 J² the excess pressure u obeys ∂J/∂t = c_v0 ∂²J/∂a², which is
/// linear.
///
/// The load under which the layer stood before, and its weight, set the stress σ'_0 and the void ratio it starts from,
/// [`Before`]; they have no part in u, J and s, because stress changes and stretches are counted from there. The loss
/// of weight of a layer whose top sinks below a water table is left out, as in the source.
///
/// # Reference
///
/// Xie & Leo, Computers and Geotechnics 31 (2004) 301–314, as implemented in geotecha (`xieandleo2004.py`) and compared
/// with its tests; the article itself was not at hand.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LargeStrainLayer {
    /// Thickness before loading H (m).
    pub height: f64,
    /// Oedometric modulus in logarithmic strain M_0 = 1/m_vl (Pa).
    pub modulus: f64,
    /// Hydraulic conductivity before loading k_0 (m/s); it falls with the square of the stretch.
    pub conductivity: f64,
    /// Unit weight of the fluid γ_w (N/m³).
    pub unit_weight: f64,
    /// The load q put on its top at once (Pa, positive in compression).
    pub load: f64,
    /// Where water leaves the layer.
    #[serde(default)]
    pub drainage: Drainage,
}

/// The state of a layer before it is loaded, in equilibrium with a preload and its own buoyant weight.
///
/// # Equation
///
/// ```text
/// e_0(a) = e_00 − m_vl γ_w (G_s − 1) a          σ'_0(a) = −q_p − M_0 ln[(1 + e_00)/(1 + e_0(a))]
/// ```
///
/// # Reference
///
/// Xie & Leo (2004), as implemented in geotecha. The same law, d(1 + e)/(1 + e) = dσ'/M_0, under the buoyant weight per
/// depth γ_w (G_s − 1)/(1 + e).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Before {
    /// The load q_p that has been on the top for long (Pa, positive in compression).
    pub preload: f64,
    /// Void ratio at the top e_00 (–).
    pub void_ratio: f64,
    /// Density of the grains over density of the fluid G_s (–).
    pub specific_gravity: f64,
}

impl LargeStrainLayer {
    /// The excess pore pressure u (Pa) at a depth before loading (m), at a time (s).
    pub fn pressure(&self, depth: f64, time: f64) -> f64 {
        self.modulus * ((self.load / self.modulus).exp_m1() * self.linear().pressure(depth, time)).ln_1p()
    }

    /// The stretch J (–), thickness over thickness before loading, at a depth before loading (m), at a time (s).
    pub fn stretch(&self, depth: f64, time: f64) -> f64 {
        if time <= 0.0 { 1.0 } else { 1.0 - self.strain_final() * (1.0 - self.linear().pressure(depth, time)) }
    }

    /// The settlement s (m, positive downwards) of the point at a depth before loading (m), at a time (s).
    pub fn settlement(&self, depth: f64, time: f64) -> f64 {
        self.strain_final() * self.modulus * self.linear().settlement_at(depth, time)
    }

    /// The settlement of the top (m, positive downwards) when all excess pressure is gone.
    pub fn settlement_final(&self) -> f64 {
        self.height * self.strain_final()
    }

    /// The degree of consolidation by settlement U_s (–) at a time (s): settlement of the top over its final value.
    pub fn degree_by_settlement(&self, time: f64) -> f64 {
        self.linear().degree(time)
    }

    /// The degree of consolidation by pressure U_p (–) at a time (s): one minus the mean excess pressure over the load.
    ///
    /// The mean is taken over the depth before loading. It stays behind the degree by settlement.
    pub fn degree_by_pressure(&self, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        // From a drained end to where nothing flows; the other half of a layer drained at both ends is its mirror
        // image.
        let length = match self.drainage {
            Drainage::Top => self.height,
            Drainage::TopAndBase => 0.5 * self.height,
        };
        // Twenty halvings resolve a drained skin down to T = 1e-12.
        let missing = |depth: f64| 1.0 - self.pressure(depth, time) / self.load;
        integrate_graded(length, 20, missing) / length
    }

    /// The coefficient of consolidation before loading c_v0 (m²/s).
    pub fn consolidation_coefficient(&self) -> f64 {
        self.conductivity * self.modulus / self.unit_weight
    }

    /// The share 1 − e^(−q/M_0) of its thickness that the layer loses.
    fn strain_final(&self) -> f64 {
        -(-self.load / self.modulus).exp_m1()
    }

    /// Terzaghi's problem behind this one, under a unit load: its pressure is F, its settlement H/M_0 [1 − a/H − ∫F
    /// da/H].
    fn linear(&self) -> Consolidation {
        let layer = Layer {
            height: self.height,
            modulus: self.modulus,
            conductivity: self.conductivity,
            unit_weight: self.unit_weight,
            fluid_compressibility: 0.0,
        };
        Consolidation { layer, ramp: Ramp { load: 1.0, duration: 0.0 }, drainage: self.drainage }
    }
}

impl Before {
    /// The void ratio e_0 (–) at a depth (m) of the layer.
    pub fn void_ratio(&self, layer: LargeStrainLayer, depth: f64) -> f64 {
        self.void_ratio - layer.unit_weight * (self.specific_gravity - 1.0) * depth / layer.modulus
    }

    /// The vertical effective stress σ'_0 (Pa, positive in tension) at a depth (m) of the layer.
    pub fn stress(&self, layer: LargeStrainLayer, depth: f64) -> f64 {
        -self.preload - layer.modulus * ((1.0 + self.void_ratio) / (1.0 + self.void_ratio(layer, depth))).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The problem of the source's figures, in SI units: q = 100 kPa, H = 10 m, k_0 = 1e-9 m/s, m_vl = 4 1/MPa.
    fn layer(drainage: Drainage) -> LargeStrainLayer {
        LargeStrainLayer { height: 10.0, modulus: 250e3, conductivity: 1e-9, unit_weight: 10e3, load: 100e3, drainage }
    }

    /// Times (s) of figure 6 of the source.
    const TIMES: [f64; 10] = [
        4.0e6,
        9.30767268e6,
        2.16581927e7,
        5.0396842e7,
        1.17269327e8,
        2.72876128e8,
        6.34960421e8,
        1.47750094e9,
        3.43802378e9,
        8.0e9,
    ];

    /// Half of the last of the eight printed decimals, and a little for the nine printed digits of the times.
    const PRINTED: f64 = 6e-9;

    fn assert_curve(expected: [f64; 10], curve: impl Fn(f64) -> f64) {
        for (time, expected) in TIMES.into_iter().zip(expected) {
            let value = curve(time);
            assert!((value - expected).abs() <= PRINTED, "{value} is not {expected} at {time}");
        }
    }

    /// Figure 6 as computed by geotecha (`test_xieandleo2004.py`), all printed digits. There, q_p = 10 kPa too.
    #[test]
    fn the_curves_of_figure_6_drained_at_the_top() {
        let layer = layer(Drainage::Top);
        let settlement = [
            0.11763799, 0.17944781, 0.27373398, 0.41756036, 0.63695657, 0.97162877, 1.48178939, 2.22256023, 2.97627998,
            3.27758078,
        ];
        let by_settlement = [
            0.03568248, 0.05443091, 0.08303022, 0.12665628, 0.19320452, 0.29471879, 0.44946299, 0.67415692, 0.90277857,
            0.99417048,
        ];
        let by_pressure = [
            0.0328077, 0.05004566, 0.07634084, 0.11645214, 0.17763889, 0.27097897, 0.4141635, 0.63411239, 0.88384332,
            0.99284489,
        ];
        assert_curve(settlement, |time| layer.settlement(0.0, time));
        assert_curve(by_settlement, |time| layer.degree_by_settlement(time));
        assert_curve(by_pressure, |time| layer.degree_by_pressure(time));
    }

    /// The same, drained at both ends.
    #[test]
    fn the_curves_of_figure_6_drained_at_both_ends() {
        let layer = layer(Drainage::TopAndBase);
        let settlement = [
            0.23527598, 0.35889561, 0.54746796, 0.83512073, 1.27388766, 1.93317306, 2.73900674, 3.22703668, 3.29624648,
            3.29679953,
        ];
        let by_settlement = [
            0.07136496, 0.10886182, 0.16606043, 0.25331256, 0.38640131, 0.58637871, 0.83080779, 0.97883922, 0.99983224,
            1.0,
        ];
        let by_pressure = [
            0.06561541, 0.10009131, 0.15268168, 0.2329045, 0.35547031, 0.54565008, 0.80191869, 0.97414702, 0.99979374,
            1.0,
        ];
        assert_curve(settlement, |time| layer.settlement(0.0, time));
        assert_curve(by_settlement, |time| layer.degree_by_settlement(time));
        assert_curve(by_pressure, |time| layer.degree_by_pressure(time));
    }

    /// Time (s), depth (m), excess pressure (kPa), stretch, settlement (m), by an independent program in double
    /// precision.
    const PROFILES: [(f64, f64, f64, f64, f64); 12] = [
        (10000000.0, 0.0, 0.0, 0.6703200460356393, 0.18600199593119607),
        (10000000.0, 0.5, 56.98196108326059, 0.8419184217914999, 0.06581771097980967),
        (10000000.0, 2.5, 99.96645676920973, 0.999865836077623, 2.365851644960922e-05),
        (282747780.0, 0.0, 0.0, 0.6703200460356393, 0.9890475838769766),
        (282747780.0, 2.5, 54.36245589413536, 0.8331428387516434, 0.37575922749970747),
        (282747780.0, 7.5, 96.09912730600588, 0.984517612987561, 0.021063578669841137),
        (787244369.0, 0.5, 7.5955146193587035, 0.6909982819632401, 1.489065184410113),
        (787244369.0, 5.0, 60.604840543258454, 0.8542079293599779, 0.4883508858576758),
        (787244369.0, 7.5, 75.94652688078203, 0.9082697232297893, 0.198417132713965),
        (1146718300.0, 2.5, 27.988520669177163, 0.7497271659840058, 1.2553824258121957),
        (3396496310.0, 2.5, 7.265588313830937, 0.6900869693863102, 2.168794688283677),
        (3396496310.0, 5.0, 13.263874963632647, 0.7068445569392322, 1.415877517082181),
    ];

    #[test]
    fn profiles_agree_with_an_independent_program() {
        let layer = layer(Drainage::Top);
        for (time, depth, pressure, stretch, settlement) in PROFILES {
            // Relative 1e-9, and the independent program's own rounding where it takes the difference of numbers near
            // one.
            let close = |value: f64, expected: f64| {
                assert!((value - expected).abs() <= 1e-9 * expected + 1e-14, "{value} is not {expected}");
            };
            close(layer.pressure(depth, time) / 1e3, pressure);
            close(layer.stretch(depth, time), stretch);
            close(layer.settlement(depth, time), settlement);
        }
    }

    /// A small load consolidates as Terzaghi says, up to the strain, q/M_0 = 1e-6.
    #[test]
    fn a_small_load_is_terzaghis() {
        for drainage in [Drainage::Top, Drainage::TopAndBase] {
            let small = LargeStrainLayer { load: 0.25, ..layer(drainage) };
            let linear = Consolidation {
                layer: Layer {
                    height: 10.0,
                    modulus: 250e3,
                    conductivity: 1e-9,
                    unit_weight: 10e3,
                    fluid_compressibility: 0.0,
                },
                ramp: Ramp { load: 0.25, duration: 0.0 },
                drainage,
            };
            for time in [1e7, 3e8, 3e9] {
                assert!((small.pressure(4.0, time) - linear.pressure(4.0, time)).abs() < 1e-6 * 0.25);
                assert!((small.settlement(4.0, time) - linear.settlement_at(4.0, time)).abs() < 1e-6 * 1e-5);
                assert!((small.degree_by_pressure(time) - linear.degree(time)).abs() < 1e-6);
            }
        }
    }

    /// Water that leaves by Darcy's law in the deformed layer, k J²/γ_w · ∂u/∂(a J), is the volume that the layer
    /// loses: both by differences at a point inside, to the 1e-6 that central differences give here.
    #[test]
    fn the_water_balance_closes_in_the_deformed_layer() {
        let layer = layer(Drainage::Top);
        for (depth, time) in [(1.0, 2e8), (4.0, 8e8), (7.0, 2e9)] {
            let (step, dt) = (1e-2, 1e-3 * time);
            let conductivity = 1e-9 * layer.stretch(depth, time).powi(2);
            let gradient = (layer.pressure(depth + step, time) - layer.pressure(depth - step, time))
                / (2.0 * step * layer.stretch(depth, time));
            let outflow = conductivity / layer.unit_weight * gradient;
            let loss = (layer.settlement(depth, time + dt) - layer.settlement(depth, time - dt)) / (2.0 * dt);
            assert!((outflow - loss).abs() < 2e-6 * loss, "{outflow} is not {loss}");
        }
    }

    /// Stretch from the stress: the law σ' = σ'_0 + M_0 ln J, with σ' − σ'_0 = −(q − u).
    #[test]
    fn stress_and_stretch_obey_the_law() {
        let layer = layer(Drainage::TopAndBase);
        for (depth, time) in [(0.5, 1e7), (5.0, 3e8), (8.0, 3e9)] {
            let stress = -(layer.load - layer.pressure(depth, time));
            assert!((stress - layer.modulus * layer.stretch(depth, time).ln()).abs() < 1e-9 * layer.load);
        }
        assert_eq!(layer.stretch(3.0, 0.0), 1.0);
    }

    /// The weight of what lies above, grain by grain: midpoint sum of γ_w (G_s − 1)/(1 + e) over 1000 slices, error
    /// 1e-7.
    #[test]
    fn before_loading_the_layer_carries_its_buoyant_weight() {
        let layer = layer(Drainage::Top);
        let before = Before { preload: 10e3, void_ratio: 3.0, specific_gravity: 2.75 };
        let slice = |i: usize| 10e3 * 1.75 / (1.0 + before.void_ratio(layer, (i as f64 + 0.5) * 0.01)) * 0.01;
        let weight: f64 = (0..1000).map(slice).sum();
        assert!((before.stress(layer, 10.0) + 10e3 + weight).abs() < 1e-6 * weight);
        assert!((before.void_ratio(layer, 10.0) - 2.3).abs() < 1e-14, "3 − 0.004 · 10 · 1.75 · 10");
    }
}
