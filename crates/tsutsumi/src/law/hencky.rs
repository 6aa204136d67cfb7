use serde::{Deserialize, Serialize};

use super::{ClosedPathWork, ConstitutiveLaw, Increment, LawError, LeftCauchyGreen, LinearElastic};
use crate::tensor::{Matrix3, Sym3};

/// Hencky's elasticity: linear in the logarithmic strain, for strains of any size.
///
/// # Equation
///
/// ```text
/// J σ' = λ tr h I + 2 G h      h = ½ ln b,  J = det F      G = E / 2(1+ν)      λ = E ν / (1+ν)(1−2ν)
/// ```
///
/// the derivative of the energy W = λ/2 (tr h)² + G h : h per volume at the start. In uniaxial strain J σ' = E_oed ln J: halving and doubling
/// the height take stresses of opposite sign and equal size, per area at the start of the side planes. The energy stops being convex at
/// stretches beyond e; the step limit is then an estimate.
///
/// An effective stress at the start is met by the stretch that it belongs to.
///
/// # Reference
///
/// H. Hencky (1928), Z. Tech. Phys. 9, 215–220 (cited from memory); the derivative of the energy is tested.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Hencky {
    /// Young's modulus E at small strains (Pa), positive.
    pub young: f64,
    /// Poisson's ratio ν at small strains (–), above −1 and below 0.5.
    pub poisson: f64,
}

impl Hencky {
    fn small_strain(&self) -> LinearElastic {
        LinearElastic { young: self.young, poisson: self.poisson }
    }

    /// The effective stress (Pa) of a stretched material.
    pub fn stress(&self, stretch: &LeftCauchyGreen) -> Sym3 {
        let strain = logarithmic_strain(stretch);
        let linear = self.small_strain();
        let kirchhoff = Sym3::IDENTITY * (linear.lame() * strain.trace()) + strain * (2.0 * linear.shear_modulus());
        kirchhoff * (-strain.trace()).exp()
    }

    /// The energy W (J per m³ of the unstretched material).
    pub fn energy(&self, stretch: &LeftCauchyGreen) -> f64 {
        let strain = logarithmic_strain(stretch);
        let linear = self.small_strain();
        0.5 * linear.lame() * strain.trace() * strain.trace() + linear.shear_modulus() * strain.double_dot(strain)
    }
}

/// h = ½ ln b (–).
fn logarithmic_strain(stretch: &LeftCauchyGreen) -> Sym3 {
    stretch.less_identity.map_eigenvalues(|c| 0.5 * c.ln_1p())
}

impl ConstitutiveLaw for Hencky {
    type State = LeftCauchyGreen;
    const FINITE_STRAIN: bool = true;

    fn update(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<(Sym3, Self::State), LawError> {
        self.deform(stress, state, &Increment { strain, ..Increment::default() })
    }

    fn deform(&self, _stress: Sym3, state: Self::State, motion: &Increment) -> Result<(Sym3, Self::State), LawError> {
        let stretch = state.after(motion);
        Ok((self.stress(&stretch), stretch))
    }

    /// Along an axis of the stretch: E_oed/J − σ'.
    fn p_wave_modulus(&self, stress: Sym3, stretch: &Self::State) -> f64 {
        let ratio = stretch.log_volume_ratio().exp();
        self.small_strain().oedometric_modulus() / ratio + largest_compression(stress)
    }

    /// In the plane of the largest and the smallest stretch: G/J · ½ (r + 1)/(r − 1) ln r, with r the ratio of their squares; and what the
    /// stress itself adds to a wave.
    fn s_wave_modulus(&self, stress: Sym3, stretch: &Self::State) -> f64 {
        let ratio = stretch.log_volume_ratio().exp();
        let excess = stretch.largest() / stretch.smallest() - 1.0;
        // The limit 1 + (r − 1)²/12 of the factor, before it becomes 0/0.
        let factor = if excess < 1e-3 { 1.0 + excess * excess / 12.0 } else { (0.5 + 1.0 / excess) * excess.ln_1p() };
        let largest_tension = stress.to_matrix().symmetric_eigenvalues().max().max(0.0);
        self.small_strain().shear_modulus() * factor / ratio + largest_tension
    }

    /// The stress is the derivative of the energy W.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Zero
    }

