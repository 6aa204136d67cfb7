//! What is read off a body.

use tsutsumi::grid::Side;
use tsutsumi::particles::Particles;
use tsutsumi::solver::{Solver, StepError};

/// The upper side along the last axis.
pub fn top<const D: usize>() -> Side {
    Side { axis: D - 1, upper: true }
}

/// The lower side along the last axis.
pub fn base<const D: usize>() -> Side {
    Side { axis: D - 1, upper: false }
}

/// Where the side of a particle's box is along the side's axis (m).
fn box_side<const D: usize>(particles: &Particles<D>, p: usize, side: Side) -> f64 {
    particles.position[p][side.axis] + side.sign() * particles.half_size[p][side.axis]
}

/// The particles whose boxes reach farthest on a side, within a thousandth of their size: for a body shaped as a box,
/// those at its surface.
pub fn outermost<const D: usize>(particles: &Particles<D>, side: Side) -> Vec<usize> {
    let reach = |p: usize| side.sign() * box_side(particles, p, side);
    let farthest = (0..particles.len()).map(reach).fold(f64::NEG_INFINITY, f64::max);
    (0..particles.len()).filter(|&p| farthest - reach(p) <= 1e-3 * particles.half_size[p][side.axis]).collect()
}

/// The mean place of the true surface that these particles carry, along the side's axis (m).
pub fn surface<const D: usize>(particles: &Particles<D>, carriers: &[usize], side: Side) -> f64 {
    let sum: f64 = carriers.iter().map(|&p| box_side(particles, p, side)).sum();
    sum / carriers.len() as f64
}

/// The mean position of these particles along an axis (m).
pub fn mean_position<const D: usize>(particles: &Particles<D>, of: &[usize], axis: usize) -> f64 {
    of.iter().map(|&p| particles.position[p][axis]).sum::<f64>() / of.len() as f64
}

/// The pressures of the active cells (Pa), in the order of their numbers: from the base to the top of a column.
pub fn cell_pressures<const D: usize>(solver: &Solver<D>) -> Vec<f64> {
    let pressure = &solver.cells().pressure;
    solver.active().cells().iter().map(|&c| pressure[c as usize]).collect()
}

/// The largest speed of a particle (m/s).
pub fn largest_speed<const D: usize>(particles: &Particles<D>) -> f64 {
    particles.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// Makes `count` equal steps of `dt` (s).
///
/// # Errors
/// The first that a step gives.
pub fn run<const D: usize>(solver: &mut Solver<D>, dt: f64, count: usize) -> Result<(), StepError> {
    for _ in 0..count {
        solver.step(dt)?;
    }
    Ok(())
}
