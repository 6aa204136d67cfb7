use super::{Gathered, VelocityUpdate};
use crate::particles::LocalMotion;
use crate::tensor::Vector;

/// APIC, the affine particle-in-cell method: particles take the grid's velocity and how it varies around them.
///
/// # Equation
///
/// ```text
/// m_I v_I = Σ_p M_p N_I(X_p) (V_p + B_p D_p⁻¹ (x_I − X_p))          step 3, in place of Eq. (10)
/// B_p ← Σ_I N_I(X_p) v_I^L ⊗ (x_I − X_p)                            step 10
/// V_p ← Σ_I N_I(X_p) v_I^L                                          step 10
/// ```
///
/// It conserves linear momentum, and angular momentum with the part Σ_p M_p ε : B_p that turns within the particles. As MPM②
/// it forgets what the grid cannot see at every step, but it passes velocities that vary linearly on unchanged: what remains
/// of the viscosity of MPM② is of higher order in h.
///
/// The moments B_p live with the particles from step to step ([`LocalMotion::Moments`]), zero at the start.
///
/// # Reference
///
/// Jiang, Schroeder, Selle, Teran and Stomakhin, The affine particle-in-cell method, ACM Transactions on Graphics 34 (2015)
/// 51:1–51:10 (cited from memory). We keep B_p, not B_p D_p⁻¹, so that the angular momentum stays when particles move.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Apic;

impl<const D: usize> VelocityUpdate<D> for Apic {
    #[inline(always)]
    fn particle_velocity(&self, _velocity: Vector<D>, at_particle: &Gathered<D>, _dt: f64) -> Vector<D> {
        at_particle.velocity
    }

    fn needs_acceleration(&self) -> bool {
        false
    }

    fn local_motion(&self) -> LocalMotion {
        LocalMotion::Moments
    }
}
