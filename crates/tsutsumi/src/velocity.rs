//! Velocity updates: how the grid's motion comes back to the particles (step 10 of the algorithm).

mod mpm1;
mod mpm2;

pub use mpm1::Mpm1;
pub use mpm2::Mpm2;

use crate::tensor::{Matrix, Vector};

/// What a particle finds on the grid at its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gathered<const D: usize> {
    /// Σ_I N_I v_I^L, the grid's velocity after its update (m/s).
    pub velocity: Vector<D>,
    /// Σ_I N_I a_I (m/s²).
    pub acceleration: Vector<D>,
    /// Σ_I v_I^L ⊗ G_Ip, component ij = ∂v_i/∂x_j (1/s).
    pub velocity_gradient: Matrix<D>,
}

impl<const D: usize> Default for Gathered<D> {
    fn default() -> Self {
        Gathered { velocity: Vector::zeros(), acceleration: Vector::zeros(), velocity_gradient: Matrix::zeros() }
    }
}

/// A rule for the particles' velocities at the end of a step.
pub trait VelocityUpdate<const D: usize>: Send + Sync {
    /// The new velocity (m/s) of a particle that had velocity `velocity` (m/s), after a step of `dt` (s).
    fn particle_velocity(&self, velocity: Vector<D>, at_particle: &Gathered<D>, dt: f64) -> Vector<D>;

    /// Updates a block of particles: one virtual call for many particles.
    fn update_block(&self, velocities: &mut [Vector<D>], at_particles: &[Gathered<D>], dt: f64) {
        for (velocity, at) in velocities.iter_mut().zip(at_particles) {
            *velocity = self.particle_velocity(*velocity, at, dt);
        }
    }
}
