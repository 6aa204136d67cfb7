//! What it costs that shape function, velocity update and material are chosen at run time.
//!
//! [`Loop`] is the step of a dry block of one material, written once more from the library's public parts, in the order of
//! [`Solver::step`](tsutsumi::solver::Solver::step). It is compiled for concrete types, where nothing is called through a pointer, and for those behind
//! `dyn`, as the solver holds them: the difference is the price of the choice. All three give the same bits.
//!
//! The law runs particle by particle ([`MaterialGroup::update_block`]): the solver's own way is not public. The solver is faster than either loop by that.

use tsutsumi::boundary::Boundary;
use tsutsumi::grid::{ActiveSet, Grid, NodeFields};
use tsutsumi::law::{Group, Increment, LinearElastic, MaterialGroup};
use tsutsumi::particles::{LocalMotion, Particles};
use tsutsumi::shape::Linear;
use tsutsumi::solver::{Parts, Solver, StepError};
use tsutsumi::tensor::{Sym3, Vector, volume_ratio};
use tsutsumi::transfer::{GatheredBlock, Transfer, Wanted};
use tsutsumi::velocity::{Mpm1, VelocityUpdate};

use crate::block::{Block, BlockError};
use crate::laws::LINEAR_ELASTIC;

/// What can be stepped.
pub trait Steps {
    /// A step of `dt` (s).
    ///
    /// # Errors
    /// See [`StepError`].
    fn step(&mut self, dt: f64) -> Result<(), StepError>;

    /// The material points.
    fn particles(&self) -> &Particles<2>;
}

impl Steps for Solver<2> {
    fn step(&mut self, dt: f64) -> Result<(), StepError> {
        Solver::step(self, dt).map(|_| ())
    }

    fn particles(&self) -> &Particles<2> {
        Solver::particles(self)
    }
}

/// Particles in a call, as in the solver.
const BLOCK: usize = 64;

/// A block of ground in two dimensions, with these parts or with any of their kind (`dyn`).
pub struct Loop<S: ?Sized, V: ?Sized, G: ?Sized> {
    grid: Grid<2>,
    active: ActiveSet,
    nodes: NodeFields<2>,
    particles: Particles<2>,
    boundary: Boundary<2>,
    gravity: Vector<2>,
    shape: Box<S>,
    velocity_update: Box<V>,
    group: Box<G>,
}

/// All parts known when the program is built.
pub type Static = Loop<Linear, Mpm1, Group<LinearElastic>>;

/// All parts chosen at run time.
pub type Boxed = Loop<dyn Transfer<2>, dyn VelocityUpdate<2>, dyn MaterialGroup>;

impl Static {
    /// The linear block of about so many particles.
    ///
    /// # Errors
    /// See [`BlockError`].
    pub fn new(particles: usize) -> Result<Self, BlockError> {
        let parts = Block::linear(particles).parts::<2>()?;
        let group = Group::new("ground", LINEAR_ELASTIC, 0..parts.particles.len(), &parts.particles.stress);
        let Parts { grid, particles, boundary, gravity, .. } = parts;
        let (active, nodes) = (ActiveSet::new(&grid), NodeFields::new(&grid));
        let (shape, velocity_update, group) = (Box::new(Linear), Box::new(Mpm1), Box::new(group));
        Ok(Loop { grid, active, nodes, particles, boundary, gravity, shape, velocity_update, group })
    }
}

impl Boxed {
    /// The same block, its parts chosen by name.
    ///
    /// # Errors
    /// See [`BlockError`].
    pub fn new(particles: usize) -> Result<Self, BlockError> {
        let parts = Block::linear(particles).parts::<2>()?;
        let Parts { grid, particles, boundary, gravity, shape, velocity_update, mut groups, .. } = parts;
        let (active, nodes) = (ActiveSet::new(&grid), NodeFields::new(&grid));
        // A block is made of one material.
        let group = groups.remove(0);
        Ok(Loop { grid, active, nodes, particles, boundary, gravity, shape, velocity_update, group })
    }
}

