//! Nothing strained, nothing changed: whether the material rests or turns.

use tsutsumi::law::{ConstitutiveLaw, Increment};
use tsutsumi::tensor::{Matrix3, Sym3, Vector, rotation};

use super::{LawPath, LawViolation, Point};

/// The steps of a rigid rotation through 360°.
const STEPS_OF_A_TURN: usize = 1000;

impl LawPath {
    pub(super) fn nothing_strained_nothing_changed<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
    ) -> Result<(), LawViolation> {
        let change = (point.update(law, increment, Sym3::ZERO)?.stress - point.stress).norm();
        match change <= 1e-12 * self.scale(law, point) {
            true => Ok(()),
            false => Err(LawViolation::Creeps { increment, change }),
        }
    }

    /// Once round, by the steps that a body makes: spins for laws of small increments, deformation gradients for those of finite strain.
    pub(super) fn a_rigid_rotation_turns_the_stress<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
    ) -> Result<(), LawViolation> {
        let axis = match self.plane {
            true => Vector::<3>::z(),
            false => Vector::<3>::new(0.6, -0.48, 0.64),
        };
        let spin = axis * (std::f64::consts::TAU / STEPS_OF_A_TURN as f64);
        let turn = rotation(&spin);
        let motion = match L::FINITE_STRAIN {
            false => Increment { spin, ..Increment::default() },
            true => Increment::of(&(turn - Matrix3::identity())),
        };
        let (mut stress, mut state, mut turned) = (point.stress, point.state, point.stress);
        for step in 1..=STEPS_OF_A_TURN {
            (stress, state) =
                law.deform(stress, state, &motion).map_err(|source| LawViolation::Failed { increment, source })?;
            turned = turned.rotated(&turn);
            let off = (stress - turned).norm();
            // The rounding of so many products of matrices, and of F − I in laws of finite strain.
            if off.is_nan() || off > 1e-9 * self.scale(law, point) {
                return Err(LawViolation::Turned { increment, degrees: 360 * step / STEPS_OF_A_TURN, off });
            }
        }
        // The product of the steps is the identity to 8e-14 rad a step, see `rotation`.
        let off = (stress - point.stress).norm();
        match off <= 1e-9 * self.scale(law, point) {
            true => Ok(()),
            false => Err(LawViolation::Turned { increment, degrees: 360, off }),
        }
    }
}
