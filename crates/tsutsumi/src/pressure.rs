//! Pore pressure by finite differences at the cell centres, coupled with the momentum balance.
//!
//! A [`PressureScheme`] turns nodal forces into cell pressures and nodal accelerations. [`Coupled`] is the paper's: both
//! equations solved together, the accelerations eliminated. [`Dry`] is for ground without water.

mod assembly;
mod checkerboard;
mod coarsest;
mod conjugate_gradient;
mod coupled;
mod dry;
mod envelope;
mod geometry;
mod lattice;
mod multigrid;
mod particle_pressure;
mod passage;
mod smoother;
mod stencil_matrix;
mod tied;
mod wide_system;

pub use coupled::{Coupled, Fluid, Quadrature};
pub use dry::Dry;
pub use particle_pressure::{CellPressure, ParticlePressure, PressureGradient, PressureIncrement};

use std::ops::Range;

use crate::damping::Damping;
use crate::grid::{ActiveSet, CellFields, Grid, NodeFields};
use crate::particles::Particles;
use crate::tensor::Vector;
use crate::transfer::Transfer;

/// What a pressure scheme may read: everything of the step but the fields it changes.
pub struct StepView<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// The active part of the grid.
    pub active: &'a ActiveSet,
    /// The shape function's passes.
    pub transfer: &'a dyn Transfer<D>,
    /// Gravity b (m/s²).
    pub gravity: Vector<D>,
    /// The damping of the nodes' motion.
    pub damping: Damping,
    /// The step Δt (s).
    pub dt: f64,
    /// The time at the end of the step (s).
    pub time: f64,
}

/// Why the pressures of a step could not be solved for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PressureError {
    /// The matrix is not positive definite.
    #[error(
        "the pressure system is not positive definite at t = {time:.6} s (pivot {pivot:.3e} in cell {cell:?}): {}",
        if *short_step {
            "the step is shorter than k/g and a surface cell is nearly empty; sum over the material points, take a longer \
             step, or leave the fluid's inertia out"
        } else {
            "volumes have turned negative, the run is unstable; take a shorter step"
        }
    )]
    NotPositiveDefinite {
        /// The time at the end of the step (s).
        time: f64,
        /// The numbers along the axes of the cell in whose row it showed.
        cell: Vec<usize>,
        /// The pivot, or the quotient xᵀAx/xᵀx, that is not positive.
        pivot: f64,
        /// True where γΔt < k/g somewhere: only then can a sound body give such a system.
        short_step: bool,
    },
    /// A coefficient, the right-hand side or the solution is infinite or not a number.
    #[error(
        "the pressure system is not finite at t = {time:.6} s in cell {cell:?}: the run is unstable, take a shorter step or `auto`"
    )]
    NotFinite {
        /// The time at the end of the step (s).
        time: f64,
        /// The numbers along the axes of the first such cell.
        cell: Vec<usize>,
    },
    /// The iteration stopped before the residual was small enough.
    #[error(
        "the pressures did not converge at t = {time:.6} s: relative residual {residual:.3e} after {iterations} iterations, \
         largest in cell {cell:?}"
    )]
    NotConverged {
        /// The time at the end of the step (s).
        time: f64,
        /// The numbers along the axes of the cell with the largest residual.
        cell: Vec<usize>,
        /// Iterations made.
        iterations: usize,
        /// Residual over right-hand side, Euclidean norms.
        residual: f64,
    },
}

/// How the linear system was solved.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PressureReport {
    /// Iterations of the linear solver; 0 for the direct one.
    pub iterations: usize,
    /// Darcy's outflow through the drained sides (m³/s; m²/s in 2-D, m/s in 1-D).
    pub outflow_rate: f64,
}

/// A scheme for the pore pressure: steps 5, 6 and 11 of the algorithm.
pub trait PressureScheme<const D: usize>: Send {
    /// Step 5: the cells' pressures from those of the particles, into `cells.pressure_old`.
    fn particles_to_cells(&mut self, at: &StepView<D>, particles: &Particles<D>, cells: &mut CellFields);

    /// Step 6: the cells' pressures and the nodes' accelerations, from the forces and old velocities of the nodes, with the
    /// damping that the view holds. It follows [`Self::particles_to_cells`] with the same particles.
    ///
    /// # Errors
    /// See [`PressureError`]. The particles are untouched then.
    fn solve(
        &mut self,
        at: &StepView<D>,
        particles: &Particles<D>,
        cells: &mut CellFields,
        nodes: &mut NodeFields<D>,
    ) -> Result<PressureReport, PressureError>;

    /// Step 11: the cells' pressures back to the particles.
    fn cells_to_particles(&mut self, at: &StepView<D>, cells: &CellFields, particles: &mut Particles<D>);

    /// Whether the pressure of the cells resists every short wave that it can see, as it does without stabilisation. Where it does
    /// not, the step is limited as in dry ground.
    fn holds_short_waves(&self) -> bool {
        true
    }

    /// The time step limit (s) of compression that the water takes part in, for the particles `group`; `None` without
    /// water: then the drained wave speed governs.
    ///
    /// `modulus` is the skeleton's oedometric modulus (Pa).
    fn consolidation_limit(
        &self,
        at: &StepView<D>,
        particles: &Particles<D>,
        group: Range<usize>,
        modulus: f64,
    ) -> Option<f64>;
}
