//! A deep saturated column under a load put on at once: a damped wave that turns into diffusion.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::bessel::i0_scaled;
use crate::gauss_legendre::integrate_graded;

/// A saturated half-space in uniaxial strain, drained and loaded at once at its top.
///
/// Small strains, linear elastic skeleton, incompressible fluid and grains, no gravity. For a column of height H the
/// solution holds until the wave is back from the base, t < 2 H/c, and in effect longer, because the front is damped by
/// e^(−κ z/c).
///
/// # Equation
///
/// ```text
/// E ∂²u/∂z² = E a ∂²u/∂t² + E b ∂u/∂t         E b = γ_w/k         c = 1/√a         κ = b/(2a)
///
/// u(z,t) = q/(E √a) ∫_{√a z}^t e^(−κ τ) I₀(κ √(τ² − a z²)) dτ
/// ∂u/∂t  = q/(E √a) e^(−κ t) I₀(κ √(t² − a z²))              for t > √a z, before that zero
/// ```
///
/// `z` is the depth, `u` the displacement of the skeleton downwards, `E` the oedometric modulus; [`Formulation`] gives
/// `E a`.
///
/// # Reference
///
/// De Boer, Ehlers & Liu, Archive of Applied Mechanics 63 (1993) 59–72, for the full formulation; written from the
/// telegraph equation's fundamental solution, not copied from there.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {
    /// Oedometric modulus of the skeleton E (Pa).
    pub modulus: f64,
    /// Porosity n (–).
    pub porosity: f64,
    /// Density of the grains ρ_s (kg/m³); more than that of the fluid.
    pub grain_density: f64,
    /// Density of the fluid ρ_f (kg/m³).
    pub fluid_density: f64,
    /// Hydraulic conductivity k (m/s).
    pub conductivity: f64,
    /// Unit weight of the fluid γ_w (N/m³), which turns k into a resistance.
    pub unit_weight: f64,
    /// The load q put on at once (Pa, positive in compression).
    pub load: f64,
    /// How the fluid's inertia is taken into account.
    #[serde(default)]
    pub formulation: Formulation,
}

/// How the fluid's inertia is taken into account; a program must be compared with the formulation that it solves.
///
/// The wave speeds differ by a factor of two in ordinary ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Formulation {
    /// The fluid has its own acceleration: E a = (1 − n) ρ_s + ((1 − n)/n)² n ρ_f.
    Full,
    /// u–p: the fluid accelerates with the skeleton, also in Darcy's law: E a = ρ − ρ_f, with ρ = (1 − n) ρ_s + n ρ_f.
    #[default]
    Up,
    /// u–p without acceleration in Darcy's law: E a = ρ.
    UpWithoutFluidAcceleration,
}

impl HalfSpace {
    /// The displacement u of the skeleton (m, positive downwards) at a depth (m), at a time (s).
    pub fn displacement(&self, depth: f64, time: f64) -> f64 {
        let arrival = depth / self.wave_speed();
        if time <= arrival {
            return 0.0;
        }
        // With σ = √(τ² − a z²) as variable the front is at σ = 0, and the square root leaves the argument of I₀.
        // Halving the panels forty times reaches every scale: that of the arrival and that of the damping.
        let end = front_distance(time, arrival);
        let velocity = |sigma: f64| {
            let tau = sigma.hypot(arrival);
            self.velocity_behind(arrival, tau, sigma) * sigma / tau
        };
        integrate_graded(end, 40, velocity)
    }

    /// The velocity ∂u/∂t of the skeleton (m/s, positive downwards) at a depth (m), at a time (s).
    pub fn velocity(&self, depth: f64, time: f64) -> f64 {
        let arrival = depth / self.wave_speed();
        if time <= arrival { 0.0 } else { self.velocity_behind(arrival, time, front_distance(time, arrival)) }
    }

    /// The speed c of the front (m/s).
    pub fn wave_speed(&self) -> f64 {
        (self.modulus / self.inertia()).sqrt()
    }

