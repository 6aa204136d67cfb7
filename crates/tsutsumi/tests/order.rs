//! The order of the particles in memory is nobody's business but the memory's.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::num::NonZeroUsize;
use std::sync::Arc;

use tsutsumi::boundary::{AppliedTo, BodyForce, Boundary, FluidLoad, GroundMotion, History, Load};
use tsutsumi::damping::Damping;
use tsutsumi::grid::{Grid, Side};
use tsutsumi::law::{Group, MaterialGroup, Newtonian};
use tsutsumi::particles::{Particle, Particles};
use tsutsumi::pressure::{Coupled, Dry, PressureGradient, PressureScheme, Quadrature};
use tsutsumi::shape::{Gimp, Linear, QuadraticBSpline};
use tsutsumi::solver::{Parts, Solver, StressLast, StressModifiedLast, StressOrder, VolumetricStrain};
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::{Apic, Mpm1, VelocityUpdate, Xpic};
use tsutsumi_testkit::body::{PAPER_SOIL, WATER};
use tsutsumi_testkit::compare::assert_close;
use tsutsumi_testkit::reading::{run, top};
use tsutsumi_testkit::soils::MORIKAWA_ASAI_CLAY;

/// All that particles carry, as bits, in the order of their numbers.
fn bits<const D: usize>(particles: &Particles<D>) -> Vec<u64> {
    let mut bits = Vec::new();
    for p in particles.places_by_number() {
        let stress = particles.stress.at(p);
        let vectors = [particles.position[p], particles.velocity[p], particles.half_size[p]];
        let numbers = [particles.mass[p], particles.volume[p], particles.pressure[p], particles.porosity[p]];
        bits.extend(vectors.iter().flat_map(|vector| vector.iter()).chain(&numbers).map(|number| number.to_bits()));
        bits.extend([stress.xx, stress.yy, stress.zz, stress.xy, stress.yz, stress.zx].map(f64::to_bits));
        bits.extend([particles.conductivity[p].to_bits(), u64::from(particles.cell[p])]);
        bits.extend(particles.local_motion.get(p).iter().flat_map(|motion| motion.iter()).map(|m| m.to_bits()));
        bits.push(Side::all::<D>().filter(|&side| particles.drained[p].contains(side)).count() as u64);
    }
    bits
}

/// What the laws say of their histories, in the order of the particles' numbers.
fn histories<const D: usize>(solver: &Solver<D>) -> Vec<Vec<f64>> {
    let group_of = |place: usize| solver.groups().iter().find(|group| group.particles().contains(&place)).unwrap();
    let outputs = |place: usize| {
        let group = group_of(place);
        let mut values = vec![0.0; group.outputs().len()];
        assert!(!values.is_empty());
        group.write_outputs(place - group.particles().start, solver.particles().stress.at(place), &mut values);
        values
    };
    solver.particles().places_by_number().map(outputs).collect()
}

/// The numbers of the particles, cell by cell.
fn by_number<const D: usize>(solver: &Solver<D>) -> Vec<usize> {
    solver.active().particles().iter().map(|&place| solver.particles().number(place as usize)).collect()
}

/// What a body that turns is made of: two materials side by side, of which one has histories.
struct Turning<const D: usize> {
    shape: Box<dyn Transfer<D>>,
    velocity_update: Box<dyn VelocityUpdate<D>>,
    stress_order: Box<dyn StressOrder>,
    pressure: Box<dyn PressureScheme<D>>,
    damping: Damping,
    volumetric_strain: VolumetricStrain,
    porosity: f64,
}

impl<const D: usize> Turning<D> {
    fn dry() -> Self {
        Turning {
            shape: Box::new(Linear),
            velocity_update: Box::new(Mpm1),
            stress_order: Box::new(StressLast),
            pressure: Box::new(Dry),
            damping: Damping::default(),
            volumetric_strain: VolumetricStrain::default(),
            porosity: 0.0,
        }
    }

    fn wet() -> Self {
        let pressure = Coupled::new(WATER, Quadrature::MaterialPoints, true);
        let pressure = pressure.with_particle_pressure(Box::new(PressureGradient::default()));
        Turning { pressure: Box::new(pressure), porosity: 0.4, ..Turning::dry() }
    }

