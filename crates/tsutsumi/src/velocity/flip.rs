use super::{Gathered, VelocityUpdate};
use crate::tensor::Vector;

/// FLIP with a share of PIC: a blend of MPM① and MPM②.
///
/// # Equation
///
/// ```text
/// V_p ← α (V_p + Δt Σ_I N_I(X_p) a_I) + (1 − α) Σ_I N_I(X_p) v_I^L          step 10
/// ```
///
/// with the share of FLIP α: 1 is [`Mpm1`](super::Mpm1), 0 is [`Mpm2`](super::Mpm2). It conserves linear momentum. The viscosity
/// of MPM② is taken 1 − α times, and so it still grows with h²/Δt; velocities that the grid cannot see decay as α^n in n steps.
///
/// # Reference
///
/// Zhu and Bridson, Animating sand as a fluid, ACM Transactions on Graphics 24 (2005) 965–972 (cited from memory).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flip {
    /// The share α of FLIP (–), from 0 to 1.
    pub share: f64,
}

impl<const D: usize> VelocityUpdate<D> for Flip {
    #[inline(always)]
    fn particle_velocity(&self, velocity: Vector<D>, at_particle: &Gathered<D>, dt: f64) -> Vector<D> {
        (velocity + at_particle.acceleration * dt) * self.share + at_particle.velocity * (1.0 - self.share)
    }
}
