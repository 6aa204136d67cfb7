use super::{Condition, ElementError, Loading, Solution, Specimen};

/// Times that an increment is halved before it is given up.
const MAX_HALVINGS: usize = 12;
/// Trials in search of the place where a quantity reaches its target.
const MAX_TRIALS: usize = 60;
/// How near to its target a quantity is taken to have reached it, relative to the way of the increment.
const HIT: f64 = 1e-9;

/// A specimen's way along a loading.
///
/// Increments that the law or Newton's method cannot follow are halved, up to twelve times in a row, and grow again afterwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    loading: Loading,
    start: [f64; 6],
    parameter: f64,
    duration: f64,
}

/// The end of an increment, and how long it takes (s).
#[derive(Clone, Copy)]
struct Goal {
    parameter: f64,
    duration: f64,
}

/// A place on the way.
struct Found {
    parameter: f64,
    solution: Solution,
    /// Whether the watched quantity has its target here.
    is_hit: bool,
}

impl Course {
    /// The start of a loading from a specimen as it is.
    pub fn begin(loading: Loading, specimen: &Specimen) -> Self {
        Course {
            loading,
            start: loading.conditions.map(|condition| condition.of(specimen)),
            parameter: 0.0,
            duration: f64::INFINITY,
        }
    }

    /// The same where every call of [`Course::advance`] takes so long (s). Without it time plays no part.
    #[must_use]
    pub fn with_duration(self, duration: f64) -> Self {
        Course { duration, ..self }
    }

    /// The loading parameter λ reached.
    pub fn parameter(&self) -> f64 {
        self.parameter
    }

    /// Moves on by a change of the loading parameter.
    ///
    /// # Errors
    /// Those of [`Specimen::solve`] for the smallest increment; course and specimen are then where the last good one has led.
    pub fn advance(&mut self, specimen: &mut Specimen, change: f64) -> Result<(), ElementError> {
        self.advance_watching(specimen, change, None).map(|_| ())
    }

    /// Moves on by a change of the loading parameter, but not beyond the place where a quantity reaches `target`. Whether it has.
    ///
    /// # Errors
    /// Those of [`Course::advance`].
    pub fn advance_until(
        &mut self,
        specimen: &mut Specimen,
        change: f64,
        watched: &Condition,
        target: f64,
    ) -> Result<bool, ElementError> {
        self.advance_watching(specimen, change, Some((watched, target)))
    }

    fn advance_watching(
        &mut self,
        specimen: &mut Specimen,
        change: f64,
        watch: Option<(&Condition, f64)>,
    ) -> Result<bool, ElementError> {
        let (from, mut done, mut share, mut halvings) = (self.parameter, 0.0, 1.0, 0);
        while done < 1.0 {
            // Sums of powers of ½ are exact: the last increment ends at 1.
            let next = done + share;
            let goal = Goal { parameter: from + change * next, duration: self.duration * share };
            match self.find(specimen, goal, watch) {
                Ok(found) => {
                    specimen.accept(&found.solution)?;
                    self.parameter = found.parameter;
                    if found.is_hit {
                        return Ok(true);
                    }
                    done = next;
                    // Larger again, but only where it ends at a multiple of its own size.
                    if halvings > 0 && (done / (2.0 * share)).fract() == 0.0 {
                        (share, halvings) = (2.0 * share, halvings - 1);
                    }
                }
                Err(_) if halvings < MAX_HALVINGS => (share, halvings) = (0.5 * share, halvings + 1),
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }

    /// The state at the goal, or where on the way there the watched quantity reaches its target.
    fn find(&self, specimen: &Specimen, goal: Goal, watch: Option<(&Condition, f64)>) -> Result<Found, ElementError> {
        let solution = self.solve(specimen, goal)?;
        let hit = match watch {
            Some((watched, target)) => self.hit(specimen, goal, solution, watched, target)?,
            None => None,
        };
        Ok(hit.unwrap_or(Found { parameter: goal.parameter, solution, is_hit: false }))
    }

    fn solve(&self, specimen: &Specimen, goal: Goal) -> Result<Solution, ElementError> {
        let wanted = std::array::from_fn(|i| self.start[i] + goal.parameter * self.loading.rates[i]);
        specimen.solve_within(&self.loading.conditions, &wanted, goal.duration)
    }

    /// Where between here and a goal a quantity reaches its target; nothing if it does not. By the Illinois variant of regula falsi.
    fn hit(
        &self,
        specimen: &Specimen,
        goal: Goal,
        solution: Solution,
        watched: &Condition,
        target: f64,
    ) -> Result<Option<Found>, ElementError> {
        let value =
            |solution: &Solution| watched.value(solution.stress, specimen.strain() + solution.increment) - target;
        let (mut low, mut at_low) = (self.parameter, watched.of(specimen) - target);
        let (mut high, mut at_high) = (goal.parameter, value(&solution));
        let on_the_way = |parameter: f64| {
            let share = (parameter - self.parameter) / (goal.parameter - self.parameter);
            // None of an infinite time would not be a number.
            let duration = if goal.duration.is_finite() { goal.duration * share } else { f64::INFINITY };
            Goal { parameter, duration }
        };
        let hit = |parameter: f64, solution: Solution| Ok(Some(Found { parameter, solution, is_hit: true }));
        if at_low * at_high > 0.0 {
            return Ok(None);
        }
        let near = HIT * (at_high - at_low).abs();
        if at_high.abs() <= near {
            return hit(high, solution);
        }
        let mut last_side = 0;
        for _ in 0..MAX_TRIALS {
            let middle = (low * at_high - high * at_low) / (at_high - at_low);
            let solution = self.solve(specimen, on_the_way(middle))?;
            let at_middle = value(&solution);
            if at_middle.abs() <= near {
                return hit(middle, solution);
            }
            let side = if at_middle * at_high > 0.0 { 1 } else { -1 };
            if side > 0 {
                (high, at_high) = (middle, at_middle);
                at_low *= if last_side == side { 0.5 } else { 1.0 };
            } else {
                (low, at_low) = (middle, at_middle);
                at_high *= if last_side == side { 0.5 } else { 1.0 };
            }
            last_side = side;
        }
        hit(high, self.solve(specimen, on_the_way(high))?)
    }
}
