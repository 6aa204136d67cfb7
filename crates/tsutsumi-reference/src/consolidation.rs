//! One-dimensional consolidation (Terzaghi) with a compressible fluid.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::modes::Sum;

/// A layer on an impermeable rigid base, drained and loaded at its top.
///
/// Small strains, linear elastic skeleton, no inertia. With an incompressible fluid set `fluid_compressibility` to
/// zero.
///
/// # Equation
///
/// ```text
/// p_w(z,t) = Σ_m b_m(t) sin(M_m z/H)          M_m = (m + ½) π          λ_m = M_m² c_v / H²
/// c_v = (k/γ_w) / (1/E_oed + n/K^f)           β = (K^f/n) / (K^f/n + E_oed)
///
/// step:  b_m = β 2 q/M_m e^(−λ_m t)
/// ramp:  b_m = β 2 q/(M_m t_r λ_m) (1 − e^(−λ_m t))   for t ≤ t_r,   then decaying with e^(−λ_m (t − t_r))
/// s(z,t) = H/E_oed [q(t) (1 − z/H) − Σ_m b_m/M_m cos(M_m z/H)]
/// ```
///
/// `z` is the depth below the drained top, `β q` the pressure that an undrained load leaves, `s(0,t)` the settlement of
/// the top.
///
/// # Reference
///
/// Terzaghi's theory; the ramp by superposition. For t ≤ t_r the undecaying part is summed in closed form,
/// Σ 2/M³ sin(M ζ) = ζ − ζ²/2.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// Thickness H (m).
    pub height: f64,
    /// Oedometric modulus of the skeleton E_oed (Pa).
    pub modulus: f64,
    /// Hydraulic conductivity k (m/s).
    pub conductivity: f64,
    /// Unit weight of the fluid γ_w (N/m³).
    pub unit_weight: f64,
    /// Porosity over bulk modulus of the fluid, n/K^f (1/Pa).
    pub fluid_compressibility: f64,
}

/// A load on the top of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// The final load q (Pa, positive in compression).
    pub load: f64,
    /// The time t_r over which it grows linearly (s); zero for a load put on at once.
    pub duration: f64,
}

/// Where water can leave a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Drainage {
    /// At the top; the base is impermeable.
    #[default]
    Top,
    /// At the top and at the base.
    TopAndBase,
}

/// A layer under a ramp, drained at its top or at both ends.
///
/// # Equation
///
/// A layer drained at both ends is two layers of half the thickness, back to back, each drained at one end: nothing
/// flows through the middle.
///
/// # Reference
///
/// Terzaghi's theory, as in [`Layer`], which is the case [`Drainage::Top`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Consolidation {
    /// The layer; its base is rigid.
    pub layer: Layer,
    /// The load on its top.
    pub ramp: Ramp,
    /// Where water leaves it.
    #[serde(default)]
    pub drainage: Drainage,
}

impl Layer {
    /// The coefficient of consolidation c_v (m²/s).
    pub fn consolidation_coefficient(&self) -> f64 {
        self.conductivity / self.unit_weight / (1.0 / self.modulus + self.fluid_compressibility)
    }

    /// The share β of an undrained load that the fluid takes at once (–).
    pub fn undrained_share(&self) -> f64 {
        1.0 / (1.0 + self.modulus * self.fluid_compressibility)
    }

    /// The pore pressure p_w (Pa) at a depth (m) below the drained top, at a time (s).
    pub fn pressure(&self, ramp: Ramp, depth: f64, time: f64) -> f64 {
        self.respond(ramp, time, Sum::Pressure(depth / self.height))
    }

    /// The settlement of the top (m, positive downwards) at a time (s).
    pub fn settlement(&self, ramp: Ramp, time: f64) -> f64 {
        self.settlement_at(ramp, 0.0, time)
    }

    /// The settlement (m, positive downwards) of the point at a depth (m), at a time (s).
    pub fn settlement_at(&self, ramp: Ramp, depth: f64, time: f64) -> f64 {
        let depth = depth / self.height;
        let undrained = self.respond(ramp, time, Sum::Below(depth));
        self.height / self.modulus * (ramp.load_at(time) * (1.0 - depth) - undrained)
    }

    /// The degree of consolidation U (–) at a time (s): settlement of the top over its final value.
    ///
    /// With a compressible fluid a load put on at once settles by `1 − β` of the final value before any water drains.
    pub fn degree(&self, ramp: Ramp, time: f64) -> f64 {
        self.settlement(ramp, time) / self.settlement_final(ramp)
    }

