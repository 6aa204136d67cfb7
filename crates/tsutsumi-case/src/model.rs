//! What moves in a simulation: material points, or the finite elements that they are compared with.

use std::error::Error;

use tsutsumi::grid::{ActiveSet, CellFields, Grid};
use tsutsumi::law::MaterialGroup;
use tsutsumi::particles::Particles;
use tsutsumi::solver::{Memory, Solver, StepLimits, StepReport};
use tsutsumi_reference::finite_elements::FiniteElements;

/// A body that is advanced step by step and can be read.
pub trait Model<const D: usize> {
    /// Makes a step of `dt` (s).
    ///
    /// # Errors
    /// The model's own reasons. What can be read is then the last good state.
    fn step(&mut self, dt: f64) -> Result<StepReport, Box<dyn Error>>;

    /// Has the particles sorted by cells in the next step, see [`Solver::sort_in_next_step`]; Gauss points keep their places.
    fn sort_in_next_step(&mut self);

    /// The time (s).
    fn time(&self) -> f64;

    /// The number of steps made.
    fn steps(&self) -> u64;

    /// The limits of the step; `None` where any step is stable.
    fn step_limits(&self) -> Option<StepLimits>;

    /// The grid, or the mesh.
    fn grid(&self) -> &Grid<D>;

    /// The cells in use.
    fn active(&self) -> &ActiveSet;

    /// The material points, or the Gauss points as they have moved.
    fn particles(&self) -> &Particles<D>;

    /// The cells' pressures.
    fn cells(&self) -> &CellFields;

    /// The materials.
    fn groups(&self) -> &[Box<dyn MaterialGroup>];

    /// Work of the effective stress since the start (J).
    fn strain_energy(&self) -> f64;

    /// Volume of water drained since the start (m³; m² in 2-D, m in 1-D).
    fn outflow(&self) -> f64;

    /// The part of the velocities that the grid cannot see (–).
    fn unseen_velocity(&self) -> f64;

    /// The memory that it keeps from step to step (bytes), without systems of equations.
    fn memory(&self) -> Memory;
}

/// The accessors that both models have under the same name.
macro_rules! readings {
    () => {
        fn time(&self) -> f64 {
            self.time()
        }

        fn steps(&self) -> u64 {
            self.steps()
        }

        fn grid(&self) -> &Grid<D> {
            self.grid()
        }

        fn active(&self) -> &ActiveSet {
            self.active()
        }

        fn cells(&self) -> &CellFields {
            self.cells()
        }

        fn groups(&self) -> &[Box<dyn MaterialGroup>] {
            self.groups()
        }

        fn strain_energy(&self) -> f64 {
            self.strain_energy()
        }

        fn outflow(&self) -> f64 {
            self.outflow()
        }
    };
}

impl<const D: usize> Model<D> for Solver<D> {
    fn step(&mut self, dt: f64) -> Result<StepReport, Box<dyn Error>> {
        Ok(self.step(dt)?)
    }

    fn sort_in_next_step(&mut self) {
        self.sort_in_next_step();
    }

    fn step_limits(&self) -> Option<StepLimits> {
        Some(self.step_limits())
    }

    fn particles(&self) -> &Particles<D> {
        self.particles()
    }

    fn unseen_velocity(&self) -> f64 {
        self.unseen_velocity()
    }

    fn memory(&self) -> Memory {
        self.memory()
    }

    readings!();
}

impl<const D: usize> Model<D> for FiniteElements<D> {
    fn step(&mut self, dt: f64) -> Result<StepReport, Box<dyn Error>> {
        Ok(self.step(dt)?)
    }

    fn sort_in_next_step(&mut self) {}

    fn step_limits(&self) -> Option<StepLimits> {
        None
    }

    fn particles(&self) -> &Particles<D> {
        self.points()
    }

    /// The nodes carry the velocities: there is nothing else.
    fn unseen_velocity(&self) -> f64 {
        0.0
    }

    /// The fields of the nodes belong to the system of equations.
    fn memory(&self) -> Memory {
        let histories = self.groups().iter().map(|group| group.history_bytes()).sum();
        Memory { particles: self.points().bytes(), histories, ..Memory::default() }
    }

    readings!();
}
