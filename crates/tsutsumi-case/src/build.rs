//! From a case to a simulation: bodies become particles, supports become fixed nodes, names become types.

use std::ops::Range;
use std::sync::Arc;

use tsutsumi::boundary::{AppliedTo, AxisSet, Boundary, FluidLoad, GroundMotion, History, Load};
use tsutsumi::damping::Damping;
use tsutsumi::grid::{Grid, Side, SideSet};
use tsutsumi::particles::{Particle, Particles};
use tsutsumi::pressure::{Coupled, Dry, Fluid, ParticlePressure, PressureScheme, Quadrature};
use tsutsumi::solver::{Parts, Solver, StepError, VolumetricStrain};
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi_reference::finite_elements::{self, FiniteElements, Newmark};

use crate::fill::{PointBox, Region};
use crate::motions::{Motion, open_motion};
use crate::registry::{MaterialRequest, choose, particle_pressures, shapes, stress_orders, velocity_updates};
use crate::simulation::{ProbeAt, Simulation};
use crate::{BoxShape, Case, CaseError, CaseSource, Face, KeyPath, Material, PressureQuadrature, Registry, SolverKind};

/// The most particles that a case may ask for: their numbers are 32 bits wide.
const MAX_PARTICLES: f64 = u32::MAX as f64;

/// Makes the simulation that a case describes. The case must have passed [`CaseSource::validate`].
///
/// # Errors
/// Names that the registry does not know, law parameters out of range, states that need gravity where there is none.
pub fn build<const D: usize>(
    source: &CaseSource,
    case: &Case,
    registry: &Registry,
) -> Result<Simulation<D>, CaseError> {
    let grid = build_grid(source, case)?;
    let gravity = case.gravity.as_deref().map_or_else(Vector::zeros, vector);
    let mut particles = Particles::default();
    let mut groups = Vec::new();
    let mut bodies = Vec::new();
    for index in 0..case.bodies.len() {
        let body = fill_body(source, case, &grid, gravity, index, &mut particles)?;
        let stresses = &particles.stress;
        let material = &case.bodies[index].material;
        let Material { law, conductivity_law, .. } = &case.materials[material];
        let (place, particles) = (KeyPath::root().key("materials").key(material), body.particles.clone());
        let request =
            MaterialRequest { source, place, name: material, conductivity_law, particles, stresses, history: None };
        groups.push(registry.group(law, &request)?);
        bodies.push(body);
    }
    drain(case, &grid, &bodies, &mut particles);
    let mut boundary = build_boundary(case, &grid, &bodies);
    shake(case, &particles, &mut boundary);
    let motion = set_in_motion(source, case, &mut particles, &mut boundary)?;
    let (probes, top) = (find_probes(case, &particles), find_top(case, &bodies));
    let refuse = |error: String| source.invalid("bodies", error, "");
    if case.method.solver == SolverKind::Fem {
        let newmark = Newmark { beta: case.method.newmark.beta, gamma: case.method.newmark.gamma };
        let (fluid, fluid_inertia) = (build_fluid(case), case.method.fluid_inertia);
        let parts = finite_elements::Parts {
            grid,
            points: particles,
            groups,
            boundary,
            gravity,
            fluid,
            fluid_inertia,
            newmark,
        };
        let model = FiniteElements::new(parts).map_err(|error| refuse(error.to_string()))?;
        return Ok(Simulation::new(Box::new(model), probes, top, motion, case));
    }
    let method = KeyPath::root().key("method");
    let shape = choose(source, method.clone().key("shape"), "shape function", &case.method.shape, shapes())?;
    let name = &case.method.velocity_update;
    let known = velocity_updates(&case.method);
    let velocity_update = choose(source, method.clone().key("velocity_update"), "velocity update", name, known)?;
    let name = &case.method.stress_order;
    let stress_order = choose(source, method.clone().key("stress_order"), "stress order", name, stress_orders())?;
    let name = &case.method.particle_pressure;
    let key = method.key("particle_pressure");
    let particle_pressure = choose(source, key, "particle pressure", name, particle_pressures())?;
    let pressure = build_pressure(case, particle_pressure);
    let crate::Damping { local, mass, stiffness } = case.method.damping;
    let damping = Damping { local, mass, stiffness };
    let volumetric_strain = match case.method.volumetric_strain {
        crate::VolumetricStrain::Pointwise => VolumetricStrain::Pointwise,
        crate::VolumetricStrain::CellAveraged => VolumetricStrain::CellAveraged,
    };
    let parts = Parts {
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
        volumetric_strain,
    };
    let model = Solver::new(parts).map_err(|error| match error {
        StepError::NarrowGrid { .. } => {
            source.invalid("grid.cells", error.to_string(), "add cells, or take `method.shape` = \"linear\"")
        }
        _ => refuse(error.to_string()),
    })?;
    Ok(Simulation::new(Box::new(model), probes, top, motion, case))
}

