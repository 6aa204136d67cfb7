use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::aligned::Aligned;
use super::block::{BLOCK, IncrementBlock, StressBlock};
use super::{ConductivityLaw, ConstantConductivity, ConstitutiveLaw, Increment, LawError, differences};
use crate::parallel::vectorized;
use crate::particles::{AtPlaces, MovesWithin, StressesMut};
use crate::tensor::{Matrix3, Matrix6, Sym3, Vector, rotation, rotation_about_z};

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
    pub(super) fn of<L: ConstitutiveLaw>(
        particle: usize,
        stress: Sym3,
        increment: &Increment,
        source: LawError,
    ) -> Box<Self> {
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
    /// The histories, block by block. Threads update different blocks, so that no lock is ever waited for.
    states: Vec<Mutex<Vec<L::State>>>,
    particles: Range<usize>,
}

impl<L: ConstitutiveLaw> Group<L> {
    /// A group of the particles `particles` with these initial effective stresses (Pa).
    pub fn new(
        name: impl Into<String>,
        law: L,
        particles: Range<usize>,
        stresses: impl IntoIterator<Item = Sym3>,
    ) -> Self {
        let states: Vec<L::State> = stresses.into_iter().map(|stress| law.initial_state(stress)).collect();
        let states = states.chunks(BLOCK).map(|block| Mutex::new(block.to_vec())).collect();
        let conductivity_law = Box::new(ConstantConductivity);
        Group { name: name.into(), law, conductivity_law, states, particles }
    }

    /// The same group, all particles with this history in place of that of their stress.
    #[must_use]
    pub fn with_history(mut self, history: L::State) -> Self {
        for block in &mut self.states {
            block.get_mut().unwrap_or_else(PoisonError::into_inner).fill(history);
        }
        self
    }

    /// The same group with another law of the conductivity; it starts with a constant one.
    #[must_use]
    pub fn with_conductivity_law(mut self, conductivity_law: Box<dyn ConductivityLaw>) -> Self {
        self.conductivity_law = conductivity_law;
        self
    }

    /// The histories of a block. A panic elsewhere leaves them as whole as any other history.
    fn block(&self, number: usize) -> MutexGuard<'_, Vec<L::State>> {
        self.states[number].lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn state(&self, particle: usize) -> L::State {
        self.block(particle / BLOCK)[particle % BLOCK]
    }

    /// The stress and history at the end of a step, of a material point that turns and is strained.
    ///
    /// Jaumann: the old stress turns with the material by the rotation of the step. Laws of finite strain follow it themselves.
    #[inline(always)]
    fn update(
        &self,
        stress: &mut Sym3,
        state: &mut L::State,
        increment: &Increment,
    ) -> Result<(Sym3, L::State), LawError> {
        if L::FINITE_STRAIN {
            return self.law.deform(*stress, *state, increment);
        }
        let spin = increment.spin;
        if spin.x == 0.0 && spin.y == 0.0 {
            let (cosine, sine) = rotation_about_z(spin.z);
            *stress = stress.rotated_about_z(cosine, sine);
            let turn = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
            *state = self.law.rotate_state(*state, &turn);
        } else {
            let turn = rotation(&spin);
            *stress = stress.rotated(&turn);
            *state = self.law.rotate_state(*state, &turn);
        }
        self.law.update_within(*stress, *state, increment.strain, increment.duration)
    }

    /// The plain loop over particles of one block of histories, which [`Aligned`] does for several particles at a time.
    fn update_states(
        &self,
        states: &mut [L::State],
        stresses: &mut [Sym3],
        increment: impl Fn(usize) -> Increment,
        volumes: &[f64],
    ) -> BlockOutcome {
        let mut outcome = BlockOutcome::default();
        for (p, (stress, state)) in stresses.iter_mut().zip(states).enumerate() {
            let increment = increment(p);
            match self.update(stress, state, &increment) {
                Ok((new_stress, new_state)) if new_stress.is_finite() => {
                    let mean = (*stress + new_stress) * 0.5;
                    outcome.work += volumes[p] * mean.double_dot(increment.strain);
                    *stress = new_stress;
                    *state = new_state;
                }
                Ok(_) if outcome.failure.is_none() => {
                    let error = LawError::NotFinite { strain: increment.strain };
                    outcome.failure = Some(LawFailure::of::<L>(p, *stress, &increment, error));
                }
                Err(error) if outcome.failure.is_none() => {
                    outcome.failure = Some(LawFailure::of::<L>(p, *stress, &increment, error));
                }
                _ => {}
            }
        }
        outcome
    }
}

