//! A box of soil on its grid, made in a few lines.
//!
//! ```
//! use tsutsumi::boundary::History;
//! use tsutsumi_testkit::body::{Body, down};
//! use tsutsumi_testkit::reading::top;
//!
//! // The paper's soil, 10 m high, one cell of 1 m wide, on rollers, drained and loaded with 50 kPa at its top.
//! let ramp = History::new(vec![[0.0, 0.0], [1000.0, 1.0]]);
//! let mut solver = Body::<2>::column(10.0, 1.0)
//!     .drained(top::<2>())
//!     .load_on_surface(top::<2>(), down(50e3), ramp)
//!     .build();
//! solver.step(0.005).unwrap();
//! ```

use tsutsumi::boundary::{AppliedTo, AxisSet, Boundary, History, Load};
use tsutsumi::damping::Damping;
use tsutsumi::grid::{Grid, Side};
use tsutsumi::law::{ConstitutiveLaw, Group, LinearElastic};
use tsutsumi::particles::{Particle, Particles};
use tsutsumi::pressure::{CellPressure, Coupled, Dry, Fluid, ParticlePressure, PressureScheme, Quadrature};
use tsutsumi::shape::Linear;
use tsutsumi::solver::{Parts, Solver, StepError, StressLast, StressOrder, VolumetricStrain};
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::{Mpm1, VelocityUpdate};

use crate::reading::outermost;

/// The soil of Goto et al., sec. 3: G = 1.5 MPa, E_oed = 16.5 MPa.
pub const PAPER_SOIL: LinearElastic = LinearElastic { young: 4.35e6, poisson: 0.45 };

/// Its density with the pore water (kg/m³).
pub const PAPER_DENSITY: f64 = 1500.0;

/// Its hydraulic conductivity k (m/s).
pub const PAPER_CONDUCTIVITY: f64 = 5.52e-5;

/// Its porosity n (–): chosen, the paper has none.
pub const POROSITY: f64 = 0.4;

/// Water: chosen, the paper has no values.
pub const WATER: Fluid = Fluid { density: 1000.0, bulk_modulus: 2.2e9, unit_weight: 9800.0 };

/// A quantity as a function of position.
type Field<T, const D: usize> = Box<dyn Fn(Vector<D>) -> T>;

/// A vector of this length (any unit) that points down along the last axis.
pub fn down<const D: usize>(length: f64) -> Vector<D> {
    Vector::from_fn(|axis, _| if axis == D - 1 { -length } else { 0.0 })
}

/// A traction (Pa) on a side of the body.
struct Traction<const D: usize> {
    side: Side,
    traction: Field<Vector<D>, D>,
    history: History,
    applied_to: AppliedTo,
}

/// A body in the shape of a box, to be changed by its methods and then built.
///
/// It starts as the paper's soil, saturated, without gravity, supports, loads or drainage, two particles per cell and
/// axis, MPM①, K_v summed over the material points.
pub struct Body<const D: usize, L: ConstitutiveLaw = LinearElastic> {
    grid: Grid<D>,
    from: Vector<D>,
    to: Vector<D>,
    particles_per_cell: [usize; D],
    law: L,
    density: f64,
    conductivity: Field<f64, D>,
    fluid: Option<Fluid>,
    quadrature: Quadrature,
    fluid_inertia: bool,
    gravity: f64,
    pressure_stabilisation: f64,
    direct_solver_up_to: Option<usize>,
    damping: Damping,
    volumetric_strain: VolumetricStrain,
    stress_order: Box<dyn StressOrder>,
    particle_pressure: Box<dyn ParticlePressure<D>>,
    shape: Box<dyn Transfer<D>>,
    velocity_update: Box<dyn VelocityUpdate<D>>,
    rollers: bool,
    closed: bool,
    plates: Vec<Side>,
    drained: Vec<Side>,
    tractions: Vec<Traction<D>>,
    stress: Field<Sym3, D>,
    pressure: Field<f64, D>,
    velocity: Field<Vector<D>, D>,
    moved: Field<Vector<D>, D>,
}

