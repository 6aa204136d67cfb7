use serde::{Deserialize, Serialize};

use super::parameter::{require, require_positive};
use super::{ClosedPathWork, ConstitutiveLaw, LawError};
use crate::tensor::{Matrix6, Sym3};

/// Elasticity of grains: stiffness grows with a power of the pressure, and no work is lost on closed paths.
///
/// # Equation
///
/// With p = −⅓ tr σ' and ε_v = −tr ε positive in compression, e the deviatoric strain, both elastic and zero and unstrained at p = p_ref:
///
/// ```text
/// W = p_ref/(k (2−m)) X^((2−m)/(1−m))        X² = (1 + k (1−m) ε_v)² + 2 g k (1−m) e : e
/// p = ∂W/∂ε_v = p_ref X^(m/(1−m)) (1 + k (1−m) ε_v)
/// s = ∂W/∂e  = 2 g p_ref X^(m/(1−m)) e
/// ```
///
/// with k = K_ref/p_ref, g = G_ref/p_ref. Without shear K = K_ref (p/p_ref)^m and G = G_ref (p/p_ref)^m; with it the pressure is replaced by p_o, where
/// p_o² = p² + (K_ref/G_ref) (1−m) s : s / 2, and the stiffness depends on the direction: shear and volume are coupled, as they must be where moduli
/// follow the pressure and an energy exists. The strain follows from the stress alone, so there is no history; steps are exact, however
/// large.
///
/// # Validity
///
/// Small strains (10⁻⁵) in sand, with m about ½. Without yield: any stress ratio can be reached, and the pressure of an undrained test grows with
/// the shear. No tension: a step that would end at p ≤ 0 is an error.
///
/// # Reference
///
/// G. T. Houlsby, A. Amorosi and E. Rojas (2005), Géotechnique 55, 383–392 (cited from memory; that the stress is the derivative of the energy
/// is tested, and the moduli were derived again).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PressureElastic {
    /// The bulk modulus K_ref at the reference pressure (Pa), positive.
    pub bulk_modulus: f64,
    /// The shear modulus G_ref at the reference pressure (Pa), positive.
    pub shear_modulus: f64,
    /// The reference pressure p_ref (Pa), positive; default 100e3.
    #[serde(default = "one_bar")]
    pub reference_pressure: f64,
    /// The exponent m (–), from 0 (linear elasticity) to below 1; default 0.5, as for sand.
    #[serde(default = "one_half")]
    pub exponent: f64,
}

fn one_bar() -> f64 {
    100e3
}

fn one_half() -> f64 {
    0.5
}

/// The elastic strain as the law counts it, and the stiffness there.
struct Strained {
    /// 1 + k (1−m) ε_v (–).
    compression: f64,
    /// e (–).
    deviator: Sym3,
    /// X² (–).
    square: f64,
    /// p_ref X^(m/(1−m)) = p_ref (p_o/p_ref)^m (Pa).
    pressure: f64,
}

impl PressureElastic {
    /// k (1−m) (–).
    fn rate(&self) -> f64 {
        self.bulk_modulus / self.reference_pressure * (1.0 - self.exponent)
    }

    /// g (–).
    fn shear_rate(&self) -> f64 {
        self.shear_modulus / self.reference_pressure
    }

    /// p_ref (p_o/p_ref)^m (Pa) at a stress.
    fn scale(&self, stress: Sym3) -> f64 {
        let (mean, deviator) = (stress.trace() / 3.0, stress.deviator());
        let weight = 0.5 * self.rate() / self.shear_rate();
        let square = mean * mean + weight * deviator.double_dot(deviator);
        self.reference_pressure * power(square / self.reference_pressure.powi(2), 0.5 * self.exponent)
    }

    /// The elastic strain of a stress: the gradient of the complementary energy.
    fn strained(&self, stress: Sym3) -> Strained {
        let pressure = self.scale(stress);
        let compression = -stress.trace() / (3.0 * pressure);
        let deviator = stress.deviator() * (0.5 / (self.shear_rate() * pressure));
        self.at(compression, deviator)
    }

    fn at(&self, compression: f64, deviator: Sym3) -> Strained {
        let square = compression * compression + 2.0 * self.shear_rate() * self.rate() * deviator.double_dot(deviator);
        let pressure = self.reference_pressure * power(square, 0.5 * self.exponent / (1.0 - self.exponent));
        Strained { compression, deviator, square, pressure }
    }