    /// The settlement of the top (m, positive downwards) when all excess pressure is gone.
    pub fn settlement_final(&self, ramp: Ramp) -> f64 {
        self.height * ramp.load / self.modulus
    }

    /// The response to the ramp: an endless one minus a later endless one.
    fn respond(&self, ramp: Ramp, time: f64, sum: Sum) -> f64 {
        let rate = self.consolidation_coefficient() / (self.height * self.height);
        let load = self.undrained_share() * ramp.load;
        if ramp.duration > 0.0 {
            let endless = |time: f64| {
                if time > 0.0 { sum.steady() - sum.decaying_cubed(rate * time) } else { 0.0 }
            };
            load / (ramp.duration * rate) * (endless(time) - endless(time - ramp.duration))
        } else if time > 0.0 {
            load * sum.decaying(rate * time)
        } else {
            0.0
        }
    }
}

impl Ramp {
    /// The load (Pa, positive in compression) at a time (s); zero at time zero, also where it is put on at once.
    pub fn load_at(&self, time: f64) -> f64 {
        if time <= 0.0 {
            0.0
        } else if time >= self.duration {
            self.load
        } else {
            self.load * time / self.duration
        }
    }
}

impl Consolidation {
    /// The pore pressure p_w (Pa) at a depth (m) below the top, at a time (s).
    pub fn pressure(&self, depth: f64, time: f64) -> f64 {
        match self.drainage {
            Drainage::Top => self.layer.pressure(self.ramp, depth, time),
            Drainage::TopAndBase => self.half().pressure(self.ramp, depth.min(self.layer.height - depth), time),
        }
    }

    /// The settlement of the top (m, positive downwards) at a time (s).
    pub fn settlement(&self, time: f64) -> f64 {
        self.settlement_at(0.0, time)
    }

    /// The settlement (m, positive downwards) of the point at a depth (m), at a time (s).
    pub fn settlement_at(&self, depth: f64, time: f64) -> f64 {
        let height = self.layer.height;
        match self.drainage {
            Drainage::Top => self.layer.settlement_at(self.ramp, depth, time),
            Drainage::TopAndBase => {
                let half = self.half();
                let of_half = half.settlement(self.ramp, time);
                // The compression of the lower half mirrors that of the upper one.
                if depth < 0.5 * height {
                    of_half + half.settlement_at(self.ramp, depth, time)
                } else {
                    of_half - half.settlement_at(self.ramp, height - depth, time)
                }
            }
        }
    }

    /// The degree of consolidation U (–) at a time (s): settlement of the top over its final value; see
    /// [`Layer::degree`].
    pub fn degree(&self, time: f64) -> f64 {
        self.settlement(time) / self.layer.settlement_final(self.ramp)
    }

