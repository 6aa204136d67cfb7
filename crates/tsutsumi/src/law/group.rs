use std::ops::Range;

use super::{ConductivityLaw, ConstantConductivity, ConstitutiveLaw, Increment, LawError, differences};
use crate::tensor::{Matrix6, Sym3, Vector, rotation};

/// The outcome of a law over a block of particles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BlockOutcome {
    /// Work of the effective stress, Σ V σ' : Δε (J).
    pub work: f64,
    /// The first particle of the block whose law failed. Its stress and history are those at the start of the step, turned
    /// with the material unless the law is one of finite strain.
    pub failure: Option<Box<LawFailure>>,
}

/// A law that gave no answer.
#[derive(Debug, Clone, PartialEq)]
pub struct LawFailure {
    /// The particle, counted from the start of the block.
    pub particle: usize,
    /// What the law was asked.
    pub question: Question,
    /// The law's reason.
    pub source: LawError,
}

/// What a law was asked: with the history, which the group keeps ([`MaterialGroup::history`]), enough to ask it again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// The effective stress at the start (Pa), turned with the material unless the law is one of finite strain.
    pub stress: Sym3,
    /// The motion, without the spin that stress and history have been turned by already.
    pub increment: Increment,
}

impl LawFailure {
    /// With what is left to ask after stress and history have been turned.
    #[cold]
    fn of<L: ConstitutiveLaw>(particle: usize, stress: Sym3, increment: &Increment, source: LawError) -> Box<Self> {
        let spin = if L::FINITE_STRAIN { increment.spin } else { Vector::zeros() };
        let question = Question { stress, increment: Increment { spin, ..*increment } };
        Box::new(LawFailure { particle, question, source })
    }
}

/// The particles of one material: its law and their histories.
pub struct Group<L: ConstitutiveLaw> {
    name: String,
    law: L,
    conductivity_law: Box<dyn ConductivityLaw>,
    states: Vec<L::State>,
    particles: Range<usize>,
}

impl<L: ConstitutiveLaw> Group<L> {
    /// A group of the particles `particles` with these initial effective stresses (Pa).
    pub fn new(name: impl Into<String>, law: L, particles: Range<usize>, stresses: &[Sym3]) -> Self {
        let states = stresses.iter().map(|&stress| law.initial_state(stress)).collect();
        let conductivity_law = Box::new(ConstantConductivity);
        Group { name: name.into(), law, conductivity_law, states, particles }
    }

    /// The same group, all particles with this history in place of that of their stress.
    #[must_use]
    pub fn with_history(mut self, history: L::State) -> Self {
        self.states.fill(history);
        self
    }

    /// The same group with another law of the conductivity; it starts with a constant one.
    #[must_use]
    pub fn with_conductivity_law(mut self, conductivity_law: Box<dyn ConductivityLaw>) -> Self {
        self.conductivity_law = conductivity_law;
        self
    }
}

/// A [`Group`] whose law is chosen at run time. A call handles many particles.
pub trait MaterialGroup: Send + Sync {
    /// The name of the material.
    fn name(&self) -> &str;

    /// The particles of the group.
    fn particles(&self) -> Range<usize>;

    /// How the conductivity of the particles follows their porosity.
    fn conductivity_law(&self) -> &dyn ConductivityLaw;

    /// Turns and updates the stresses (Pa) and histories of a block of particles.
    ///
    /// `first` is the number of the block's first particle within the group; `volumes` (m³) weight the work.
    fn update_block(
        &mut self,
        first: usize,
        stresses: &mut [Sym3],
        increments: &[Increment],
        volumes: &[f64],
    ) -> BlockOutcome;

    /// The stress (Pa) that a strain increment without spin would lead to within a duration (s), and the tangent there
    /// ([`ConstitutiveLaw::tangent`], or central differences in a finite time), for the group's particle number `particle`.
    /// Nothing is changed: implicit schemes try increments before they accept one.
    ///
    /// # Errors
    /// The law's.
    fn trial(&self, particle: usize, stress: Sym3, strain: Sym3, duration: f64) -> Result<(Sym3, Matrix6), LawError>;

