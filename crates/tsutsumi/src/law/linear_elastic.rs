use serde::{Deserialize, Serialize};

use super::{ClosedPathWork, ConstitutiveLaw, LawError};
use crate::tensor::{Matrix6, Sym3};

/// Isotropic linear elasticity.
///
/// # Equation
///
/// ```text
/// Δσ' = λ tr(Δε) I + 2 G Δε      G = E / 2(1+ν)      λ = E ν / (1+ν)(1−2ν)
/// ```
///
/// # Reference
///
/// The "poroelastic body" of Goto et al., sec. 3.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LinearElastic {
    /// Young's modulus E (Pa), positive.
    pub young: f64,
    /// Poisson's ratio ν (–), above −1 and below 0.5.
    pub poisson: f64,
}

impl LinearElastic {
    /// The shear modulus G (Pa).
    pub fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// Lamé's first parameter λ (Pa).
    pub fn lame(&self) -> f64 {
        self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }

    /// The bulk modulus K = E / 3(1−2ν) (Pa).
    pub fn bulk_modulus(&self) -> f64 {
        self.young / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// The oedometric modulus E_oed = λ + 2 G (Pa): stiffness in uniaxial strain.
    pub fn oedometric_modulus(&self) -> f64 {
        self.lame() + 2.0 * self.shear_modulus()
    }
}

impl ConstitutiveLaw for LinearElastic {
    type State = ();

    #[inline(always)]
    fn update(&self, stress: Sym3, state: (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        let volumetric = Sym3::IDENTITY * (self.lame() * strain.trace());
        Ok((stress + volumetric + strain * (2.0 * self.shear_modulus()), state))
    }

    fn tangent(&self, _stress: Sym3, _state: (), _strain: Sym3) -> Result<Matrix6, LawError> {
        let mut tangent = Matrix6::identity() * (2.0 * self.shear_modulus());
        tangent.fixed_view_mut::<3, 3>(0, 0).add_scalar_mut(self.lame());
        Ok(tangent)
    }

    fn p_wave_modulus(&self, _stress: Sym3, _state: &()) -> f64 {
        self.oedometric_modulus()
    }

    fn s_wave_modulus(&self, _stress: Sym3, _state: &()) -> f64 {
        self.shear_modulus()
    }

    /// The stress is the derivative of a quadratic energy.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Zero
    }

    fn validate(&self) -> Result<(), LawError> {
        if !(self.young > 0.0 && self.young.is_finite()) {
            return Err(LawError::Parameter { name: "young", value: self.young, expected: "positive (Pa)" });
        }
        if !(self.poisson > -1.0 && self.poisson < 0.5) {
            let expected = "above -1 and below 0.5";
            return Err(LawError::Parameter { name: "poisson", value: self.poisson, expected });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's soil; moduli derived by hand: G = 1500 kPa, E_oed = 16500 kPa.
    const SOIL: LinearElastic = LinearElastic { young: 4.35e6, poisson: 0.45 };

    #[test]
    fn moduli_of_the_papers_soil() {
        assert!((SOIL.shear_modulus() - 1.5e6).abs() < 1e-6);
        assert!((SOIL.oedometric_modulus() - 16.5e6).abs() < 1e-6);
    }

    #[test]
    fn a_free_bar_in_tension_follows_youngs_modulus_and_poissons_ratio() {
        let strain = Sym3::diagonal(-0.45e-3, -0.45e-3, 1e-3);
        let (stress, ()) = SOIL.update(Sym3::ZERO, (), strain).unwrap();
        assert!((stress.zz - 4.35e3).abs() < 1e-8 && stress.xx.abs() < 1e-8 && stress.yy.abs() < 1e-8);
    }

    /// The same law without a tangent of its own.
    struct ByDifferences;

    impl ConstitutiveLaw for ByDifferences {
        type State = ();

        fn update(&self, stress: Sym3, state: (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
            SOIL.update(stress, state, strain)
        }

        fn p_wave_modulus(&self, stress: Sym3, state: &()) -> f64 {
            SOIL.p_wave_modulus(stress, state)
        }
    }

    #[test]
    fn the_tangent_and_the_one_by_differences_are_the_stiffness() {
        let (stress, strain) = (Sym3::diagonal(1e3, 0.0, 0.0), Sym3::diagonal(1e-3, 0.0, 2e-3));
        let tangents = [SOIL.tangent(stress, (), strain), ByDifferences.tangent(stress, (), strain)];
        for tangent in tangents.map(Result::unwrap) {
            let close = |i, j, expected: f64| assert!((tangent[(i, j)] - expected).abs() < 1e-7 * 16.5e6, "{i} {j}");
            close(0, 0, 16.5e6);
            close(0, 1, 13.5e6);
            close(3, 3, 3.0e6);
            close(0, 4, 0.0);
        }
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        let error = LinearElastic { poisson: 0.5, ..SOIL }.validate().unwrap_err();
        assert_eq!(error.to_string(), "parameter `poisson` is 0.5, but must be above -1 and below 0.5");
        assert!(LinearElastic { young: f64::NAN, ..SOIL }.validate().is_err());
        assert!(SOIL.validate().is_ok());
    }
}
