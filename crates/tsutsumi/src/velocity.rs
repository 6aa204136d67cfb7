//! Velocity updates: how the grid's motion comes back to the particles (step 10 of the algorithm).

mod apic;
mod flip;
mod fmpm;
mod mpm1;
mod mpm2;
mod series;
mod tpic;
mod xpic;

pub use apic::Apic;
pub use flip::Flip;
pub use fmpm::Fmpm;
pub use mpm1::Mpm1;
pub use mpm2::Mpm2;
pub use tpic::Tpic;
pub use xpic::Xpic;

use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::parallel::vectorized;
use crate::particles::{LocalMotion, Particles};
use crate::tensor::Vector;
use crate::transfer::Transfer;
pub use crate::transfer::{Gathered, GatheredBlock};

/// A rule for the particles' velocities at the end of a step.
///
/// Most need [`particle_velocity`](Self::particle_velocity) only. One that carries more than a velocity per particle says so in
/// [`local_motion`](Self::local_motion); one that looks at more of the grid than [`Gathered`] holds does so in
/// [`look_at_grid`](Self::look_at_grid).
pub trait VelocityUpdate<const D: usize>: Send + Sync {
    /// The new velocity (m/s) of a particle that had velocity `velocity` (m/s), after a step of `dt` (s).
    fn particle_velocity(&self, velocity: Vector<D>, at_particle: &Gathered<D>, dt: f64) -> Vector<D>;

    /// Updates a block of particles: one virtual call for many particles.
    fn update_block(&self, velocities: &mut [Vector<D>], at_particles: &GatheredBlock<D>, dt: f64) {
        vectorized(
            #[inline(always)]
            || {
                for (p, velocity) in velocities.iter_mut().enumerate() {
                    *velocity = self.particle_velocity(*velocity, &at_particles.at(p), dt);
                }
            },
        );
    }

    /// Whether [`particle_velocity`](Self::particle_velocity) looks at the acceleration of the grid; if not, that is zero there.
    fn needs_acceleration(&self) -> bool {
        true
    }

    /// What is kept in step 10 of the motion around the particles, in [`Particles::local_motion`], and goes to the nodes in step 3. By
    /// default nothing.
    fn local_motion(&self) -> LocalMotion {
        LocalMotion::Nothing
    }

    /// Between steps 7 and 8, all particles still in their places: takes from the nodes what [`Gathered`] does not hold, and may
    /// change the velocities that step 10 starts from. By default nothing.
    fn look_at_grid(
        &mut self,
        _grid: &Grid<D>,
        _active: &ActiveSet,
        _transfer: &dyn Transfer<D>,
        _nodes: &NodeFields<D>,
        _particles: &mut Particles<D>,
    ) {
    }

    /// The memory that the update carries from step to step (bytes), for so many particles and nodes. By default none.
    fn bytes(&self, _particles: usize, _nodes: usize) -> usize {
        0
    }
}
