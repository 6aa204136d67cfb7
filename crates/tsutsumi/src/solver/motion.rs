use std::ops::Range;

use super::dilation::{Dilation, VolumetricStrain};
use super::error::{StepError, closed_pores};
use super::stress_order::{NodalVelocity, Pass};
use super::viscosity::{Viscosity, remember, resist};
use crate::boundary::Boundary;
use crate::damping::Damping;
use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::law::{BLOCK, BlockOutcome, IncrementBlock, LANES, LawFailure, MaterialGroup, StressBlock};
use crate::parallel::{self, FAR, Pieces, fetch, vectorized};
use crate::particles::{Follows, LocalMotion, Particles, Places, Stresses, StressesMut};
use crate::pressure::StepView;
use crate::tensor::{Matrix, Vector, volume_ratio};
use crate::transfer::{GRAIN, GatheredBlock, Wanted};
use crate::velocity::VelocityUpdate;

/// Steps 8 to 10: what the motion of the nodes does to the particles. Holds the work arrays.
pub(super) struct Motion<const D: usize> {
    dilation: Dilation,
    viscosity: Viscosity,
    /// Whether any particle has a porosity to follow.
    has_pores: bool,
    /// Whether the grains of any particle have left no room for water.
    pores_closed: bool,
    /// The nodes' velocities from the particles' new ones (m/s); empty until a stress order asks for them.
    mapped: Vec<Vector<D>>,
    /// Work of the effective stress since the start (J).
    pub(super) strain_energy: f64,
}

/// The parts of the solver that a pass changes or asks.
pub(super) struct Followers<'a, const D: usize> {
    pub(super) particles: &'a mut Particles<D>,
    pub(super) groups: &'a mut [Box<dyn MaterialGroup>],
    pub(super) velocity_update: &'a dyn VelocityUpdate<D>,
}

impl<const D: usize> Motion<D> {
    pub(super) fn new(
        grid: &Grid<D>,
        particles: &Particles<D>,
        volumetric_strain: VolumetricStrain,
        damping: Damping,
    ) -> Self {
        Motion {
            dilation: Dilation::new(volumetric_strain, grid, particles),
            viscosity: Viscosity::new(damping.stiffness, &particles.stress),
            has_pores: particles.porosity.iter().any(|&porosity| porosity != 0.0),
            pores_closed: false,
            mapped: Vec::new(),
            strain_energy: 0.0,
        }
    }

    /// What follows the particles to other places.
    pub(super) fn of_particles(&mut self) -> &mut dyn Follows {
        self.viscosity.felt()
    }

    /// The memory that grows with the particles (bytes).
    pub(super) fn bytes_of_particles(&self) -> usize {
        self.viscosity.bytes() + self.dilation.bytes_of_particles()
    }

    /// The memory that grows with the cells (bytes).
    pub(super) fn bytes_of_cells(&self) -> usize {
        self.dilation.bytes_of_cells()
    }

    /// Step 3: masses, velocities and the force of the effective stress at the nodes.
    pub(super) fn map(
        &mut self,
        at: &StepView<D>,
        particles: &mut Particles<D>,
        velocity_update: &dyn VelocityUpdate<D>,
        boundary: &Boundary<D>,
        nodes: &mut NodeFields<D>,
    ) {
        self.viscosity.swap(&mut particles.stress);
        at.transfer.particles_to_nodes(at.grid, at.active, particles, velocity_update.local_motion(), nodes);
        self.viscosity.swap(&mut particles.stress);
        boundary.hold(at.active, nodes);
        nodes.momentum_to_velocity(at.active);
    }

    /// One pass over the particles. Returns the first failure of a law, by the number of the particle.
    pub(super) fn follow(
        &mut self,
        pass: Pass,
        at: &StepView<D>,
        nodes: &NodeFields<D>,
        followers: Followers<D>,
    ) -> Option<StepError> {
        let Followers { particles, groups, velocity_update } = followers;
        if pass.stress == Some(NodalVelocity::Mapped) {
            self.map_again(at, nodes, particles, velocity_update);
        }
        let strained_by: Option<&[Vector<D>]> = pass.stress.map(|field| match field {
            NodalVelocity::Old => &nodes.velocity_old[..],
            NodalVelocity::New => &nodes.velocity[..],
            NodalVelocity::Mapped => &self.mapped[..],
        });
        if let Some(field) = strained_by {
            self.dilation.measure(at, field, particles);
        }

        let ahead = if particles.len() >= FAR { BLOCK } else { 0 };
        let mut failure = None;
        for group in groups {
            let (dilation, has_pores) = (&self.dilation, self.has_pores);
            let step = FollowStep {
                pass,
                at,
                nodes,
                strained_by,
                dilation,
                has_pores,
                ahead,
                group: &**group,
                velocity_update,
            };
            let piece = Piece::new(particles, self.viscosity.felt(), group.particles());
            let Followed { outcome, pores_closed } =
                parallel::fold(piece, GRAIN, &|piece| step.follow(piece), &Followed::and);
            self.strain_energy += outcome.work;
            self.pores_closed |= pores_closed;
            if let (None, Some(failed)) = (&failure, outcome.failure) {
                let LawFailure { particle, question, source } = *failed;
                let (question, source) = (Box::new(question), Box::new(source));
                let position = particles.position[particles.place_of(particle)].iter().copied().collect();
                let material = group.name().to_owned();
                failure = Some(StepError::Law { material, particle, position, time: at.time, question, source });
            }
        }
        failure
    }

