use crate::law::{BLOCK, IncrementBlock};
use crate::parallel::vectorized;
use crate::particles::{Stresses, StressesMut};
use crate::tensor::rotation;

/// The stress that the nodes feel with stiffness-proportional damping: the effective stress and the resistance to its change.
///
/// # Equation
///
/// ```text
/// σ'_f = σ' + β Δσ'/Δt        Δσ' = σ' − R σ'|t Rᵀ, the last increment of the law, R the rotation of the step
/// ```
///
/// A rigid rotation is not resisted. Without damping there is no such stress and the particles' own is used.
#[derive(Debug, Clone, Default)]
pub(super) struct Viscosity {
    /// σ'_f of every particle (Pa); empty without damping. While forces are summed it holds the particles' σ'.
    felt: Stresses,
}

impl Viscosity {
    /// Room for particles with these stresses (Pa), at rest so far, if β = `stiffness` (s) is not zero.
    pub(super) fn new(stiffness: f64, stresses: &Stresses) -> Self {
        Viscosity { felt: if stiffness > 0.0 { stresses.clone() } else { Stresses::default() } }
    }

    /// The memory of its stresses (bytes).
    pub(super) fn bytes(&self) -> usize {
        self.felt.bytes()
    }

    /// Puts the stress that the nodes feel in the particles' place; a second call puts back the particles' own, bit by bit.
    pub(super) fn swap(&mut self, stresses: &mut Stresses) {
        if !self.felt.is_empty() {
            std::mem::swap(&mut self.felt, stresses);
        }
    }

    /// The stresses that the nodes feel, by the places of the particles; empty without damping.
    pub(super) fn felt(&mut self) -> &mut Stresses {
        &mut self.felt
    }
}

/// Before the law of a block: keeps the old stresses (Pa), turned as the law will turn them, in `felt`, which is empty without damping.
pub(super) fn remember(felt: &mut StressesMut, stresses: &StressesMut, increments: &IncrementBlock) {
    vectorized(
        #[inline(always)]
        || {
            for p in 0..felt.len().min(BLOCK) {
                felt.set(p, stresses.at(p).rotated(&rotation(&increments.at(p).spin)));
            }
        },
    );
}

/// After the law of a block: adds the resistance to the new stresses (Pa). `duration` is β/Δt (–).
pub(super) fn resist(felt: &mut StressesMut, stresses: &StressesMut, duration: f64) {
    vectorized(
        #[inline(always)]
        || {
            for p in 0..felt.len() {
                let stress = stresses.at(p);
                felt.set(p, stress + (stress - felt.at(p)) * duration);
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::{Sym3, Vector};

    #[test]
    fn growth_is_resisted_and_rotation_is_not() {
        let old = Sym3::diagonal(-10.0, -20.0, -30.0);
        let spin = Vector::<3>::new(0.0, 0.0, 0.01);
        let turned = old.rotated(&rotation(&spin));
        let mut before: Stresses = [old; 2].into_iter().collect();
        let mut stresses: Stresses = [turned, old * 1.5].into_iter().collect();
        let mut viscosity = Viscosity::new(0.1, &before);
        let mut increments = IncrementBlock::within(1.0, 3);
        increments.spin[2][0] = spin.z;
        remember(&mut viscosity.felt().all_mut(), &before.all_mut(), &increments);
        resist(&mut viscosity.felt().all_mut(), &stresses.all_mut(), 4.0);
        let own = stresses.clone();
        viscosity.swap(&mut stresses);
        // The first only turned; the second grew by half of the old, four times that is added.
        assert_eq!(stresses, [turned, old * 3.5].into_iter().collect());
        viscosity.swap(&mut stresses);
        assert_eq!(stresses, own);
    }
}
