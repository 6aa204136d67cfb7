//! The u–p finite element method that the paper compares with: elements fixed to the body, pore pressure by finite
//! differences at the element centres, implicit in time.
//!
//! It solves the equations of [`Coupled`](tsutsumi::pressure::Coupled) with the same laws, supports, loads and drained
//! sides, but independently of it in time and space: nodes keep their displacements and velocities, stresses live at Gauss
//! points, nothing is carried by particles, and momentum and continuity are solved together without eliminating either.

mod continuity;
mod system;
mod unknowns;

use nalgebra::Vector6;

use self::continuity::Continuity;
use self::system::{Singular, System};
use self::unknowns::Unknowns;
use tsutsumi::boundary::Boundary;
use tsutsumi::grid::{ActiveSet, CellFields, Grid, NodeFields};
use tsutsumi::law::{Increment, LawError, MaterialGroup, Question};
use tsutsumi::particles::{LocalMotion, OutsideGrid, Particles, Stresses};
use tsutsumi::pressure::{Fluid, PressureReport};
use tsutsumi::shape::Linear;
use tsutsumi::solver::{Clock, StepReport};
use tsutsumi::tensor::{Matrix6, Sym3, Vector, embed};
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::Gathered;

/// Newton's iterations in a step, at most.
const MAX_ITERATIONS: usize = 40;
/// Forces and flows are in balance when what is left of them is this small against the largest of their parts.
const TOLERANCE: f64 = 1e-9;

/// Newmark's parameters.
///
/// ```text
/// u = u_t + Δt v_t + Δt² [(½ − β) a_t + β a]          v = v_t + Δt [(1 − γ) a_t + γ a]
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newmark {
    /// Weight β of the new acceleration in the displacement (–), positive; stable for any step with 2β ≥ γ.
    pub beta: f64,
    /// Weight γ of the new acceleration in the velocity (–), at least ½.
    pub gamma: f64,
}

/// What a finite element model is made of.
pub struct Parts<const D: usize> {
    /// The mesh: every cell that holds Gauss points is an element.
    pub grid: Grid<D>,
    /// The Gauss points, see [`gauss_points`].
    pub points: Particles<D>,
    /// The materials; their points follow each other without gaps.
    pub groups: Vec<Box<dyn MaterialGroup>>,
    /// Supports and loads.
    pub boundary: Boundary<D>,
    /// Gravity b (m/s²).
    pub gravity: Vector<D>,
    /// The pore water; `None` for dry ground.
    pub fluid: Option<Fluid>,
    /// Keeps the term with k/g in the continuity equation.
    pub fluid_inertia: bool,
    /// Newmark's parameters.
    pub newmark: Newmark,
}

/// A place and half length on one axis (m) for each Gauss point of the elements between two coordinates, and the length
/// that it stands for.
///
/// Two points per element integrate the stiffness of linear elements exactly. The half length reaches to the nearest side
/// of the element, so that the outer faces of the outermost points are the true surface.
pub fn gauss_points(lower: f64, upper: f64, num_elements: usize) -> Vec<GaussPoint> {
    let length = (upper - lower) / num_elements as f64;
    let to_side = 0.5 * length * (1.0 - 1.0 / 3.0_f64.sqrt());
    let point = |place: f64| GaussPoint { place, half_length: to_side, weight: 0.5 * length };
    (0..num_elements)
        .flat_map(|element| {
            let start = lower + element as f64 * length;
            [point(start + to_side), point(start + length - to_side)]
        })
        .collect()
}

/// A Gauss point on one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussPoint {
    /// Its coordinate (m).
    pub place: f64,
    /// The distance to the nearest side of its element (m).
    pub half_length: f64,
    /// The length that it stands for (m).
    pub weight: f64,
}

