//! De Leeuw's problem: a long saturated cylinder under a pressure on its drained surface.
//!
//! The surface drains and shrinks first and squeezes the core, whose pressure rises before it falls. It stands between
//! [`crate::mandel`] (flow in one direction) and [`crate::cryer`] (in three).

use crate::drained_body::{DrainedBody, Part, Shape};
use crate::ground::Ground;

/// A cylinder of radius a in plane strain under the total radial pressure q, with p = 0 on its surface.
///
/// # Equation
///
/// Equilibrium in the radius integrates to M ε_v = p + f(t), M = λ+2G; the total stress −q on the surface gives f:
///
/// ```text
/// u = r/(2M) [⟨p⟩_r + f]        f = (G ⟨p⟩ − q M)/(λ+G)        ⟨p⟩_r = 2/r² ∫₀^r r' p dr',  ⟨p⟩ = ⟨p⟩_a
/// ```
///
/// and the balance of water becomes diffusion that is fed by the mean pressure,
///
/// ```text
/// (1/M + n/K^f) ṗ + G/(M(λ+G)) d⟨p⟩/dt = (k/γ_w) (∂²p/∂r² + 1/r ∂p/∂r) + q̇/(λ+G)        p(a) = 0
/// ```
///
/// For a load put on at once, with T = c t/a² and h = 1 + (1/M + n/K^f) M(λ+G)/G,
///
/// ```text
/// p = −p₀ h Σ_i [1 − J₀(α_i r/a)/J₀(α_i)]/(1 − h + α_i² h²/4) e^(−α_i² T)        2 J₁(α_i) = h α_i J₀(α_i)
/// p₀ = q/(1 + (λ+G) n/K^f)
/// ```
///
/// A ramp is the mean of steps shifted over its duration, term by term. Early times are found by Laplace inversion.
///
/// # Validity
///
/// Small strains, no inertia. Errors of some 1e-13 of q; any time, zero and the undrained state included.
///
/// # Reference
///
/// E.H. de Leeuw, The theory of three-dimensional consolidation applied to cylindrical bodies, Proc. 6th Int. Conf.
/// Soil Mech. Found. Eng. 1 (1965) 287–290; A. Verruijt, Theory and problems of poroelasticity, 2016. The compressible
/// fluid follows from the equations above.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeLeeuw {
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

impl DeLeeuw {
    /// The pore pressure (Pa) at a distance from the axis (m) and a time (s).
    pub fn pressure(&self, distance: f64, time: f64) -> f64 {
        self.body().pressure(Part::At(distance / self.radius), time)
    }

    /// The radial displacement u (m, positive outwards) at a distance from the axis (m) and a time (s).
    pub fn displacement(&self, distance: f64, time: f64) -> f64 {
        let (body, ground) = (self.body(), &self.ground);
        let modulus = ground.oedometric_modulus();
        let mean = body.pressure(Part::Within(1.0), time);
        let constant = (ground.shear_modulus() * mean - self.load * body.load_factor(time) * modulus)
            / (ground.lame_modulus() + ground.shear_modulus());
        let within = body.pressure(Part::Within(distance / self.radius), time);
        distance / (2.0 * modulus) * (within + constant)
    }

    /// The pressure p₀ that the whole load leaves undrained (Pa).
    pub fn undrained_pressure(&self) -> f64 {
        self.body().undrained
    }