/// With the numbers of the paper's algorithm. Loads, water and updates that carry more than a velocity have no part in it.
impl<S, V, G> Steps for Loop<S, V, G>
where
    S: Transfer<2> + ?Sized,
    V: VelocityUpdate<2> + ?Sized,
    G: MaterialGroup + ?Sized,
{
    fn particles(&self) -> &Particles<2> {
        &self.particles
    }

    fn step(&mut self, dt: f64) -> Result<(), StepError> {
        let Loop { grid, active, nodes, particles, boundary, gravity, shape, .. } = self;
        // 2.
        if particles.locate(grid).map_err(|outside| StepError::Outside { time: f64::NAN, outside })? > 0 {
            active.update(particles.located(), |cell, visit| shape.visit_stencil(grid, cell, visit));
        }
        // 3.
        shape.particles_to_nodes(grid, active, particles, LocalMotion::Nothing, nodes);
        boundary.hold(active, nodes);
        let mut field = std::mem::take(&mut nodes.velocity_old);
        nodes.momenta_to_velocities(active, &mut field);
        nodes.velocity_old = field;
        // 4. to 7.
        for &node in active.nodes() {
            let node = node as usize;
            for axis in 0..2 {
                nodes.force[node][axis] += gravity[axis] * nodes.mass[node];
                nodes.acceleration[node][axis] = nodes.force[node][axis];
            }
        }
        nodes.forces_to_accelerations(active);
        for &node in active.nodes() {
            let node = node as usize;
            for axis in 0..2 {
                nodes.velocity[node][axis] = nodes.velocity_old[node][axis] + nodes.acceleration[node][axis] * dt;
            }
        }
        // 8. to 10.
        let mut at_particles = GatheredBlock::new();
        let mut increments = [Increment { duration: dt, ..Increment::default() }; BLOCK];
        for start in (0..self.particles.len()).step_by(BLOCK) {
            self.follow(start, dt, &mut at_particles, &mut increments);
        }
        Ok(())
    }
}

impl<S, V, G> Loop<S, V, G>
where
    S: Transfer<2> + ?Sized,
    V: VelocityUpdate<2> + ?Sized,
    G: MaterialGroup + ?Sized,
{
    /// Steps 8 to 10 for the particles from number `start` on.
    fn follow(
        &mut self,
        start: usize,
        dt: f64,
        at_particles: &mut GatheredBlock<2>,
        increments: &mut [Increment; BLOCK],
    ) {
        let Loop { grid, nodes, particles, shape, velocity_update, group, .. } = self;
        let block = start..particles.len().min(start + BLOCK);
        let wanted = Wanted { acceleration: true, moments: &mut [] };
        shape.gather_block(grid, nodes, particles.places().part(block.clone()), wanted, at_particles);
        let increments = &mut increments[..block.len()];
        for (p, increment) in increments.iter_mut().enumerate() {
            let gradient = at_particles.at(p).velocity_gradient * dt;
            let [[xx, yx], [xy, yy]] = gradient.data.0;
            increment.strain = Sym3 { xx, yy, xy: 0.5 * (xy + yx), ..Sym3::ZERO };
            increment.spin[2] = 0.5 * (yx - xy);
        }
        let volumes = &mut particles.volume[block.clone()];
        let mut stresses = [Sym3::ZERO; BLOCK];
        let stresses = &mut stresses[..block.len()];
        stresses.iter_mut().zip(block.clone()).for_each(|(stress, p)| *stress = particles.stress.at(p));
        let outcome = group.update_block(start, stresses, increments, volumes);
        assert!(outcome.failure.is_none(), "linear elasticity cannot fail");
        stresses.iter().zip(block.clone()).for_each(|(&stress, p)| particles.stress.set(p, stress));
        let boxes = volumes.iter_mut().zip(&mut particles.half_size[block.clone()]);
        for (p, (volume, half_size)) in boxes.enumerate() {
            let gradient = at_particles.at(p).velocity_gradient * dt;
            *volume *= volume_ratio(&gradient);
            for axis in 0..2 {
                half_size[axis] *= 1.0 + gradient[(axis, axis)];
            }
        }
        velocity_update.update_block(&mut particles.velocity[block.clone()], at_particles, dt);
        for (p, position) in particles.position[block].iter_mut().enumerate() {
            *position += at_particles.at(p).velocity * dt;
        }
    }
}

/// Every bit of the particles' state: a sum in which the order counts.
pub fn fingerprint(particles: &Particles<2>) -> u64 {
    let vectors = [&particles.position, &particles.velocity, &particles.half_size].into_iter().flatten();
    let numbers = vectors.flat_map(|vector| [vector[0], vector[1]]).chain(particles.volume.iter().copied());
    let stresses = particles.stress.iter().flat_map(|s| [s.xx, s.yy, s.zz, s.xy, s.yz, s.zx]);
    numbers
        .chain(stresses)
        .fold(0, |sum: u64, number| (sum ^ number.to_bits()).wrapping_mul(0x100_0000_01b3).rotate_left(7))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_loops_give_every_bit_of_the_solver() {
        let (mut known, mut chosen) = (Static::new(1000).unwrap(), Boxed::new(1000).unwrap());
        let mut solver = Block::linear(1000).build::<2>().unwrap();
        let dt = Block::linear(1000).step(&solver);
        for _ in 0..30 {
            solver.step(dt).unwrap();
            known.step(dt).unwrap();
            chosen.step(dt).unwrap();
        }
        let expected = fingerprint(solver.particles());
        assert_eq!([fingerprint(known.particles()), fingerprint(chosen.particles())], [expected; 2]);
        assert!(solver.particles().velocity[0] != Vector::<2>::zeros());
    }
}