/// Why a step could not be made. The body is as at the start of the step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FiniteElementError {
    /// A Gauss point is outside the mesh.
    #[error(transparent)]
    Outside(#[from] OutsideGrid),
    /// A law failed.
    #[error(
        "at t = {time:.6} s the law of material `{material}` failed at {position:.4?} m: {source}; take a shorter step"
    )]
    Law {
        /// The name of the material.
        material: String,
        /// The Gauss point.
        point: usize,
        /// Its position at the start (m).
        position: Vec<f64>,
        /// The time at the end of the step (s).
        time: f64,
        /// What the law was asked; the group still holds the history.
        question: Box<Question>,
        /// The law's reason.
        source: Box<LawError>,
    },
    /// A force or flow is infinite or not a number.
    #[error("at t = {time:.6} s a force is not finite: are the loads and the step?")]
    NotFinite {
        /// The time at the end of the step (s).
        time: f64,
    },
    /// The equations have no unique solution.
    #[error(
        "at t = {time:.6} s the equations have no unique solution: the law's stiffness may have vanished; take a shorter step"
    )]
    Singular {
        /// The time at the end of the step (s).
        time: f64,
    },
    /// Newton's iteration did not converge.
    #[error(
        "at t = {time:.6} s Newton's iteration did not converge: residual {residual:.3e} of the forces after \
         {MAX_ITERATIONS} iterations; take a shorter step"
    )]
    NotConverged {
        /// The time at the end of the step (s).
        time: f64,
        /// What is left of the forces or flows over the largest of their parts (–).
        residual: f64,
    },
}

/// A body of finite elements, advanced step by step.
///
/// # Equation
///
/// ```text
/// M a + ∫ Bᵀ σ' dΩ − K_v p_w = F                                        momentum, Eq. (5)
/// K_vᵀ (v − k/g a) + C (p_w − p_w|t) + L p_w + q_g = 0                  continuity, Eq. (8) in the form of Eq. (9)
/// ```
///
/// with the lumped mass M, the law's stress σ' at the end of the step, Newmark's u and v ([`Newmark`]), and C, L and q_g as
/// in [`Coupled`](tsutsumi::pressure::Coupled). Newton's method with the law's tangent solves both for displacements and
/// pressures. Small displacements: the mesh keeps its shape.
///
/// # Reference
///
/// The method called FEM by Goto et al.: Akai and Tamura (1978), as in the program LIQCA. Known here from the paper and
/// the derivation in the book, "The continuity equation".
pub struct FiniteElements<const D: usize> {
    parts: Parts<D>,
    /// The points as they have moved, for output.
    moved: Particles<D>,
    active: ActiveSet,
    cells: CellFields,
    continuity: Continuity<D>,
    unknowns: Unknowns<D>,
    system: System,
    /// Sums at the nodes: masses and forces.
    sums: NodeFields<D>,
    /// Nodal displacement of the step so far (m), velocity and acceleration at its start and its end.
    step: Motion<D>,
    trial_stress: Stresses,
    tangents: Vec<Matrix6>,
    /// The step (s) and the tangents that the factors in `system` are made of.
    factorized: (f64, Vec<Matrix6>),
    clock: Clock,
    strain_energy: f64,
    outflow: f64,
    /// Outflow at the end of the last step (m³/s).
    outflow_rate: f64,
}

/// The motion of the nodes in a step.
#[derive(Default)]
struct Motion<const D: usize> {
    displacement: Vec<Vector<D>>,
    velocity_old: Vec<Vector<D>>,
    acceleration_old: Vec<Vector<D>>,
    velocity: Vec<Vector<D>>,
    acceleration: Vec<Vector<D>>,
}

impl<const D: usize> Motion<D> {
    /// Velocities and accelerations from the displacements.
    fn newmark(&mut self, newmark: Newmark, dt: f64) {
        let Newmark { beta, gamma } = newmark;
        for node in 0..self.displacement.len() {
            let (v, a) = (self.velocity_old[node], self.acceleration_old[node]);
            let forward = self.displacement[node] - v * dt - a * (dt * dt * (0.5 - beta));
            self.acceleration[node] = forward / (beta * dt * dt);
            self.velocity[node] = v + (a * (1.0 - gamma) + self.acceleration[node] * gamma) * dt;
        }
    }

    fn begin_step(&mut self) {
        self.displacement.fill(Vector::zeros());
        self.velocity_old.clone_from(&self.velocity);
        self.acceleration_old.clone_from(&self.acceleration);
    }