    /// A free square or cube of four cells that turns about its middle, half a cell from the grid lines.
    fn build(self) -> Solver<D> {
        let grid = Grid::new(Vector::zeros(), Vector::repeat(1.0), [12; D]).unwrap();
        let middle = Vector::repeat(5.9);
        let mut particles = Particles::default();
        let count = 9_usize;
        for number in 0..count.pow(D as u32) {
            let mut rest = number;
            let arm = Vector::<D>::from_fn(|_, _| {
                let along = (rest % count) as f64;
                rest /= count;
                (along - 4.0) * 0.45
            });
            let mut velocity = Vector::zeros();
            (velocity[0], velocity[1]) = (-6.0 * arm[1] - 0.4 * arm[0], 6.0 * arm[0]);
            particles.push(Particle {
                position: middle + arm,
                half_size: Vector::repeat(0.225),
                velocity,
                density: 1800.0,
                stress: Sym3::IDENTITY * -50e3,
                pressure: self.porosity * 1e3 * arm[0],
                porosity: self.porosity,
                conductivity: self.porosity * 1e-3,
            });
        }
        let half = particles.len() / 2;
        let boundary = Self::boundary(&grid, &mut particles);
        let clay: Box<dyn MaterialGroup> =
            Box::new(Group::new("clay", MORIKAWA_ASAI_CLAY, 0..half, particles.stress.within(0..half)));
        let liquid = Newtonian { bulk_modulus: 2e5, viscosity: 10.0, tait_exponent: 0.0, bears_tension: true };
        let rest = half..particles.len();
        let liquid = Group::new("liquid", liquid, rest.clone(), particles.stress.within(rest));
        Solver::new(self.parts(grid, particles, vec![clay, Box::new(liquid)], boundary)).unwrap()
    }

    fn parts(
        self,
        grid: Grid<D>,
        particles: Particles<D>,
        groups: Vec<Box<dyn MaterialGroup>>,
        boundary: Boundary<D>,
    ) -> Parts<D> {
        let Turning { shape, velocity_update, stress_order, pressure, damping, volumetric_strain, .. } = self;
        Parts {
            grid,
            particles,
            groups,
            boundary,
            gravity: Vector::zeros(),
            shape,
            velocity_update,
            stress_order,
            pressure,
            damping,
            volumetric_strain,
        }
    }

    /// A load on some particles, a fluid around some of a group, a motion of the ground; some particles drain.
    fn boundary(grid: &Grid<D>, particles: &mut Particles<D>) -> Boundary<D> {
        let mut boundary = Boundary::free(grid);
        let pull = Vector::from_fn(|axis, _| [900.0, -400.0, 100.0][axis]);
        let loaded = [particles.len() - 1, 3, 40];
        boundary.push_load(Load {
            forces: loaded.map(|p| (p, pull)).to_vec(),
            history: History::new(vec![]),
            applied_to: AppliedTo::Surface(top::<D>()),
        });
        boundary.push_fluid_load(FluidLoad { particles: 5..30, pressure: 2e3, history: History::new(vec![]) });
        let motion = GroundMotion { acceleration: pull * 1e-3, history: History::sine(8.0, 0.0), end: 9.0 };
        boundary.push_body_force(Arc::new(motion), particles.position.clone());
        boundary.push_body_force(Arc::new(Outwards), particles.position.clone());
        loaded.iter().for_each(|&p| particles.drained[p].insert(top::<D>()));
        boundary
    }
}

/// A force that depends on where a particle started.
#[derive(Debug)]
struct Outwards;

impl<const D: usize> BodyForce<D> for Outwards {
    fn force(&self, start: &Vector<D>, _time: f64) -> Vector<D> {
        *start * 0.3
    }
}

/// A body that is sorted in every step moves as one that never is, bit by bit.
fn sorting_changes_nothing<const D: usize>(what: &str, build: impl Fn() -> Turning<D>) {
    let (mut plain, mut sorted) = (build().build(), build().build());
    let dt = 0.25 * plain.step_limits().longest().min(2e-3);
    for step in 0..(0.12 / dt) as usize {
        plain.step(dt).unwrap();
        sorted.sort_in_next_step();
        sorted.step(dt).unwrap();
        assert_eq!(by_number(&plain), by_number(&sorted), "{what} in step {step}");
    }
    assert!(plain.particles().numbers().is_empty());
    let numbers = sorted.particles().numbers();
    let moved = numbers.iter().enumerate().filter(|(place, number)| *place != **number as usize).count();
    assert!(moved > numbers.len() / 2, "{what}: {moved} in other places");
    assert!(bits(plain.particles()) == bits(sorted.particles()), "{what}: particles");
    assert_eq!(histories(&plain), histories(&sorted), "{what}");
    let fields = |solver: &Solver<D>| (solver.nodes().velocity.clone(), solver.cells().pressure.clone());
    assert_eq!(fields(&plain), fields(&sorted), "{what}");
    assert_eq!(plain.outflow().to_bits(), sorted.outflow().to_bits(), "{what}");
    // Sums over some 700 particles in other orders, step by step: round-off.
    let energies = |solver: &Solver<D>| [solver.strain_energy(), solver.particles().kinetic_energy()];
    for (one, other) in energies(&plain).into_iter().zip(energies(&sorted)) {
        assert_close(what, one, other, 1e-11 * one.abs());
    }
    // What stands together in the lists stands together in memory, in both groups.
    for (place, pair) in sorted.particles().cell.windows(2).enumerate() {
        let groups = sorted.groups();
        let apart = |range: std::ops::Range<usize>| range.start == place + 1 || range.end == place + 1;
        let ends = groups.iter().any(|group| apart(group.particles())) || apart(5..30);
        assert!(ends || pair[0] <= pair[1], "{what} at {place}");
    }
}

