//! One time step, in the order of the paper's algorithm, and how long it may be.

mod dilation;
mod error;
mod limits;
mod memory;
mod motion;
mod sorting;
mod stress_order;
mod unseen;
mod viscosity;

pub use dilation::VolumetricStrain;
pub use error::StepError;
pub use limits::{Governing, StepLimits};
pub use memory::Memory;
pub use stress_order::{NodalVelocity, Pass, StressFirst, StressLast, StressModifiedLast, StressOrder};

use crate::boundary::Boundary;
use crate::damping::Damping;
use crate::grid::{ActiveSet, CellFields, Grid, NodeFields};
use crate::law::MaterialGroup;
use crate::parallel;
use crate::particles::Particles;
use crate::pressure::{PressureReport, PressureScheme, StepView};
use crate::tensor::Vector;
use crate::transfer::{GRAIN, Transfer};
use crate::velocity::VelocityUpdate;
use motion::{Followers, Motion};
use sorting::Sorting;

/// The parts that a [`Solver`] is made of. Each can be replaced by any other of its kind.
pub struct Parts<const D: usize> {
    /// The background grid.
    pub grid: Grid<D>,
    /// The material points.
    pub particles: Particles<D>,
    /// The materials; their particles follow each other without gaps.
    pub groups: Vec<Box<dyn MaterialGroup>>,
    /// Supports and loads.
    pub boundary: Boundary<D>,
    /// Gravity b (m/s²).
    pub gravity: Vector<D>,
    /// The shape function.
    pub shape: Box<dyn Transfer<D>>,
    /// The velocity update: MPM①, MPM②, …
    pub velocity_update: Box<dyn VelocityUpdate<D>>,
    /// When the stresses follow the strains.
    pub stress_order: Box<dyn StressOrder>,
    /// The pore pressure.
    pub pressure: Box<dyn PressureScheme<D>>,
    /// The damping of the nodes' motion; off by default.
    pub damping: Damping,
    /// Where the volume change of a particle comes from.
    pub volumetric_strain: VolumetricStrain,
}

/// A body on its grid, advanced step by step.
///
/// # Equation
///
/// ```text
/// ρ a = ∇·σ + ρ b          Eq. (1), momentum balance of soil and water together
/// ```
#[doc(alias = "Eq. (1)")]
pub struct Solver<const D: usize> {
    parts: Parts<D>,
    active: ActiveSet,
    nodes: NodeFields<D>,
    cells: CellFields,
    motion: Motion<D>,
    sorting: Sorting,
    clock: Clock,
    outflow: f64,
}

/// Time and steps so far. Equal steps are counted, not summed, so that time stays exact over millions of them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Clock {
    steps: u64,
    /// Start and length of the current run of equal steps (s), and how many of them are done.
    start: f64,
    dt: f64,
    count: u64,
}

impl Clock {
    /// The time (s).
    pub fn time(&self) -> f64 {
        self.start + self.dt * self.count as f64
    }

    /// The number of steps made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The clock after another step of `dt` (s).
    #[must_use]
    pub fn after(&self, dt: f64) -> Clock {
        let steps = self.steps + 1;
        match dt == self.dt {
            true => Clock { steps, count: self.count + 1, ..*self },
            false => Clock { steps, start: self.time(), dt, count: 1 },
        }
    }
}

/// What a step tells.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StepReport {
    /// The time at the end of the step (s).
    pub time: f64,
    /// How the pressures were solved for.
    pub pressure: PressureReport,
}

