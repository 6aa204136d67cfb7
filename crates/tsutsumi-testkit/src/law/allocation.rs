//! No memory is asked for in a step.

use tsutsumi::law::{ConstitutiveLaw, Increment};
use tsutsumi::tensor::{Sym3, Vector};

use super::{LawPath, LawViolation, Point};

impl LawPath {
    /// A step with strain and spin, as a material point makes it. One that fails may build its message.
    pub(super) fn a_step_does_not_allocate<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
        strain: Sym3,
    ) -> Result<(), LawViolation> {
        let spin = Vector::<3>::z() * self.strain;
        let motion = Increment { strain, spin, duration: point.duration };
        let mut has_answer = false;
        let count = allocations(|| has_answer = law.deform(point.stress, point.state, &motion).is_ok());
        match has_answer && count > 0 {
            true => Err(LawViolation::Allocates { increment, count }),
            false => Ok(()),
        }
    }
}

#[cfg(feature = "count-allocations")]
fn allocations(step: impl FnOnce()) -> u64 {
    allocation_counter::measure(step).count_total
}

/// Without the counter nothing is counted.
#[cfg(not(feature = "count-allocations"))]
fn allocations(step: impl FnOnce()) -> u64 {
    step();
    0
}