#[test]
fn bodies_move_as_if_they_were_never_sorted() {
    sorting_changes_nothing::<2>("linear", Turning::dry);
    sorting_changes_nothing::<2>("boxes, modified last", || Turning {
        shape: Box::new(Gimp),
        stress_order: Box::new(StressModifiedLast),
        ..Turning::dry()
    });
    sorting_changes_nothing::<2>("splines, APIC", || Turning {
        shape: Box::new(QuadraticBSpline),
        velocity_update: Box::new(Apic),
        ..Turning::dry()
    });
    sorting_changes_nothing::<2>("XPIC, averaged, viscous", || Turning {
        velocity_update: Box::new(Xpic::new(NonZeroUsize::new(3).unwrap())),
        volumetric_strain: VolumetricStrain::CellAveraged,
        damping: Damping { local: 0.1, mass: 0.5, stiffness: 1e-5 },
        ..Turning::dry()
    });
    sorting_changes_nothing::<2>("wet", Turning::wet);
    sorting_changes_nothing::<3>("3-D", || Turning { shape: Box::new(Gimp), ..Turning::dry() });
}

/// Ground of 51,200 particles on 160 × 80 cells, which flies sideways; numbered row by row of particles, or column by column.
fn flying_ground(column_by_column: bool) -> Solver<2> {
    let grid = Grid::new(Vector::zeros(), Vector::repeat(1.0), [170, 82]).unwrap();
    let mut particles = Particles::default();
    let [across, up] = [320, 160];
    for number in 0..across * up {
        let [i, j] = if column_by_column { [number / up, number % up] } else { [number % across, number / across] };
        particles.push(Particle {
            position: Vector::from([1.25 + 0.5 * i as f64, 1.25 + 0.5 * j as f64]),
            half_size: Vector::repeat(0.25),
            velocity: Vector::from([40.0, 0.0]),
            density: 1800.0,
            stress: Sym3::ZERO,
            pressure: 0.0,
            porosity: 0.0,
            conductivity: 0.0,
        });
    }
    let group = Group::new("soil", PAPER_SOIL, 0..particles.len(), &particles.stress);
    let boundary = Boundary::free(&grid);
    Solver::new(Turning::dry().parts(grid, particles, vec![Box::new(group)], boundary)).unwrap()
}

#[test]
fn large_bodies_are_sorted_where_they_are_out_of_order() {
    let mut ground = flying_ground(true);
    assert!(ground.particles().numbers().is_empty(), "places change in steps only");
    ground.step(1e-3).unwrap();
    let particles = ground.particles();
    assert!(particles.cell.is_sorted() && particles.number(1) == 1 && particles.number(2) == 160);
    assert_eq!((particles.place_of(160), particles.place_of(51_199)), (2, 51_199));
    let listed: Vec<u32> = (0..51_200).collect();
    assert_eq!(ground.active().particles(), listed);
}

/// Rows of particles stand in two parts of memory for every row of cells, which is no disorder by chance, but counts as one; a cell further on
/// nothing has changed.
#[test]
fn ground_that_moves_as_one_keeps_its_order() {
    let mut ground = flying_ground(false);
    ground.step(1e-3).unwrap();
    let numbers = ground.particles().numbers().to_vec();
    assert!(ground.particles().cell.is_sorted());
    let before = ground.particles().cell[0];
    run(&mut ground, 1e-3, 40).unwrap();
    assert!(ground.particles().cell[0] > before);
    assert_eq!(ground.particles().numbers(), numbers);
}
