use super::sorting::bytes_to_come;
use super::{NodalVelocity, Parts, Pass, Solver};
use crate::boundary::AxisSet;
use crate::tensor::Vector;

/// The memory that a solver keeps from step to step (bytes), by what it is for.
///
/// Loads and the work arrays of the pressure scheme are not in it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Memory {
    /// The arrays of the material points, with what damping by stiffness adds, and their numbers, which large bodies carry once they have been
    /// sorted.
    pub particles: usize,
    /// The histories of the laws.
    pub histories: usize,
    /// What the velocity update carries.
    pub velocity_update: usize,
    /// The fields of nodes and cells, and the list of those in use.
    pub grid: usize,
}

impl Memory {
    /// All of it (bytes).
    pub fn total(&self) -> usize {
        self.particles + self.histories + self.velocity_update + self.grid
    }
}

impl<const D: usize> Solver<D> {
    /// The memory that the solver keeps once it steps.
    pub fn memory(&self) -> Memory {
        let Parts { grid, particles, groups, velocity_update, stress_order, .. } = &self.parts;
        let passes = stress_order.before_forces().iter().chain(stress_order.after_motion());
        let maps_again = passes.into_iter().any(|pass: &Pass| pass.stress == Some(NodalVelocity::Mapped));
        let mapped = if maps_again { grid.num_nodes() * size_of::<Vector<D>>() } else { 0 };
        Memory {
            particles: particles.bytes() + self.motion.bytes_of_particles() + bytes_to_come(particles),
            histories: groups.iter().map(|group| group.history_bytes()).sum(),
            velocity_update: velocity_update.bytes(particles.len(), grid.num_nodes()),
            grid: self.nodes.bytes()
                + self.cells.bytes()
                + self.active.bytes()
                + self.motion.bytes_of_cells()
                + mapped
                + grid.num_nodes() * size_of::<AxisSet>(),
        }
    }
}
