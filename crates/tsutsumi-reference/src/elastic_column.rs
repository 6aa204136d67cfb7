//! An elastic column at rest under gravity and a load, and elastic bars that vibrate.

use std::f64::consts::{PI, TAU};

use schemars::JsonSchema;
use serde::Deserialize;

/// A laterally confined elastic column on a rigid base, at rest, dry or filled with water up to its top.
///
/// Small strains; all excess pore pressure is gone, and the load is carried by the skeleton. The column was free of
/// stress and unstrained before gravity and load.
///
/// # Equation
///
/// ```text
/// p_w = ρ_f g z          σ'_v = −[(ρ − ρ_f) g z + q]          σ'_h = K_0 σ'_v          K_0 = ν/(1 − ν)
/// s(z) = 1/E_oed [(ρ − ρ_f) g (H² − z²)/2 + q (H − z)]        E_oed = E (1 − ν)/[(1 + ν)(1 − 2ν)]
/// ```
///
/// `z` is the depth below the top, `s` the settlement.
///
/// # Reference
///
/// Equilibrium and Hooke's law in uniaxial strain; any textbook of soil mechanics.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticColumn {
    /// Height H (m).
    pub height: f64,
    /// Young's modulus E of the skeleton (Pa).
    pub young: f64,
    /// Poisson's ratio ν of the skeleton (–), less than ½.
    pub poisson: f64,
    /// Density ρ of the ground, with its water (kg/m³).
    pub density: f64,
    /// Density ρ_f of the water (kg/m³); zero for dry ground.
    #[serde(default)]
    pub fluid_density: f64,
    /// Gravity g (m/s²).
    pub gravity: f64,
    /// Load q on the top (Pa, positive in compression).
    #[serde(default)]
    pub load: f64,
}

/// The ends of a vibrating bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BarEnds {
    /// Fixed at x = 0, free at x = L.
    #[default]
    FixedFree,
    /// Fixed at both ends.
    FixedFixed,
    /// Free at both ends.
    FreeFree,
}

/// A standing axial wave in an elastic bar, which passes through the unstrained state at time zero.
///
/// Small strains; one-dimensional. Energies are per cross-section.
///
/// # Equation
///
/// ```text
/// u = v_0/ω sin(β x) sin(ω t)        σ = E β v_0/ω cos(β x) sin(ω t)        ω = β √(E/ρ)
/// β = (m − ½) π/L  fixed–free,       β = m π/L  fixed–fixed                 m = 1, 2, …
/// u = v_0/ω cos(β x) sin(ω t)        β = m π/L  free–free
/// kinetic energy  ρ v_0² L/4 cos²(ω t)        strain energy  ρ v_0² L/4 sin²(ω t)
/// ```
///
/// # Reference
///
/// The wave equation ρ ü = E u″; as a test of material point codes in Bardenhagen, Journal of Computational Physics 180
/// (2002) 383–403 (cited from memory, not re-read).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VibratingBar {
    /// Length L (m).
    pub length: f64,
    /// Stiffness E against stretching (Pa): Young's modulus of a slender bar, the oedometric modulus of a confined
    /// column.
    pub modulus: f64,
    /// Density ρ (kg/m³).
    pub density: f64,
    /// The largest velocity v_0 (m/s), which a belly of the wave has at time zero.
    pub velocity: f64,
    /// The mode m, counted from one.
    pub mode: u32,
    /// How the ends are held.
    #[serde(default)]
    pub ends: BarEnds,
}

impl ElasticColumn {
    /// The oedometric modulus E_oed (Pa).
    pub fn oedometric_modulus(&self) -> f64 {
        self.young * (1.0 - self.poisson) / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }

    /// The earth pressure coefficient at rest K_0 (–) of a confined elastic column.
    pub fn rest_coefficient(&self) -> f64 {
        self.poisson / (1.0 - self.poisson)
    }

    /// The pore pressure p_w (Pa, positive in compression) at a depth (m).
    pub fn pressure(&self, depth: f64) -> f64 {
        self.fluid_density * self.gravity * depth
    }

