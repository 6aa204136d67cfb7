//! A block of ground on rollers under gravity: the problem that all programs are given.
//!
//! A unit square or cube in n cells per axis with 2 particles per axis and cell, 3 empty cells all round. Its sides roll, its top is free, and gravity is
//! put on at once. Linear elastic, E = 10 MPa, ν = 0.3, ρ = 1000 kg/m³; a step is a fifth of the time that a compression wave takes through a cell.
//!
//! Nothing moves sideways, so that no stress turns: programs with and without the rotation of stresses give the same numbers.

use std::f64::consts::PI;

use clap::{Args, ValueEnum};
use tsutsumi::boundary::{AppliedTo, AxisSet, Boundary, History, Load};
use tsutsumi::damping::Damping;
use tsutsumi::grid::{Grid, GridError, Side};
use tsutsumi::law::{Group, MaterialGroup, Newtonian};
use tsutsumi::particles::{Particle, Particles};
use tsutsumi::pressure::{Coupled, Dry, Fluid, PressureScheme, Quadrature};
use tsutsumi::shape::{Gimp, Linear, QuadraticBSpline};
use tsutsumi::solver::{Parts, Solver, StepError, StressLast, VolumetricStrain};
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::{Apic, Flip, Mpm1, Mpm2, VelocityUpdate};

use tsutsumi_testkit::soils::TOYOURA_SAND;

use crate::laws::{CLAY, LINEAR_ELASTIC};

/// Empty cells around the block.
const PADDING: usize = 3;

/// Density of the ground, with its water if any (kg/m³).
const DENSITY: f64 = 1000.0;

/// Gravity (m/s²).
const GRAVITY: f64 = 9.81;

/// The load on the top of saturated ground, and of laws that need a confining pressure; they start from it (Pa).
const LOAD: f64 = 100e3;

/// Water.
const WATER: Fluid = Fluid { density: 1000.0, bulk_modulus: 2.2e9, unit_weight: 9810.0 };

/// As fast to sound as the elastic ground, and so viscous that a whirl of the block's size loses a tenth of its energy in some ten turns.
const LIQUID: Newtonian = Newtonian { bulk_modulus: 13.46e6, viscosity: 5.0, tait_exponent: 0.0, bears_tension: true };

/// A block to be built.
#[derive(Debug, Clone, PartialEq, Args)]
pub struct Block {
    /// The number of particles wanted: the block gets 2^D n^D, with the nearest n.
    #[arg(long, default_value_t = 100_000)]
    pub particles: usize,
    /// The shape function: linear, gimp or bspline2.
    #[arg(long, default_value = "linear")]
    pub shape: String,
    /// The velocity update: mpm1, mpm2, flip or apic.
    #[arg(long, default_value = "mpm1")]
    pub update: String,
    /// The law: linear-elastic, modified-cam-clay or sanisand; the last two from 100 kPa.
    #[arg(long, default_value = "linear-elastic")]
    pub law: String,
    /// Saturated ground, drained at its top and loaded there by 100 kPa at once.
    #[arg(long)]
    pub saturated: bool,
    /// The particles stand in memory in an order by chance.
    #[arg(long)]
    pub shuffled: bool,
    /// How it moves at the start.
    #[arg(long, value_enum, default_value_t = Motion::Rest)]
    pub motion: Motion,
}

/// How a block moves at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Motion {
    /// It rests, and settles.
    Rest,
    /// It is free and spins about its middle: cells at its edges come and go.
    Spin,
    /// It is a liquid in a closed box, in which it turns: its particles mix.
    Whirl,
}

