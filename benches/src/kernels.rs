//! The kernels whose instructions are counted: what nearly all time of nearly all runs goes into.

use std::error::Error;

use tsutsumi::boundary::History;
use tsutsumi::law::{ConstitutiveLaw, Group, Increment, MaterialGroup};
use tsutsumi::solver::Solver;
use tsutsumi::tensor::Sym3;
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::reading::top;
use tsutsumi_testkit::soils::TOYOURA_SAND;

use crate::block::Block;
use crate::laws::CLAY;

/// A kernel by name.
#[derive(Debug, Clone, Copy)]
pub struct Kernel {
    /// Its name.
    pub name: &'static str,
    /// Makes it ready, work arrays set aside.
    pub prepare: fn() -> Result<Work, Box<dyn Error>>,
}

/// The work that is counted.
pub type Work = Box<dyn FnMut()>;

/// All kernels.
pub const KERNELS: &[Kernel] = &[
    Kernel { name: "column-2d", prepare: column },
    Kernel { name: "linear-2d", prepare: || steps::<2>(&Block::linear(4096)) },
    Kernel { name: "linear-3d", prepare: || steps::<3>(&Block::linear(4096)) },
    Kernel { name: "spline-apic-2d", prepare: || steps::<2>(&Block::spline(4096)) },
    Kernel { name: "spline-apic-3d", prepare: || steps::<3>(&Block::spline(4096)) },
    Kernel { name: "coupled-2d-2500-cells", prepare: || steps::<2>(&Block::linear(10_000).with_water()) },
    Kernel { name: "modified-cam-clay", prepare: || Ok(updates(CLAY)) },
    Kernel { name: "sanisand", prepare: || Ok(updates(TOYOURA_SAND)) },
];

/// The paper's column: ten cells, four particles in each.
fn column() -> Result<Work, Box<dyn Error>> {
    let ramp = History::new(vec![[0.0, 0.0], [1.0, 1.0]]);
    let body = Body::<2>::column(10.0, 1.0).drained(top::<2>()).load_on_surface(top::<2>(), down(50e3), ramp);
    stepping(body.build(), 1e-3, 100)
}

fn steps<const D: usize>(block: &Block) -> Result<Work, Box<dyn Error>> {
    let solver = block.build::<D>()?;
    let dt = block.step(&solver);
    stepping(solver, dt, 1)
}

/// `count` steps of `dt` (s), after three that set memory aside.
fn stepping<const D: usize>(mut solver: Solver<D>, dt: f64, count: usize) -> Result<Work, Box<dyn Error>> {
    for _ in 0..3 {
        solver.step(dt)?;
    }
    let work = move || {
        for _ in 0..count {
            if let Err(error) = solver.step(dt) {
                unreachable!("a block under its own weight: {error}");
            }
        }
    };
    Ok(Box::new(work))
}

/// 64 points in simple shear at constant volume from 100 kPa, 100 increments of γ = 1e-4.
fn updates(law: impl ConstitutiveLaw) -> Work {
    const POINTS: usize = 64;
    const INCREMENTS: usize = 100;
    let mut stresses = vec![Sym3::IDENTITY * -100e3; POINTS];
    let group = Group::new("ground", law, 0..POINTS, stresses.iter().copied());
    let increments = [Increment { strain: Sym3 { xy: 0.5e-4, ..Sym3::ZERO }, ..Increment::default() }; POINTS];
    let volumes = [1.0; POINTS];
    let work = move || {
        for _ in 0..INCREMENTS {
            let outcome = group.update_block(0, &mut stresses, &increments, &volumes);
            assert!(outcome.failure.is_none(), "{:?}", outcome.failure);
        }
    };
    Box::new(work)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kernel_works_and_has_a_name_of_its_own() {
        for (number, kernel) in KERNELS.iter().enumerate() {
            (kernel.prepare)().unwrap()();
            assert!(KERNELS[..number].iter().all(|other| other.name != kernel.name));
        }
    }
}
