//! Mandel's problem: a saturated slab squeezed between two rigid, smooth, impermeable plates.
//!
//! ```text
//!            2F (per metre)
//!       ═══════╪═══════    plate
//!   p=0 │      y       │ p=0
//!       │      └ x     │         2b
//!       │              │
//!       ═══════╪═══════
//!              2a
//! ```
//!
//! The sides drain and soften first. The plates keep the slab plane, so the load moves to the stiff, undrained core,
//! whose pressure rises before it falls: the effect of Mandel and Cryer, which no uncoupled theory has.

use crate::drained_body::{DrainedBody, Part, Shape};
use crate::ground::Ground;

/// A slab of width 2a and height 2b in plane strain under the force 2F per metre.
///
/// # Equation
///
/// Nothing depends on y but u_y, and σ_xx = 0. With e = ε_yy and M = λ+2G, Hooke's law and ∫₀^a σ_yy dx = −F give
///
/// ```text
/// ε_xx = (p − λ e)/M        e = [2G ⟨p⟩ − F M/a] / (4G(λ+G))        σ_yy = −F/a + 2G/M (⟨p⟩ − p)
/// ```
///
/// and the balance of water becomes diffusion that is fed by the mean pressure ⟨p⟩ over the width,
///
/// ```text
/// (1/M + n/K^f) ṗ + G/(M(λ+G)) d⟨p⟩/dt = (k/γ_w) ∂²p/∂x² + Ḟ/(2a(λ+G))        p(±a) = 0
/// ```
///
/// For a load put on at once, with T = c t/a²,
///
/// ```text
/// p = 2 p₀ Σ_i sin α_i/(α_i − sin α_i cos α_i) (cos(α_i x/a) − cos α_i) e^(−α_i² T)
/// tan α_i = (1−ν)/(ν_u−ν) α_i        p₀ = F B (1+ν_u)/(3a)
/// ```
///
/// A ramp is the mean of steps shifted over its duration, term by term. Early times are found by Laplace inversion.
///
/// # Validity
///
/// Small strains, no inertia. Errors of some 1e-13 of p₀; any time, zero and the undrained state included.
///
/// # Example
///
/// ```
/// use tsutsumi_reference::{ground::Ground, mandel::Mandel};
///
/// let ground = Ground {
///     young: 10e6,
///     poisson: 0.2,
///     conductivity: 1e-5,
///     unit_weight: 9800.0,
///     porosity: 0.4,
///     fluid_modulus: f64::INFINITY,
/// };
/// let slab = Mandel { ground, half_width: 1.0, half_height: 1.0, force: 10e3, ramp: 0.0 };
/// // The core's pressure rises by a tenth before it falls.
/// let time = 0.05 / ground.consolidation_coefficient();
/// assert!((slab.pressure(0.0, time) / slab.undrained_pressure() - 1.09888).abs() < 5e-6);
/// ```
///
/// # Reference
///
/// J. Mandel, Géotechnique 3 (1953) 287–299; A.H.-D. Cheng, E. Detournay, A direct boundary element method for plane
/// strain poroelasticity, Int. J. Numer. Anal. Methods Geomech. 12 (1988) 551–572, for the compressible fluid.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mandel {
    /// The saturated ground.
    pub ground: Ground,
    /// Half of the width, a (m).
    pub half_width: f64,
    /// Half of the height, b (m).
    pub half_height: f64,
    /// Half of the force on each plate per metre of thickness, F (N/m, positive in compression).
    pub force: f64,
    /// The time over which the force grows linearly (s); zero, or left out, for a force put on at once.
    #[serde(default)]
    pub ramp: f64,
}

impl Mandel {
    /// The pore pressure (Pa) at a distance x from the middle (m, up to ±a) and a time (s).
    pub fn pressure(&self, x: f64, time: f64) -> f64 {
        self.body().pressure(Part::At(x.abs() / self.half_width), time)
    }

    /// The total vertical stress σ_yy (Pa, positive in tension) at a distance x from the middle (m) and a time (s).
    pub fn vertical_stress(&self, x: f64, time: f64) -> f64 {
        let share = 2.0 * self.ground.shear_modulus() / self.ground.oedometric_modulus();
        share * (self.mean_pressure(time) - self.pressure(x, time)) - self.mean_load(time)
    }

    /// The horizontal displacement u_x (m, positive along x) at a distance x from the middle (m) and a time (s).
    pub fn horizontal_displacement(&self, x: f64, time: f64) -> f64 {
        let within = self.body().pressure(Part::Within(x.abs() / self.half_width), time);
        let strain = self.vertical_strain(time);
        x * (within - self.ground.lame_modulus() * strain) / self.ground.oedometric_modulus()
    }