    /// The history of the group's particle number `particle`, to be written.
    fn history(&self, particle: usize) -> &dyn erased_serde::Serialize;

    /// The largest compression and shear wave moduli in the group (Pa), for the stresses of its particles.
    fn wave_moduli(&self, stresses: &[Sym3]) -> (f64, f64);

    /// The names of the law's own output quantities.
    fn outputs(&self) -> &'static [&'static str];

    /// The values of [`MaterialGroup::outputs`] for the group's particle number `particle`.
    fn write_outputs(&self, particle: usize, stress: Sym3, values: &mut [f64]);
}

impl<L: ConstitutiveLaw> MaterialGroup for Group<L> {
    fn name(&self) -> &str {
        &self.name
    }

    fn particles(&self) -> Range<usize> {
        self.particles.clone()
    }

    fn conductivity_law(&self) -> &dyn ConductivityLaw {
        &*self.conductivity_law
    }

    fn update_block(
        &mut self,
        first: usize,
        stresses: &mut [Sym3],
        increments: &[Increment],
        volumes: &[f64],
    ) -> BlockOutcome {
        let mut outcome = BlockOutcome::default();
        let states = &mut self.states[first..first + stresses.len()];
        for (p, (stress, state)) in stresses.iter_mut().zip(states).enumerate() {
            let increment = &increments[p];
            // Jaumann: the old stress turns with the material by the rotation of the step. Laws of finite strain follow it themselves.
            if !L::FINITE_STRAIN && increment.spin != Vector::<3>::zeros() {
                let turn = rotation(&increment.spin);
                let in_plane = increment.spin.x == 0.0 && increment.spin.y == 0.0;
                *stress = match in_plane {
                    true => stress.rotated_about_z(turn[(0, 0)], turn[(1, 0)]),
                    false => stress.rotated(&turn),
                };
                *state = self.law.rotate_state(*state, &turn);
            }
            let answer = match L::FINITE_STRAIN {
                false => self.law.update_within(*stress, *state, increment.strain, increment.duration),
                true => self.law.deform(*stress, *state, increment),
            };
            match answer {
                Ok((new_stress, new_state)) if new_stress.is_finite() => {
                    let mean = (*stress + new_stress) * 0.5;
                    outcome.work += volumes[p] * mean.double_dot(increment.strain);
                    *stress = new_stress;
                    *state = new_state;
                }
                Ok(_) if outcome.failure.is_none() => {
                    let error = LawError::NotFinite { strain: increment.strain };
                    outcome.failure = Some(LawFailure::of::<L>(p, *stress, increment, error));
                }
                Err(error) if outcome.failure.is_none() => {
                    outcome.failure = Some(LawFailure::of::<L>(p, *stress, increment, error));
                }
                _ => {}
            }
        }
        outcome
    }

    fn trial(&self, particle: usize, stress: Sym3, strain: Sym3, duration: f64) -> Result<(Sym3, Matrix6), LawError> {
        let state = self.states[particle];
        let update = |strain| Ok(self.law.update_within(stress, state, strain, duration)?.0);
        let new_stress = update(strain)?;
        if !new_stress.is_finite() {
            return Err(LawError::NotFinite { strain });
        }
        let tangent = match duration.is_infinite() {
            true => self.law.tangent(stress, state, strain)?,
            false => differences(update, strain)?,
        };
        Ok((new_stress, tangent))
    }

    fn history(&self, particle: usize) -> &dyn erased_serde::Serialize {
        &self.states[particle]
    }

    fn wave_moduli(&self, stresses: &[Sym3]) -> (f64, f64) {
        self.states.iter().zip(stresses).fold((0.0, 0.0), |(p_wave, s_wave): (f64, f64), (state, &stress)| {
            (p_wave.max(self.law.p_wave_modulus(stress, state)), s_wave.max(self.law.s_wave_modulus(stress, state)))
        })
    }

