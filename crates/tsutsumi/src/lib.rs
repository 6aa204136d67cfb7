//! # Tsutsumi: the material point method for saturated ground
//!
//! The soil skeleton is carried by material points, its momentum balance is solved on a background grid, and the pore
//! pressure is solved by finite differences at the centres of the grid's cells, after
//! Goto, Morinaka, Oka, Higo and Kimoto, "Deformation analysis of a solid–liquid two-phase porous body by a coupled
//! MPM–FDM method" (in Japanese).
//!
//! Everything is generic over the dimension of space `D` = 1, 2 or 3. [`solver::Solver::step`] is the paper's algorithm,
//! line for line. Search this documentation for `Eq. (9)` to find an equation of the paper.
//!
//! Units are SI. Stress and strain are positive in tension, pore pressure is positive in compression.
//!
//! The modules are floors: each uses only those above it in this list.
//!
//! | module | what is in it |
//! |---|---|
//! | [`tensor`] | vectors and matrices of space, the symmetric 3-D tensor |
//! | `parallel` | loops on all threads with one order of sums |
//! | `lanes` | vectors of four numbers |
//! | `large_pages` | large arrays in large pages of memory |
//! | [`grid`] | the background grid, its node and cell fields, the active part |
//! | [`shape`] | shape functions |
//! | [`particles`] | the material points |
//! | [`law`] | constitutive laws of the effective stress |
//! | [`element`] | element tests: one specimen under mixed control of stress and strain |
//! | [`transfer`] | sums from particles to nodes and back |
//! | [`velocity`] | velocity updates: MPM①, MPM②, FLIP, APIC, TPIC, XPIC, FMPM |
//! | [`damping`] | damping of the nodes' motion, for states of rest |
//! | [`pressure`] | pore pressure, coupled with the momentum balance |
//! | [`boundary`] | supports and loads |
//! | [`solver`] | one time step |
//!
//! A whole program: a metre of saturated ground settles under a load, from the modules alone. Case files say the same in fewer words,
//! see `tsutsumi-case`.
//!
//! ```
//! use tsutsumi::boundary::{AppliedTo, AxisSet, Boundary, History, Load};
//! use tsutsumi::damping::Damping;
//! use tsutsumi::grid::{Grid, Side};
//! use tsutsumi::law::{Group, LinearElastic};
//! use tsutsumi::particles::{Particle, Particles};
//! use tsutsumi::pressure::{Coupled, Fluid, Quadrature};
//! use tsutsumi::shape::Linear;
//! use tsutsumi::solver::{Parts, Solver, StressLast, VolumetricStrain};
//! use tsutsumi::tensor::{Sym3, Vector};
//! use tsutsumi::velocity::Mpm1;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Ten cells of ground and an empty one above them; two material points in a cell. The last one drains through its top.
//! let grid = Grid::new(Vector::zeros(), Vector::repeat(0.1), [11])?;
//! let [base, top] = [false, true].map(|upper| Side { axis: 0, upper });
//! let mut particles = Particles::<1>::default();
//! for p in 0..20 {
//!     particles.push(Particle {
//!         position: Vector::repeat(0.05 * (p as f64 + 0.5)),
//!         half_size: Vector::repeat(0.025),
//!         velocity: Vector::zeros(),
//!         density: 1900.0,
//!         stress: Sym3::ZERO,
//!         pressure: 0.0,
//!         porosity: 0.4,
//!         conductivity: 1e-4,
//!     });
//! }
//! particles.drained[19].insert(top);
//!
//! // The base is held; 10 kPa come onto the true surface within a second.
//! let mut boundary = Boundary::free(&grid);
//! let mut along_x = AxisSet::default();
//! along_x.insert(0);
//! boundary.fix_side(&grid, base, along_x);
//! boundary.push_load(Load {
//!     forces: vec![(19, Vector::repeat(-10e3))],
//!     history: History::new(vec![[0.0, 0.0], [1.0, 1.0]]),
//!     applied_to: AppliedTo::Surface(top),
//! });
//!
//! let law = LinearElastic { young: 10e6, poisson: 0.0 };
//! let water = Fluid { density: 1000.0, bulk_modulus: 2.2e9, unit_weight: 9800.0 };
//! let group = Group::new("soil", law, 0..20, &particles.stress);
//! let mut solver = Solver::new(Parts {
//!     grid,
//!     particles,
//!     groups: vec![Box::new(group)],
//!     boundary,
//!     gravity: Vector::zeros(),
//!     shape: Box::new(Linear),
//!     velocity_update: Box::new(Mpm1),
//!     stress_order: Box::new(StressLast),
//!     pressure: Box::new(Coupled::new(water, Quadrature::MaterialPoints, true)),
//!     damping: Damping::default(),
//!     volumetric_strain: VolumetricStrain::default(),
//! })?;
//!
//! let dt = 0.5 * solver.step_limits().longest();
//! while solver.time() < 60.0 {
//!     solver.step(dt)?;
//! }
//! // All water that had to leave has left: the logarithmic strain is q/E, which differs by half of itself, 5e-4.
//! let fall = 0.975 - solver.particles().position[19][0];
//! assert!((fall / (0.975 * 10e3 / 10e6) - 1.0).abs() < 6e-4);
//! # Ok(())
//! # }
//! ```

pub mod boundary;
pub mod damping;
pub mod element;
pub mod grid;
mod lanes;
mod large_pages;
pub mod law;

mod parallel;
pub mod particles;
pub mod pressure;
pub mod shape;
pub mod solver;
pub mod tensor;
pub mod transfer;
pub mod velocity;