    /// Takes back a step that failed.
    fn restore(&mut self) {
        self.velocity.clone_from(&self.velocity_old);
        self.acceleration.clone_from(&self.acceleration_old);
    }
}

impl<const D: usize> FiniteElements<D> {
    /// A model at time zero: velocities, stresses and pressures are those of the points.
    ///
    /// # Errors
    /// A point outside the mesh.
    pub fn new(mut parts: Parts<D>) -> Result<Self, FiniteElementError> {
        parts.points.locate(&parts.grid)?;
        let (grid, points) = (&parts.grid, &parts.points);
        let mut active = ActiveSet::new(grid);
        active.update(points.located(), |cell, visit| Linear.visit_stencil(grid, cell, visit));
        let mut sums = NodeFields::new(grid);
        Linear.particles_to_nodes(grid, &active, points, LocalMotion::Nothing, &mut sums);
        parts.boundary.hold(&active, &mut sums);
        let unknowns = Unknowns::new(grid, &active, &sums, parts.fluid.is_some());
        let continuity = Continuity::new(&parts, &active);
        let mut cells = CellFields::new(grid);
        continuity.mean_pressures(points, &active, &mut cells);
        let outflow_rate = continuity.outflow_rate(&cells);
        let zeros = vec![Vector::zeros(); grid.num_nodes()];
        for tie in &sums.ties {
            tie.gather(&mut sums.velocity_old);
        }
        let momentum_to_velocity = |node: usize| sums.velocity_old[node].component_mul(&sums.mobility[node]);
        let step = Motion {
            velocity: (0..grid.num_nodes()).map(momentum_to_velocity).collect(),
            displacement: zeros.clone(),
            velocity_old: zeros.clone(),
            acceleration_old: zeros.clone(),
            acceleration: zeros,
        };
        Ok(FiniteElements {
            moved: points.clone(),
            trial_stress: points.stress.clone(),
            tangents: vec![Matrix6::zeros(); points.len()],
            active,
            cells,
            continuity,
            unknowns,
            system: System::default(),
            sums,
            step,
            factorized: (0.0, Vec::new()),
            clock: Clock::default(),
            strain_energy: 0.0,
            outflow: 0.0,
            outflow_rate,
            parts,
        })
    }

    /// Advances the body by a step of `dt` (s).
    ///
    /// # Errors
    /// See [`FiniteElementError`]. The body is then as it was.
    pub fn step(&mut self, dt: f64) -> Result<StepReport, FiniteElementError> {
        let after = self.clock.after(dt);
        self.step.begin_step();
        self.cells.pressure_old.clone_from(&self.cells.pressure);
        match self.iterate(dt, after.time()) {
            Ok(iterations) => {
                self.clock = after;
                let outflow_rate = self.accept(dt);
                Ok(StepReport { time: after.time(), pressure: PressureReport { iterations, outflow_rate } })
            }
            Err(error) => {
                self.step.restore();
                self.cells.pressure.clone_from(&self.cells.pressure_old);
                Err(error)
            }
        }
    }

    /// Newton's iteration on displacements and pressures; returns the number of corrections.
    fn iterate(&mut self, dt: f64, time: f64) -> Result<usize, FiniteElementError> {
        let mut left = 0.0;
        for iteration in 0..MAX_ITERATIONS {
            self.step.newmark(self.parts.newmark, dt);
            self.try_laws(time)?;
            let mut residual = self.unknowns.zeros();
            left = self.momentum_residual(time, &mut residual);
            left = left.max(self.continuity.residual(
                &self.unknowns,
                &self.cells,
                (&self.step.velocity, &self.step.acceleration),
                dt,
                &mut residual,
            ));
            let singular = |_: Singular| FiniteElementError::Singular { time };
            // A comparison of maxima would pass over a value that is not a number.
            if !residual.iter().all(|value| value.is_finite()) {
                return Err(FiniteElementError::NotFinite { time });
            }
            if left <= TOLERANCE {
                return Ok(iteration);
            }
            self.factorize(dt).map_err(singular)?;
            self.system.solve(&mut residual).map_err(singular)?;
            self.unknowns.correct(&self.active, &residual, &mut self.step.displacement, &mut self.cells.pressure);
        }
        Err(FiniteElementError::NotConverged { time, residual: left })
    }