    /// The first particle whose grains leave no room for water. Nobody has to look as long as no pass has seen one.
    pub(super) fn closed_pores(&self, particles: &Particles<D>, time: f64) -> Option<StepError> {
        if self.pores_closed { closed_pores(particles, time) } else { None }
    }

    /// The nodes' velocities from the particles' new ones, by Eq. (10) in the old places.
    fn map_again(
        &mut self,
        at: &StepView<D>,
        nodes: &NodeFields<D>,
        particles: &Particles<D>,
        velocity_update: &dyn VelocityUpdate<D>,
    ) {
        self.mapped.resize(at.grid.num_nodes(), Vector::zeros());
        at.active.change_runs(&mut self.mapped, |_, momenta| momenta.fill(Vector::zeros()));
        at.transfer.spread_momentum(at.grid, at.active, particles, velocity_update.local_motion(), &mut self.mapped);
        nodes.momenta_to_velocities(at.active, &mut self.mapped);
    }
}

/// The fields of particles that follow each other, with what a pass may change of them.
struct Piece<'a, const D: usize> {
    /// The place of the first one within its group.
    first: usize,
    /// Empty where the numbers of the particles are their places.
    numbers: &'a [u32],
    position: &'a mut [Vector<D>],
    velocity: &'a mut [Vector<D>],
    volume: &'a mut [f64],
    half_size: &'a mut [Vector<D>],
    half_size_at_start: &'a [Vector<D>],
    stress: StressesMut<'a>,
    /// The stress that the nodes feel; empty without damping.
    felt: StressesMut<'a>,
    porosity: &'a mut [f64],
    conductivity: &'a mut [f64],
    cell: &'a [u32],
    /// Empty where the velocity update keeps nothing.
    local_motion: &'a mut [Matrix<D>],
}

impl<'a, const D: usize> Piece<'a, D> {
    /// The particles of a range, which is a group.
    fn new(particles: &'a mut Particles<D>, felt: &'a mut Stresses, range: Range<usize>) -> Self {
        let felt = if felt.is_empty() { felt.all_mut() } else { felt.all_mut().part(range.clone()) };
        let local_motion = &mut particles.local_motion[..];
        let local_motion = if local_motion.is_empty() { local_motion } else { &mut local_motion[range.clone()] };
        let numbers = &particles.numbers[..];
        Piece {
            first: 0,
            numbers: if numbers.is_empty() { numbers } else { &numbers[range.clone()] },
            position: &mut particles.position[range.clone()],
            velocity: &mut particles.velocity[range.clone()],
            volume: &mut particles.volume[range.clone()],
            half_size: &mut particles.half_size[range.clone()],
            half_size_at_start: &particles.half_size_at_start[range.clone()],
            stress: particles.stress.all_mut().part(range.clone()),
            felt,
            porosity: &mut particles.porosity[range.clone()],
            conductivity: &mut particles.conductivity[range.clone()],
            cell: &particles.cell[range],
            local_motion,
        }
    }

    fn places(&self) -> Places<'_, D> {
        Places { position: self.position, half_size: self.half_size, half_size_at_start: self.half_size_at_start }
    }
}

impl<const D: usize> Pieces for Piece<'_, D> {
    fn count(&self) -> usize {
        self.position.len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let numbers = self.numbers.split_at(at.min(self.numbers.len()));
        let position = self.position.split_at_mut(at);
        let velocity = self.velocity.split_at_mut(at);
        let volume = self.volume.split_at_mut(at);
        let half_size = self.half_size.split_at_mut(at);
        let half_size_at_start = self.half_size_at_start.split_at(at);
        let stress = self.stress.cut(at);
        let felt_before = at.min(self.felt.len());
        let felt = self.felt.cut(felt_before);
        let porosity = self.porosity.split_at_mut(at);
        let conductivity = self.conductivity.split_at_mut(at);
        let cell = self.cell.split_at(at);
        let local_motion = self.local_motion.split_at_mut(at.min(self.local_motion.len()));
        let before = Piece {
            first: self.first,
            numbers: numbers.0,
            position: position.0,
            velocity: velocity.0,
            volume: volume.0,
            half_size: half_size.0,
            half_size_at_start: half_size_at_start.0,
            stress: stress.0,
            felt: felt.0,
            porosity: porosity.0,
            conductivity: conductivity.0,
            cell: cell.0,
            local_motion: local_motion.0,
        };
        let after = Piece {
            first: self.first + at,
            numbers: numbers.1,
            position: position.1,
            velocity: velocity.1,
            volume: volume.1,
            half_size: half_size.1,
            half_size_at_start: half_size_at_start.1,
            stress: stress.1,
            felt: felt.1,
            porosity: porosity.1,
            conductivity: conductivity.1,
            cell: cell.1,
            local_motion: local_motion.1,
        };
        (before, after)
    }
}