impl<const D: usize> Solver<D> {
    /// A solver at time zero. The cells' pressures are those of the particles.
    ///
    /// # Errors
    /// A particle outside the grid; a grid that is too narrow for the shape function.
    pub fn new(mut parts: Parts<D>) -> Result<Self, StepError> {
        let needed = parts.shape.least_cells();
        if let Some(axis) = parts.grid.cells().iter().position(|&cells| cells < needed) {
            return Err(StepError::NarrowGrid { axis, cells: parts.grid.cells()[axis], needed });
        }
        let active = ActiveSet::new(&parts.grid);
        let nodes = NodeFields::new(&parts.grid);
        let cells = CellFields::new(&parts.grid);
        parts.particles.keep(parts.velocity_update.local_motion());
        parts.particles.settle();
        let Parts { grid, particles, volumetric_strain, damping, .. } = &parts;
        let motion = Motion::new(grid, particles, *volumetric_strain, *damping);
        let sorting = Sorting::new(&parts);
        let mut solver = Solver { parts, active, nodes, cells, motion, sorting, clock: Clock::default(), outflow: 0.0 };
        let moved = solver.locate()?;
        solver.sorting.note(moved);
        let Solver { parts, active, cells, clock, .. } = &mut solver;
        let Parts { grid, particles, shape, pressure, gravity, damping, .. } = parts;
        let (gravity, damping) = (*gravity, *damping);
        let at = StepView { grid, active, transfer: &**shape, gravity, damping, dt: 0.0, time: clock.time() };
        pressure.particles_to_cells(&at, particles, cells);
        cells.pressure.clone_from(&cells.pressure_old);
        Ok(solver)
    }

    /// Advances the body by a step of `dt` (s): the algorithm of the paper, figure 1, with its numbers.
    ///
    /// # Errors
    /// See [`StepError`].
    pub fn step(&mut self, dt: f64) -> Result<StepReport, StepError> {
        // Loops of smaller bodies do not leave the thread.
        match self.parts.particles.len() > GRAIN {
            true => parallel::within_pool(|| self.step_here(dt)),
            false => self.step_here(dt),
        }
    }

    /// The step, on this thread and those that help it.
    fn step_here(&mut self, dt: f64) -> Result<StepReport, StepError> {
        // 2. The grid is as it was at the start; find the particles in it.
        let moved = self.locate()?;
        self.keep_order(moved)?;

        let Solver { parts, active, nodes, cells, motion, clock, outflow, .. } = self;
        let Parts {
            grid,
            particles,
            groups,
            boundary,
            gravity,
            shape,
            velocity_update,
            stress_order,
            pressure,
            damping,
            ..
        } = parts;
        let after = clock.after(dt);
        let (gravity, damping) = (*gravity, *damping);
        let at = StepView { grid, active, transfer: &**shape, gravity, damping, dt, time: after.time() };

        // 3. Masses and velocities of the nodes, Eq. (10); with them the force of the effective stress.
        motion.map(&at, particles, &**velocity_update, boundary, nodes);
        let mut failure = None;
        for &pass in stress_order.before_forces() {
            let followers = Followers { particles, groups, velocity_update: &**velocity_update };
            failure = failure.or(motion.follow(pass, &at, nodes, followers));
            motion.map(&at, particles, &**velocity_update, boundary, nodes);
        }

        // 4. Gravity and loads on the nodes: the right side of Eq. (5).
        nodes.add_gravity(active, gravity);
        boundary.add_loads(grid, active, &**shape, particles, at.time, nodes);

        // 5. Pressures of the cells from the particles.
        pressure.particles_to_cells(&at, particles, cells);

        // 6. Momentum and continuity together, Eqs. (5) and (9), damped on demand: accelerations a_I and pressures p_E^L.
        let report = pressure.solve(&at, particles, cells, nodes)?;

        // 7. Velocities of the nodes, v_I^L.
        nodes.advance(active, dt);
        velocity_update.look_at_grid(grid, active, &**shape, nodes, particles);

        // 8. Strain increments from v_I^L, 9. effective stresses by the constitutive law, 10. velocities of the particles, with a_I (MPM①)
        // or v_I^L (MPM②), positions, volumes and pores: in the order that the stress order says.
        for &pass in stress_order.after_motion() {
            let followers = Followers { particles, groups, velocity_update: &**velocity_update };
            failure = failure.or(motion.follow(pass, &at, nodes, followers));
        }

        // 11. Pressures of the cells back to the particles.
        pressure.cells_to_particles(&at, cells, particles);

        // 12. Next step.
        *clock = after;
        *outflow += dt * report.outflow_rate;
        match failure.or_else(|| motion.closed_pores(particles, at.time)) {
            Some(error) => Err(error),
            None => Ok(StepReport { time: after.time(), pressure: report }),
        }
    }