    fn validate(&self) -> Result<(), LawError> {
        self.small_strain().validate()
    }

    /// tr h = x from 3 K x = eˣ tr σ' by Newton's method, then h = (eˣ σ' − λ x I) / 2G and b = exp 2h.
    fn initial_state(&self, stress: Sym3) -> Self::State {
        let linear = self.small_strain();
        let bulk = 3.0 * linear.lame() + 2.0 * linear.shear_modulus();
        let mut trace = 0.0;
        for _ in 0..MOST_ITERATIONS {
            let pull = f64::exp(trace) * stress.trace();
            let correction = (bulk * trace - pull) / (bulk - pull);
            trace -= correction;
            if correction.abs() <= f64::EPSILON * trace.abs() {
                break;
            }
        }
        // A tension that no stretch can carry leaves no number: the first update says so.
        let deviatoric = stress * f64::exp(trace) - Sym3::IDENTITY * (linear.lame() * trace);
        let strain = deviatoric * (0.5 / linear.shear_modulus());
        LeftCauchyGreen { less_identity: strain.map_eigenvalues(|h| (2.0 * h).exp_m1()) }
    }

    fn rotate_state(&self, state: Self::State, rotation: &Matrix3) -> Self::State {
        state.rotated(rotation)
    }
}

/// The largest compression in any direction (Pa), 0 in tension.
fn largest_compression(stress: Sym3) -> f64 {
    (-stress.to_matrix().symmetric_eigenvalues().min()).max(0.0)
}

/// Newton's method doubles the digits in each step.
const MOST_ITERATIONS: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;

    const SOLID: Hencky = Hencky { young: 1e6, poisson: 0.3 };

    /// σ' : ε̇ J = Ẇ along any motion: by central differences, 1e-6 of a strain of 1e-5 squared.
    #[test]
    fn the_stress_is_the_derivative_of_the_energy() {
        let gradient = Matrix3::new(0.3, 0.4, 0.1, -0.2, -0.25, 0.05, 0.0, 0.15, 0.2);
        let stretch = LeftCauchyGreen::default().after(&Increment::of(&gradient));
        let ratio = (Matrix3::identity() + gradient).determinant();
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 1), (2, 2)] {
            let mut motion = Matrix3::zeros();
            motion[(row, column)] = 1e-5;
            let [forward, backward] = [motion, -motion].map(|step| SOLID.energy(&stretch.after(&Increment::of(&step))));
            let power = ratio * SOLID.stress(&stretch).double_dot(Sym3::symmetric_part(&motion));
            assert!((0.5 * (forward - backward) - power).abs() < 1e-9 * SOLID.young * 1e-5, "{row} {column}");
        }
    }

    /// Halved: J σ = E_oed ln ½, and the same with the other sign when doubled.
    #[test]
    fn uniaxial_strain_is_linear_in_the_logarithm() {
        let modulus = LinearElastic { young: 1e6, poisson: 0.3 }.oedometric_modulus();
        for change in [-0.5, 1.0_f64] {
            let motion = Increment::of(&Matrix3::new(change, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
            let stress = SOLID.stress(&LeftCauchyGreen::default().after(&motion));
            assert!((stress.xx * (1.0 + change) - modulus * change.ln_1p()).abs() < 1e-9 * modulus);
        }
    }

    #[test]
    fn a_stress_at_the_start_is_kept() {
        let stress = Sym3 { xx: -4e5, yy: -1e5, zz: 2e4, xy: 1e5, yz: -5e4, zx: 0.0 };
        let (after, _) = SOLID.update(stress, SOLID.initial_state(stress), Sym3::ZERO).unwrap();
        let off = after - stress;
        assert!(off.norm() < 1e-9 * 4e5);
    }
}
