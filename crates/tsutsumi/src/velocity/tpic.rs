use super::{Gathered, VelocityUpdate};
use crate::particles::LocalMotion;
use crate::tensor::Vector;

/// TPIC, the Taylor particle-in-cell method: particles take the grid's velocity and its gradient.
///
/// # Equation
///
/// ```text
/// m_I v_I = Σ_p M_p N_I(X_p) (V_p + ∇v_p (x_I − X_p))          step 3, in place of Eq. (10)
/// ∇v_p ← Σ_I v_I^L ⊗ ∇N_I(X_p)                                 step 10
/// V_p ← Σ_I N_I(X_p) v_I^L                                     step 10
/// ```
///
/// With linear shape functions Σ_I N_I (x_I − X_p)_j v_I / D_j *is* ∂v/∂x_j, and TPIC differs from [`Apic`](super::Apic) only in
/// what stays while a particle moves: ∇v here, the moments there. It conserves linear momentum, and passes velocities that vary
/// linearly on unchanged. Angular momentum changes in a step by
///
/// ```text
/// Σ_p M_p ε : (∇v_p D_p|new − B_p)      ε : A = A_yx − A_xy,  B_p and D_p as in APIC
/// ```
///
/// little with linear shape functions, where only D_p of the moved particle differs, and more with wider ones, whose B_p is not
/// ∇v_p D_p. No D_p has to be inverted, so particles on grid lines and shape functions that are no products make no trouble.
///
/// The gradients live with the particles from step to step ([`LocalMotion::Gradient`]), zero at the start.
///
/// # Reference
///
/// Nakamura, Matsumura and Mizutani, Taylor particle-in-cell transfer and kernel correction for material point method, Computer
/// Methods in Applied Mechanics and Engineering 403 (2023) 115720 (cited from memory, not re-read; without its kernel correction).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tpic;

impl<const D: usize> VelocityUpdate<D> for Tpic {
    #[inline(always)]
    fn particle_velocity(&self, _velocity: Vector<D>, at_particle: &Gathered<D>, _dt: f64) -> Vector<D> {
        at_particle.velocity
    }

    fn needs_acceleration(&self) -> bool {
        false
    }

    fn local_motion(&self) -> LocalMotion {
        LocalMotion::Gradient
    }
}
