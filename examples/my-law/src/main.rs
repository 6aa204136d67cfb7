//! A constitutive law of your own, with the whole command line of Tsutsumi: `cargo run -p my-law -- run CASE`.

// ANCHOR: imports
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tsutsumi::law::{ConstitutiveLaw, LawError};
use tsutsumi::tensor::Sym3;
use tsutsumi_case::Registry;
// ANCHOR_END: imports

// ANCHOR: struct
/// Elasticity that grows with the confining pressure.
///
/// ```text
/// K = K_ref (max(p', p_min) / p_ref)^m      G = K · 3 (1 − 2ν) / 2 (1 + ν)      p' = −⅓ tr σ'
/// ```
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureDependent {
    /// Bulk modulus at the reference pressure, K_ref (Pa).
    pub bulk_modulus: f64,
    /// Poisson's ratio ν (–).
    pub poisson: f64,
    /// Reference pressure p_ref (Pa).
    pub reference_pressure: f64,
    /// Exponent m (–), 0 to 1.
    pub exponent: f64,
    /// The mean effective stress below which the stiffness falls no more, p_min (Pa).
    pub minimum_pressure: f64,
}
// ANCHOR_END: struct

// ANCHOR: moduli
impl PressureDependent {
    /// Bulk and shear modulus (Pa) at an effective stress.
    fn moduli(&self, stress: Sym3) -> (f64, f64) {
        let pressure = (-stress.trace() / 3.0).max(self.minimum_pressure);
        let bulk = self.bulk_modulus * (pressure / self.reference_pressure).powf(self.exponent);
        (bulk, bulk * 1.5 * (1.0 - 2.0 * self.poisson) / (1.0 + self.poisson))
    }
}
// ANCHOR_END: moduli

// ANCHOR: impl
impl ConstitutiveLaw for PressureDependent {
    // No history: the stress says it all.
    type State = ();

    fn update(&self, stress: Sym3, state: (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        let (bulk, shear) = self.moduli(stress);
        let volumetric = Sym3::IDENTITY * (bulk * strain.trace());
        Ok((stress + volumetric + strain.deviator() * (2.0 * shear), state))
    }

    fn p_wave_modulus(&self, stress: Sym3, _state: &()) -> f64 {
        let (bulk, shear) = self.moduli(stress);
        bulk + 4.0 / 3.0 * shear
    }

    fn validate(&self) -> Result<(), LawError> {
        let positive = [
            ("bulk_modulus", self.bulk_modulus),
            ("reference_pressure", self.reference_pressure),
            ("minimum_pressure", self.minimum_pressure),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(LawError::Parameter { name, value, expected: "positive (Pa)" });
            }
        }
        if !(self.poisson > -1.0 && self.poisson < 0.5) {
            let expected = "above -1 and below 0.5";
            return Err(LawError::Parameter { name: "poisson", value: self.poisson, expected });
        }
        if !(0.0..=1.0).contains(&self.exponent) {
            return Err(LawError::Parameter { name: "exponent", value: self.exponent, expected: "from 0 to 1" });
        }
        Ok(())
    }
}
// ANCHOR_END: impl

// ANCHOR: main
fn main() -> ExitCode {
    tsutsumi_cli::main_with(&Registry::built_in().law::<PressureDependent>("pressure-dependent"))
}
// ANCHOR_END: main

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: PressureDependent = PressureDependent {
        bulk_modulus: 20e6,
        poisson: 0.3,
        reference_pressure: 100e3,
        exponent: 0.5,
        minimum_pressure: 1e3,
    };

    // ANCHOR: test
    #[test]
    fn the_law_passes_the_checks_for_laws() {
        tsutsumi_testkit::check_law(&LAW).unwrap();
    }
    // ANCHOR_END: test

    /// Isotropic compression in small steps against the closed form √p' = √p'₀ + K_ref ε / (2 √p_ref), m = ½.
    #[test]
    fn isotropic_compression_follows_the_closed_form() {
        let (mut stress, steps, strain) = (Sym3::IDENTITY * -50e3, 10_000, 5e-3);
        for _ in 0..steps {
            let increment = Sym3::IDENTITY * (-strain / 3.0 / steps as f64);
            (stress, ()) = LAW.update(stress, (), increment).unwrap();
        }
        let root = 50e3_f64.sqrt() + 20e6 * strain / (2.0 * 100e3_f64.sqrt());
        // First order in the step: the error is about strain/steps of the gain.
        assert!((-stress.trace() / 3.0 / root.powi(2) - 1.0).abs() < 1e-4);
    }
}
