use super::dilation::{Dilation, VolumetricStrain};
use super::error::StepError;
use super::stress_order::{NodalVelocity, Pass};
use super::viscosity::Viscosity;
use crate::boundary::Boundary;
use crate::damping::Damping;

use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::law::{Increment, LawFailure, MaterialGroup};
use crate::particles::Particles;
use crate::pressure::StepView;
use crate::tensor::{Matrix, Vector, embed, volume_ratio};
use crate::transfer::{BLOCK, Gathered};
use crate::velocity::VelocityUpdate;

/// Steps 8 to 10: what the motion of the nodes does to the particles. Holds the work arrays.
pub(super) struct Motion<const D: usize> {
    dilation: Dilation,
    viscosity: Viscosity,
    at_particles: Vec<Gathered<D>>,
    increments: Vec<Increment>,
    porosities: Vec<f64>,
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
            dilation: Dilation::new(volumetric_strain, grid),
            viscosity: Viscosity::new(damping.stiffness, &particles.stress),
            at_particles: vec![Gathered::default(); BLOCK],
            increments: vec![Increment::default(); BLOCK],
            porosities: vec![0.0; BLOCK],
            mapped: Vec::new(),
            strain_energy: 0.0,
        }
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
        nodes.clear(at.active);
        self.viscosity.swap(&mut particles.stress);
        at.transfer.particles_to_nodes(at.grid, particles, nodes);
        self.viscosity.swap(&mut particles.stress);
        velocity_update.add_momentum(at.grid, at.transfer, particles, &mut nodes.velocity_old);
        boundary.hold(at.active, nodes);
        nodes.momentum_to_velocity(at.active);
    }

    /// One pass over the particles. Returns the first failure of a law.
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
        let Motion { dilation, viscosity, at_particles, increments, porosities, mapped, strain_energy } = self;
        let strained_by: Option<&[Vector<D>]> = pass.stress.map(|field| match field {
            NodalVelocity::Old => &nodes.velocity_old[..],
            NodalVelocity::New => &nodes.velocity[..],
            NodalVelocity::Mapped => &mapped[..],
        });
        if let Some(field) = strained_by {
            dilation.measure(at, field, particles, at_particles);
        }

        let mut failure = None;
        for group in groups {
            let all = group.particles();
            for start in all.clone().step_by(BLOCK) {
                let block = start..all.end.min(start + BLOCK);
                let at_particles = &mut at_particles[..block.len()];
                let gathers = pass.velocity || pass.position;
                if gathers {
                    at.transfer.nodes_to_particles(at.grid, nodes, particles, block.clone(), at_particles);
                }
                if let Some(field) = strained_by {
                    // The gradient of v_I^L is there already.
                    if !(gathers && pass.stress == Some(NodalVelocity::New)) {
                        at.transfer.velocity_gradients(at.grid, field, particles, block.clone(), at_particles);
                    }

                    // 8. Strain increments.
                    dilation.impose(&particles.cell[block.clone()], at_particles);
                    let increments = &mut increments[..block.len()];
                    strain_increments(at_particles, at.dt, increments);

                    // 9. Effective stresses by the constitutive law.
                    let stresses = &mut particles.stress[block.clone()];
                    let volumes = &particles.volume[block.clone()];
                    viscosity.remember(block.clone(), stresses, increments);
                    let outcome = group.update_block(start - all.start, stresses, increments, volumes);
                    viscosity.resist(block.clone(), stresses, at.damping.stiffness / at.dt);
                    *strain_energy += outcome.work;
                    if let (None, Some(failed)) = (&failure, outcome.failure) {
                        let LawFailure { particle, question, source } = *failed;
                        let (particle, question, source) = (start + particle, Box::new(question), Box::new(source));
                        let position = particles.position[particle].iter().copied().collect();
                        let material = group.name().to_owned();
                        failure =
                            Some(StepError::Law { material, particle, position, time: at.time, question, source });
                    }

                    // 10. Volumes and pores.
                    let porosities = &mut porosities[..block.len()];
                    porosities.copy_from_slice(&particles.porosity[block.clone()]);
                    particles.stretch(block.clone(), at_particles, at.dt);
                    let conductivities = &mut particles.conductivity[block.clone()];
                    let law = group.conductivity_law();
                    law.update_block(porosities, &particles.porosity[block.clone()], conductivities);
                }
                // 10. Velocities of the particles, with a_I (MPM①) or v_I^L (MPM②), and positions.
                if pass.velocity {
                    velocity_update.update_block(&mut particles.velocity[block.clone()], at_particles, at.dt);
                }
                if pass.position {
                    particles.advance(block, at_particles, at.dt);
                }
            }
        }
        failure
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
        for &node in at.active.nodes() {
            self.mapped[node as usize] = Vector::zeros();
        }
        at.transfer.spread_momentum(at.grid, particles, &mut self.mapped);
        velocity_update.add_momentum(at.grid, at.transfer, particles, &mut self.mapped);
        nodes.momenta_to_velocities(at.active, &mut self.mapped);
    }
}

/// Step 8: strain and spin increments from the velocity gradients.
///
/// # Equation
///
/// ```text
/// Δε = ½ (∇v + ∇vᵀ) Δt      Δω = ½ (∇v − ∇vᵀ) Δt
/// ```
fn strain_increments<const D: usize>(at_particles: &[Gathered<D>], dt: f64, increments: &mut [Increment]) {
    for (at, increment) in at_particles.iter().zip(increments) {
        *increment = Increment::of(&embed(&(at.velocity_gradient * dt))).within(dt);
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

impl<const D: usize> Particles<D> {
    /// Moves particles with the grid, X_p ← X_p + Δt v^L(X_p).
    fn advance(&mut self, block: std::ops::Range<usize>, at_particles: &[Gathered<D>], dt: f64) {
        for (position, at) in self.position[block].iter_mut().zip(at_particles) {
            *position += at.velocity * dt;
        }
    }

    /// Stretches volumes, by det(I + Δt ∇v), boxes and pores.
    ///
    /// The grains keep their volume: (1 − n) V stays. Dry ground has n = 0 and no pores to follow.
    fn stretch(&mut self, block: std::ops::Range<usize>, at_particles: &[Gathered<D>], dt: f64) {
        for (p, at) in block.zip(at_particles) {
            let gradient: Matrix<D> = at.velocity_gradient * dt;
            let ratio = volume_ratio(&gradient);
            self.volume[p] *= ratio;
            if self.porosity[p] > 0.0 {
                self.porosity[p] = 1.0 - (1.0 - self.porosity[p]) / ratio;
            }
            for axis in 0..D {
                self.half_size[p][axis] *= 1.0 + gradient[(axis, axis)];
            }
        }
    }
}
