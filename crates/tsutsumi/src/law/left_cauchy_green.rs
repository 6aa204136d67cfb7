use serde::{Deserialize, Serialize};

use super::Increment;
use crate::tensor::{Matrix3, Sym3};

/// How far a material is stretched: the left Cauchy–Green tensor b = F Fᵀ, kept as b − I so that zero is unstretched.
///
/// The history of hyperelastic laws: it holds of the deformation gradient F all that an isotropic solid sees. A law that needs F itself
/// keeps that in its history, F ← f F.
///
/// # Equation
///
/// ```text
/// b ← f b fᵀ      f = I + ∇u, the deformation gradient of the step
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct LeftCauchyGreen {
    /// b − I (–).
    pub less_identity: Sym3,
}

impl LeftCauchyGreen {
    /// The tensor after another step.
    #[must_use]
    pub fn after(self, motion: &Increment) -> Self {
        let gradient = motion.displacement_gradient();
        let deformation = Matrix3::identity() + gradient;
        // f fᵀ − I without the cancellation: 2 Δε + ∇u ∇uᵀ.
        let step = motion.strain * 2.0 + Sym3::IDENTITY.rotated(&gradient);
        LeftCauchyGreen { less_identity: self.less_identity.rotated(&deformation) + step }
    }

    /// The tensor of a material that has turned.
    #[must_use]
    pub fn rotated(self, rotation: &Matrix3) -> Self {
        LeftCauchyGreen { less_identity: self.less_identity.rotated(rotation) }
    }

    /// ln J, the logarithm of the volume ratio J = det F = √det b (–); not a number where a stretch has vanished.
    pub fn log_volume_ratio(self) -> f64 {
        let c = self.less_identity;
        // det(I + c) − 1 by the invariants of c: exact for small stretches too.
        let second = 0.5 * (c.trace() * c.trace() - c.double_dot(c));
        0.5 * (c.trace() + second + c.to_matrix().determinant()).ln_1p()
    }

    /// The largest eigenvalue of b (–): the square of the largest stretch.
    pub fn largest(self) -> f64 {
        1.0 + self.less_identity.to_matrix().symmetric_eigenvalues().max()
    }

    /// The smallest eigenvalue of b (–).
    pub fn smallest(self) -> f64 {
        1.0 + self.less_identity.to_matrix().symmetric_eigenvalues().min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::{Vector, rotation};

    /// A simple shear of 0.3, then a stretch of 1.2: F by hand.
    #[test]
    fn steps_multiply() {
        let shear = Matrix3::new(0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let stretch = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0);
        let b = LeftCauchyGreen::default().after(&Increment::of(&shear)).after(&Increment::of(&stretch));
        let gradient = (Matrix3::identity() + stretch) * (Matrix3::identity() + shear);
        let expected = Sym3::symmetric_part(&(gradient * gradient.transpose()));
        let off = b.less_identity + Sym3::IDENTITY - expected;
        assert!(off.norm() < 1e-15);
        assert!((b.log_volume_ratio() - 1.2_f64.ln()).abs() < 1e-15);
    }

    #[test]
    fn a_rotation_stretches_nothing() {
        let turn = rotation(&Vector::<3>::new(0.2, -0.1, 0.4));
        let b = LeftCauchyGreen::default().after(&Increment::of(&(turn - Matrix3::identity())));
        assert!(b.less_identity.norm() < 1e-15);
    }
}
