use std::num::NonZeroUsize;

use super::series::Series;
use super::{Gathered, VelocityUpdate};
use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::particles::Particles;
use crate::tensor::Vector;
use crate::transfer::Transfer;

/// FMPM(k), the material point method with a full mass matrix: particles take the grid's velocity, as with MPM②, but found from
/// its momentum with k terms of the series for the inverse of the full mass matrix.
///
/// # Equation
///
/// ```text
/// V_p ← Σ_I N_I(X_p) v_I^(k)                                        step 10
/// v^(k) = Σ_l (I − m⁻¹ m̃)^l v^L      l = 0 … k − 1
/// m̃_IJ = Σ_p M_p N_I(X_p) N_J(X_p),  m̃ = m S⁺ S      m: the lumped masses
/// ```
///
/// v^L is the momentum over the lumped masses. Since m̃ v = m v^L gives particles that hand exactly v^L back to the nodes, little
/// is smoothed: a step keeps the part 1 − (1 − λ)^k of a mode that S⁺ S multiplies with λ, and nothing of what the grid cannot
/// see. k = 1 is [`Mpm2`](super::Mpm2). In contrast to [`Xpic`](super::Xpic) the accelerations pass through the series too, so the nodes
/// see all of them. It conserves linear momentum; of angular momentum it loses what MPM② does, times (1 − λ)^(k−1) of its modes.
///
/// At the nodes a step is that of MPM② with 1 − (1 − λ)^k for λ, between 0 and 1: the limits of the time step hold. That is so
/// because strains and positions follow v^L, as with the other updates. In the paper particles move with v^(k), and high orders
/// ask for shorter steps.
///
/// Two passes over the particles for every order beyond the first. Nodes that supports hold stay at rest in every term.
///
/// # Reference
///
/// Nairn and Hammerquist, Material point method simulations using an approximate full mass matrix inverse, Computer Methods in
/// Applied Mechanics and Engineering 377 (2021) 113667 (cited from memory, not re-read).
#[derive(Debug, Clone, PartialEq)]
pub struct Fmpm<const D: usize> {
    series: Series<D>,
}

impl<const D: usize> Fmpm<D> {
    /// FMPM of an order k.
    pub fn new(order: NonZeroUsize) -> Self {
        Fmpm { series: Series::new(order) }
    }
}

impl<const D: usize> VelocityUpdate<D> for Fmpm<D> {
    /// What [`Self::look_at_grid`] gave to the particle.
    #[inline(always)]
    fn particle_velocity(&self, velocity: Vector<D>, _at_particle: &Gathered<D>, _dt: f64) -> Vector<D> {
        velocity
    }

    /// Gives the particles their new velocities.
    fn look_at_grid(
        &mut self,
        grid: &Grid<D>,
        active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        nodes: &NodeFields<D>,
        particles: &mut Particles<D>,
    ) {
        self.series.give_to_particles(grid, active, transfer, nodes, &nodes.velocity, particles);
    }

    fn bytes(&self, _particles: usize, nodes: usize) -> usize {
        Series::<D>::bytes(nodes)
    }
}
