//! One time step, in the order of the paper's algorithm, and how long it may be.

mod dilation;
mod limits;
mod viscosity;

pub use dilation::VolumetricStrain;
pub use limits::{Governing, StepLimits};

use crate::boundary::Boundary;
use crate::damping::Damping;
use crate::grid::{ActiveSet, CellFields, Grid, NodeFields};
use crate::law::{Increment, LawError, MaterialGroup};
use crate::particles::{OutsideGrid, Particles};
use crate::pressure::{PressureError, PressureReport, PressureScheme, StepView};
use crate::tensor::{Sym3, Vector, embed, spin, volume_ratio};
use crate::transfer::{Gathered, Transfer};
use crate::velocity::VelocityUpdate;
use dilation::Dilation;
use viscosity::Viscosity;

/// Particles handled by one virtual call: few enough for the cache, many enough to hide the call.
const BLOCK: usize = 64;

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
    dilation: Dilation,
    viscosity: Viscosity,
    at_particles: Vec<Gathered<D>>,
    increments: Vec<Increment>,
    porosities: Vec<f64>,
    clock: Clock,
    strain_energy: f64,
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

/// Why a step could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// A particle left the grid. The particles are those at the start of the step.
    #[error("at t = {time:.6} s {outside}: enlarge the grid, or take a shorter step or `auto` if the run is unstable")]
    Outside {
        /// The time at the start of the step (s).
        time: f64,
        /// The particle and the grid.
        outside: OutsideGrid,
    },
    /// The pressures could not be solved for. The particles are those at the start of the step.
    #[error(transparent)]
    Pressure(#[from] PressureError),
    /// A law failed. The step is complete but for the stress of the failing particles, which keep their old one.
    #[error(
        "at t = {time:.6} s the law of material `{material}` failed in particle {particle} at {position:.4?} m: {source}"
    )]
    Law {
        /// The name of the material.
        material: String,
        /// The first particle whose law failed.
        particle: usize,
        /// Its position (m).
        position: Vec<f64>,
        /// The time at the end of the step (s).
        time: f64,
        /// The law's reason.
        source: LawError,
    },
    /// The grid is too narrow for the shape function.
    #[error("the grid has {cells} cell(s) along axis {axis}, but the shape function needs {needed}")]
    NarrowGrid {
        /// The axis, 0 = x.
        axis: usize,
        /// The cells along it.
        cells: usize,
        /// The cells that it needs.
        needed: usize,
    },
    /// A particle was pressed together beyond its pores. The step is complete.
    #[error(
        "at t = {time:.6} s particle {particle} at {position:.4?} m is pressed to a porosity of {porosity:.3}: its grains are \
         incompressible; take a stiffer law, or a shorter step if the run is unstable"
    )]
    ClosedPores {
        /// The first such particle.
        particle: usize,
        /// Its position (m).
        position: Vec<f64>,
        /// The porosity that follows from its volume (–).
        porosity: f64,
        /// The time at the end of the step (s).
        time: f64,
    },
}