/// Gives the boundary the ground motion.
fn shake<const D: usize>(case: &Case, particles: &Particles<D>, boundary: &mut Boundary<D>) {
    let Some(crate::GroundMotion { acceleration, history, end }) = &case.ground_motion else { return };
    let (acceleration, history) = (vector(acceleration), build_history(history));
    let motion = GroundMotion { acceleration, history, end: end.unwrap_or(f64::INFINITY) };
    boundary.push_body_force(Arc::new(motion), particles.position.clone());
}

/// Gives the particles the velocities of the exact motion, and the boundary its body force.
fn set_in_motion<const D: usize>(
    source: &CaseSource,
    case: &Case,
    particles: &mut Particles<D>,
    boundary: &mut Boundary<D>,
) -> Result<Option<Arc<dyn Motion<D>>>, CaseError> {
    let Some(wanted) = &case.exact_motion else { return Ok(None) };
    let motion = open_motion::<D>(source, wanted)?;
    for (velocity, start) in particles.velocity.iter_mut().zip(&particles.position) {
        *velocity = motion.velocity(start, 0.0);
    }
    if let Some(force) = motion.body_force() {
        boundary.push_body_force(force, particles.position.clone());
    }
    Ok(Some(motion))
}

/// The particles of a body: a part of a lattice, x fastest.
struct Lattice<const D: usize> {
    name: String,
    particles: Range<usize>,
    region: Region<D>,
    /// The numbers of the particles along the axes of the lattice.
    places: Vec<[usize; D]>,
}

impl<const D: usize> Lattice<D> {
    /// The particles of the layer next to a side.
    fn layer(&self, side: Side) -> impl Iterator<Item = usize> + '_ {
        let along = move |place: &[usize; D]| place[side.axis];
        let places = self.places.iter().map(along);
        let wanted = if side.upper { places.max() } else { places.min() };
        let first = self.particles.start;
        let is_there = move |(_, place): &(usize, &[usize; D])| Some(along(place)) == wanted;
        self.places.iter().enumerate().filter(is_there).map(move |(number, _)| first + number)
    }
}

fn vector<const D: usize>(numbers: impl AsRef<[f64]>) -> Vector<D> {
    // Lengths were validated; a missing number would be a zero.
    Vector::from_fn(|axis, _| numbers.as_ref().get(axis).copied().unwrap_or(0.0))
}

pub(crate) fn build_grid<const D: usize>(source: &CaseSource, case: &Case) -> Result<Grid<D>, CaseError> {
    let cells = std::array::from_fn(|axis| case.grid.cells.get(axis).copied().unwrap_or(1));
    Grid::new(vector(&case.grid.origin), vector(&case.grid.spacing), cells)
        .map_err(|error| source.invalid("grid", error.to_string(), ""))
}

/// Adds the particles of a body.
fn fill_body<const D: usize>(
    source: &CaseSource,
    case: &Case,
    grid: &Grid<D>,
    gravity: Vector<D>,
    index: usize,
    particles: &mut Particles<D>,
) -> Result<Lattice<D>, CaseError> {
    let body = &case.bodies[index];
    let key = KeyPath::root().key("bodies").index(index);
    let finite_elements = case.method.solver == SolverKind::Fem;
    // Two Gauss points per axis and element.
    let per_cell = if finite_elements { &[2; 3] } else { body.particles_per_cell.as_slice() };
    let region = Region::new(&body.shape, grid, per_cell);
    let total = particles.len() as f64 + region.num_boxes();
    if total > MAX_PARTICLES {
        let message = format!("this body makes {total:.3e} particles in all");
        let help = format!("at most {MAX_PARTICLES:.3e} can be numbered: take fewer per cell or a coarser grid");
        return Err(source.invalid(key.key("particles_per_cell"), message, help));
    }
    if finite_elements && !region.fills_cells(grid) {
        let help = "finite elements need boxes between grid lines: change `grid.spacing` or `grid.origin`";
        return Err(source.invalid(key.key("shape"), "a side of this body cuts through cells", help));
    }
    let mut points = if finite_elements { region.gauss_points() } else { region.points() };
    if !finite_elements {
        // What stands together in space stands together in memory.
        points.sort_by_key(|point| grid.cell_at(&point.position));
    }
    if points.is_empty() {
        let help = "it must cover at least a tenth of one: take smaller cells or more points per cell";
        return Err(source.invalid(key.key("shape"), "this body is too small to hold a material point", help));
    }
    let material = &case.materials[&body.material];
    let state = InitialState::new(source, case, gravity, index)?;
    let start = particles.len();
    particles.reserve_exact(points.len());
    for &PointBox { position, half_size, .. } in &points {
        let level = position[D - 1];
        particles.push(Particle {
            position,
            half_size,
            velocity: state.velocity,
            density: material.density,
            stress: state.stress(level),
            pressure: state.pressure(level),
            porosity: material.porosity.unwrap_or(0.0),
            conductivity: material.conductivity.unwrap_or(0.0),
        });
        if finite_elements {
            particles.set_volume(particles.len() - 1, region.box_volume());
        }
    }
    let places = points.iter().map(|point| point.place).collect();
    Ok(Lattice { name: body.name().to_owned(), particles: start..particles.len(), region, places })
}

