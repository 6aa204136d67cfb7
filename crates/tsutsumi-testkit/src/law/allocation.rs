//! No memory is asked for in a step.

use tsutsumi::law::{ConstitutiveLaw, Increment};
use tsutsumi::tensor::{Sym3, Vector};

use super::{LawPath, LawViolation, Point};

impl LawPath {
    /// A step with strain and spin, as a material point makes it. One that fails may build its message.
    #[cfg(feature = "count-allocations")]
    pub(super) fn a_step_does_not_allocate<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
        strain: Sym3,
    ) -> Result<(), LawViolation> {
        let spin = Vector::<3>::z() * self.strain;
        let motion = Increment { strain, spin, duration: point.duration };
        let mut answer = None;
        let counted = allocation_counter::measure(|| answer = Some(law.deform(point.stress, point.state, &motion)));
        match (answer, counted.count_total) {
            (Some(Ok(_)), count) if count > 0 => Err(LawViolation::Allocates { increment, count }),
            _ => Ok(()),
        }
    }

    /// Without the counter nothing is counted.
    #[cfg(not(feature = "count-allocations"))]
    pub(super) fn a_step_does_not_allocate<L: ConstitutiveLaw>(
        &self,
        _: &L,
        _: usize,
        _: &Point<L::State>,
        _: Sym3,
    ) -> Result<(), LawViolation> {
        Ok(())
    }
}