impl<const D: usize> Body<D> {
    /// A free body between two corners (m), on a grid from the origin with `cells` cells of edge `spacing` (m).
    #[expect(clippy::expect_used, reason = "a testkit reports by panicking")]
    pub fn free(from: Vector<D>, to: Vector<D>, spacing: f64, cells: [usize; D]) -> Self {
        Body {
            grid: Grid::new(Vector::zeros(), Vector::repeat(spacing), cells).expect("a grid for the body"),
            from,
            to,
            particles_per_cell: [2; D],
            law: PAPER_SOIL,
            density: PAPER_DENSITY,
            conductivity: Box::new(|_| PAPER_CONDUCTIVITY),
            fluid: Some(WATER),
            quadrature: Quadrature::MaterialPoints,
            fluid_inertia: true,
            gravity: 0.0,
            pressure_stabilisation: 0.0,
            direct_solver_up_to: None,
            damping: Damping::default(),
            volumetric_strain: VolumetricStrain::default(),
            stress_order: Box::new(StressLast),
            particle_pressure: Box::new(CellPressure),
            shape: Box::new(Linear),
            velocity_update: Box::new(Mpm1),
            rollers: false,
            closed: false,
            plates: Vec::new(),
            drained: Vec::new(),
            tractions: Vec::new(),
            stress: Box::new(|_| Sym3::ZERO),
            pressure: Box::new(|_| 0.0),
            velocity: Box::new(|_| Vector::zeros()),
            moved: Box::new(|position| position),
        }
    }

    /// A column on rollers, one cell wide, that stands on the base of the grid. One row of cells above it is empty.
    pub fn column(height: f64, spacing: f64) -> Self {
        Body::layer(height, spacing, 1)
    }

    /// A layer on rollers, `width` cells wide along every axis but the last. One row of cells above it is empty.
    pub fn layer(height: f64, spacing: f64, width: usize) -> Self {
        let rows = (height / spacing - 1e-9).ceil() as usize + 1;
        let cells = std::array::from_fn(|axis| if axis == D - 1 { rows } else { width });
        let to = Vector::from_fn(|axis, _| if axis == D - 1 { height } else { width as f64 * spacing });
        Body::free(Vector::zeros(), to, spacing, cells).on_rollers()
    }
}

impl<const D: usize, L: ConstitutiveLaw> Body<D, L> {
    /// The same body with another law.
    pub fn law<M: ConstitutiveLaw>(self, law: M) -> Body<D, M> {
        Body {
            law,
            grid: self.grid,
            from: self.from,
            to: self.to,
            particles_per_cell: self.particles_per_cell,
            density: self.density,
            conductivity: self.conductivity,
            fluid: self.fluid,
            quadrature: self.quadrature,
            fluid_inertia: self.fluid_inertia,
            gravity: self.gravity,
            pressure_stabilisation: self.pressure_stabilisation,
            direct_solver_up_to: self.direct_solver_up_to,
            damping: self.damping,
            volumetric_strain: self.volumetric_strain,
            shape: self.shape,
            velocity_update: self.velocity_update,
            stress_order: self.stress_order,
            particle_pressure: self.particle_pressure,
            rollers: self.rollers,
            closed: self.closed,
            plates: self.plates,
            drained: self.drained,
            tractions: self.tractions,
            stress: self.stress,
            pressure: self.pressure,
            velocity: self.velocity,
            moved: self.moved,
        }
    }

    /// Particles per cell along each axis. Their boxes are a spacing divided by this number, counted from the body's
    /// lower corner, so that none straddles a grid line when the corner is on a multiple of it.
    pub fn particles_per_cell(mut self, particles_per_cell: [usize; D]) -> Self {
        self.particles_per_cell = particles_per_cell;
        self
    }

    /// The density of soil and water together (kg/m³).
    pub fn density(mut self, density: f64) -> Self {
        self.density = density;
        self
    }

    /// The hydraulic conductivity (m/s) as a function of position.
    pub fn conductivity(mut self, conductivity: impl Fn(Vector<D>) -> f64 + 'static) -> Self {
        self.conductivity = Box::new(conductivity);
        self
    }

    /// No pore water.
    pub fn dry(mut self) -> Self {
        self.fluid = None;
        self
    }