    /// Strain increments at the points, from the nodal displacements of the step.
    fn gather(&mut self, values: Gathering) -> Vec<Gathered<D>> {
        let field = match values {
            Gathering::Displacement => &self.step.displacement,
            Gathering::Velocity => &self.step.velocity,
        };
        self.sums.velocity.clone_from(field);
        let count = self.parts.points.len();
        let mut at_points = vec![Gathered::default(); count];
        Linear.nodes_to_particles(&self.parts.grid, &self.sums, self.parts.points.places(), &mut at_points);
        at_points
    }

    /// Stresses and tangents for the displacements so far.
    fn try_laws(&mut self, time: f64) -> Result<(), FiniteElementError> {
        let at_points = self.gather(Gathering::Displacement);
        let points = &self.parts.points;
        for group in &self.parts.groups {
            let range = group.particles();
            for p in range.clone() {
                let strain = strain_of(&at_points[p]);
                let (stress, tangent) =
                    group.trial(p - range.start, points.stress.at(p), strain, f64::INFINITY).map_err(|source| {
                        let increment = Increment { strain, ..Increment::default() };
                        FiniteElementError::Law {
                            material: group.name().to_owned(),
                            point: p,
                            question: Box::new(Question { stress: points.stress.at(p), increment }),
                            position: points.position[p].iter().copied().collect(),
                            time,
                            source: Box::new(source),
                        }
                    })?;
                self.trial_stress.set(p, stress);
                self.tangents[p] = tangent;
            }
        }
        Ok(())
    }

    /// F − ∫ Bᵀ σ' dΩ − M a + K_v p_w into the rows of the displacements; returns its largest component over the largest
    /// of the parts.
    fn momentum_residual(&mut self, time: f64, residual: &mut [f64]) -> f64 {
        let Parts { grid, points, boundary, gravity, .. } = &mut self.parts;
        std::mem::swap(&mut points.stress, &mut self.trial_stress);
        Linear.particles_to_nodes(grid, &self.active, points, LocalMotion::Nothing, &mut self.sums);
        std::mem::swap(&mut points.stress, &mut self.trial_stress);
        let mut largest: f64 = 0.0;
        let mut note = |force: &Vector<D>| largest = largest.max(force.amax());
        for &node in self.active.nodes() {
            let node = node as usize;
            let inertia = self.step.acceleration[node] * self.sums.mass[node];
            let weight = *gravity * self.sums.mass[node];
            [&self.sums.force[node], &inertia, &weight].into_iter().for_each(&mut note);
            self.sums.force[node] += weight - inertia;
        }
        boundary.add_loads(grid, &self.active, &Linear, points, time, &mut self.sums);
        self.continuity.push_nodes(&self.cells, |node, force| {
            note(&force);
            self.sums.force[node] += force;
        });
        self.unknowns.gather_forces(&self.active, &self.sums.force, residual);
        self.unknowns.largest_force(residual) / largest.max(f64::MIN_POSITIVE)
    }

    /// Makes the factors of the matrix of Newton's method, unless those at hand still hold.
    fn factorize(&mut self, dt: f64) -> Result<(), Singular> {
        if self.system.is_factorized() && self.factorized.0 == dt && self.factorized.1 == self.tangents {
            return Ok(());
        }
        self.system.clear();
        self.add_stiffness(dt);
        let Newmark { beta, gamma } = self.parts.newmark;
        let rates = (gamma / (beta * dt), 1.0 / (beta * dt * dt));
        self.continuity.add_to(&mut self.system, &self.unknowns, rates, dt);
        self.system.factorize(self.unknowns.count())?;
        self.factorized = (dt, self.tangents.clone());
        Ok(())
    }

