use std::num::NonZeroUsize;

use super::series::Series;
use super::{Gathered, VelocityUpdate};
use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::particles::Particles;
use crate::tensor::Vector;
use crate::transfer::Transfer;

/// XPIC(m), the extended particle-in-cell method: MPM① on velocities from which a filter of order m has taken what the grid
/// cannot see.
///
/// # Equation
///
/// ```text
/// V_p ← ((I − (I − S S⁺)^m) V)_p + Δt Σ_I N_I(X_p) a_I          step 10
/// (S v)_p = Σ_I N_I(X_p) v_I      (S⁺ V)_I = Σ_p M_p N_I(X_p) V_p / m_I
/// ```
///
/// S S⁺ is symmetric in the scalar product with the masses, and its eigenvalues λ lie between 0 and 1. A step keeps the part
/// 1 − (1 − λ)^m of a mode: all of what the grid carries whole (λ = 1), nothing of what it cannot see (λ = 0). m = 1 is
/// [`Mpm2`](super::Mpm2); with growing m the damping of smooth motions, (κ² h²)^m per step, fades away. It conserves linear
/// momentum.
///
/// The filter is summed at the nodes, S Σ_k (I − S⁺ S)^k S⁺ V with k from 0 to m − 1: two passes over the particles for every
/// order beyond the first. Nodes that supports hold are zero in S⁺. Particles move with v^L, as with the other updates, not by
/// the paper's own rule for positions.
///
/// # Reference
///
/// Hammerquist and Nairn, A new method for material point method particle updates that reduces noise and enhances stability,
/// Computer Methods in Applied Mechanics and Engineering 318 (2017) 724–738 (cited from memory, not re-read).
#[derive(Debug, Clone, PartialEq)]
pub struct Xpic<const D: usize> {
    series: Series<D>,
}

impl<const D: usize> Xpic<D> {
    /// XPIC of an order m.
    pub fn new(order: NonZeroUsize) -> Self {
        Xpic { series: Series::new(order) }
    }
}

impl<const D: usize> VelocityUpdate<D> for Xpic<D> {
    #[inline(always)]
    fn particle_velocity(&self, velocity: Vector<D>, at_particle: &Gathered<D>, dt: f64) -> Vector<D> {
        velocity + at_particle.acceleration * dt
    }

    /// Filters the velocities of the particles.
    fn look_at_grid(
        &mut self,
        grid: &Grid<D>,
        active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        nodes: &NodeFields<D>,
        particles: &mut Particles<D>,
    ) {
        self.series.give_to_particles(grid, active, transfer, nodes, &nodes.velocity_old, particles);
    }

    fn bytes(&self, _particles: usize, nodes: usize) -> usize {
        Series::<D>::bytes(nodes)
    }
}