    /// The strain after a step.
    fn after(&self, stress: Sym3, strain: Sym3) -> Result<Strained, LawError> {
        let pressure = stress.pressure();
        if pressure <= 0.0 {
            return Err(LawError::NoCompression { pressure });
        }
        let start = self.strained(stress);
        let end = self.at(start.compression - self.rate() * strain.trace(), start.deviator + strain.deviator());
        match end.compression > 0.0 {
            true => Ok(end),
            false => Err(LawError::NoCompression { pressure: end.compression * end.pressure }),
        }
    }

    fn stress(&self, strained: &Strained) -> Sym3 {
        strained.deviator * (2.0 * self.shear_rate() * strained.pressure)
            - Sym3::IDENTITY * (strained.compression * strained.pressure)
    }

    /// The elastic energy (J/m³) at a stress with compression, zero where the stress vanishes.
    pub fn energy(&self, stress: Sym3) -> f64 {
        let Strained { square, pressure, .. } = self.strained(stress);
        square * pressure * self.reference_pressure / (self.bulk_modulus * (2.0 - self.exponent))
    }

    /// m k σ ⊗ σ over this (Pa²) is what the change of the moduli adds to the stiffness.
    fn coupling(&self, strained: &Strained) -> f64 {
        self.exponent * self.bulk_modulus / (self.reference_pressure * strained.square * strained.pressure)
    }

    /// The bulk and shear moduli (Pa) for a stiffness that stayed as it is.
    fn frozen_moduli(&self, strained: &Strained) -> (f64, f64) {
        (self.rate() * strained.pressure, self.shear_rate() * strained.pressure)
    }
}

/// A power of a number that is not negative; the exponents of sand are roots.
fn power(base: f64, exponent: f64) -> f64 {
    if exponent == 0.25 {
        base.sqrt().sqrt()
    } else if exponent == 0.5 {
        base.sqrt()
    } else {
        base.powf(exponent)
    }
}

impl ConstitutiveLaw for PressureElastic {
    type State = ();

    fn update(&self, stress: Sym3, (): (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        Ok((self.stress(&self.after(stress, strain)?), ()))
    }

    /// ∂²W/∂ε² = K_f I ⊗ I + 2 G_f (I₄ − ⅓ I ⊗ I) + m k/(X² p_ref X^(m/(1−m))) σ' ⊗ σ', with K_f = (1−m) K.
    fn tangent(&self, stress: Sym3, (): (), strain: Sym3) -> Result<Matrix6, LawError> {
        let end = self.after(stress, strain)?;
        let (bulk_modulus, shear_modulus) = self.frozen_moduli(&end);
        let (unit, stress) = (Sym3::IDENTITY.to_kelvin(), self.stress(&end).to_kelvin());
        Ok(Matrix6::identity() * (2.0 * shear_modulus)
            + unit * unit.transpose() * (bulk_modulus - 2.0 / 3.0 * shear_modulus)
            + stress * stress.transpose() * self.coupling(&end))
    }

    /// Along the axis of the largest compression, at most p + ⅔ q.
    fn p_wave_modulus(&self, stress: Sym3, (): &()) -> f64 {
        let strained = self.strained(stress);
        let (bulk_modulus, shear_modulus) = self.frozen_moduli(&strained);
        let deviator = stress.deviator();
        let largest = stress.trace().abs() / 3.0 + (2.0 / 3.0 * deviator.double_dot(deviator)).sqrt();
        bulk_modulus + 4.0 / 3.0 * shear_modulus + self.coupling(&strained) * largest * largest
    }

    /// In the plane of the largest shear stress, at most √J₂.
    fn s_wave_modulus(&self, stress: Sym3, (): &()) -> f64 {
        let strained = self.strained(stress);
        let (_, shear_modulus) = self.frozen_moduli(&strained);
        let deviator = stress.deviator();
        shear_modulus + self.coupling(&strained) * 0.5 * deviator.double_dot(deviator)
    }

    /// The stress is the derivative of the energy W.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Zero
    }

    fn validate(&self) -> Result<(), LawError> {
        require_positive("bulk_modulus", self.bulk_modulus, "positive (Pa)")?;
        require_positive("shear_modulus", self.shear_modulus, "positive (Pa)")?;
        require_positive("reference_pressure", self.reference_pressure, "positive (Pa)")?;
        require((0.0..1.0).contains(&self.exponent), "exponent", self.exponent, "from 0 to below 1")
    }
}