    /// The coefficient of consolidation c_v (m²/s) of the diffusion that the motion turns into.
    pub fn consolidation_coefficient(&self) -> f64 {
        self.conductivity * self.modulus / self.unit_weight
    }

    /// The velocity at a time τ ≥ `arrival`, with σ = √(τ² − arrival²) given because it is the better known of the two.
    fn velocity_behind(&self, arrival: f64, tau: f64, sigma: f64) -> f64 {
        let damping = 0.5 * self.unit_weight / (self.conductivity * self.inertia());
        // e^(−κ τ) I₀(κ σ) with the exponentials joined: τ − σ = arrival²/(τ + σ).
        let excess = if arrival > 0.0 { arrival * arrival / (tau + sigma) } else { 0.0 };
        self.load / (self.inertia() * self.modulus).sqrt() * (-damping * excess).exp() * i0_scaled(damping * sigma)
    }

    /// E a, the mass that the skeleton moves (kg/m³).
    fn inertia(&self) -> f64 {
        let solid = 1.0 - self.porosity;
        let (grains, fluid) = (solid * self.grain_density, self.porosity * self.fluid_density);
        match self.formulation {
            Formulation::Full => grains + (solid / self.porosity).powi(2) * fluid,
            Formulation::Up => grains + fluid - self.fluid_density,
            Formulation::UpWithoutFluidAcceleration => grains + fluid,
        }
    }
}