/// Why a block cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum BlockError {
    /// A name that is not known.
    #[error("unknown {kind} `{name}`; known: {known}")]
    Name {
        /// What the name is of.
        kind: &'static str,
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
    /// There is no such grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The grid does not hold the block.
    #[error(transparent)]
    Step(#[from] StepError),
}

impl Block {
    /// Dry ground with linear shape functions and MPM①.
    pub fn linear(particles: usize) -> Self {
        let [shape, update, law] = ["linear", "mpm1", "linear-elastic"].map(str::to_owned);
        Block { particles, shape, update, law, saturated: false, shuffled: false, motion: Motion::Rest }
    }

    /// Dry ground with quadratic B-splines and APIC.
    pub fn spline(particles: usize) -> Self {
        Block { shape: "bspline2".to_owned(), update: "apic".to_owned(), ..Block::linear(particles) }
    }

    /// The same block with another law.
    #[must_use]
    pub fn of(self, law: &str) -> Self {
        Block { law: law.to_owned(), ..self }
    }

    /// The same block, saturated.
    #[must_use]
    pub fn with_water(self) -> Self {
        Block { saturated: true, ..self }
    }

    /// The number of cells along an axis.
    pub fn cells_per_axis(&self, dimension: usize) -> usize {
        let cells = self.particles as f64 / (1 << dimension) as f64;
        (cells.powf(1.0 / dimension as f64).round() as usize).max(2)
    }

    /// The block on its grid.
    ///
    /// # Errors
    /// See [`BlockError`].
    pub fn build<const D: usize>(&self) -> Result<Solver<D>, BlockError> {
        Ok(Solver::new(self.parts()?)?)
    }

    /// What the block's solver is made of.
    ///
    /// # Errors
    /// See [`BlockError`].
    pub fn parts<const D: usize>(&self) -> Result<Parts<D>, BlockError> {
        let cells = self.cells_per_axis(D);
        let spacing = 1.0 / cells as f64;
        let grid =
            Grid::new(Vector::repeat(-(PADDING as f64) * spacing), Vector::repeat(spacing), [cells + 2 * PADDING; D])?;
        let confined = self.motion == Motion::Rest && self.law != "linear-elastic";
        let loaded = confined || self.saturated;
        let mut particles = self.fill(&grid, confined);
        let top = Side { axis: D - 1, upper: true };
        let surface = outermost(&particles, 1.0 - 0.5 * spacing);
        if self.saturated {
            surface.iter().for_each(|&p| particles.drained[p].insert(top));
        }
        let mut boundary = match self.motion {
            Motion::Rest => rollers(&grid, false),
            Motion::Spin => Boundary::free(&grid),
            Motion::Whirl => rollers(&grid, true),
        };
        if loaded {
            let force = down::<D>(LOAD * (0.5 * spacing).powi(D as i32 - 1));
            let forces = surface.into_iter().map(|p| (p, force)).collect();
            boundary.push_load(Load { forces, history: History::new(vec![]), applied_to: AppliedTo::Surface(top) });
        }
        let pressure: Box<dyn PressureScheme<D>> = match self.saturated {
            true => Box::new(Coupled::new(WATER, Quadrature::MaterialPoints, true)),
            false => Box::new(Dry),
        };
        Ok(Parts {
            groups: vec![self.group(&particles)?],
            grid,
            particles,
            boundary,
            gravity: down(GRAVITY),
            shape: self.shape()?,
            velocity_update: self.velocity_update()?,
            stress_order: Box::new(StressLast),
            pressure,
            damping: Damping::default(),
            volumetric_strain: VolumetricStrain::default(),
        })
    }

    /// The step (s): that of all programs, shorter where the ground is stiffer or holds water.
    pub fn step<const D: usize>(&self, solver: &Solver<D>) -> f64 {
        let speed = (LINEAR_ELASTIC.oedometric_modulus() / DENSITY).sqrt();
        let compared = 0.2 * solver.grid().spacing()[0] / speed;
        compared.min(solver.step_limits().accurate())
    }

    /// Two particles per axis in every cell of the block, cell by cell.
    fn fill<const D: usize>(&self, grid: &Grid<D>, confined: bool) -> Particles<D> {
        let cells = self.cells_per_axis(D);
        let half_size = grid.spacing() * 0.25;
        let stress = if confined { Sym3::IDENTITY * -LOAD } else { Sym3::ZERO };
        let water = |level: f64| if self.saturated { WATER.density * GRAVITY * (1.0 - level) } else { 0.0 };
        let mut numbers: Vec<usize> = (0..(2 * cells).pow(D as u32)).collect();
        if self.shuffled {
            shuffle(&mut numbers);
        }
        let mut particles = Particles::default();
        particles.reserve_exact(numbers.len());
        for number in numbers {
            let (mut cell, mut place) = (number >> D, number % (1 << D));
            let position = Vector::from_fn(|axis, _| {
                let at = (cell % cells) as f64 + [0.25, 0.75][place % 2];
                (cell, place) = (cell / cells, place / 2);
                at * grid.spacing()[axis]
            });
            particles.push(Particle {
                position,
                half_size,
                velocity: self.motion.velocity(&position),
                density: DENSITY,
                stress,
                pressure: water(position[D - 1]),
                porosity: if self.saturated { 0.4 } else { 0.0 },
                conductivity: if self.saturated { 1e-4 } else { 0.0 },
            });
        }
        particles
    }

    fn shape<const D: usize>(&self) -> Result<Box<dyn Transfer<D>>, BlockError> {
        let shapes: Vec<(&str, Box<dyn Transfer<D>>)> =
            vec![("linear", Box::new(Linear)), ("gimp", Box::new(Gimp)), ("bspline2", Box::new(QuadraticBSpline))];
        choose("shape function", &self.shape, shapes)
    }

    fn velocity_update<const D: usize>(&self) -> Result<Box<dyn VelocityUpdate<D>>, BlockError> {
        let updates: Vec<(&str, Box<dyn VelocityUpdate<D>>)> = vec![
            ("mpm1", Box::new(Mpm1)),
            ("mpm2", Box::new(Mpm2)),
            ("flip", Box::new(Flip { share: 0.99 })),
            ("apic", Box::new(Apic)),
        ];
        choose("velocity update", &self.update, updates)
    }

    fn group<const D: usize>(&self, particles: &Particles<D>) -> Result<Box<dyn MaterialGroup>, BlockError> {
        let (all, stresses) = (0..particles.len(), &particles.stress);
        if self.motion == Motion::Whirl {
            return Ok(Box::new(Group::new("liquid", LIQUID, all, stresses)));
        }
        let laws: Vec<(&str, Box<dyn MaterialGroup>)> = vec![
            ("linear-elastic", Box::new(Group::new("ground", LINEAR_ELASTIC, all.clone(), stresses))),
            ("modified-cam-clay", Box::new(Group::new("ground", CLAY, all.clone(), stresses))),
            ("sanisand", Box::new(Group::new("ground", TOYOURA_SAND, all, stresses))),
        ];
        choose("law", &self.law, laws)
    }
}

fn choose<T>(kind: &'static str, name: &str, from: Vec<(&'static str, T)>) -> Result<T, BlockError> {
    let known = from.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let found = from.into_iter().find(|(known, _)| *known == name);
    found.map(|(_, chosen)| chosen).ok_or_else(|| BlockError::Name { kind, name: name.to_owned(), known })
}