    /// Adds M/(β Δt²) + ∫ Bᵀ D B dΩ.
    fn add_stiffness(&mut self, dt: f64) {
        let inertia = 1.0 / (self.parts.newmark.beta * dt * dt);
        for &node in self.active.nodes() {
            for axis in 0..D {
                if let Some(row) = self.unknowns.of_node(node as usize, axis) {
                    self.system.add(row, row, inertia * self.sums.mass[node as usize]);
                }
            }
        }
        let Parts { grid, points, .. } = &self.parts;
        let mut strains: Vec<(usize, Vector6<f64>)> = Vec::new();
        for p in 0..points.len() {
            strains.clear();
            Linear.visit_weights(grid, points, p, &mut |node, _, gradient| {
                for axis in 0..D {
                    if let Some(row) = self.unknowns.of_node(node, axis) {
                        // The root of the volume on both sides weights the product.
                        let mut displacement = Vector::<D>::zeros();
                        displacement[axis] = points.volume[p].sqrt();
                        let strain = Sym3::symmetric_part(&embed(&(displacement * gradient.transpose())));
                        strains.push((row, strain.to_kelvin()));
                    }
                }
            });
            for (column, of_column) in &strains {
                let stress = self.tangents[p] * of_column;
                for (row, of_row) in &strains {
                    self.system.add(*row, *column, of_row.dot(&stress));
                }
            }
        }
    }

    /// Takes the step: histories, stresses, pressures and what is shown of them. Returns the outflow rate.
    fn accept(&mut self, dt: f64) -> f64 {
        let at_points = self.gather(Gathering::Displacement);
        let velocities = self.gather(Gathering::Velocity);
        let increments: Vec<Increment> =
            at_points.iter().map(|at| Increment { strain: strain_of(at), ..Increment::default() }).collect();
        let points = &mut self.parts.points;
        for group in &mut self.parts.groups {
            let range = group.particles();
            let mut stresses: Vec<Sym3> = points.stress.within(range.clone()).collect();
            // These increments were tried and accepted: none fails.
            let outcome =
                group.update_block(0, &mut stresses, &increments[range.clone()], &points.volume[range.clone()]);
            range.zip(stresses).for_each(|(p, stress)| points.stress.set(p, stress));
            self.strain_energy += outcome.work;
        }
        self.continuity.pressures_to_points(&self.cells, points);
        let moved = &mut self.moved;
        for (p, at) in at_points.iter().enumerate() {
            moved.position[p] += at.velocity;
            moved.velocity[p] = velocities[p].velocity;
            // Gradients on the mesh, which keeps its shape: lengths and volumes grow by shares of what they were.
            moved.volume[p] += points.volume[p] * at.velocity_gradient.trace();
            for axis in 0..D {
                moved.half_size[p][axis] += points.half_size[p][axis] * at.velocity_gradient[(axis, axis)];
            }
        }
        moved.stress.clone_from(&points.stress);
        moved.pressure.clone_from(&points.pressure);
        // With the weights that β = ½ gives velocities in displacements.
        let rate = self.continuity.outflow_rate(&self.cells);
        self.outflow += 0.5 * dt * (self.outflow_rate + rate);
        self.outflow_rate = rate;
        rate
    }

    /// The time (s).
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// The number of steps made.
    pub fn steps(&self) -> u64 {
        self.clock.steps()
    }

    /// The mesh.
    pub fn grid(&self) -> &Grid<D> {
        &self.parts.grid
    }

    /// The Gauss points, moved with the body.
    pub fn points(&self) -> &Particles<D> {
        &self.moved
    }

    /// The materials.
    pub fn groups(&self) -> &[Box<dyn MaterialGroup>] {
        &self.parts.groups
    }

    /// The elements' pressures.
    pub fn cells(&self) -> &CellFields {
        &self.cells
    }

    /// The elements and their nodes.
    pub fn active(&self) -> &ActiveSet {
        &self.active
    }

    /// Work that the effective stress has done on the skeleton since the start (J).
    pub fn strain_energy(&self) -> f64 {
        self.strain_energy
    }

    /// Volume of water that has left through drained sides since the start (m³; m² in 2-D, m in 1-D).
    pub fn outflow(&self) -> f64 {
        self.outflow
    }
}

/// A nodal field whose values at the points are wanted.
#[derive(Clone, Copy)]
enum Gathering {
    Displacement,
    Velocity,
}

fn strain_of<const D: usize>(at: &Gathered<D>) -> Sym3 {
    Sym3::symmetric_part(&embed(&at.velocity_gradient))
}