    /// The vertical effective stress σ'_v (Pa, positive in tension) at a depth (m).
    pub fn vertical_stress(&self, depth: f64) -> f64 {
        -(self.buoyant_unit_weight() * depth + self.load)
    }

    /// The horizontal effective stress σ'_h (Pa, positive in tension) at a depth (m).
    pub fn horizontal_stress(&self, depth: f64) -> f64 {
        self.rest_coefficient() * self.vertical_stress(depth)
    }

    /// The settlement (m, positive downwards) of the point at a depth (m).
    pub fn settlement(&self, depth: f64) -> f64 {
        let weight = 0.5 * self.buoyant_unit_weight() * (self.height * self.height - depth * depth);
        (weight + self.load * (self.height - depth)) / self.oedometric_modulus()
    }

    /// The natural frequency (Hz) of the column's first mode of compression, √(E_oed/ρ)/(4 H).
    ///
    /// For a dry column; with water, the skeleton's stiffness alone with the mass of all, which is the limit of water
    /// that neither carries pressure nor moves against the skeleton.
    pub fn natural_frequency(&self) -> f64 {
        (self.oedometric_modulus() / self.density).sqrt() / (4.0 * self.height)
    }

    /// (ρ − ρ_f) g (N/m³).
    fn buoyant_unit_weight(&self) -> f64 {
        (self.density - self.fluid_density) * self.gravity
    }
}

impl VibratingBar {
    /// The natural frequency ω/2π of the mode (Hz).
    pub fn frequency(&self) -> f64 {
        self.angular_frequency() / TAU
    }

    /// The displacement u (m) at a position (m) along the bar, at a time (s).
    pub fn displacement(&self, position: f64, time: f64) -> f64 {
        let frequency = self.angular_frequency();
        self.velocity / frequency * self.mode_shape(position) * (frequency * time).sin()
    }

    /// The velocity (m/s) at a position (m) along the bar, at a time (s).
    pub fn velocity(&self, position: f64, time: f64) -> f64 {
        self.velocity * self.mode_shape(position) * (self.angular_frequency() * time).cos()
    }

    /// The stress σ (Pa, positive in tension) at a position (m) along the bar, at a time (s).
    pub fn stress(&self, position: f64, time: f64) -> f64 {
        let (number, frequency) = (self.wave_number(), self.angular_frequency());
        let slope = match self.ends {
            BarEnds::FreeFree => -(number * position).sin(),
            BarEnds::FixedFree | BarEnds::FixedFixed => (number * position).cos(),
        };
        self.modulus * number * self.velocity / frequency * slope * (frequency * time).sin()
    }

    /// The mean velocity over the bar (m/s), which is that of its centre of mass, at a time (s).
    pub fn mean_velocity(&self, time: f64) -> f64 {
        let phase = self.wave_number() * self.length;
        let mean = match self.ends {
            BarEnds::FreeFree => phase.sin() / phase,
            BarEnds::FixedFree | BarEnds::FixedFixed => (1.0 - phase.cos()) / phase,
        };
        self.velocity * mean * (self.angular_frequency() * time).cos()
    }

    /// The kinetic energy (J/m²) at a time (s).
    pub fn kinetic_energy(&self, time: f64) -> f64 {
        self.energy() * (self.angular_frequency() * time).cos().powi(2)
    }

    /// The strain energy (J/m²) at a time (s).
    pub fn strain_energy(&self, time: f64) -> f64 {
        self.energy() * (self.angular_frequency() * time).sin().powi(2)
    }

    /// The sum of kinetic and strain energy (J/m²), which does not change.
    pub fn energy(&self) -> f64 {
        0.25 * self.density * self.velocity * self.velocity * self.length
    }

    /// The largest displacement v_0/ω (m), which a belly of the wave has.
    pub fn amplitude(&self) -> f64 {
        self.velocity / self.angular_frequency()
    }

