use super::{Gathered, VelocityUpdate};
use crate::tensor::Vector;

/// MPM②: particles take the grid's velocity (PIC).
///
/// # Equation
///
/// ```text
/// V_p ← Σ_I N_I(X_p) v_I^L          step 10, with v_I^L
/// ```
///
/// It conserves linear momentum and smooths the velocities at every step: a viscosity that grows with h²/Δt.
///
/// # Reference
///
/// Goto et al., sec. 3 (MPM②).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Mpm2;

impl<const D: usize> VelocityUpdate<D> for Mpm2 {
    #[inline(always)]
    fn particle_velocity(&self, _velocity: Vector<D>, at_particle: &Gathered<D>, _dt: f64) -> Vector<D> {
        at_particle.velocity
    }
    fn needs_acceleration(&self) -> bool {
        false
    }
}