/// √(τ² − arrival²) without cancellation.
fn front_distance(time: f64, arrival: f64) -> f64 {
    ((time - arrival) * (time + arrival)).sqrt()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// The column of de Boer, Ehlers & Liu: E = 20.1 MPa, ν = 0.2 (an oedometric modulus of 22.333 MPa), 3 kPa.
    fn column(formulation: Formulation) -> HalfSpace {
        HalfSpace {
            modulus: 20.1e6 * 0.8 / (1.2 * 0.6),
            porosity: 0.33,
            grain_density: 2000.0,
            fluid_density: 1000.0,
            conductivity: 0.01,
            unit_weight: 9810.0,
            load: 3000.0,
            formulation,
        }
    }

    #[test]
    fn speeds_of_the_published_column() {
        assert!((column(Formulation::Full).wave_speed() - 90.94).abs() < 0.005);
        assert!((column(Formulation::Up).wave_speed() - 182.57).abs() < 0.005);
        assert!((column(Formulation::Up).consolidation_coefficient() - 22.766).abs() < 5e-4);
    }

    /// Time (s), depth (m), displacement (mm) by the full formulation and by u–p, from another program's quadrature, to
    /// five decimals.
    const TABLE: [(f64, f64, f64, f64); 15] = [
        (0.005, 0.0, 0.04236, 0.04928),
        (0.01, 0.0, 0.06653, 0.07105),
        (0.02, 0.0, 0.09853, 0.10139),
        (0.05, 0.0, 0.15944, 0.16116),
        (0.1, 0.0, 0.22711, 0.22831),
        (0.2, 0.0, 0.32231, 0.32315),
        (0.3, 0.0, 0.39521, 0.39589),
        (0.01, 0.4, 0.0243, 0.02949),
        (0.05, 0.4, 0.11128, 0.11306),
        (0.1, 0.4, 0.17736, 0.17858),
        (0.3, 0.4, 0.34379, 0.34448),
        (0.02, 1.0, 0.01482, 0.0184),
        (0.05, 1.0, 0.05902, 0.06102),
        (0.1, 1.0, 0.1173, 0.11861),
        (0.3, 1.0, 0.27526, 0.27597),
    ];

    #[test]
    fn the_table_of_the_published_column() {
        let (full, up) = (column(Formulation::Full), column(Formulation::Up));
        for (time, depth, by_full, by_up) in TABLE {
            for (column, expected) in [(full, by_full), (up, by_up)] {
                let value = 1e3 * column.displacement(depth, time);
                assert!((value - expected).abs() < 5e-6, "{value} is not {expected} at {depth} m, {time} s");
            }
        }
    }

    /// Displacements (mm) by numerical inversion (de Hoog, 60 digits, mpmath) of the Laplace transform
    /// q e^(−λ z)/(E s λ), λ² = a s² + b s: no Bessel function and no integral over time.
    #[test]
    fn displacements_agree_with_the_inverted_laplace_transform() {
        let (full, up, darcy) = (Formulation::Full, Formulation::Up, Formulation::UpWithoutFluidAcceleration);
        for (formulation, depth, time, expected) in [
            (up, 0.0, 0.005, 0.0492786963540343),
            (up, 0.4, 0.01, 0.029494691498349),
            (up, 1.0, 0.02, 0.0184032638457378),
            (up, 1.0, 0.05, 0.0610165466769341),
            (up, 5.0, 0.1, 0.00168647059812476),
            (full, 0.0, 0.005, 0.0423560219297269),
            (full, 0.4, 0.01, 0.0243008852418074),
            (full, 1.0, 0.02, 0.0148196882834603),
            (full, 1.0, 0.05, 0.0590227968857425),
            (full, 5.0, 0.1, 0.00121353280085419),
            (darcy, 0.0, 0.005, 0.0459119370829608),
            (darcy, 0.4, 0.01, 0.0271174061270735),
            (darcy, 1.0, 0.02, 0.0167106344083858),
            (darcy, 1.0, 0.05, 0.0600442055541337),
            (darcy, 5.0, 0.1, 0.00145018615974087),
        ] {
            let value = 1e3 * column(formulation).displacement(depth, time);
            assert!((value / expected - 1.0).abs() < 1e-13, "{value} is not {expected}, {formulation:?}");
        }
    }

    /// Late, inertia is forgotten, and the top settles as a drained half-space does: u = 2 q/E √(c_v t/π). The first
    /// term left out is 1/(8 κ t) = 1.7e-7 of it here.
    #[test]
    fn late_settlement_is_diffusion() {
        let column = column(Formulation::Up);
        let time = 1000.0_f64;
        let diffusion = 2.0 * 3000.0 / column.modulus * (column.consolidation_coefficient() * time / PI).sqrt();
        let value = column.displacement(0.0, time);
        assert!((value / diffusion - 1.0).abs() < 2e-7, "{value} is not {diffusion}");
    }

    /// Without drag (k → ∞) the wave is d'Alembert's: u = q/(ρ c) (t − z/c). What drag is left is κ t = 4e-9.
    #[test]
    fn without_drag_the_wave_keeps_its_shape() {
        let column = HalfSpace { conductivity: 1e8, ..column(Formulation::Full) };
        let (speed, depth, time) = (column.wave_speed(), 3.0, 0.2);
        let expected = 3000.0 / (column.modulus / speed) * (time - depth / speed);
        assert!((column.displacement(depth, time) / expected - 1.0).abs() < 1e-8);
        assert_eq!(column.displacement(depth, 0.999 * depth / speed), 0.0);
        assert!((column.velocity(depth, time) * column.modulus / speed / 3000.0 - 1.0).abs() < 1e-8);
    }

    /// The momentum below a depth changes by the effective stress there and the drag below: at the top, where the
    /// stress is the load, q = E a d/dt ∫ v dz + (γ_w/k) ∫ v dz. Simpson in z on the part that moves; error 1e-9.
    #[test]
    fn momentum_balance_of_the_whole_half_space() {
        let column = column(Formulation::Up);
        let moving = |time: f64| {
            let front = column.wave_speed() * time * (1.0 - 1e-12);
            let (count, interval) = (2000, front / 2000.0);
            let weight = |i: usize| if i == 0 || i == count { 1.0 } else { [2.0, 4.0][i % 2] };
            (0..=count).map(|i| weight(i) * column.velocity(i as f64 * interval, time)).sum::<f64>() * interval / 3.0
        };
        let (time, dt) = (0.004, 1e-6);
        let rate = (moving(time + dt) - moving(time - dt)) / (2.0 * dt);
        let force = column.inertia() * rate + 9810.0 / 0.01 * moving(time);
        assert!((force / 3000.0 - 1.0).abs() < 1e-8, "{force}");
    }
}