    /// The motion at a position (m) over that of a belly (–).
    fn mode_shape(&self, position: f64) -> f64 {
        let phase = self.wave_number() * position;
        match self.ends {
            BarEnds::FreeFree => phase.cos(),
            BarEnds::FixedFree | BarEnds::FixedFixed => phase.sin(),
        }
    }

    /// β (1/m).
    fn wave_number(&self) -> f64 {
        let half_waves = match self.ends {
            BarEnds::FixedFree => f64::from(self.mode) - 0.5,
            BarEnds::FixedFixed | BarEnds::FreeFree => f64::from(self.mode),
        };
        half_waves * PI / self.length
    }

    /// ω (1/s).
    fn angular_frequency(&self) -> f64 {
        self.wave_number() * (self.modulus / self.density).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Morikawa & Asai, table 1: E = 10 MPa, ν = 0.3, grains of 2800 kg/m³, porosity 0.3.
    fn column() -> ElasticColumn {
        ElasticColumn {
            height: 2.0,
            young: 10e6,
            poisson: 0.3,
            density: 0.7 * 2800.0 + 0.3 * 1000.0,
            fluid_density: 1000.0,
            gravity: 9.81,
            load: 5e3,
        }
    }

    fn bar(ends: BarEnds) -> VibratingBar {
        VibratingBar { length: 25.0, modulus: 100.0, density: 1.0, velocity: 0.1, mode: 2, ends }
    }

    /// The vertical stress from Hooke's law in three dimensions with the horizontal strains held at zero, and the
    /// strain from the settlement; grains under buoyancy weigh (1 − n)(ρ_s − ρ_f) g.
    #[test]
    fn stresses_obey_hookes_law_and_carry_the_grains() {
        let column = column();
        let (lame, shear) = (10e6 * 0.3 / (1.3 * 0.4), 10e6 / 2.6);
        for depth in [0.0, 0.7, 2.0] {
            // Quadratic in the depth, so that central differences are exact up to rounding (1e-9 relative here).
            let strain = (column.settlement(depth + 1e-3) - column.settlement(depth - 1e-3)) / 2e-3;
            let (vertical, horizontal) = (column.vertical_stress(depth), column.horizontal_stress(depth));
            assert!((vertical - (lame + 2.0 * shear) * strain).abs() < 1e-8 * vertical.abs());
            assert!((horizontal - lame * strain).abs() < 1e-8 * horizontal.abs());
            let grains = 0.7 * 1800.0 * 9.81 * depth;
            assert!((vertical + 5e3 + grains).abs() < 1e-9);
            assert!((vertical - column.pressure(depth) + 5e3 + column.density * 9.81 * depth).abs() < 1e-9);
        }
        assert_eq!(column.settlement(2.0), 0.0);
    }

    /// The frequency of a chain of 400 masses and springs, by Rayleigh's quotient after inverse iteration. The chain
    /// with half a mass at its end is second order: 1 − (π/2/400)²/24 of the exact frequency, 6e-7.
    #[test]
    fn the_first_frequency_is_that_of_a_chain_of_springs() {
        let column = column();
        let count = 400;
        let spring = column.oedometric_modulus() / (2.0 / count as f64);
        let mass = |i: usize| column.density * 2.0 / count as f64 * if i == count { 0.5 } else { 1.0 };
        let mut shape: Vec<f64> = (0..=count).map(|i| i as f64).collect();
        let mut quotient = 0.0;
        for _ in 0..20 {
            let load: Vec<f64> = (0..=count).map(|i| mass(i) * shape[i]).collect();
            let mut deflection = vec![0.0; count + 1];
            let mut force: f64 = load[1..].iter().sum();
            for i in 1..=count {
                deflection[i] = deflection[i - 1] + force / spring;
                force -= load[i];
            }
            let work: f64 = (1..=count).map(|i| deflection[i] * load[i]).sum();
            let inertia: f64 = (1..=count).map(|i| mass(i) * deflection[i] * deflection[i]).sum();
            quotient = work / inertia;
            let top = deflection[count];
            shape = deflection.iter().map(|value| value / top).collect();
        }
        let frequency = quotient.sqrt() / TAU;
        assert!((column.natural_frequency() / frequency - 1.0).abs() < 1e-6, "{frequency}");
        let bar = VibratingBar {
            length: 2.0,
            modulus: column.oedometric_modulus(),
            density: column.density,
            velocity: 1.0,
            mode: 1,
            ends: BarEnds::FixedFree,
        };
        assert!((bar.frequency() / frequency - 1.0).abs() < 1e-6);
    }

    /// ρ ∂v/∂t = ∂σ/∂x, σ = E ∂u/∂x and v = ∂u/∂t by central differences, whose error is (β Δx)²/6 = 1e-7 of the
    /// amplitudes.
    #[test]
    fn the_standing_wave_obeys_the_wave_equation() {
        for ends in [BarEnds::FixedFree, BarEnds::FixedFixed, BarEnds::FreeFree] {
            let bar = bar(ends);
            let (dx, dt) = (2e-3, 2e-4);
            let amplitude = 0.1 * 10.0;
            for (x, t) in [(3.0, 0.4), (11.0, 1.3), (20.0, 5.0)] {
                let strain = (bar.displacement(x + dx, t) - bar.displacement(x - dx, t)) / (2.0 * dx);
                assert!((bar.stress(x, t) - bar.modulus * strain).abs() < 1e-6 * amplitude);
                let velocity = (bar.displacement(x, t + dt) - bar.displacement(x, t - dt)) / (2.0 * dt);
                assert!((bar.velocity(x, t) - velocity).abs() < 1e-6 * 0.1);
                let acceleration = (bar.velocity(x, t + dt) - bar.velocity(x, t - dt)) / (2.0 * dt);
                let force = (bar.stress(x + dx, t) - bar.stress(x - dx, t)) / (2.0 * dx);
                assert!((bar.density * acceleration - force).abs() < 1e-6 * amplitude);
            }
        }
        // A free end carries no stress, a fixed one does not move.
        assert_eq!(bar(BarEnds::FixedFree).velocity(0.0, 0.3), 0.0);
        assert_eq!(bar(BarEnds::FixedFixed).velocity(0.0, 0.3), 0.0);
        assert_eq!(bar(BarEnds::FreeFree).stress(0.0, 1.0), 0.0);
        assert!(bar(BarEnds::FreeFree).stress(25.0, 1.0).abs() < 1e-14);
        assert!(bar(BarEnds::FixedFree).stress(25.0, 1.0).abs() < 1e-14);
        assert!(bar(BarEnds::FixedFixed).velocity(25.0, 1.0).abs() < 1e-15);
    }

    /// Energies and mean velocity are integrals over the bar: midpoint rule on 2000 intervals, exact for whole half
    /// waves' squares and to 3e-6 for the mean velocity.
    #[test]
    fn energies_and_mean_velocity_are_integrals_over_the_bar() {
        for ends in [BarEnds::FixedFree, BarEnds::FixedFixed, BarEnds::FreeFree] {
            let bar = bar(ends);
            let (count, interval, time) = (2000, 25.0 / 2000.0, 1.7);
            let integrate = |function: &dyn Fn(f64) -> f64| {
                (0..count).map(|i| function((i as f64 + 0.5) * interval)).sum::<f64>() * interval
            };
            let kinetic = integrate(&|x| 0.5 * bar.density * bar.velocity(x, time).powi(2));
            let strain = integrate(&|x| 0.5 * bar.stress(x, time).powi(2) / bar.modulus);
            let mean = integrate(&|x| bar.velocity(x, time)) / 25.0;
            assert!((bar.kinetic_energy(time) - kinetic).abs() < 1e-12);
            assert!((bar.strain_energy(time) - strain).abs() < 1e-12);
            assert!((bar.energy() - kinetic - strain).abs() < 1e-12);
            assert!((bar.mean_velocity(time) - mean).abs() < 3e-6 * 0.1);
        }
    }
}
