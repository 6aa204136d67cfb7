use std::num::NonZeroUsize;

use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::particles::{LocalMotion, Particles};
use crate::tensor::Vector;
use crate::transfer::Transfer;

/// The series with which XPIC and FMPM undo the smoothing of a trip from nodes to particles and back.
///
/// # Equation
///
/// ```text
/// Σ_k (I − S⁺ S)^k v      k = 0 … order − 1
/// (S v)_p = Σ_I N_I(X_p) v_I      (S⁺ V)_I = Σ_p M_p N_I(X_p) V_p / m_I
/// ```
///
/// S⁺ S is symmetric in the scalar product with the nodes' masses, with eigenvalues from 0 to 1, and it keeps a motion that is the
/// same everywhere. So the sum has the momentum of v. Nodes that supports hold are zero in S⁺.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Series<const D: usize> {
    order: NonZeroUsize,
    /// (I − S⁺ S)^k v of the nodes (m/s).
    term: Vec<Vector<D>>,
    /// S⁺ S of the term (m/s), its momentum while sums are made.
    seen: Vec<Vector<D>>,
    /// The sum of the terms (m/s).
    sum: Vec<Vector<D>>,
}

impl<const D: usize> Series<D> {
    pub(super) fn new(order: NonZeroUsize) -> Self {
        Series { order, term: Vec::new(), seen: Vec::new(), sum: Vec::new() }
    }

    /// The memory of the three fields for so many nodes (bytes).
    pub(super) fn bytes(nodes: usize) -> usize {
        3 * nodes * size_of::<Vector<D>>()
    }

    /// V_p ← (S Σ_k (I − S⁺ S)^k v)_p for velocities v of the nodes (m/s): two passes over the particles for every order beyond
    /// the first.
    pub(super) fn give_to_particles(
        &mut self,
        grid: &Grid<D>,
        active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        nodes: &NodeFields<D>,
        at_nodes: &[Vector<D>],
        particles: &mut Particles<D>,
    ) {
        self.seen.resize(at_nodes.len(), Vector::zeros());
        self.term.resize(at_nodes.len(), Vector::zeros());
        self.sum.resize(at_nodes.len(), Vector::zeros());
        self.term.copy_from_slice(at_nodes);
        self.sum.copy_from_slice(at_nodes);
        for _ in 1..self.order.get() {
            self.next_term(grid, active, transfer, nodes, particles);
        }
        take_velocities(grid, transfer, &self.sum, particles);
    }

    /// The next term: what S⁺ S sees of the last one is taken away. It passes through the velocities of the
    /// particles, which the sum replaces at the end.
    fn next_term(
        &mut self,
        grid: &Grid<D>,
        active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        nodes: &NodeFields<D>,
        particles: &mut Particles<D>,
    ) {
        for &node in active.nodes() {
            self.seen[node as usize] = Vector::zeros();
        }
        take_velocities(grid, transfer, &self.term, particles);
        transfer.spread_momentum(grid, active, particles, LocalMotion::Nothing, &mut self.seen);
        nodes.momenta_to_velocities(active, &mut self.seen);
        for &node in active.nodes() {
            let node = node as usize;
            self.term[node] -= self.seen[node];
            self.sum[node] += self.term[node];
        }
    }
}

/// V_p ← (S v)_p for velocities v of the nodes (m/s).
fn take_velocities<const D: usize>(
    grid: &Grid<D>,
    transfer: &dyn Transfer<D>,
    at_nodes: &[Vector<D>],
    particles: &mut Particles<D>,
) {
    let mut velocities = std::mem::take(&mut particles.velocity);
    transfer.interpolate(grid, particles.places(), at_nodes, &mut velocities);
    particles.velocity = velocities;
}
