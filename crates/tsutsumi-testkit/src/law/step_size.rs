//! Smaller steps, one answer.

use tsutsumi::law::ConstitutiveLaw;

use super::{LawPath, LawViolation, Point};

/// The path is followed in so many ways: increments as they are, in 2, 4, … 32 equal parts.
const LEVELS: usize = 6;
/// What may be left of the largest difference. A law of first order leaves a sixteenth; where it begins to yield, or turns, an increment
/// is cut at a place that differs from level to level, and errors fall in fits and starts.
const LEFT: f64 = 0.25;

/// The largest difference between one level and the next on the path.
#[derive(Clone, Copy, Default)]
struct Difference {
    /// In Pa.
    off: f64,
    /// Relative to the stress there (–).
    relative: f64,
    increment: usize,
}

impl LawPath {
    /// Whole paths are compared, not single increments, so that the history counts.
    pub(super) fn smaller_steps_agree<L: ConstitutiveLaw>(&self, law: &L) -> Result<(), LawViolation> {
        let start = self.start(law);
        let parts: [u32; LEVELS] = std::array::from_fn(|level| 1 << level);
        let mut points = parts.map(|parts| Point { duration: self.duration / f64::from(parts), ..start });
        let mut largest = [Difference::default(); LEVELS - 1];
        for (increment, &strain) in self.strain_increments().iter().enumerate() {
            for (point, parts) in points.iter_mut().zip(parts) {
                let part = strain * f64::from(parts).recip();
                for _ in 0..parts {
                    *point = point.update(law, increment, part)?;
                }
            }
            for (pair, largest) in points.windows(2).zip(&mut largest) {
                let off = (pair[0].stress - pair[1].stress).norm();
                let relative = off / self.scale(law, &pair[1]);
                if relative > largest.relative {
                    *largest = Difference { off, relative, increment };
                }
            }
        }
        let worst = largest.iter().map(|difference| difference.relative).fold(0.0, f64::max);
        let Difference { off, relative, increment } = largest[LEVELS - 2];
        match relative <= self.accuracy.max(LEFT * worst) {
            true => Ok(()),
            false => Err(LawViolation::StepSize { increment, parts: parts[LEVELS - 1], off, relative }),
        }
    }
}