fn down<const D: usize>(length: f64) -> Vector<D> {
    Vector::from_fn(|axis, _| if axis == D - 1 { -length } else { 0.0 })
}

/// The particles above a level (m).
fn outermost<const D: usize>(particles: &Particles<D>, level: f64) -> Vec<usize> {
    (0..particles.len()).filter(|&p| particles.position[p][D - 1] > level).collect()
}

/// Brings numbers into an order by chance, the same every time.
fn shuffle(numbers: &mut [usize]) {
    let mut state = 1_u64;
    for end in (2..=numbers.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        numbers.swap(end - 1, (state >> 33) as usize % end);
    }
}

impl Motion {
    /// The velocity at a place (m/s), in the plane of the first and the last axis; at most a twentieth of the speed of sound, or nearly so.
    fn velocity<const D: usize>(self, position: &Vector<D>) -> Vector<D> {
        let speed = 0.05 * (LIQUID.bulk_modulus / DENSITY).sqrt();
        let [x, y] = [position[0], position[D - 1]];
        let [(sin_x, cos_x), (sin_y, cos_y)] = [x, y].map(|at| (PI * at).sin_cos());
        let along = match self {
            Motion::Rest => [0.0, 0.0],
            Motion::Spin => [0.5 - y, x - 0.5].map(|arm| 1.5 * speed * arm),
            // Without volume change, and along the walls of the box.
            Motion::Whirl => [sin_x * cos_y, -cos_x * sin_y].map(|part| speed * part),
        };
        Vector::from_fn(|axis, _| match axis {
            0 => along[0],
            _ if axis == D - 1 => along[1],
            _ => 0.0,
        })
    }
}