    /// The upper half of a layer drained at both ends.
    fn half(&self) -> Layer {
        Layer { height: 0.5 * self.layer.height, ..self.layer }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closeness::assert_close;

    /// The material of Goto et al. with an incompressible fluid: c_v = 0.0928 m²/s.
    fn layer(height: f64) -> Layer {
        let (modulus, conductivity, unit_weight) = (16.5e6, 5.52e-5, 9810.0);
        Layer { height, modulus, conductivity, unit_weight, fluid_compressibility: 0.0 }
    }

    const RAMP: Ramp = Ramp { load: 50e3, duration: 1000.0 };

    /// Terzaghi's table: base p_w/q, mid-height p_w/q and U at time factors T, five digits (Taylor 1948 and every
    /// textbook since; recomputed independently).
    #[test]
    fn a_load_put_on_at_once_follows_terzaghis_table() {
        let layer = Layer { height: 2.0, ..layer(2.0) };
        let step = Ramp { load: 1.0, duration: 0.0 };
        let table = [
            (0.01, 1.00000, 0.99959, 0.11284),
            (0.05, 0.99687, 0.88615, 0.25231),
            (0.1, 0.94931, 0.73565, 0.35682),
            (0.2, 0.77231, 0.55318, 0.50409),
            (0.5, 0.37078, 0.26219, 0.76395),
            (1.0, 0.10798, 0.07635, 0.93126),
        ];
        for (time_factor, base, middle, degree) in table {
            let time = time_factor * 4.0 / layer.consolidation_coefficient();
            assert_close(layer.pressure(step, 2.0, time), base, 5e-6);
            assert_close(layer.pressure(step, 1.0, time), middle, 5e-6);
            assert_close(layer.settlement(step, time) * layer.modulus / 2.0, degree, 5e-6);
        }
    }

    /// Base pressure and settlements under the ramp, computed with an independent program for three heights.
    #[test]
    fn the_ramp_of_the_papers_problem() {
        for (height, base, at_1000, at_2000) in [
            (1.0, 0.269e3, 3.019e-3, 3.030e-3),
            (5.0, 6.731e3, 13.792e-3, 15.151e-3),
            (10.0, 24.115e3, 20.508e-3, 29.328e-3),
        ] {
            let layer = layer(height);
            assert_close(layer.pressure(RAMP, height, 1000.0), base, 0.5);
            assert_close(layer.settlement(RAMP, 1000.0), at_1000, 0.5e-6);
            assert_close(layer.settlement(RAMP, 2000.0), at_2000, 0.5e-6);
        }
    }

    /// OpenSees 3.7 quadUP (100 elements, Δt 0.1 s) for the same column with n = 0.4, K_f = 2.2 GPa: its stated
    /// accuracy is 6e-6 of the largest settlement and 2e-5 of the largest pressure.
    #[test]
    fn the_ramp_agrees_with_opensees() {
        let layer = Layer { fluid_compressibility: 0.4 / 2.2e9, unit_weight: 9800.0, ..layer(10.0) };
        for (time, settlement, base) in OPENSEES {
            assert_close(layer.settlement(RAMP, time), settlement, 6e-6 * 0.0303 + 1e-9);
            assert_close(layer.pressure(RAMP, 10.0, time), base, 2e-5 * 24.2e3);
        }
    }

    /// Time (s), settlement (m), base pressure (Pa).
    const OPENSEES: [(f64, f64, f64); 4] = [
        (100.0, 0.0007008875653637276, 4942.489664),
        (500.0, 0.007697965071021574, 18049.196405),
        (1000.0, 0.02052341682057426, 24077.997551),
        (2000.0, 0.02932509187306507, 2534.686598),
    ];

    /// OpenGeoSys 6.5, hydro-mechanics, 40 quadratic elements, Δt 0.5 s, same column: its accuracy is 1e-4 of the largest
    /// settlement and 2e-4 of the largest pressure. Time (s), settlement (m), pressures (Pa) 2.5 m deep and at the base.
    #[test]
    fn the_ramp_agrees_with_opengeosys() {
        let layer = Layer { fluid_compressibility: 0.4 / 2.2e9, unit_weight: 9800.0, ..layer(10.0) };
        for (time, settlement, middle, base) in [
            (100.0, 7.024770950e-4, 3191.988590, 4941.165193),
            (500.0, 7.700902863e-3, 8379.760720, 18044.314143),
            (1000.0, 2.052590211e-2, 10687.635825, 24074.926411),
            (1500.0, 2.723442816e-2, 3043.997837, 7954.216377),
            (2000.0, 2.932423133e-2, 970.941148, 2537.190581),
        ] {
            assert_close(layer.settlement(RAMP, time), settlement, 1e-4 * 0.0303);
            assert_close(layer.pressure(RAMP, 2.5, time), middle, 2e-4 * 24.2e3);
            assert_close(layer.pressure(RAMP, 10.0, time), base, 2e-4 * 24.2e3);
        }
    }

    #[test]
    fn a_short_ramp_is_a_load_put_on_at_once() {
        let layer = layer(10.0);
        let short = Ramp { duration: 1e-3, ..RAMP };
        let step = Ramp { duration: 0.0, ..RAMP };
        assert_close(layer.pressure(short, 7.0, 300.0), layer.pressure(step, 7.0, 300.0), 0.1);
    }

    /// Water drained (by Darcy's law at the top) plus water compressed is the settlement: an independent balance.
    #[test]
    fn the_water_balance_closes() {
        let layer = Layer { fluid_compressibility: 1e-8, ..layer(10.0) };
        let flow = |time: f64| {
            let gradient = layer.pressure(RAMP, 1e-6, time) / 1e-6;
            layer.conductivity / layer.unit_weight * gradient
        };
        // Simpson over the first 800 s; the flow starts like √t, hence the substitution t = s².
        let (count, end) = (2000, 800.0_f64.sqrt());
        let weight = |i: usize| {
            if i == 0 || i == count {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        let at = |i: usize| end * i as f64 / count as f64;
        let drained: f64 = (0..=count).map(|i| weight(i) * flow(at(i).powi(2)) * 2.0 * at(i)).sum::<f64>() * end
            / (3.0 * count as f64);
        let compressed: f64 = (0..1000)
            .map(|i| layer.pressure(RAMP, (i as f64 + 0.5) * 0.01, 800.0) * 0.01 * layer.fluid_compressibility)
            .sum();
        let settlement = layer.settlement(RAMP, 800.0);
        assert_close(drained + compressed, settlement, 2e-5 * settlement);
    }

    /// A point settles by the compression of what lies below it: the effective stress is integrated from the pressures
    /// by the midpoint rule, whose error on 4000 intervals stays below 2e-8 of the top's settlement.
    #[test]
    fn settlement_at_a_depth_is_the_compression_below_it() {
        for drainage in [Drainage::Top, Drainage::TopAndBase] {
            let problem = Consolidation { layer: layer(10.0), ramp: RAMP, drainage };
            for (depth, time) in [(0.0, 400.0), (3.0, 400.0), (7.0, 400.0), (3.0, 1500.0), (7.0, 1500.0)] {
                let count = 4000;
                let interval = (10.0 - depth) / count as f64;
                let stress =
                    |i: usize| RAMP.load_at(time) - problem.pressure(depth + (i as f64 + 0.5) * interval, time);
                let compression = (0..count).map(stress).sum::<f64>() * interval / problem.layer.modulus;
                assert_close(problem.settlement_at(depth, time), compression, 1e-7 * problem.settlement(time));
            }
        }
    }

    /// Crank–Nicolson on 100 intervals, both ends drained; second order in space and time, and nearly exact under
    /// a steady ramp (seen: 4e-8 of the load).
    #[test]
    fn drained_at_both_ends_agrees_with_finite_differences() {
        let problem = Consolidation { layer: layer(10.0), ramp: RAMP, drainage: Drainage::TopAndBase };
        let (intervals, dt) = (100, 2.0);
        let interval = 10.0 / intervals as f64;
        let mut pressure = vec![0.0; intervals + 1];
        let half = 0.5 * problem.layer.consolidation_coefficient() * dt / (interval * interval);
        for step in 0..400 {
            let source = RAMP.load_at((step + 1) as f64 * dt) - RAMP.load_at(step as f64 * dt);
            pressure = crank_nicolson(&pressure, half, source);
        }
        for (i, computed) in pressure.iter().enumerate() {
            assert_close(problem.pressure(i as f64 * interval, 800.0), *computed, 2e-7 * RAMP.load);
        }
    }

    /// One step of p_t = c_v p_zz + q_t between two drained ends: (1 + r) … solved by elimination.
    fn crank_nicolson(old: &[f64], half: f64, source: f64) -> Vec<f64> {
        let last = old.len() - 1;
        let (mut factor, mut right) = (vec![0.0; last + 1], vec![0.0; last + 1]);
        for i in 1..last {
            let explicit = old[i] + half * (old[i - 1] - 2.0 * old[i] + old[i + 1]) + source;
            let pivot = 1.0 + 2.0 * half - half * factor[i - 1];
            factor[i] = half / pivot;
            right[i] = (explicit + half * right[i - 1]) / pivot;
        }
        let mut new = vec![0.0; last + 1];
        for i in (1..last).rev() {
            new[i] = right[i] + factor[i] * new[i + 1];
        }
        new
    }

    /// Half the drainage path is a quarter of the time: U = 0.50409 (Terzaghi's table at T = 0.2) at T = 0.05.
    #[test]
    fn degrees_of_consolidation() {
        let step = Ramp { load: 1.0, duration: 0.0 };
        let both = Consolidation { layer: layer(2.0), ramp: step, drainage: Drainage::TopAndBase };
        let time = 0.05 * 4.0 / both.layer.consolidation_coefficient();
        assert_close(both.degree(time), 0.50409, 5e-6);
        assert_close(both.layer.degree(step, 4.0 * time), 0.50409, 5e-6);
        assert_close(both.layer.degree(step, time), 0.25231, 5e-6);
        // A fluid as stiff as the skeleton takes half of the load; the other half settles at once.
        let soft = Layer { fluid_compressibility: 1.0 / 16.5e6, ..layer(2.0) };
        // Whatever drains in 1 µs drains from a height of √(c_v t) = 0.2 mm of the 2 m.
        assert_close(soft.degree(step, 0.0), 0.0, 0.0);
        assert_close(soft.degree(step, 1e-6), 0.5, 1e-4);
    }
}
