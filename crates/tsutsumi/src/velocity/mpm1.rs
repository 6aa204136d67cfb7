use super::{Gathered, VelocityUpdate};
use crate::tensor::Vector;

/// MPM①: particles are accelerated by the grid (FLIP).
///
/// # Equation
///
/// ```text
/// V_p ← V_p + Δt Σ_I N_I(X_p) a_I          step 10, with a_I^k
/// ```
///
/// It conserves linear momentum and adds no viscosity; velocities that the grid cannot see stay on the particles.
///
/// # Reference
///
/// Goto et al., sec. 3 (MPM①).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Mpm1;

impl<const D: usize> VelocityUpdate<D> for Mpm1 {
    #[inline(always)]
    fn particle_velocity(&self, velocity: Vector<D>, at_particle: &Gathered<D>, dt: f64) -> Vector<D> {
        velocity + at_particle.acceleration * dt
    }
}