/// Rollers on the block's base and sides, on its top too where it is `closed`, and on the nodes beyond them.
fn rollers<const D: usize>(grid: &Grid<D>, closed: bool) -> Boundary<D> {
    let mut boundary = Boundary::free(grid);
    let slack = 0.5 * grid.spacing()[0];
    for axis in 0..D {
        let mut normal = AxisSet::default();
        normal.insert(axis);
        let sides_too = closed || axis != D - 1;
        boundary.fix(grid, normal, |node| node[axis] < slack || (sides_too && node[axis] > 1.0 - slack));
    }
    boundary
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean velocity (m/s) and mean stress (Pa) along the last axis after 45 steps.
    fn after_45_steps<const D: usize>(block: &Block) -> [f64; 2] {
        let mut solver = block.build::<D>().unwrap();
        let dt = block.step(&solver);
        for _ in 0..45 {
            solver.step(dt).unwrap();
        }
        let particles = solver.particles();
        let along = |stress: &Sym3| [stress.xx, stress.yy, stress.zz][D - 1];
        let sums = (0..particles.len()).fold([0.0, 0.0], |[velocity, stress], p| {
            [velocity + particles.velocity[p][D - 1], stress + along(&particles.stress.at(p))]
        });
        sums.map(|sum| sum / particles.len() as f64)
    }

    /// The numbers are those of two independent programs, in C (2-D) and in Python with numba: `benches/peers`. The sums have other orders,
    /// and 45 steps of round-off: 1e-11 is a thousand times what is seen.
    #[test]
    fn the_linear_block_moves_as_that_of_other_programs() {
        for (got, expected) in [
            (after_45_steps::<2>(&Block::linear(400)), [-0.041_846_006_796_485_71, -4_030.758_783_395_11]),
            (after_45_steps::<3>(&Block::linear(400)), [0.012_986_201_003_610_93, -9_501.473_311_415_491]),
        ] {
            for (got, expected) in got.into_iter().zip(expected) {
                assert!((got / expected - 1.0).abs() < 1e-11, "{got} {expected}");
            }
        }
    }

    #[test]
    fn every_kind_of_block_can_be_stepped() {
        let blocks = [Block::spline(400), Block::linear(400).with_water()];
        for block in blocks.into_iter().chain(["modified-cam-clay", "sanisand"].map(|law| Block::linear(400).of(law))) {
            let [velocity, stress] = after_45_steps::<2>(&block);
            assert!(velocity < 0.0 && stress < 0.0, "{block:?}: it settles and is compressed");
        }
    }

    /// Bodies of the same particles, in another order of the sums.
    #[test]
    fn shuffled_blocks_move_as_others() {
        for motion in [Motion::Rest, Motion::Spin, Motion::Whirl] {
            let block = Block { motion, ..Block::linear(400) };
            let after = |block: &Block| {
                let mut solver = block.build::<2>().unwrap();
                let dt = block.step(&solver);
                (0..45).for_each(|_| assert!(solver.step(dt).is_ok()));
                [solver.particles().kinetic_energy(), solver.strain_energy()]
            };
            let shuffled = after(&Block { shuffled: true, ..block.clone() });
            for (one, other) in after(&block).into_iter().zip(shuffled) {
                // 45 steps of round-off, see above.
                assert!((one / other - 1.0).abs() < 1e-11, "{motion:?}: {one} {other}");
            }
        }
    }

    #[test]
    fn an_unknown_name_is_answered_with_those_there_are() {
        let error = Block::linear(400).of("snow").build::<2>().err().unwrap();
        assert_eq!(error.to_string(), "unknown law `snow`; known: linear-elastic, modified-cam-clay, sanisand");
    }
}
