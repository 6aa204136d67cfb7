use serde::{Deserialize, Serialize};

use super::{ClosedPathWork, ConstitutiveLaw, Increment, LawError, LeftCauchyGreen, LinearElastic};
use crate::tensor::{Matrix3, Sym3};

/// Compressible neo-Hookean elasticity: rubber-like, for strains of any size.
///
/// # Equation
///
/// ```text
/// σ' = μ/J (b − I) + λ ln J / J I      μ = E / 2(1+ν)      λ = E ν / (1+ν)(1−2ν)
/// ```
///
/// the derivative of the energy W = μ/2 (tr b − 3 − 2 ln J) + λ/2 (ln J)² per volume at the start, with b = F Fᵀ and J = det F. For small
/// strains it is linear elasticity. No work is lost on closed paths, whatever their size.
///
/// An effective stress at the start is met by the stretch that it belongs to.
///
/// # Reference
///
/// J. Bonet and R. D. Wood, Nonlinear continuum mechanics for finite element analysis, sec. 6.4.3 (compressible neo-Hookean
/// material; cited from memory); the derivative of the energy is tested.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NeoHookean {
    /// Young's modulus E at small strains (Pa), positive.
    pub young: f64,
    /// Poisson's ratio ν at small strains (–), above −1 and below 0.5.
    pub poisson: f64,
}

impl NeoHookean {
    fn small_strain(&self) -> LinearElastic {
        LinearElastic { young: self.young, poisson: self.poisson }
    }

    /// The effective stress (Pa) of a stretched material.
    pub fn stress(&self, stretch: &LeftCauchyGreen) -> Sym3 {
        let (shear_modulus, lame) = (self.small_strain().shear_modulus(), self.small_strain().lame());
        let log_ratio = stretch.log_volume_ratio();
        (stretch.less_identity * shear_modulus + Sym3::IDENTITY * (lame * log_ratio)) * (-log_ratio).exp()
    }

    /// The energy W (J per m³ of the unstretched material).
    pub fn energy(&self, stretch: &LeftCauchyGreen) -> f64 {
        let (shear_modulus, lame) = (self.small_strain().shear_modulus(), self.small_strain().lame());
        let log_ratio = stretch.log_volume_ratio();
        0.5 * shear_modulus * (stretch.less_identity.trace() - 2.0 * log_ratio) + 0.5 * lame * log_ratio * log_ratio
    }
}

impl ConstitutiveLaw for NeoHookean {
    // ANCHOR: finite
    type State = LeftCauchyGreen;
    const FINITE_STRAIN: bool = true;

    fn update(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<(Sym3, Self::State), LawError> {
        self.deform(stress, state, &Increment { strain, ..Increment::default() })
    }

    fn deform(&self, _stress: Sym3, state: Self::State, motion: &Increment) -> Result<(Sym3, Self::State), LawError> {
        let stretch = state.after(motion);
        Ok((self.stress(&stretch), stretch))
    }
    // ANCHOR_END: finite

    /// Along an axis of stretch √b: (λ (1 − ln J) + μ (1 + b)) / J.
    fn p_wave_modulus(&self, _stress: Sym3, stretch: &Self::State) -> f64 {
        let (shear_modulus, lame) = (self.small_strain().shear_modulus(), self.small_strain().lame());
        let log_ratio = stretch.log_volume_ratio();
        (lame * (1.0 - log_ratio) + shear_modulus * (1.0 + stretch.largest())) * (-log_ratio).exp()
    }

    /// Along an axis of stretch √b: μ b / J.
    fn s_wave_modulus(&self, _stress: Sym3, stretch: &Self::State) -> f64 {
        self.small_strain().shear_modulus() * stretch.largest() * (-stretch.log_volume_ratio()).exp()
    }

    /// The stress is the derivative of the energy W.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Zero
    }

    fn validate(&self) -> Result<(), LawError> {
        self.small_strain().validate()
    }

