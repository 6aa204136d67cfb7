//! From a case to a simulation: bodies become particles, supports become fixed nodes, names become types.

use std::ops::Range;

use tsutsumi::boundary::{AppliedTo, AxisSet, Boundary, History, Load};
use tsutsumi::grid::{Grid, Side, SideSet};
use tsutsumi::particles::{Particle, Particles};
use tsutsumi::pressure::{Coupled, Dry, Fluid, PressureScheme, Quadrature};
use tsutsumi::solver::{Parts, Solver};
use tsutsumi::tensor::{Sym3, Vector};

use crate::registry::{MaterialRequest, choose, shapes, velocity_updates};
use crate::simulation::{ProbeAt, Simulation};
use crate::{BodyShape, BoxShape, Case, CaseError, CaseSource, Face, KeyPath, PressureQuadrature, Registry};

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
        let stresses = &particles.stress[body.particles.clone()];
        let material = &case.bodies[index].material;
        let request = MaterialRequest { source, material, particles: body.particles.clone(), stresses };
        groups.push(registry.group(&case.materials[material].law, &request)?);
        bodies.push(body);
    }
    drain(case, &bodies, &mut particles);
    let method = KeyPath::root().key("method");
    let shape = choose(source, method.clone().key("shape"), "shape function", &case.method.shape, shapes())?;
    let name = &case.method.velocity_update;
    let velocity_update = choose(source, method.key("velocity_update"), "velocity update", name, velocity_updates())?;
    let boundary = build_boundary(case, &grid, &bodies);
    let pressure = build_pressure(case);
    let (probes, top) = (find_probes(case, &particles), find_top(case, &bodies));
    let parts = Parts { grid, particles, groups, boundary, gravity, shape, velocity_update, pressure };
    let solver = Solver::new(parts).map_err(|error| source.invalid("bodies", error.to_string(), ""))?;
    Ok(Simulation::new(solver, probes, top, case))
}

/// The particles of a body: a lattice, x fastest.
struct Lattice<const D: usize> {
    name: String,
    particles: Range<usize>,
    counts: [usize; D],
    size: Vector<D>,
}

impl<const D: usize> Lattice<D> {
    /// The particles of the layer next to a side.
    fn layer(&self, side: Side) -> impl Iterator<Item = usize> + '_ {
        let stride: usize = self.counts[..side.axis].iter().product();
        let wanted = if side.upper { self.counts[side.axis] - 1 } else { 0 };
        self.particles.clone().filter(move |p| (p - self.particles.start) / stride % self.counts[side.axis] == wanted)
    }

    /// The part of a side that one particle stands for (m²; m in 2-D, 1 in 1-D).
    fn side_area(&self, side: Side) -> f64 {
        (0..D).filter(|&axis| axis != side.axis).map(|axis| self.size[axis]).product()
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
    let BodyShape::Box(BoxShape { min, max }) = &body.shape;
    let (lower, upper): (Vector<D>, Vector<D>) = (vector(min), vector(max));
    let wish = Vector::<D>::from_fn(|axis, _| {
        let per_cell = body.particles_per_cell.get(axis).copied().unwrap_or(1) as f64;
        ((upper[axis] - lower[axis]) / grid.spacing()[axis] * per_cell).round().max(1.0)
    });
    let total = particles.len() as f64 + wish.product();
    if total > MAX_PARTICLES {
        let message = format!("this body makes {total:.3e} particles in all");
        let help = format!("at most {MAX_PARTICLES:.3e} can be numbered: take fewer per cell or a coarser grid");
        return Err(source.invalid(key.key("particles_per_cell"), message, help));
    }
    let counts: [usize; D] = std::array::from_fn(|axis| wish[axis] as usize);
    let size = (upper - lower).component_div(&wish);
    let material = &case.materials[&body.material];
    let state = InitialState::new(source, case, gravity, index)?;
    let start = particles.len();
    for number in 0..counts.iter().product() {
        let mut rest = number;
        let position = Vector::from_fn(|axis, _| {
            let place = rest % counts[axis];
            rest /= counts[axis];
            lower[axis] + (place as f64 + 0.5) * size[axis]
        });
        let level = position[D - 1];
        particles.push(Particle {
            position,
            half_size: size * 0.5,
            velocity: state.velocity,
            density: material.density,
            stress: state.stress(level),
            pressure: state.pressure(level),
            porosity: material.porosity.unwrap_or(0.0),
            conductivity: material.conductivity.unwrap_or(0.0),
        });
    }
    Ok(Lattice { name: body.name().to_owned(), particles: start..particles.len(), counts, size })
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
fn drain<const D: usize>(case: &Case, bodies: &[Lattice<D>], particles: &mut Particles<D>) {
    for drainage in &case.drainage {
        let mut sides = SideSet::EMPTY;
        let faces = drainage.sides.as_deref().unwrap_or(std::slice::from_ref(&drainage.on.surface));
        faces.iter().for_each(|&face| sides.insert(side(face)));
        for body in named(bodies, &drainage.on.of) {
            for p in body.layer(side(drainage.on.surface)) {
                particles.drained[p] = particles.drained[p].union(sides);
            }
        }
    }
}

fn build_boundary<const D: usize>(case: &Case, grid: &Grid<D>, bodies: &[Lattice<D>]) -> Boundary<D> {
    let mut boundary = Boundary::free(grid);
    for support in &case.supports {
        let mut axes = AxisSet::default();
        support.fix.iter().for_each(|&axis| axes.insert(axis as usize));
        if let Some(face) = support.face {
            boundary.fix_side(grid, side(face), axes);
        }
        if let Some(BoxShape { min, max }) = &support.region {
            // A node on the border of the region counts, whatever the last bit says.
            let slack = grid.spacing() * 1e-9;
            let (lower, upper): (Vector<D>, Vector<D>) = (vector(min) - slack, vector(max) + slack);
            boundary
                .fix(grid, axes, |position| (0..D).all(|axis| (lower[axis]..=upper[axis]).contains(&position[axis])));
        }
    }
    for load in &case.loads {
        let on = side(load.on.surface);
        let traction: Vector<D> = vector(&load.traction);
        let forces = named(bodies, &load.on.of)
            .flat_map(|body| body.layer(on).map(move |p| (p, traction * body.side_area(on))))
            .collect();
        let applied_to = match load.applied_to {
            crate::AppliedTo::Particles => AppliedTo::Particles,
            crate::AppliedTo::Surface => AppliedTo::Surface(on),
        };
        boundary.push_load(Load { forces, history: History::new(load.history.clone()), applied_to });
    }
    boundary
}

fn build_pressure<const D: usize>(case: &Case) -> Box<dyn PressureScheme<D>> {
    let Some(fluid) = &case.fluid else { return Box::new(Dry) };
    let fluid = Fluid { density: fluid.density, bulk_modulus: fluid.bulk_modulus, unit_weight: fluid.unit_weight };
    let quadrature = match case.method.pressure_quadrature {
        PressureQuadrature::Cell => Quadrature::Cell,
        PressureQuadrature::MaterialPoints => Quadrature::MaterialPoints,
    };
    Box::new(Coupled::new(fluid, quadrature, case.method.fluid_inertia))
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
    let loaded = case.loads.iter().filter(|load| side(load.on.surface) == up);
    let mut top: Vec<usize> =
        loaded.flat_map(|load| named(bodies, &load.on.of).flat_map(|body| body.layer(up))).collect();
    if top.is_empty() {
        top = bodies.iter().flat_map(|body| body.layer(up)).collect();
    }
    top.sort_unstable();
    top.dedup();
    top
}
