use super::{Gathered, VelocityUpdate};
use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::law::BLOCK;
use crate::particles::Particles;
use crate::tensor::{Matrix, Vector};
use crate::transfer::Transfer;

/// TPIC, the Taylor particle-in-cell method: particles take the grid's velocity and its gradient.
///
/// # Equation
///
/// ```text
/// m_I v_I = Σ_p M_p N_I(X_p) (V_p + ∇v_p (x_I − X_p))          step 3, in place of Eq. (10)
/// ∇v_p ← Σ_I v_I^L ⊗ ∇N_I(X_p)                                 between steps 7 and 8
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
/// The gradients live in the update from step to step, zero at the start; they belong to the particles of one solver.
///
/// # Reference
///
/// Nakamura, Matsumura and Mizutani, Taylor particle-in-cell transfer and kernel correction for material point method, Computer
/// Methods in Applied Mechanics and Engineering 403 (2023) 115720 (cited from memory, not re-read; without its kernel correction).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tpic<const D: usize> {
    /// ∇v_p, component ij = ∂v_i/∂x_j (1/s); empty before the first step.
    gradients: Vec<Matrix<D>>,
}

impl<const D: usize> VelocityUpdate<D> for Tpic<D> {
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
        transfer.spread_gradients(grid, active, particles, &self.gradients, momentum);
    }

    fn look_at_grid(
        &mut self,
        grid: &Grid<D>,
        _active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        nodes: &NodeFields<D>,
        particles: &mut Particles<D>,
    ) {
        self.gradients.resize(particles.len(), Matrix::zeros());
        let mut at_particles = [Gathered::default(); BLOCK];
        for (number, gradients) in self.gradients.chunks_mut(BLOCK).enumerate() {
            let start = number * BLOCK;
            let at_particles = &mut at_particles[..gradients.len()];
            let block = start..start + gradients.len();
            transfer.velocity_gradients(grid, &nodes.velocity, particles.places().part(block), at_particles);
            for (gradient, at) in gradients.iter_mut().zip(at_particles) {
                *gradient = at.velocity_gradient;
            }
        }
    }

    fn bytes(&self, particles: usize, _nodes: usize) -> usize {
        particles * size_of::<Matrix<D>>()
    }
}