/// The first particle whose grains leave no room for water.
fn closed_pores<const D: usize>(particles: &Particles<D>, time: f64) -> Option<StepError> {
    let particle = particles.porosity.iter().position(|&porosity| porosity < 0.0)?;
    let position = particles.position[particle].iter().copied().collect();
    Some(StepError::ClosedPores { particle, position, porosity: particles.porosity[particle], time })
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
    pub fn new(parts: Parts<D>) -> Result<Self, StepError> {
        let needed = parts.shape.least_cells();
        if let Some(axis) = parts.grid.cells().iter().position(|&cells| cells < needed) {
            return Err(StepError::NarrowGrid { axis, cells: parts.grid.cells()[axis], needed });
        }
        let active = ActiveSet::new(&parts.grid);
        let nodes = NodeFields::new(&parts.grid);
        let cells = CellFields::new(&parts.grid);
        let dilation = Dilation::new(parts.volumetric_strain, &parts.grid);
        let viscosity = Viscosity::new(parts.damping.stiffness, &parts.particles.stress);
        let mut solver = Solver {
            parts,
            active,
            nodes,
            cells,
            dilation,
            viscosity,
            at_particles: vec![Gathered::default(); BLOCK],
            increments: vec![Increment::default(); BLOCK],
            porosities: vec![0.0; BLOCK],
            clock: Clock::default(),
            strain_energy: 0.0,
            outflow: 0.0,
        };
        solver.locate()?;
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
        // 2. The grid is as it was at the start; find the particles in it.
        self.locate()?;

        let Solver {
            parts,
            active,
            nodes,
            cells,
            dilation,
            viscosity,
            at_particles,
            increments,
            porosities,
            clock,
            strain_energy,
            outflow,
        } = self;
        let Parts { grid, particles, groups, boundary, gravity, shape, velocity_update, pressure, damping, .. } = parts;
        let after = clock.after(dt);
        let (gravity, damping) = (*gravity, *damping);
        let at = StepView { grid, active, transfer: &**shape, gravity, damping, dt, time: after.time() };

        // 3. Masses and velocities of the nodes, Eq. (10); with them the force of the effective stress.
        nodes.clear(active);
        viscosity.swap(&mut particles.stress);
        shape.particles_to_nodes(grid, particles, nodes);
        viscosity.swap(&mut particles.stress);
        velocity_update.add_momentum(grid, &**shape, particles, &mut nodes.velocity_old);
        boundary.hold(active, nodes);
        nodes.momentum_to_velocity(active);

        // 4. Gravity and loads on the nodes: the right side of Eq. (5).
        nodes.add_gravity(active, gravity);
        boundary.add_loads(grid, &**shape, particles, at.time, nodes);

        // 5. Pressures of the cells from the particles.
        pressure.particles_to_cells(&at, particles, cells);

        // 6. Momentum and continuity together, Eqs. (5) and (9), damped on demand: accelerations a_I and pressures p_E^L.
        let report = pressure.solve(&at, particles, cells, nodes)?;

        // 7. Velocities of the nodes, v_I^L.
        nodes.advance(active, dt);
        velocity_update.look_at_grid(grid, active, &**shape, nodes, particles);
        dilation.measure(&**shape, grid, active, nodes, particles, at_particles);

        let mut failure = None;
        for group in groups {
            let all = group.particles();
            for start in all.clone().step_by(BLOCK) {
                let block = start..all.end.min(start + BLOCK);
                let at_particles = &mut at_particles[..block.len()];
                let increments = &mut increments[..block.len()];

                // 8. Strain increments from v_I^L.
                shape.nodes_to_particles(grid, nodes, particles, block.clone(), at_particles);
                dilation.impose(&particles.cell[block.clone()], at_particles);
                strain_increments(at_particles, dt, increments);

                // 9. Effective stresses by the constitutive law.
                let stresses = &mut particles.stress[block.clone()];
                let volumes = &particles.volume[block.clone()];
                viscosity.remember(block.clone(), stresses, increments);
                let outcome = group.update_block(start - all.start, stresses, increments, volumes);
                viscosity.resist(block.clone(), stresses, damping.stiffness / dt);
                *strain_energy += outcome.work;
                if let (None, Some((p, source))) = (&failure, outcome.failure) {
                    let particle = start + p;
                    let position = particles.position[particle].iter().copied().collect();
                    let material = group.name().to_owned();
                    failure = Some(StepError::Law { material, particle, position, time: at.time, source });
                }

                // 10. Velocities of the particles, with a_I (MPM①) or v_I^L (MPM②), positions, volumes and pores.
                velocity_update.update_block(&mut particles.velocity[block.clone()], at_particles, dt);
                let porosities = &mut porosities[..block.len()];
                porosities.copy_from_slice(&particles.porosity[block.clone()]);
                particles.advance(block.clone(), at_particles, dt);
                let conductivities = &mut particles.conductivity[block.clone()];
                group.conductivity_law().update_block(porosities, &particles.porosity[block], conductivities);
            }
        }

        // 11. Pressures of the cells back to the particles.
        pressure.cells_to_particles(&at, cells, particles);

        // 12. Next step.
        *clock = after;
        *outflow += dt * report.outflow_rate;
        match failure.or_else(|| closed_pores(particles, at.time)) {
            Some(error) => Err(error),
            None => Ok(StepReport { time: after.time(), pressure: report }),
        }
    }

    /// Finds the cells of the particles and, where one has changed, the active part of the grid.
    fn locate(&mut self) -> Result<(), StepError> {
        let Parts { grid, particles, shape, .. } = &mut self.parts;
        let moved =
            particles.locate(grid).map_err(|outside| StepError::Outside { time: self.clock.time(), outside })?;
        if moved {
            let occupied = particles.cell.iter().copied();
            self.active.rebuild(occupied, |cell, visit| shape.visit_stencil(grid, cell, visit));
        }
        Ok(())
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

    /// The material points.
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
        self.strain_energy
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

/// Step 8: strain and spin increments from the velocity gradients.
///
/// # Equation
///
/// ```text
/// Δε = ½ (∇v + ∇vᵀ) Δt      Δω = ½ (∇v − ∇vᵀ) Δt
/// ```
fn strain_increments<const D: usize>(at_particles: &[Gathered<D>], dt: f64, increments: &mut [Increment]) {
    for (at, increment) in at_particles.iter().zip(increments) {
        let gradient = at.velocity_gradient * dt;
        *increment = Increment { strain: Sym3::symmetric_part(&embed(&gradient)), spin: spin(&gradient) };
    }
}

impl<const D: usize> NodeFields<D> {
    /// v_I = Σ M_p V_p N_I / m_I; zero where a support holds, one for all nodes that move as one.
    fn momentum_to_velocity(&mut self, active: &ActiveSet) {
        let mut field = std::mem::take(&mut self.velocity_old);
        self.momenta_to_velocities(active, &mut field);
        self.velocity_old = field;
    }

    /// Adds m_I b to the forces.
    fn add_gravity(&mut self, active: &ActiveSet, gravity: Vector<D>) {
        for &node in active.nodes() {
            self.force[node as usize] += gravity * self.mass[node as usize];
        }
    }

    /// v_I^L = v_I + Δt a_I.
    fn advance(&mut self, active: &ActiveSet, dt: f64) {
        for &node in active.nodes() {
            let node = node as usize;
            self.velocity[node] = self.velocity_old[node] + self.acceleration[node] * dt;
        }
    }
}

impl<const D: usize> Particles<D> {
    /// Moves particles with the grid, X_p ← X_p + Δt v^L(X_p), and stretches their volumes, boxes and pores.
    ///
    /// The grains keep their volume: (1 − n) V stays. Dry ground has n = 0 and no pores to follow.
    fn advance(&mut self, block: std::ops::Range<usize>, at_particles: &[Gathered<D>], dt: f64) {
        for (p, at) in block.zip(at_particles) {
            let gradient = at.velocity_gradient * dt;
            self.position[p] += at.velocity * dt;
            let ratio = volume_ratio(&gradient);
            self.volume[p] *= ratio;
            if self.porosity[p] > 0.0 {
                self.porosity[p] = 1.0 - (1.0 - self.porosity[p]) / ratio;
            }
            for axis in 0..D {
                self.half_size[p][axis] *= 1.0 + gradient[(axis, axis)];
            }
        }
    }
}
