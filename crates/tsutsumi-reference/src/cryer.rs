//! Cryer's problem: a saturated sphere under a pressure on its drained surface.
//!
//! The surface drains and shrinks first and squeezes the core, whose pressure rises before it falls. The
//! three-dimensional sister of [`crate::mandel`].

use crate::drained_body::{DrainedBody, Part, Shape};
use crate::ground::Ground;

/// A sphere of radius a under the total normal pressure q, with p = 0 on its surface.
///
/// # Equation
///
/// Equilibrium in the radius integrates to M ε_v = p + f(t), M = λ+2G; the total stress −q on the surface gives f:
///
/// ```text
/// u = r/(3M) [⟨p⟩_r + f]        f = (4G/3 ⟨p⟩ − q M)/K        ⟨p⟩_r = 3/r³ ∫₀^r r'² p dr',  ⟨p⟩ = ⟨p⟩_a
/// ```
///
/// and the balance of water becomes diffusion that is fed by the mean pressure,
///
/// ```text
/// (1/M + n/K^f) ṗ + 4G/(3MK) d⟨p⟩/dt = (k/γ_w) (∂²p/∂r² + 2/r ∂p/∂r) + q̇/K        p(a) = 0
/// ```
///
/// For a load put on at once, with T = c t/a² and h = 1 + (1/M + n/K^f) 3MK/(4G),
///
/// ```text
/// p = −2/3 B q h Σ_i [1 − a sin(α_i r/a)/(r sin α_i)]/(1 − h + α_i² h²/9) e^(−α_i² T)
/// 3 (1 − α_i cot α_i) = h α_i²
/// ```
///
/// A ramp is the mean of steps shifted over its duration, term by term. Early times are found by Laplace inversion.
///
/// # Validity
///
/// Small strains, no inertia, ν > −0.9. Errors of some 1e-13 of q; any time, zero and the undrained state included.
///
/// # Reference
///
/// C.W. Cryer, A comparison of the three-dimensional consolidation theories of Biot and Terzaghi, Q. J. Mech. Appl.
/// Math. 16 (1963) 401–412, for the incompressible fluid; the compressible one follows from the equations above.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cryer {
    /// The saturated ground.
    pub ground: Ground,
    /// Radius a (m).
    pub radius: f64,
    /// The pressure on the surface q (Pa, positive in compression).
    pub load: f64,
    /// The time over which the load grows linearly (s); zero, or left out, for a load put on at once.
    #[serde(default)]
    pub ramp: f64,
}

impl Cryer {
    /// The pore pressure (Pa) at a distance from the centre (m) and a time (s).
    pub fn pressure(&self, distance: f64, time: f64) -> f64 {
        self.body().pressure(Part::At(distance / self.radius), time)
    }

    /// The radial displacement u (m, positive outwards) at a distance from the centre (m) and a time (s).
    pub fn displacement(&self, distance: f64, time: f64) -> f64 {
        let (body, ground) = (self.body(), &self.ground);
        let modulus = ground.oedometric_modulus();
        let mean = body.pressure(Part::Within(1.0), time);
        let constant = (4.0 / 3.0 * ground.shear_modulus() * mean - self.load * body.load_factor(time) * modulus)
            / ground.bulk_modulus();
        let within = body.pressure(Part::Within(distance / self.radius), time);
        distance / (3.0 * modulus) * (within + constant)
    }

    /// The pressure B q that the whole load leaves undrained (Pa).
    pub fn undrained_pressure(&self) -> f64 {
        self.body().undrained
    }