    /// Another pore water.
    pub fn fluid(mut self, fluid: Fluid) -> Self {
        self.fluid = Some(fluid);
        self
    }

    /// Where K_v, storage and conductance are summed.
    pub fn quadrature(mut self, quadrature: Quadrature) -> Self {
        self.quadrature = quadrature;
        self
    }

    /// Leaves out the inertia of the water relative to the soil, the term with k/g.
    pub fn without_fluid_inertia(mut self) -> Self {
        self.fluid_inertia = false;
        self
    }

    /// Gravity g (m/s²), down along the last axis.
    pub fn gravity(mut self, gravity: f64) -> Self {
        self.gravity = gravity;
        self
    }

    /// The stabilisation of the pressure's checkerboard, see [`Coupled::stabilised`]; it starts with none.
    pub fn pressure_stabilisation(mut self, softening: f64) -> Self {
        self.pressure_stabilisation = softening;
        self
    }

    /// Another limit for the direct solver of the pressures, see [`Coupled::with_direct_solver_up_to`].
    pub fn direct_solver_up_to(mut self, mean_square_width: usize) -> Self {
        self.direct_solver_up_to = Some(mean_square_width);
        self
    }

    /// The damping of the nodes' motion; it starts with none.
    pub fn damping(mut self, damping: Damping) -> Self {
        self.damping = damping;
        self
    }

    /// The volume change of a particle is the mean of its cell.
    pub fn cell_averaged(mut self) -> Self {
        self.volumetric_strain = VolumetricStrain::CellAveraged;
        self
    }

    /// How the cells' pressures come back to the particles; as in the paper without it.
    #[must_use]
    pub fn particle_pressure(self, particle_pressure: impl ParticlePressure<D> + 'static) -> Self {
        self.boxed_particle_pressure(Box::new(particle_pressure))
    }

    /// The same for one that is chosen at run time.
    #[must_use]
    pub fn boxed_particle_pressure(mut self, particle_pressure: Box<dyn ParticlePressure<D>>) -> Self {
        self.particle_pressure = particle_pressure;
        self
    }

    /// When the stresses follow the strains; last without it.
    #[must_use]
    pub fn stress_order(self, stress_order: impl StressOrder + 'static) -> Self {
        self.boxed_stress_order(Box::new(stress_order))
    }

    /// The same for one that is chosen at run time.
    #[must_use]
    pub fn boxed_stress_order(mut self, stress_order: Box<dyn StressOrder>) -> Self {
        self.stress_order = stress_order;
        self
    }

    /// The velocity update.
    pub fn velocity_update(mut self, velocity_update: impl VelocityUpdate<D> + 'static) -> Self {
        self.velocity_update = Box::new(velocity_update);
        self
    }

    /// A velocity update chosen at run time.
    pub fn boxed_velocity_update(mut self, velocity_update: Box<dyn VelocityUpdate<D>>) -> Self {
        self.velocity_update = velocity_update;
        self
    }

    /// The shape function; it starts with the linear one.
    pub fn shape(mut self, shape: impl Transfer<D> + 'static) -> Self {
        self.shape = Box::new(shape);
        self
    }

    /// A shape function chosen at run time.
    pub fn boxed_shape(mut self, shape: Box<dyn Transfer<D>>) -> Self {
        self.shape = shape;
        self
    }

    /// Rollers on the base of the grid and on all its sides but the top.
    pub fn on_rollers(mut self) -> Self {
        self.rollers = true;
        self
    }

    /// Rollers on all sides of the grid, its top too.
    pub fn in_a_box(mut self) -> Self {
        self.closed = true;
        self.on_rollers()
    }

    /// A rigid plate on a side of the body that lies on a grid line: the nodes there move as one along the side's axis.
    pub fn plate(mut self, side: Side) -> Self {
        self.plates.push(side);
        self
    }

    /// Drains the particles at a side of the body through that side.
    pub fn drained(mut self, side: Side) -> Self {
        self.drained.push(side);
        self
    }