/// What came of a pass over some particles.
#[derive(Default)]
struct Followed {
    outcome: BlockOutcome,
    pores_closed: bool,
}

impl Followed {
    fn and(self, next: Self) -> Self {
        Followed { outcome: self.outcome.and(next.outcome), pores_closed: self.pores_closed | next.pores_closed }
    }
}

/// A pass over the particles of a group: what it asks.
struct FollowStep<'a, const D: usize> {
    pass: Pass,
    at: &'a StepView<'a, D>,
    nodes: &'a NodeFields<D>,
    /// The velocities of the nodes that strain the material (m/s), if it is strained.
    strained_by: Option<&'a [Vector<D>]>,
    dilation: &'a Dilation,
    has_pores: bool,
    /// So many particles of the next block are asked for.
    ahead: usize,
    group: &'a dyn MaterialGroup,
    velocity_update: &'a dyn VelocityUpdate<D>,
}

impl<const D: usize> FollowStep<'_, D> {
    /// Steps 8 to 10 for a piece of the group, block by block. A failure is that of the particle with the lowest number.
    fn follow(&self, piece: Piece<D>) -> Followed {
        let mut followed = Followed::default();
        let mut at_particles = GatheredBlock::new();
        let mut increments = IncrementBlock::within(self.at.dt, D);
        let mut stresses = StressBlock::new();
        let mut rest = piece;
        while !rest.position.is_empty() {
            let len = rest.count().min(BLOCK);
            let (block, after) = rest.cut(len);
            let of_block = self.follow_block(block, &after, &mut at_particles, &mut increments, &mut stresses);
            followed = followed.and(of_block);
            rest = after;
        }
        followed
    }

    /// The number of a particle of a block.
    #[cold]
    fn number(&self, block: &Piece<D>, p: usize) -> usize {
        let place = self.group.particles().start + block.first + p;
        block.numbers.get(p).map_or(place, |&number| number as usize)
    }

    fn follow_block(
        &self,
        mut block: Piece<D>,
        next: &Piece<D>,
        at_particles: &mut GatheredBlock<D>,
        increments: &mut IncrementBlock,
        stresses: &mut StressBlock,
    ) -> Followed {
        let &FollowStep { pass, at, nodes, ahead, .. } = self;
        let mut followed = Followed::default();
        let gathers = pass.velocity || pass.position;
        // The fields of the next block come a few at a time, each long before it is needed.
        fetch(next.position, 0..ahead);
        if at.transfer.reach() > 0.0 {
            fetch(next.half_size_at_start, 0..ahead);
        }
        if gathers {
            let (wanted, places) = self.ask(&mut block);
            at.transfer.gather_block(at.grid, nodes, places, wanted, at_particles);
        }
        if pass.velocity && self.velocity_update.local_motion() == LocalMotion::Gradient {
            // Before anything changes that of v_I^L.
            for (p, gradient) in block.local_motion.iter_mut().enumerate() {
                *gradient = at_particles.at(p).velocity_gradient;
            }
        }
        if let Some(field) = self.strained_by {
            // The gradient of v_I^L is there already.
            if !(gathers && pass.stress == Some(NodalVelocity::New)) {
                at.transfer.gather_gradients(at.grid, field, block.places(), at_particles);
            }

            next.stress.fetch(0..ahead);

            // 8. Strain increments.
            self.dilation.impose(block.cell, at_particles);
            vectorized(
                #[inline(always)]
                || strain_increments(at_particles, at.dt, block.count(), increments),
            );

            // 9. Effective stresses by the constitutive law.
            remember(&mut block.felt, &block.stress, increments);
            let mut outcome =
                self.group.update_aligned(block.first, block.stress.reborrow(), increments, block.volume, stresses);
            if let Some(failure) = &mut outcome.failure {
                failure.particle = self.number(&block, failure.particle);
            }
            resist(&mut block.felt, &block.stress, at.damping.stiffness / at.dt);

            fetch(next.volume, 0..ahead);
            fetch(next.half_size, 0..ahead);

            // 10. Volumes and pores.
            let pores_closed = vectorized(
                #[inline(always)]
                || self.stretch(&mut block, at_particles),
            );
            followed = Followed { outcome, pores_closed };
        }
        // 10. Velocities of the particles, with a_I (MPM①) or v_I^L (MPM②), and positions.
        if pass.velocity {
            fetch(next.velocity, 0..ahead);
            self.velocity_update.update_block(block.velocity, at_particles, at.dt);
        }
        if pass.position {
            vectorized(
                #[inline(always)]
                || advance(block.position, at_particles, at.dt),
            );
        }
        followed
    }

    /// What is asked of the grid for a block, and where. Moments go where they stay.
    fn ask<'b>(&self, block: &'b mut Piece<D>) -> (Wanted<'b, D>, Places<'b, D>) {
        let keeps_moments = self.pass.velocity && self.velocity_update.local_motion() == LocalMotion::Moments;
        let Piece { position, half_size, half_size_at_start, local_motion, .. } = block;
        let acceleration = self.velocity_update.needs_acceleration();
        let moments = if keeps_moments { &mut local_motion[..] } else { &mut [] };
        (Wanted { acceleration, moments }, Places { position, half_size, half_size_at_start })
    }

    /// Stretches volumes, by det(I + Δt ∇v), boxes and pores. Returns whether the grains of any particle leave no room for water.
    ///
    /// The grains keep their volume: (1 − n) V stays. Dry ground has n = 0 and no pores to follow.
    #[inline(always)]
    fn stretch(&self, block: &mut Piece<D>, at_particles: &GatheredBlock<D>) -> bool {
        let mut ratios = [1.0; BLOCK];
        let boxes = block.volume.iter_mut().zip(block.half_size.iter_mut());
        for (p, ((volume, half_size), ratio)) in boxes.zip(&mut ratios).enumerate() {
            let gradient: Matrix<D> = at_particles.at(p).velocity_gradient * self.at.dt;
            *ratio = volume_ratio(&gradient);
            *volume *= *ratio;
            for axis in 0..D {
                half_size[axis] *= 1.0 + gradient[(axis, axis)];
            }
        }
        if !self.has_pores {
            return false;
        }
        let mut old = [0.0; BLOCK];
        let old = &mut old[..block.count()];
        old.copy_from_slice(block.porosity);
        for (porosity, ratio) in block.porosity.iter_mut().zip(ratios) {
            if *porosity > 0.0 {
                *porosity = 1.0 - (1.0 - *porosity) / ratio;
            }
        }
        self.group.conductivity_law().update_block(old, block.porosity, block.conductivity);
        block.porosity.iter().fold(false, |any, &porosity| any | (porosity < 0.0))
    }
}