    fn outputs(&self) -> &'static [&'static str] {
        self.law.outputs()
    }

    fn write_outputs(&self, particle: usize, stress: Sym3, values: &mut [f64]) {
        self.law.write_outputs(stress, &self.states[particle], values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::LinearElastic;

    fn group() -> Group<LinearElastic> {
        Group::new("soil", LinearElastic { young: 1e6, poisson: 0.25 }, 0..2, &[Sym3::ZERO; 2])
    }

    #[test]
    fn a_rotation_turns_the_stress_and_does_no_work() {
        let mut stresses = [Sym3::diagonal(-10.0, -20.0, -30.0); 2];
        let spin = Vector::<3>::new(0.0, 0.0, std::f64::consts::FRAC_PI_2 / 100.0);
        let increments = [Increment { spin, ..Default::default() }; 2];
        for _ in 0..100 {
            let outcome = group().update_block(0, &mut stresses, &increments, &[1.0; 2]);
            assert_eq!(outcome, BlockOutcome::default());
        }
        // The angle of each step is right to |w|⁵/120 = 8e-12 rad.
        assert!((stresses[1].xx + 20.0).abs() < 1e-8 && (stresses[1].yy + 10.0).abs() < 1e-8);
        assert!((stresses[1].trace() + 60.0).abs() < 1e-12);
    }

    #[test]
    fn a_failing_particle_is_named_and_keeps_its_stress() {
        let mut stresses = [Sym3::diagonal(-1.0, -1.0, -1.0); 2];
        let increments = [
            Increment { strain: Sym3::diagonal(1e-6, 0.0, 0.0), ..Default::default() },
            Increment { strain: Sym3::diagonal(f64::NAN, 0.0, 0.0), ..Default::default() },
        ];
        let outcome = group().update_block(0, &mut stresses, &increments, &[1.0; 2]);
        let failure = outcome.failure.unwrap();
        assert!(matches!(*failure, LawFailure { particle: 1, source: LawError::NotFinite { .. }, .. }), "{failure:?}");
        assert_eq!(stresses[1], Sym3::diagonal(-1.0, -1.0, -1.0));
        assert!((stresses[0].xx - (-1.0 + 1.2)).abs() < 1e-12);
    }

    /// A law that answers nothing but rest.
    struct Mute;

    impl ConstitutiveLaw for Mute {
        type State = f64;

        fn update(&self, stress: Sym3, state: f64, strain: Sym3) -> Result<(Sym3, f64), LawError> {
            match strain == Sym3::ZERO {
                true => Ok((stress, state)),
                false => Err(LawError::NotConverged { iterations: 1, residual: strain.norm() }),
            }
        }

        fn p_wave_modulus(&self, _: Sym3, _: &f64) -> f64 {
            1.0
        }
    }

    #[test]
    fn what_a_law_was_asked_can_be_asked_again() {
        let (old, strain) = (Sym3::diagonal(-10.0, -20.0, -30.0), Sym3::diagonal(1e-3, 0.0, 2e-3));
        let increment = Increment { strain, spin: Vector::<3>::new(0.1, -0.2, 0.3), duration: 0.5 };
        let mut group = Group::new("soil", Mute, 0..1, &[old]).with_history(7.0);
        let failure = group.update_block(0, &mut [old], &[increment], &[1.0]).failure.unwrap();
        // Turned already: there is no spin left to ask about.
        let turned = old.rotated(&rotation(&increment.spin));
        let left = Increment { spin: Vector::zeros(), ..increment };
        assert_eq!(failure.question, Question { stress: turned, increment: left });
        let Question { stress, increment } = failure.question;
        let again = group.update_block(0, &mut [stress], &[increment], &[1.0]).failure.unwrap();
        assert_eq!(again, failure);
        assert_eq!(group.states, [7.0]);
    }
}