    fn body(&self) -> DrainedBody {
        DrainedBody::new(Shape::Cylinder, &self.ground, self.radius, self.load, self.ramp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closeness::assert_close;

    fn de_leeuw() -> DeLeeuw {
        let ground = Ground {
            young: 10e6,
            poisson: 0.0,
            conductivity: 1e-5,
            unit_weight: 9800.0,
            porosity: 0.4,
            fluid_modulus: f64::INFINITY,
        };
        DeLeeuw { ground, radius: 1.0, load: 10e3, ramp: 0.0 }
    }

    /// The field equations solved with Bessel functions of 30 digits, the two constants from the two boundary
    /// conditions, and inverted by another program (mpmath): time (s), r (m), p (Pa), u at the surface (m); ν = 0.25,
    /// K^f = 20 MPa, a = 1.5 m.
    const INVERTED: &[[f64; 4]] = &[
        [0.02, 0.0, 8673.09772662748, -0.0001414952214408892],
        [0.02, 0.6, 8673.09772662748, -0.0001414952214408892],
        [0.02, 1.35, 8673.097726627076, -0.0001414952214408892],
        [0.3, 0.0, 8823.963524577435, -0.0001765715194642535],
        [0.3, 0.6, 8823.963524577435, -0.0001765715194642535],
        [0.3, 1.35, 8352.183442388898, -0.0001765715194642535],
        [2.0, 0.0, 9146.48670676092, -0.000251558159323629],
        [2.0, 0.6, 9146.404009630377, -0.000251558159323629],
        [2.0, 1.35, 4868.121211448426, -0.000251558159323629],
        [10.0, 0.0, 9734.853904815495, -0.0004018940655691598],
        [10.0, 0.6, 9155.932678947181, -0.0004018940655691598],
        [10.0, 1.35, 2298.496636582102, -0.0004018940655691598],
        [40.0, 0.0, 6669.61681553361, -0.0006543371168028151],
        [40.0, 0.6, 5348.012527696152, -0.0006543371168028151],
        [40.0, 1.35, 979.6994504314806, -0.0006543371168028151],
        [120.0, 0.0, 1380.376132040252, -0.000879492019291976],
        [120.0, 0.6, 1099.299419477446, -0.000879492019291976],
        [120.0, 1.35, 198.9658236046902, -0.000879492019291976],
    ];

    #[test]
    fn a_compressible_fluid_follows_an_independent_inversion() {
        let ground = Ground { poisson: 0.25, fluid_modulus: 2e7, ..de_leeuw().ground };
        let cylinder = DeLeeuw { ground, radius: 1.5, ..de_leeuw() };
        for &[time, distance, pressure, surface] in INVERTED {
            // Talbot's stated accuracy of 1e-13 of the load, times its amplification in this problem.
            assert_close(cylinder.pressure(distance, time), pressure, 5e-13 * 10e3);
            assert_close(cylinder.displacement(1.5, time), surface, 5e-13 * 1e-3);
        }
    }

    /// Undrained, Skempton's B times the mean of the stresses q, q and 2ν_u q; the surface moves by −q (1−2ν_u) r/(2G);
    /// drained, with ν for ν_u.
    #[test]
    fn it_starts_undrained_and_ends_drained() {
        let ground = Ground { poisson: 0.3, fluid_modulus: 5e7, ..de_leeuw().ground };
        let cylinder = DeLeeuw { ground, radius: 2.0, ..de_leeuw() };
        let (b, undrained) = (ground.skempton_coefficient(), ground.undrained_poisson());
        assert_close(cylinder.undrained_pressure(), b * (2.0 + 2.0 * undrained) / 3.0 * 10e3, 1e-9);
        assert_close(cylinder.pressure(1.1, 0.0), cylinder.undrained_pressure(), 1e-9);
        let shrunk = |poisson: f64| -10e3 * (1.0 - 2.0 * poisson) * 1.6 / (2.0 * ground.shear_modulus());
        assert_close(cylinder.displacement(1.6, 0.0), shrunk(undrained), 1e-17);
        assert_close(cylinder.displacement(1.6, 1e9), shrunk(0.3), 1e-17);
    }

    /// Direct substitution in the balances of momentum and water, and the stress on the surface, all from u and p.
    #[test]
    fn the_balances_hold_also_on_a_ramp() {
        let ground = Ground { poisson: 0.25, fluid_modulus: 2e7, ..de_leeuw().ground };
        let cylinder = DeLeeuw { ground, ramp: 5.0, radius: 1.5, ..de_leeuw() };
        let step = 2.5e-4;
        let slope = |of: &dyn Fn(f64) -> f64, at: f64| (of(at + step) - of(at - step)) / (2.0 * step);
        let volume = |r: f64, time: f64| slope(&|r| r * cylinder.displacement(r, time), r) / r;
        let modulus = ground.oedometric_modulus();
        for time in [0.5, 4.0, 5.5, 60.0] {
            for r in [0.3, 0.9, 1.35] {
                let pull = slope(&|r| modulus * volume(r, time) - cylinder.pressure(r, time), r);
                // Second-order differences: 6e-8 of third derivatives, here up to some 1e6 Pa/m³.
                assert_close(pull, 0.0, 1.0);
                let dt = 1e-4 * time;
                let rate = |of: &dyn Fn(f64) -> f64| (of(time + dt) - of(time - dt)) / (2.0 * dt);
                let stored = ground.fluid_compressibility() * rate(&|time| cylinder.pressure(r, time));
                let flux = |r: f64| r * slope(&|r| cylinder.pressure(r, time), r);
                let flow = ground.mobility() * slope(&flux, r) / r;
                // Rates are of the order of 1e-5 to 1e-4 per second; the differences' error falls fourfold with half
                // the step.
                assert_close(rate(&|time| volume(r, time)) + stored, flow, 1e-9);
            }
            // σ_rr = λ ε_v + 2G u' with p = 0, from one side of the surface.
            let u = |r: f64| cylinder.displacement(r, time);
            let stretch = (3.0 * u(1.5) - 4.0 * u(1.5 - step) + u(1.5 - 2.0 * step)) / (2.0 * step);
            let stress = modulus * stretch + ground.lame_modulus() * u(1.5) / 1.5;
            assert_close(stress, -10e3 * (time / 5.0).min(1.0), 1.0);
        }
    }

    #[test]
    fn it_is_read_by_the_names_of_its_fields() {
        let text = r#"{ "ground": { "young": 10e6, "poisson": 0.2, "conductivity": 1e-5, "unit_weight": 9800.0,
            "porosity": 0.4, "fluid_modulus": 2.2e9 }, "radius": 1.0, "load": 10e3, "ramp": 0.5 }"#;
        assert_eq!(serde_json::from_str::<DeLeeuw>(text).unwrap().ramp, 0.5);
        assert!(serde_json::from_str::<DeLeeuw>(&text.replace("radius", "size")).is_err());
    }
}