/// Step 8: strain and spin increments from the velocity gradients.
///
/// # Equation
///
/// ```text
/// Δε = ½ (∇v + ∇vᵀ) Δt      Δω = ½ (∇v − ∇vᵀ) Δt
/// ```
#[inline(always)]
fn strain_increments<const D: usize>(at: &GatheredBlock<D>, dt: f64, len: usize, increments: &mut IncrementBlock) {
    let gradient = |i: usize, j: usize, p: usize| at.velocity_gradient[i][j][p] * dt;
    for p in 0..len.next_multiple_of(LANES).min(BLOCK) {
        for i in 0..D {
            increments.strain[i][p] = gradient(i, i, p);
        }
        if D > 1 {
            increments.strain[3][p] = 0.5 * (gradient(0, 1, p) + gradient(1, 0, p));
            increments.spin[2][p] = 0.5 * (gradient(1, 0, p) - gradient(0, 1, p));
        }
        if D > 2 {
            increments.strain[4][p] = 0.5 * (gradient(1, 2, p) + gradient(2, 1, p));
            increments.strain[5][p] = 0.5 * (gradient(2, 0, p) + gradient(0, 2, p));
            increments.spin[0][p] = 0.5 * (gradient(2, 1, p) - gradient(1, 2, p));
            increments.spin[1][p] = 0.5 * (gradient(0, 2, p) - gradient(2, 0, p));
        }
    }
}

impl<const D: usize> NodeFields<D> {
    /// v_I = Σ M_p V_p N_I / m_I; zero where a support holds, one for all nodes that move as one.
    fn momentum_to_velocity(&mut self, active: &ActiveSet) {
        let mut field = std::mem::take(&mut self.velocity_old);
        self.momenta_to_velocities(active, &mut field);
        self.velocity_old = field;
    }
}

/// Moves particles with the grid, X_p ← X_p + Δt v^L(X_p).
#[inline(always)]
fn advance<const D: usize>(positions: &mut [Vector<D>], at_particles: &GatheredBlock<D>, dt: f64) {
    for (p, position) in positions.iter_mut().enumerate().take(BLOCK) {
        for axis in 0..D {
            position[axis] += at_particles.velocity[axis][p] * dt;
        }
    }
}