    /// The vertical displacement u_y (m, positive upwards) at a height y above the middle (m, up to ±b) and a time (s).
    ///
    /// At y = b it is the plate's, and negative.
    pub fn vertical_displacement(&self, y: f64, time: f64) -> f64 {
        y * self.vertical_strain(time)
    }

    /// The pressure p₀ that the whole force leaves undrained (Pa).
    pub fn undrained_pressure(&self) -> f64 {
        self.body().undrained
    }

    fn vertical_strain(&self, time: f64) -> f64 {
        let (shear, lame) = (self.ground.shear_modulus(), self.ground.lame_modulus());
        let modulus = self.ground.oedometric_modulus();
        (2.0 * shear * self.mean_pressure(time) - modulus * self.mean_load(time)) / (4.0 * shear * (lame + shear))
    }

    fn mean_pressure(&self, time: f64) -> f64 {
        self.body().pressure(Part::Within(1.0), time)
    }

    /// F/a (Pa) at a time (s).
    fn mean_load(&self, time: f64) -> f64 {
        self.force / self.half_width * self.body().load_factor(time)
    }

    fn body(&self) -> DrainedBody {
        // The sides carry nothing: half of the plates' F/a on the mean of the two directions.
        let mean_load = self.force / (2.0 * self.half_width);
        DrainedBody::new(Shape::Slab, &self.ground, self.half_width, mean_load, self.ramp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closeness::assert_close;

    fn mandel() -> Mandel {
        let ground = Ground {
            young: 10e6,
            poisson: 0.2,
            conductivity: 1e-5,
            unit_weight: 9800.0,
            porosity: 0.4,
            fluid_modulus: 2.2e9,
        };
        Mandel { ground, half_width: 1.0, half_height: 1.0, force: 10e3, ramp: 0.0 }
    }

    /// The series of Cheng and Detournay in terms of B and ν_u, by an independent program, checked there by Laplace
    /// inversion: time (s), x (m), p (kPa), σ_yy (kPa), u_x (m), u_y of the plate (m).
    const SERIES: &[[f64; 6]] = &[
        [0.08837818181818183, 0.0, 5.061137610986159, -10.135055872505113, 0.0, -0.0006085634557694874],
        [0.08837818181818183, 0.9, 4.933819487524678, -10.039567279909, 0.000546700775570686, -0.0006085634557694874],
        [0.08837818181818183, 1.0, 0.0, -6.339202664265493, 0.0005914365442305126, -0.0006085634557694874],
        [
            0.8837818181818182,
            0.5,
            5.209880343591535,
            -10.435496374191437,
            0.00031286778842849495,
            -0.0006266962671837876,
        ],
        [
            1.7675636363636364,
            0.95,
            1.075049053048881,
            -7.453106696050519,
            0.0005514911600293425,
            -0.0006380947110013305,
        ],
        [8.837818181818182, 0.0, 5.4691367002375895, -11.288677736487688, 0.0, -0.0006899352202857117],
        [
            8.837818181818182,
            0.75,
            2.5304546240873322,
            -9.084666179374995,
            0.0004374152941762881,
            -0.0006899352202857117,
        ],
        [
            44.18909090909091,
            0.25,
            2.747467121596457,
            -10.624853294829375,
            0.00011636091992684088,
            -0.0008221682835486752,
        ],
        [
            176.75636363636363,
            0.5,
            0.17757578387867906,
            -10.013849746776549,
            0.00012859386671970177,
            -0.0009485441192512836,
        ],
    ];

    #[test]
    fn a_compressible_fluid_follows_cheng_and_detournay() {
        let mandel = mandel();
        for &[time, x, pressure, stress, side, plate] in SERIES {
            // 1e-12 of the largest of each: the other program's thousand terms of round-off.
            assert_close(mandel.pressure(x, time), pressure * 1e3, 1e-12 * 5e3);
            assert_close(mandel.vertical_stress(x, time), stress * 1e3, 1e-12 * 10e3);
            assert_close(mandel.horizontal_displacement(x, time), side, 1e-12 * 6e-4);
            assert_close(mandel.vertical_displacement(1.0, time), plate, 1e-12 * 6e-4);
        }
    }

    /// Centre pressure over F/(2a) for an incompressible fluid, by an independent program from the series for ν_u = ½,
    /// to five digits.
    #[test]
    fn an_incompressible_fluid_follows_the_table() {
        let times = [0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0];
        for (poisson, row) in [
            (0.0, [1.01809, 1.05902, 1.13652, 1.15179, 1.04927, 0.70273, 0.35628, 0.09158]),
            (0.2, [1.01352, 1.04376, 1.09888, 1.09541, 0.96811, 0.59279, 0.25884, 0.04935]),
            (0.3, [1.01028, 1.03307, 1.07317, 1.05766, 0.91551, 0.52724, 0.20787, 0.03231]),
        ] {
            let ground = Ground { poisson, fluid_modulus: f64::INFINITY, ..mandel().ground };
            let mandel = Mandel { ground, half_width: 3.0, ..mandel() };
            for (time_factor, expected) in times.into_iter().zip(row) {
                let time = time_factor * 9.0 / ground.consolidation_coefficient();
                assert_close(mandel.pressure(0.0, time) / (10e3 / 6.0), expected, 5e-6);
            }
        }
    }

    /// The undrained state of Cheng and Detournay: p = F B(1+ν_u)/(3a), u_x = F ν_u/(2G) x/a, u_y = −F(1−ν_u)/(2G) y/a;
    /// and the drained one with ν for ν_u.
    #[test]
    fn it_starts_undrained_and_ends_drained() {
        let mandel = mandel();
        let (b, poisson) = (mandel.ground.skempton_coefficient(), mandel.ground.undrained_poisson());
        let double = 2.0 * mandel.ground.shear_modulus();
        assert_close(mandel.undrained_pressure(), 10e3 * b * (1.0 + poisson) / 3.0, 1e-9);
        assert_close(mandel.pressure(0.7, 0.0), mandel.undrained_pressure(), 1e-9);
        for (time, poisson) in [(0.0, poisson), (1e9, 0.2)] {
            assert_close(mandel.horizontal_displacement(0.5, time), 10e3 * poisson / double * 0.5, 1e-17);
            assert_close(mandel.vertical_displacement(-0.5, time), 10e3 * (1.0 - poisson) / double * 0.5, 1e-17);
            assert_close(mandel.vertical_stress(0.3, time), -10e3, 1e-9);
        }
    }

    /// Direct substitution: no horizontal stress, the plates' force, and the balance of water written in strains.
    #[test]
    fn the_balances_hold_also_on_a_ramp() {
        let mandel = Mandel { ramp: 5.0, half_width: 1.5, half_height: 0.7, ..mandel() };
        let ground = &mandel.ground;
        let step = 1e-4;
        let across = |x: f64, time: f64| {
            let ahead = mandel.horizontal_displacement(x + step, time);
            (ahead - mandel.horizontal_displacement(x - step, time)) / (2.0 * step)
        };
        let up = |time: f64| mandel.vertical_displacement(0.7, time) / 0.7;
        for time in [0.5, 4.0, 5.5, 60.0] {
            for x in [0.2, 0.9, 1.3] {
                let pressure = mandel.pressure(x, time);
                let (lame, modulus) = (ground.lame_modulus(), ground.oedometric_modulus());
                // Central differences of second order: 1e-8 of p''.
                assert_close(modulus * across(x, time) + lame * up(time) - pressure, 0.0, 1e-3);
                assert_close(
                    lame * across(x, time) + modulus * up(time) - pressure,
                    mandel.vertical_stress(x, time),
                    1e-3,
                );
                let dt = 1e-4 * time;
                let rate = |of: &dyn Fn(f64) -> f64| (of(time + dt) - of(time - dt)) / (2.0 * dt);
                let volume = rate(&|time| across(x, time) + up(time));
                let stored = ground.fluid_compressibility() * rate(&|time| mandel.pressure(x, time));
                let dx = 1e-3;
                let bend = mandel.pressure(x + dx, time) - 2.0 * pressure + mandel.pressure(x - dx, time);
                let flow = ground.mobility() * bend / (dx * dx);
                // Rates are of the order of 1e-5 to 1e-4 per second.
                assert_close(volume + stored, flow, 1e-9);
            }
            // Simpson's rule over the width; the stress is smooth in x after the start.
            let stress = |index: usize| mandel.vertical_stress(1.5 * index as f64 / 400.0, time);
            let weight = |index: usize| if index % 2 == 1 { 4.0 } else { 2.0 };
            let inner: f64 = (1..400).map(|index| weight(index) * stress(index)).sum();
            let force = (stress(0) + inner + stress(400)) * 1.5 / 1200.0;
            assert_close(force, -10e3 * (time / 5.0).min(1.0), 1e-2);
        }
    }

    #[test]
    fn it_is_read_by_the_names_of_its_fields() {
        let text = r#"{ "ground": { "young": 10e6, "poisson": 0.2, "conductivity": 1e-5, "unit_weight": 9800.0,
            "porosity": 0.4, "fluid_modulus": 2.2e9 }, "half_width": 1.0, "half_height": 1.0, "force": 10e3 }"#;
        assert_eq!(serde_json::from_str::<Mandel>(text).unwrap(), mandel());
        assert!(serde_json::from_str::<Mandel>(&text.replace("force", "load")).is_err());
    }
}