    /// The stretch c = b − I = (J σ' − λ ln J I) / μ, with ln J by Newton's method from ½ ln det(I + c) = ln J.
    fn initial_state(&self, stress: Sym3) -> Self::State {
        let (shear_modulus, lame) = (self.small_strain().shear_modulus(), self.small_strain().lame());
        let stretch = |x: f64| LeftCauchyGreen {
            less_identity: (stress * x.exp() - Sym3::IDENTITY * (lame * x)) * (1.0 / shear_modulus),
        };
        // A volume so small that the stretches of this stress are positive.
        let mut log_ratio = 0.0;
        for _ in 0..MOST_ITERATIONS {
            if stretch(log_ratio).smallest() > 0.0 {
                break;
            }
            log_ratio = 2.0 * log_ratio - 0.1;
        }
        for _ in 0..MOST_ITERATIONS {
            let b = stretch(log_ratio);
            let change = (stress * f64::exp(log_ratio) - Sym3::IDENTITY * lame) * (1.0 / shear_modulus);
            let inverse = (b.less_identity + Sym3::IDENTITY).to_matrix().try_inverse().unwrap_or_default();
            let slope = 0.5 * Sym3::symmetric_part(&inverse).double_dot(change) - 1.0;
            let mut correction = (b.log_volume_ratio() - log_ratio) / slope;
            for _ in 0..MOST_ITERATIONS {
                if stretch(log_ratio - correction).smallest() > 0.0 {
                    break;
                }
                correction *= 0.5;
            }
            log_ratio -= correction;
            if correction.abs() <= f64::EPSILON * log_ratio.abs() {
                break;
            }
        }
        // A tension that no stretch can carry leaves no number: the first update says so.
        stretch(log_ratio)
    }

    fn rotate_state(&self, state: Self::State, rotation: &Matrix3) -> Self::State {
        state.rotated(rotation)
    }
}

/// Newton's method doubles the digits in each step.
const MOST_ITERATIONS: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;

    const RUBBER: NeoHookean = NeoHookean { young: 1e6, poisson: 0.3 };

    fn stretched() -> (LeftCauchyGreen, Matrix3) {
        let gradient = Matrix3::new(0.3, 0.4, 0.1, -0.2, -0.25, 0.05, 0.0, 0.15, 0.2);
        (LeftCauchyGreen::default().after(&Increment::of(&gradient)), Matrix3::identity() + gradient)
    }

    /// σ' : ε̇ J = Ẇ along any motion: by central differences, 1e-6 of a strain of 1e-5 squared.
    #[test]
    fn the_stress_is_the_derivative_of_the_energy() {
        let (stretch, gradient) = stretched();
        let ratio = gradient.determinant();
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 1), (2, 2)] {
            let mut motion = Matrix3::zeros();
            motion[(row, column)] = 1e-5;
            let [forward, backward] =
                [motion, -motion].map(|step| RUBBER.energy(&stretch.after(&Increment::of(&step))));
            let power = ratio * RUBBER.stress(&stretch).double_dot(Sym3::symmetric_part(&motion));
            assert!((0.5 * (forward - backward) - power).abs() < 1e-9 * RUBBER.young * 1e-5, "{row} {column}");
        }
    }

    /// Uniaxial strain by hand: σ = (μ (λ₁² − 1) + λ ln λ₁) / λ₁.
    #[test]
    fn uniaxial_strain_has_its_closed_form() {
        let halved = Increment::of(&Matrix3::new(-0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
        let stress = RUBBER.stress(&LeftCauchyGreen::default().after(&halved));
        let (mu, lame) = (1e6 / 2.6, 0.3e6 / (1.3 * 0.4));
        let expected = (mu * (0.25 - 1.0) + lame * 0.5_f64.ln()) / 0.5;
        assert!((stress.xx - expected).abs() < 1e-9 * 1e6);
    }

    #[test]
    fn a_stress_at_the_start_is_kept() {
        let stress = Sym3 { xx: -4e5, yy: -1e5, zz: 2e4, xy: 1e5, yz: -5e4, zx: 0.0 };
        let (after, _) = RUBBER.update(stress, RUBBER.initial_state(stress), Sym3::ZERO).unwrap();
        let off = after - stress;
        assert!(off.norm() < 1e-9 * 4e5);
    }
}
