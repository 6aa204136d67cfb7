use super::{Gathered, VelocityUpdate};
use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::particles::Particles;
use crate::tensor::{Matrix, Vector};
use crate::transfer::Transfer;

/// APIC, the affine particle-in-cell method: particles take the grid's velocity and how it varies around them.
///
/// # Equation
///
/// ```text
/// m_I v_I = Σ_p M_p N_I(X_p) (V_p + B_p D_p⁻¹ (x_I − X_p))          step 3, in place of Eq. (10)
/// B_p ← Σ_I N_I(X_p) v_I^L ⊗ (x_I − X_p)                            between steps 7 and 8
/// V_p ← Σ_I N_I(X_p) v_I^L                                          step 10
/// ```
///
/// It conserves linear momentum, and angular momentum with the part Σ_p M_p ε : B_p that turns within the particles. As MPM②
/// it forgets what the grid cannot see at every step, but it passes velocities that vary linearly on unchanged: what remains
/// of the viscosity of MPM② is of higher order in h.
///
/// The moments B_p live in the update from step to step, zero at the start; they belong to the particles of one solver.
///
/// # Reference
///
/// Jiang, Schroeder, Selle, Teran and Stomakhin, The affine particle-in-cell method, ACM Transactions on Graphics 34 (2015)
/// 51:1–51:10 (cited from memory). We keep B_p, not B_p D_p⁻¹, so that the angular momentum stays when particles move.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Apic<const D: usize> {
    /// B_p (m²/s); empty before the first step.
    moments: Vec<Matrix<D>>,
}

impl<const D: usize> VelocityUpdate<D> for Apic<D> {
    #[inline(always)]
    fn particle_velocity(&self, _velocity: Vector<D>, at_particle: &Gathered<D>, _dt: f64) -> Vector<D> {
        at_particle.velocity
    }

    fn add_momentum(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        particles: &Particles<D>,
        momentum: &mut [Vector<D>],
    ) {
        transfer.spread_moments(grid, active, particles, &self.moments, momentum);
    }

    fn look_at_grid(
        &mut self,
        grid: &Grid<D>,
        _active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        nodes: &NodeFields<D>,
        particles: &mut Particles<D>,
    ) {
        self.moments.resize(particles.len(), Matrix::zeros());
        transfer.velocity_moments(grid, particles.places(), &nodes.velocity, &mut self.moments);
    }

    fn bytes(&self, particles: usize, _nodes: usize) -> usize {
        particles * size_of::<Matrix<D>>()
    }
}
