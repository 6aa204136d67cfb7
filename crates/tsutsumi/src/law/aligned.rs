//! A law over the particles of a block, in loops that the compiler can turn into vectors: what [`Group`](super::Group) does one by one, bit by
//! bit.
//!
//! In plane strain four of six components are loaded, turned and checked: a law that answers with stress out of the plane is still heard.

use super::block::{BLOCK, IncrementBlock, LANES, StressBlock, set_tensor, tensor};
use super::group::{BlockOutcome, LawFailure};
use super::{ConstitutiveLaw, LawError};
use crate::particles::StressesMut;
use crate::tensor::{Matrix3, Sym3, rotation, rotation_about_z};

/// The particles of a block, with what they are asked.
pub(super) struct Aligned<'a, L: ConstitutiveLaw> {
    pub(super) law: &'a L,
    pub(super) states: &'a mut [L::State],
    pub(super) stresses: StressesMut<'a>,
    pub(super) increments: &'a IncrementBlock,
    pub(super) volumes: &'a [f64],
    pub(super) room: &'a mut StressBlock,
}

/// The particles whose law failed.
#[derive(Default)]
struct Failures {
    /// One bit for each particle.
    particles: u64,
    first: Option<Box<LawFailure>>,
}

impl Failures {
    fn add(&mut self, failure: Box<LawFailure>) {
        self.particles |= 1 << failure.particle;
        if self.first.as_ref().is_none_or(|first| failure.particle < first.particle) {
            self.first = Some(failure);
        }
    }
}

impl<L: ConstitutiveLaw> Aligned<'_, L> {
    /// Turns and updates stresses and histories of small increments.
    #[inline(always)]
    pub(super) fn update(mut self) -> BlockOutcome {
        match self.increments.in_plane && self.stresses.are_in_plane() {
            true => self.update_components::<4>(),
            false => self.update_components::<6>(),
        }
    }

    /// The same where only the first `C` components of stresses and strains are other than zero.
    #[inline(always)]
    fn update_components<const C: usize>(&mut self) -> BlockOutcome {
        self.turn::<C>();
        let failures = self.ask::<C>();
        if C == 4 && !self.answers_are_in_plane() {
            self.room.old[4..].as_flattened_mut().fill(0.0);
            return self.accept::<6>(failures);
        }
        self.accept::<C>(failures)
    }

    /// Jaumann: the old stresses and histories turn with the material by the rotations of the step.
    #[inline(always)]
    fn turn<const C: usize>(&mut self) {
        let Aligned { law, states, stresses, increments, room: StressBlock { old, .. }, .. } = self;
        let (in_plane, out_of_plane) = stresses.both();
        let of_particles = states.iter_mut().zip(in_plane);
        if C == 4 {
            for (p, (state, &[xx, yy, zz, xy])) in (0..BLOCK).zip(of_particles) {
                let stress = Sym3 { xx, yy, zz, xy, yz: 0.0, zx: 0.0 };
                let (cosine, sine) = rotation_about_z(increments.spin[2][p]);
                set_tensor::<C>(old, p, stress.rotated_about_z(cosine, sine));
                let turn = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
                *state = law.rotate_state(*state, &turn);
            }
        } else {
            for (p, ((state, &[xx, yy, zz, xy]), &[yz, zx])) in (0..BLOCK).zip(of_particles.zip(out_of_plane)) {
                let stress = Sym3 { xx, yy, zz, xy, yz, zx };
                let turn = rotation(&increments.at(p).spin);
                set_tensor::<C>(old, p, stress.rotated(&turn));
                *state = law.rotate_state(*state, &turn);
            }
        }
    }

    /// The law for stresses and histories that have been turned; those of particles that fail stay.
    #[inline(always)]
    fn ask<const C: usize>(&mut self) -> Failures {
        let mut failures = Failures::default();
        let Aligned { law, states, increments, room: StressBlock { old, new, .. }, .. } = self;
        for (p, state) in (0..BLOCK).zip(states.iter_mut()) {
            let strain = tensor::<C>(&increments.strain, p);
            match law.update_within(tensor::<C>(old, p), *state, strain, increments.duration) {
                Ok((stress, new_state)) => {
                    set_tensor::<6>(new, p, stress);
                    // Histories that hold nothing need no care, and no branch.
                    if size_of::<L::State>() == 0 || stress.is_finite() {
                        *state = new_state;
                    }
                }
                Err(error) => {
                    set_tensor::<6>(new, p, tensor::<C>(old, p));
                    failures.add(LawFailure::of::<L>(p, tensor::<C>(old, p), &increments.at(p), error));
                }
            }
        }
        failures
    }

    /// True when no law has answered with a stress out of the plane.
    #[inline(always)]
    fn answers_are_in_plane(&self) -> bool {
        let [.., yz, zx] = &self.room.new;
        let len = self.stresses.len();
        yz[..len].iter().zip(&zx[..len]).fold(0, |bits, (yz, zx)| bits | yz.to_bits() | zx.to_bits()) == 0
    }

    /// Takes the answers as the new stresses, and sums their work.
    #[inline(always)]
    fn accept<const C: usize>(&mut self, mut failures: Failures) -> BlockOutcome {
        let all_finite = self.measure_work::<C>();
        if !all_finite || failures.particles != 0 {
            self.refuse::<C>(&mut failures);
        }
        let len = self.stresses.len();
        let StressBlock { new, work, .. } = &mut *self.room;
        let [xx, yy, zz, xy, yz, zx] = new;
        for (p, stress) in (0..BLOCK).zip(self.stresses.in_plane()) {
            *stress = [xx[p], yy[p], zz[p], xy[p]];
        }
        if C > 4 {
            for (p, stress) in (0..BLOCK).zip(self.stresses.out_of_plane()) {
                *stress = [yz[p], zx[p]];
            }
        }
        work[len..].fill(0.0);
        let mut sums = [0.0; LANES];
        for group in work.as_chunks::<LANES>().0 {
            for l in 0..LANES {
                sums[l] += group[l];
            }
        }
        BlockOutcome { work: sums.iter().sum(), failure: failures.first }
    }

    /// Work of the mean stress of the step, V ½ (σ' + σ'|t) : Δε (J). Returns whether all answers are finite.
    #[inline(always)]
    fn measure_work<const C: usize>(&mut self) -> bool {
        let Aligned { increments, volumes, room: StressBlock { old, new, work }, .. } = self;
        let mut all_finite = true;
        for (p, (work, volume)) in work.iter_mut().zip(*volumes).enumerate() {
            let answer = tensor::<C>(new, p);
            let mean = (tensor::<C>(old, p) + answer) * 0.5;
            *work = volume * mean.double_dot(tensor::<C>(&increments.strain, p));
            all_finite &= answer.is_finite();
        }
        all_finite
    }

    /// Particles without a finite answer keep their stress and do no work.
    #[cold]
    fn refuse<const C: usize>(&mut self, failures: &mut Failures) {
        let Aligned { increments, room: StressBlock { old, new, work }, .. } = self;
        for (p, work) in work.iter_mut().enumerate().take(self.stresses.len()) {
            if !tensor::<C>(new, p).is_finite() {
                let error = LawError::NotFinite { strain: tensor::<C>(&increments.strain, p) };
                failures.add(LawFailure::of::<L>(p, tensor::<C>(old, p), &increments.at(p), error));
                set_tensor::<C>(new, p, tensor::<C>(old, p));
            }
            if failures.particles >> p & 1 != 0 {
                *work = 0.0;
            }
        }
    }
}