impl BlockOutcome {
    /// The same with the failed particle counted from `first` particles before the block.
    #[must_use]
    pub(crate) fn from(self, first: usize) -> Self {
        let mut outcome = self;
        if let Some(failure) = &mut outcome.failure {
            failure.particle += first;
        }
        outcome
    }

    /// With what happened elsewhere: of two failures, that of the lower particle stays.
    #[must_use]
    pub(crate) fn and(self, other: BlockOutcome) -> Self {
        let failures = self.failure.into_iter().chain(other.failure);
        BlockOutcome { work: self.work + other.work, failure: failures.min_by_key(|failure| failure.particle) }
    }
}

/// The histories of a group by the places of the particles, counted from its first.
struct Histories<'a, S>(&'a mut [Mutex<Vec<S>>]);

impl<S: Copy> AtPlaces for Histories<'_, S> {
    type Value = S;

    #[inline(always)]
    fn at(&mut self, place: usize) -> &mut S {
        &mut self.0[place / BLOCK].get_mut().unwrap_or_else(PoisonError::into_inner)[place % BLOCK]
    }
}

/// A [`Group`] whose law is chosen at run time. A call handles many particles.
///
/// Its particles are counted by their places from the group's first; they stay within the group when they change places.
pub trait MaterialGroup: Send + Sync {
    /// The name of the material.
    fn name(&self) -> &str;

    /// The particles of the group: their places, and their numbers as well.
    fn particles(&self) -> Range<usize>;

    /// How the conductivity of the particles follows their porosity.
    fn conductivity_law(&self) -> &dyn ConductivityLaw;

    /// Turns and updates the stresses (Pa) and histories of a block of particles.
    ///
    /// `first` is the number of the block's first particle within the group; `volumes` (m³) weight the work. Any number of threads may
    /// update different blocks at the same time.
    fn update_block(
        &self,
        first: usize,
        stresses: &mut [Sym3],
        increments: &[Increment],
        volumes: &[f64],
    ) -> BlockOutcome;

    /// The same for at most one block of particles, whose first number is a multiple of the length of a block: several at a time, with
    /// the same stresses and histories, bit by bit. What stands in `room` does not matter.
    fn update_aligned(
        &self,
        first: usize,
        stresses: StressesMut,
        increments: &IncrementBlock,
        volumes: &[f64],
        room: &mut StressBlock,
    ) -> BlockOutcome;

    /// The stress (Pa) that a strain increment without spin would lead to within a duration (s), and the tangent there
    /// ([`ConstitutiveLaw::tangent`], or central differences in a finite time), for the particle at the group's place `particle`.
    /// Nothing is changed: implicit schemes try increments before they accept one.
    ///
    /// # Errors
    /// The law's.
    fn trial(&self, particle: usize, stress: Sym3, strain: Sym3, duration: f64) -> Result<(Sym3, Matrix6), LawError>;

    /// The history of the particle at the group's place `particle`, to be written.
    fn history(&self, particle: usize) -> Box<dyn erased_serde::Serialize>;

    /// Brings the histories to the new places of their particles, which are counted from the group's first.
    fn carry(&mut self, moves: MovesWithin);

    /// The largest compression and shear wave moduli in the group (Pa), for the stresses of its particles.
    fn wave_moduli(&self, stresses: &mut dyn Iterator<Item = Sym3>) -> (f64, f64);

    /// The memory of the histories (bytes).
    fn history_bytes(&self) -> usize;