    /// Finds the cells of the particles and, where one has changed, the active part of the grid. Returns how many have changed theirs.
    fn locate(&mut self) -> Result<usize, StepError> {
        let moved = self.find_cells()?;
        if moved > 0 {
            let Parts { grid, particles, shape, .. } = &self.parts;
            self.active.update(particles.located(), |cell, visit| shape.visit_stencil(grid, cell, visit));
        }
        Ok(moved)
    }

    /// Finds the cells of the particles.
    fn find_cells(&mut self) -> Result<usize, StepError> {
        let Parts { grid, particles, .. } = &mut self.parts;
        particles.locate(grid).map_err(|outside| StepError::Outside { time: self.clock.time(), outside })
    }

    /// The time (s).
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// The number of steps made.
    pub fn steps(&self) -> u64 {
        self.clock.steps()
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.parts.grid
    }

    /// The material points. Their places may change in a step, their numbers do not, see [`Particles::number`].
    pub fn particles(&self) -> &Particles<D> {
        &self.parts.particles
    }

    /// The materials.
    pub fn groups(&self) -> &[Box<dyn MaterialGroup>] {
        &self.parts.groups
    }

    /// Supports and loads.
    pub fn boundary(&self) -> &Boundary<D> {
        &self.parts.boundary
    }

    /// The nodes as the last step left them.
    pub fn nodes(&self) -> &NodeFields<D> {
        &self.nodes
    }

    /// The cells' pressures as the last step left them.
    pub fn cells(&self) -> &CellFields {
        &self.cells
    }

    /// The cells that hold particles, and their nodes.
    pub fn active(&self) -> &ActiveSet {
        &self.active
    }

    /// Work that the effective stress has done on the skeleton since the start (J).
    pub fn strain_energy(&self) -> f64 {
        self.motion.strain_energy
    }

    /// Volume of water that has left through drained sides since the start (m³; m² in 2-D, m in 1-D), by Darcy's law
    /// for the pressure gradient and gravity.
    pub fn outflow(&self) -> f64 {
        self.outflow
    }

    /// The limits of the time step for the body as it is now.
    pub fn step_limits(&self) -> StepLimits {
        let &Parts { ref grid, ref shape, gravity, damping, .. } = &self.parts;
        let active = &self.active;
        let at = StepView { grid, active, transfer: &**shape, gravity, damping, dt: 0.0, time: self.clock.time() };
        limits::step_limits(&self.parts, &at)
    }
}

impl<const D: usize> NodeFields<D> {
    /// Adds m_I b to the forces.
    fn add_gravity(&mut self, active: &ActiveSet, gravity: Vector<D>) {
        let mass = &self.mass;
        active.change_runs(&mut self.force, |nodes, forces| {
            for (force, mass) in forces.iter_mut().zip(&mass[nodes]) {
                for axis in 0..D {
                    force[axis] += gravity[axis] * mass;
                }
            }
        });
    }

    /// v_I^L = v_I + Δt a_I.
    fn advance(&mut self, active: &ActiveSet, dt: f64) {
        let NodeFields { velocity, velocity_old, acceleration, .. } = self;
        active.change_runs(velocity, |nodes, velocities| {
            let motions = velocity_old[nodes.clone()].iter().zip(&acceleration[nodes]);
            for (velocity, (old, acceleration)) in velocities.iter_mut().zip(motions) {
                for axis in 0..D {
                    velocity[axis] = old[axis] + acceleration[axis] * dt;
                }
            }
        });
    }
}