    fn body(&self) -> DrainedBody {
        DrainedBody::new(Shape::Sphere, &self.ground, self.radius, self.load, self.ramp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closeness::assert_close;

    fn cryer() -> Cryer {
        let ground = Ground {
            young: 10e6,
            poisson: 0.0,
            conductivity: 1e-5,
            unit_weight: 9800.0,
            porosity: 0.4,
            fluid_modulus: f64::INFINITY,
        };
        Cryer { ground, radius: 1.0, load: 10e3, ramp: 0.0 }
    }

    /// An independent program's residue series, checked there by Laplace inversion: time (s), r (m), p (kPa), u at the
    /// surface (m).
    const SERIES: &[[f64; 4]] = &[
        [0.098, 0.0, 10.733628871909994, -3.6681443595416676e-05],
        [0.098, 0.9, 10.443105402076029, -3.6681443595416676e-05],
        [0.9800000000000001, 0.75, 11.303839446938737, -0.0001227252176507305],
        [1.9553570686695025, 0.9, 4.788770593878583, -0.00017886939070651842],
        [2.461648702879389, 0.5, 13.463984594125106, -0.00020319317992602314],
        [9.8, 0.0, 14.755053869330794, -0.00044239832185189555],
        [30.990321069650122, 0.25, 5.574878640271715, -0.0007822021454756581],
        [98.00000000000001, 0.0, 0.31201681374889384, -0.000988745065199084],
        [155.31953286118915, 0.9, 0.00385288150237523, -0.0009991073058719005],
    ];

    #[test]
    fn an_incompressible_fluid_without_lateral_strain_follows_an_independent_series() {
        let cryer = cryer();
        for &[time, distance, pressure, surface] in SERIES {
            // Round-off of the other program's series where it takes hundreds of terms; later 1e-13.
            assert_close(cryer.pressure(distance, time), pressure * 1e3, 1e-11 * 10e3);
            assert_close(cryer.displacement(1.0, time), surface, 1e-12 * 1e-3);
        }
    }

    /// Undrained p = B q with the volume strain −q/K_u, 1/K_u = 1/K (1 − B); drained −q/K; u = −q r/(3K).
    #[test]
    fn it_starts_undrained_and_ends_drained() {
        let ground = Ground { poisson: 0.3, fluid_modulus: 5e7, ..cryer().ground };
        let cryer = Cryer { ground, radius: 2.0, ..cryer() };
        let b = ground.skempton_coefficient();
        assert_close(cryer.undrained_pressure(), b * 10e3, 1e-9);
        assert_close(cryer.pressure(1.1, 0.0), b * 10e3, 1e-9);
        let drained = -10e3 / (3.0 * ground.bulk_modulus());
        assert_close(cryer.displacement(1.6, 0.0), drained * (1.0 - b) * 1.6, 1e-17);
        assert_close(cryer.displacement(1.6, 1e9), drained * 1.6, 1e-17);
    }

    /// Direct substitution in the balances of momentum and water, and the stress on the surface, all from u and p.
    #[test]
    fn the_balances_hold_also_on_a_ramp() {
        let ground = Ground { poisson: 0.25, fluid_modulus: 2e7, ..cryer().ground };
        let cryer = Cryer { ground, ramp: 5.0, radius: 1.5, ..cryer() };
        let step = 2.5e-4;
        let slope = |of: &dyn Fn(f64) -> f64, at: f64| (of(at + step) - of(at - step)) / (2.0 * step);
        let volume = |r: f64, time: f64| slope(&|r| r * r * cryer.displacement(r, time), r) / (r * r);
        let modulus = ground.oedometric_modulus();
        for time in [0.5, 4.0, 5.5, 60.0] {
            for r in [0.3, 0.9, 1.35] {
                let pull = slope(&|r| modulus * volume(r, time) - cryer.pressure(r, time), r);
                // Second-order differences: 6e-8 of third derivatives, here up to some 1e6 Pa/m³.
                assert_close(pull, 0.0, 1.0);
                let dt = 1e-4 * time;
                let rate = |of: &dyn Fn(f64) -> f64| (of(time + dt) - of(time - dt)) / (2.0 * dt);
                let stored = ground.fluid_compressibility() * rate(&|time| cryer.pressure(r, time));
                let flux = |r: f64| r * r * slope(&|r| cryer.pressure(r, time), r);
                let flow = ground.mobility() * slope(&flux, r) / (r * r);
                // Rates are of the order of 1e-5 to 1e-4 per second; the differences' error falls fourfold with half
                // the step.
                assert_close(rate(&|time| volume(r, time)) + stored, flow, 1e-9);
            }
            // σ_rr = λ ε_v + 2G u' with p = 0, from one side of the surface.
            let u = |r: f64| cryer.displacement(r, time);
            let stretch = (3.0 * u(1.5) - 4.0 * u(1.5 - step) + u(1.5 - 2.0 * step)) / (2.0 * step);
            let stress = modulus * stretch + 2.0 * ground.lame_modulus() * u(1.5) / 1.5;
            assert_close(stress, -10e3 * (time / 5.0).min(1.0), 1.0);
        }
    }

    #[test]
    fn it_is_read_by_the_names_of_its_fields() {
        let text = r#"{ "ground": { "young": 10e6, "poisson": 0.2, "conductivity": 1e-5, "unit_weight": 9800.0,
            "porosity": 0.4, "fluid_modulus": 2.2e9 }, "radius": 1.0, "load": 10e3, "ramp": 0.5 }"#;
        assert_eq!(serde_json::from_str::<Cryer>(text).unwrap().ramp, 0.5);
        assert!(serde_json::from_str::<Cryer>(&text.replace("radius", "size")).is_err());
    }
}