    /// The names of the law's own output quantities.
    fn outputs(&self) -> &'static [&'static str];

    /// The values of [`MaterialGroup::outputs`] for the particle at the group's place `particle`.
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
        &self,
        first: usize,
        stresses: &mut [Sym3],
        increments: &[Increment],
        volumes: &[f64],
    ) -> BlockOutcome {
        let mut outcome = BlockOutcome::default();
        let mut done = 0;
        while done < stresses.len() {
            let mut states = self.block((first + done) / BLOCK);
            let states = &mut states[(first + done) % BLOCK..];
            let end = stresses.len().min(done + states.len());
            let increment = |p| increments[done + p];
            let of_block = self.update_states(states, &mut stresses[done..end], increment, &volumes[done..end]);
            outcome = outcome.and(of_block.from(done));
            done = end;
        }
        outcome
    }

    fn update_aligned(
        &self,
        first: usize,
        mut stresses: StressesMut,
        increments: &IncrementBlock,
        volumes: &[f64],
        room: &mut StressBlock,
    ) -> BlockOutcome {
        let mut states = self.block(first / BLOCK);
        let len = stresses.len();
        if L::FINITE_STRAIN {
            let mut whole = [Sym3::ZERO; BLOCK];
            let whole = &mut whole[..len];
            whole.iter_mut().enumerate().for_each(|(p, stress)| *stress = stresses.at(p));
            let outcome = self.update_states(&mut states, whole, |p| increments.at(p), volumes);
            whole.iter().enumerate().for_each(|(p, &stress)| stresses.set(p, stress));
            return outcome;
        }
        let (law, states, volumes) = (&self.law, &mut states[..len], &volumes[..len]);
        vectorized(
            #[inline(always)]
            || Aligned { law, states, stresses, increments, volumes, room }.update(),
        )
    }

    fn trial(&self, particle: usize, stress: Sym3, strain: Sym3, duration: f64) -> Result<(Sym3, Matrix6), LawError> {
        let state = self.state(particle);
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

    fn history(&self, particle: usize) -> Box<dyn erased_serde::Serialize> {
        Box::new(self.state(particle))
    }

    fn carry(&mut self, moves: MovesWithin) {
        if size_of::<L::State>() > 0 {
            moves.carry(&mut Histories(&mut self.states));
        }
    }

    fn wave_moduli(&self, stresses: &mut dyn Iterator<Item = Sym3>) -> (f64, f64) {
        let mut moduli = (0.0_f64, 0.0_f64);
        for number in 0..self.states.len() {
            for (state, stress) in self.block(number).iter().zip(&mut *stresses) {
                moduli.0 = moduli.0.max(self.law.p_wave_modulus(stress, state));
                moduli.1 = moduli.1.max(self.law.s_wave_modulus(stress, state));
            }
        }
        moduli
    }

    fn history_bytes(&self) -> usize {
        let of_block = size_of::<Mutex<Vec<L::State>>>() + BLOCK * size_of::<L::State>();
        self.states.len() * of_block
    }

    fn outputs(&self) -> &'static [&'static str] {
        self.law.outputs()
    }

    fn write_outputs(&self, particle: usize, stress: Sym3, values: &mut [f64]) {
        self.law.write_outputs(stress, &self.state(particle), values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::LinearElastic;
    use crate::particles::Stresses;
    use crate::tensor::Vector;

    fn group() -> Group<LinearElastic> {
        Group::new("soil", LinearElastic { young: 1e6, poisson: 0.25 }, 0..2, [Sym3::ZERO; 2])
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

    /// Elastic, with the strain so far as its history; compression beyond a limit has no answer.
    struct Brittle;

    impl ConstitutiveLaw for Brittle {
        type State = Sym3;

        fn update(&self, stress: Sym3, state: Sym3, strain: Sym3) -> Result<(Sym3, Sym3), LawError> {
            match strain.trace() < -2e-3 {
                true => Err(LawError::NoCompression { pressure: strain.trace() }),
                false => Ok((stress + strain * 1e6 + state, state + strain)),
            }
        }

        fn rotate_state(&self, state: Sym3, rotation: &Matrix3) -> Sym3 {
            state.rotated(rotation)
        }

        fn p_wave_modulus(&self, _: Sym3, _: &Sym3) -> f64 {
            1e6
        }
    }

    /// Elastic, but answers to shear in the plane with shear out of it.
    struct Tilted;

    impl ConstitutiveLaw for Tilted {
        type State = ();

        fn update(&self, stress: Sym3, state: (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
            let yz = stress.yz + 1e6 * (strain.yz + strain.xy);
            Ok((Sym3 { yz, ..stress + strain * 1e6 }, state))
        }

        fn p_wave_modulus(&self, _: Sym3, _: &()) -> f64 {
            1e6
        }
    }

    /// Pseudo-random numbers from −½ to ½.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    /// Where stresses and motions of a block are.
    #[derive(Clone, Copy, PartialEq)]
    enum Setting {
        Space,
        /// Motions are in the plane, stresses are not.
        TiltedStress,
        Plane,
    }

    /// Several particles at a time: the same stresses, histories and failures as one after the other, bit by bit.
    fn blocks_are_updated_as_their_particles<L: ConstitutiveLaw<State: PartialEq + std::fmt::Debug>>(law: fn() -> L) {
        // What another block has left does not matter.
        let mut room = StressBlock::new();
        for (len, setting) in [
            (64, Setting::Plane),
            (64, Setting::TiltedStress),
            (64, Setting::Space),
            (13, Setting::Plane),
            (8, Setting::Plane),
            (1, Setting::TiltedStress),
            (1, Setting::Space),
        ] {
            let mut number = numbers();
            let mut stress = || {
                let stress = Sym3::from_kelvin(&nalgebra::Vector6::from_fn(|_, _| number() * 1e3));
                if setting == Setting::Plane { Sym3 { yz: 0.0, zx: 0.0, ..stress } } else { stress }
            };
            let stresses: Vec<Sym3> = (0..len).map(|_| stress()).collect();
            let (strains, spins) = if setting == Setting::Space { (0..6, 0..3) } else { (0..4, 2..3) };
            let mut block = IncrementBlock::within(0.1, if setting == Setting::Space { 3 } else { 2 });
            let mut number = numbers();
            for p in 0..len {
                block.strain[strains.clone()].iter_mut().for_each(|component| component[p] = number() * 2e-3);
                block.spin[spins.clone()].iter_mut().for_each(|component| component[p] = number() * 0.1);
            }
            if len > 7 {
                block.strain[0][7] = f64::NAN;
            }
            let increments: Vec<Increment> = (0..len).map(|p| block.at(p)).collect();
            let volumes: Vec<f64> = (0..len).map(|p| 1.0 + p as f64).collect();
            let (plain, lanes) = (
                Group::new("soil", law(), 0..len, stresses.clone()),
                Group::new("soil", law(), 0..len, stresses.clone()),
            );
            let mut lanes_stresses: Stresses = stresses.iter().copied().collect();
            let mut plain_stresses = stresses;
            let expected = plain.update_block(0, &mut plain_stresses, &increments, &volumes);
            let outcome = lanes.update_aligned(0, lanes_stresses.all_mut(), &block, &volumes, &mut room);
            let bits = |stresses: &[Sym3]| -> Vec<[u64; 6]> {
                stresses.iter().map(|s| [s.xx, s.yy, s.zz, s.xy, s.yz, s.zx].map(f64::to_bits)).collect()
            };
            assert_eq!(bits(&lanes_stresses.iter().collect::<Vec<_>>()), bits(&plain_stresses));
            for p in (0..len).filter(|&p| p != 7) {
                assert_eq!(lanes.state(p), plain.state(p));
            }
            let asked =
                |failure: Option<Box<LawFailure>>| failure.map(|failure| (failure.particle, failure.question.stress));
            assert_eq!(asked(outcome.failure), asked(expected.failure));
            assert!((outcome.work - expected.work).abs() <= 1e-12 * expected.work.abs());
        }
    }

    #[test]
    fn blocks_are_updated_as_their_particles_with_and_without_history() {
        blocks_are_updated_as_their_particles(|| LinearElastic { young: 1e6, poisson: 0.25 });
        blocks_are_updated_as_their_particles(|| Brittle);
        blocks_are_updated_as_their_particles(|| Tilted);
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
        let group = Group::new("soil", Mute, 0..1, [old]).with_history(7.0);
        let failure = group.update_block(0, &mut [old], &[increment], &[1.0]).failure.unwrap();
        // Turned already: there is no spin left to ask about.
        let turned = old.rotated(&rotation(&increment.spin));
        let left = Increment { spin: Vector::zeros(), ..increment };
        assert_eq!(failure.question, Question { stress: turned, increment: left });
        let Question { stress, increment } = failure.question;
        let again = group.update_block(0, &mut [stress], &[increment], &[1.0]).failure.unwrap();
        assert_eq!(again, failure);
        assert_eq!(group.state(0), 7.0);
    }
}