/// The state of a body at the start, by level.
struct InitialState<const D: usize> {
    velocity: Vector<D>,
    /// Level of the water table (m) and weight of the water (N/m³).
    water: Option<(f64, f64)>,
    /// Level of the surface (m), weight of the ground (N/m³), earth pressure coefficient (–).
    ground: Option<(f64, f64, f64)>,
}

impl<const D: usize> InitialState<D> {
    fn new(source: &CaseSource, case: &Case, gravity: Vector<D>, index: usize) -> Result<Self, CaseError> {
        let initial = &case.bodies[index].initial;
        let downwards = -gravity[D - 1];
        let key = KeyPath::root().key("bodies").index(index).key("initial");
        if (initial.water_table.is_some() || initial.geostatic.is_some()) && downwards <= 0.0 {
            let help = "give `gravity` with a negative last component, or leave the initial state out";
            return Err(source.invalid(key, "an initial state from weight needs gravity", help));
        }
        let fluid_density = case.fluid.as_ref().map(|fluid| fluid.density);
        if initial.water_table.is_some() && fluid_density.is_none() {
            let help = "add a [fluid], or leave `water_table` out";
            return Err(source.invalid(key.key("water_table"), "a water table in dry ground", help));
        }
        let density = case.materials[&case.bodies[index].material].density;
        Ok(InitialState {
            velocity: initial.velocity.as_deref().map_or_else(Vector::zeros, vector),
            water: initial.water_table.zip(fluid_density).map(|(level, density)| (level, density * downwards)),
            ground: initial.geostatic.as_ref().map(|state| (state.surface, density * downwards, state.k0)),
        })
    }

    /// Hydrostatic below the water table, none above (Pa).
    fn pressure(&self, level: f64) -> f64 {
        self.water.map_or(0.0, |(table, weight)| weight * (table - level).max(0.0))
    }

    /// Total weight above less the water's pressure, vertically; k0 times that horizontally (Pa).
    fn stress(&self, level: f64) -> Sym3 {
        let Some((surface, weight, k0)) = self.ground else {
            return Sym3::ZERO;
        };
        let vertical = -(weight * (surface - level).max(0.0) - self.pressure(level));
        let horizontal = k0 * vertical;
        match D {
            1 => Sym3::diagonal(vertical, horizontal, horizontal),
            2 => Sym3::diagonal(horizontal, vertical, horizontal),
            _ => Sym3::diagonal(horizontal, horizontal, vertical),
        }
    }
}

fn side(face: Face) -> Side {
    Side { axis: face.axis() as usize, upper: face.is_max() }
}

fn named<'a, const D: usize>(bodies: &'a [Lattice<D>], name: &'a str) -> impl Iterator<Item = &'a Lattice<D>> {
    bodies.iter().filter(move |body| body.name == name)
}

/// Drainage is given to particles; the pressure scheme reflects it on the grid.
fn drain<const D: usize>(case: &Case, grid: &Grid<D>, bodies: &[Lattice<D>], particles: &mut Particles<D>) {
    for drainage in &case.drainage {
        for body in named(bodies, &drainage.on.of) {
            let Some(face) = drainage.on.surface.face() else {
                drain_all_round(grid, body, particles);
                continue;
            };
            let mut sides = SideSet::EMPTY;
            let faces = drainage.sides.as_deref().unwrap_or(std::slice::from_ref(&face));
            faces.iter().for_each(|&face| sides.insert(side(face)));
            for p in body.layer(side(face)) {
                particles.drained[p] = particles.drained[p].union(sides);
            }
        }
    }
}

/// Every particle drains wherever it is next to a free surface; inside the body that has no effect.
fn drain_all_round<const D: usize>(grid: &Grid<D>, body: &Lattice<D>, particles: &mut Particles<D>) {
    for p in body.particles.clone() {
        for side in Side::all::<D>().filter(|&side| body.region.is_free(grid, &particles.position[p], side)) {
            particles.drained[p].insert(side);
        }
    }
}