    /// A traction (Pa) on a side, acting on the true surface.
    pub fn load_on_surface(self, side: Side, traction: Vector<D>, history: History) -> Self {
        self.load(side, move |_| traction, history, AppliedTo::Surface(side))
    }

    /// A traction (Pa) on a side, acting at the particles there, as in the paper.
    pub fn load_on_particles(self, side: Side, traction: Vector<D>, history: History) -> Self {
        self.load(side, move |_| traction, history, AppliedTo::Particles)
    }

    /// A traction (Pa) that varies with the position of the particles at a side, acting on the true surface at once.
    pub fn load_varying(self, side: Side, traction: impl Fn(Vector<D>) -> Vector<D> + 'static) -> Self {
        self.load(side, traction, History::new(vec![]), AppliedTo::Surface(side))
    }

    fn load(
        mut self,
        side: Side,
        traction: impl Fn(Vector<D>) -> Vector<D> + 'static,
        history: History,
        applied_to: AppliedTo,
    ) -> Self {
        self.tractions.push(Traction { side, traction: Box::new(traction), history, applied_to });
        self
    }

    /// The initial effective stress (Pa, positive in tension) as a function of position.
    pub fn stress(mut self, stress: impl Fn(Vector<D>) -> Sym3 + 'static) -> Self {
        self.stress = Box::new(stress);
        self
    }

    /// The initial pore pressure (Pa, positive in compression) as a function of position.
    pub fn pressure(mut self, pressure: impl Fn(Vector<D>) -> f64 + 'static) -> Self {
        self.pressure = Box::new(pressure);
        self
    }

    /// The initial velocity (m/s) as a function of position.
    pub fn velocity(mut self, velocity: impl Fn(Vector<D>) -> Vector<D> + 'static) -> Self {
        self.velocity = Box::new(velocity);
        self
    }

    /// Puts particles elsewhere than at the centres of their boxes (m), where all other fields are taken.
    pub fn moved(mut self, moved: impl Fn(Vector<D>) -> Vector<D> + 'static) -> Self {
        self.moved = Box::new(moved);
        self
    }

    /// The body on its grid.
    #[expect(clippy::expect_used, reason = "a testkit reports by panicking")]
    pub fn build(self) -> Solver<D> {
        self.try_build().expect("every particle inside the grid")
    }

    /// The body on its grid, for bodies that may not fit.
    ///
    /// # Errors
    /// A particle outside the grid.
    pub fn try_build(self) -> Result<Solver<D>, StepError> {
        let particles = self.particles();
        let boundary = self.boundary(&particles);
        let pressure: Box<dyn PressureScheme<D>> = match self.fluid {
            Some(fluid) => {
                let scheme = Coupled::new(fluid, self.quadrature, self.fluid_inertia);
                let scheme = scheme.with_particle_pressure(self.particle_pressure);
                let scheme = scheme.stabilised(self.pressure_stabilisation);
                match self.direct_solver_up_to {
                    Some(width) => Box::new(scheme.with_direct_solver_up_to(width)),
                    None => Box::new(scheme),
                }
            }
            None => Box::new(Dry),
        };
        let group = Group::new("soil", self.law, 0..particles.len(), &particles.stress);
        Solver::new(Parts {
            grid: self.grid,
            particles,
            groups: vec![Box::new(group)],
            boundary,
            gravity: down(self.gravity),
            shape: self.shape,
            velocity_update: self.velocity_update,
            stress_order: self.stress_order,
            pressure,
            damping: self.damping,
            volumetric_strain: self.volumetric_strain,
        })
    }