fn build_boundary<const D: usize>(case: &Case, grid: &Grid<D>, bodies: &[Lattice<D>]) -> Boundary<D> {
    let mut boundary = Boundary::free(grid);
    for support in &case.supports {
        let mut axes = AxisSet::default();
        support.fix.iter().for_each(|&axis| axes.insert(axis as usize));
        let together = || support.together.iter().map(|&axis| axis as usize);
        if let Some(face) = support.face {
            boundary.fix_side(grid, side(face), axes);
            together().for_each(|axis| boundary.tie_side(grid, side(face), axis));
        }
        if let Some(BoxShape { min, max }) = &support.region {
            // A node on the border of the region counts, whatever the last bit says.
            let slack = grid.spacing() * 1e-9;
            let (lower, upper): (Vector<D>, Vector<D>) = (vector(min) - slack, vector(max) + slack);
            let holds = |position: Vector<D>| (0..D).all(|axis| (lower[axis]..=upper[axis]).contains(&position[axis]));
            boundary.fix(grid, axes, holds);
            together().for_each(|axis| boundary.tie(grid, axis, holds));
        }
    }
    for load in &case.loads {
        let history = build_history(&load.history);
        let Some(on) = load.on.surface.face().map(side) else {
            for body in named(bodies, &load.on.of) {
                let (particles, history) = (body.particles.clone(), history.clone());
                // Validation has seen to it that there is a pressure.
                boundary.push_fluid_load(FluidLoad { particles, pressure: load.pressure.unwrap_or(0.0), history });
            }
            continue;
        };
        let traction = load_on_face(load, on);
        let forces = named(bodies, &load.on.of)
            .flat_map(|body| body.layer(on).map(move |p| (p, traction * body.region.side_area(on))))
            .collect();
        // Gauss points carry no loads: those of finite elements act on the true surface.
        let applied_to = match (load.applied_to, case.method.solver) {
            (crate::AppliedTo::Particles, SolverKind::Mpm) => AppliedTo::Particles,
            _ => AppliedTo::Surface(on),
        };
        boundary.push_load(Load { forces, history, applied_to });
    }
    boundary
}

fn build_fluid(case: &Case) -> Option<Fluid> {
    let crate::Fluid { density, bulk_modulus, unit_weight } = *case.fluid.as_ref()?;
    Some(Fluid { density, bulk_modulus, unit_weight })
}

fn build_history(history: &crate::History) -> History {
    match history {
        crate::History::Points(points) => History::new(points.clone()),
        crate::History::SmoothStep(step) => History::smooth_step(step.duration),
        crate::History::Sine(sine) => History::sine(sine.angular_frequency, sine.start),
    }
}

/// The traction of a load on a face (Pa): its own, or that of its pressure.
fn load_on_face<const D: usize>(load: &crate::Load, on: Side) -> Vector<D> {
    match (&load.traction, load.pressure) {
        (Some(traction), _) => vector(traction),
        (None, pressure) => {
            Vector::from_fn(|axis, _| if axis == on.axis { -on.sign() * pressure.unwrap_or(0.0) } else { 0.0 })
        }
    }
}

fn build_pressure<const D: usize>(
    case: &Case,
    particle_pressure: Box<dyn ParticlePressure<D>>,
) -> Box<dyn PressureScheme<D>> {
    let Some(fluid) = build_fluid(case) else { return Box::new(Dry) };
    let quadrature = match case.method.pressure_quadrature {
        PressureQuadrature::Cell => Quadrature::Cell,
        PressureQuadrature::MaterialPoints => Quadrature::MaterialPoints,
    };
    let scheme = Coupled::new(fluid, quadrature, case.method.fluid_inertia);
    Box::new(scheme.with_particle_pressure(particle_pressure).stabilised(case.method.pressure_stabilisation))
}

/// The points of the probes: a place for pressures, the nearest particle for displacements.
fn find_probes<const D: usize>(case: &Case, particles: &Particles<D>) -> Vec<ProbeAt<D>> {
    let nearest = |point: Vector<D>| {
        let distance = |&p: &usize| (particles.position[p] - point).norm_squared();
        (0..particles.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let probe = |probe: &crate::Probe| ProbeAt {
        name: probe.name.clone(),
        pressure_at: probe.pressure_at.as_ref().map(vector),
        particle: probe.displacement_at.as_ref().map(vector).and_then(nearest),
    };
    case.probes.iter().map(probe).collect()
}

/// The particles whose fall is the settlement: the loaded ones on upper surfaces, else the tops of the bodies.
fn find_top<const D: usize>(case: &Case, bodies: &[Lattice<D>]) -> Vec<usize> {
    let up = Side { axis: D - 1, upper: true };
    let loaded = case.loads.iter().filter(|load| load.on.surface.face().map(side) == Some(up));
    let mut top: Vec<usize> =
        loaded.flat_map(|load| named(bodies, &load.on.of).flat_map(|body| body.layer(up))).collect();
    if top.is_empty() {
        top = bodies.iter().flat_map(|body| body.layer(up)).collect();
    }
    top.sort_unstable();
    top.dedup();
    top
}