    /// Equal boxes that fill the body, cell after cell, in each of them x fastest.
    fn particles(&self) -> Particles<D> {
        let counts: [usize; D] = std::array::from_fn(|axis| {
            let edge = self.grid.spacing()[axis] / self.particles_per_cell[axis] as f64;
            (((self.to - self.from)[axis] / edge).round() as usize).max(1)
        });
        let size = Vector::from_fn(|axis, _| (self.to - self.from)[axis] / counts[axis] as f64);
        let wet = if self.fluid.is_some() { 1.0 } else { 0.0 };
        let mut particles = Particles::default();
        particles.reserve_exact(counts.iter().product());
        let place = |number: usize| {
            let mut rest = number;
            Vector::from_fn(|axis, _| {
                let index = rest % counts[axis];
                rest /= counts[axis];
                self.from[axis] + size[axis] * (index as f64 + 0.5)
            })
        };
        let mut positions: Vec<Vector<D>> = (0..counts.iter().product()).map(place).collect();
        positions.sort_by_cached_key(|position| self.grid.cell_at(&(self.moved)(*position)));
        for position in positions {
            particles.push(Particle {
                position: (self.moved)(position),
                half_size: size * 0.5,
                velocity: (self.velocity)(position),
                density: self.density,
                stress: (self.stress)(position),
                pressure: wet * (self.pressure)(position),
                porosity: wet * POROSITY,
                conductivity: wet * (self.conductivity)(position),
            });
        }
        for &side in &self.drained {
            for p in outermost(&particles, side) {
                particles.drained[p].insert(side);
            }
        }
        particles
    }

    fn boundary(&self, particles: &Particles<D>) -> Boundary<D> {
        let mut boundary = Boundary::free(&self.grid);
        if self.rollers {
            for side in Side::all::<D>().filter(|side| self.closed || !(side.upper && side.axis == D - 1)) {
                let mut normal = AxisSet::default();
                normal.insert(side.axis);
                boundary.fix_side(&self.grid, side, normal);
            }
        }
        for plate in &self.plates {
            let place = if plate.upper { self.to } else { self.from }[plate.axis];
            let reach = 1e-6 * self.grid.spacing()[plate.axis];
            boundary.tie(&self.grid, plate.axis, |node| (node[plate.axis] - place).abs() < reach);
        }
        for load in &self.tractions {
            let force = |p: usize| {
                let edges = particles.half_size[p] * 2.0;
                let area: f64 = (0..D).filter(|&axis| axis != load.side.axis).map(|axis| edges[axis]).product();
                (p, (load.traction)(particles.position[p]) * area)
            };
            boundary.push_load(Load {
                forces: outermost(particles, load.side).into_iter().map(force).collect(),
                history: load.history.clone(),
                applied_to: load.applied_to,
            });
        }
        boundary
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::assert_close;
    use crate::reading::{base, surface, top};

    #[test]
    fn a_column_is_filled_supported_and_loaded() {
        let solver = Body::<3>::column(2.5, 1.0)
            .drained(top::<3>())
            .load_on_particles(top::<3>(), down(7.0), History::new(vec![]))
            .build();
        let particles = solver.particles();
        assert_eq!((particles.len(), solver.grid().cells()), (20, [1, 1, 4]));
        assert_close("mass", particles.mass.iter().sum(), 2.5 * PAPER_DENSITY, 1e-9);
        let carriers = outermost(particles, top::<3>());
        assert_eq!(carriers, [16, 17, 18, 19]);
        assert_close("top", surface(particles, &carriers, top::<3>()), 2.5, 1e-15);
        assert_eq!(outermost(particles, base::<3>()), [0, 1, 2, 3]);
        let load: Vector<3> = solver.boundary().loads()[0].forces.iter().map(|(_, force)| force).sum();
        assert_close("load", load[2], -7.0, 1e-12);
        assert!(carriers.iter().all(|&p| particles.drained[p].contains(top::<3>())));
        assert!(particles.drained[0].is_empty());
    }

    #[test]
    fn fields_and_laws_reach_the_particles() {
        let law = LinearElastic { young: 1e6, poisson: 0.0 };
        let solver = Body::<1>::column(1.0, 1.0)
            .law(law)
            .density(2000.0)
            .stress(|x| Sym3::diagonal(x[0], 0.0, 0.0))
            .pressure(|x| 2.0 * x[0])
            .velocity(|x| x * 3.0)
            .build();
        let particles = solver.particles();
        assert_eq!((particles.stress.at(1).xx, particles.pressure[1], particles.velocity[1][0]), (0.75, 1.5, 2.25));
        assert_eq!(particles.mass, [1000.0; 2]);
        assert_eq!(solver.groups()[0].wave_moduli(&mut particles.stress.iter()).0, 1e6);
    }
}
