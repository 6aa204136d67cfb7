//! A parameter within its bounds, as the search sees it: any real number.

use super::schema::SoughtParameter;

/// Within which part of its range a parameter counts as being at a bound.
const AT_BOUND: f64 = 1e-3;

/// The bounds of a parameter, and how a real number stands for a value between them.
///
/// ```text
/// p = a + (b − a) · ½ (1 + sin z),   for ln p instead of p if equal ratios count as equal steps
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Range {
    pub(super) fn of(parameter: &SoughtParameter) -> Self {
        let even = |value: f64| if parameter.logarithmic { value.ln() } else { value };
        let [low, high] = parameter.bounds.map(even);
        Range { low, high, logarithmic: parameter.logarithmic }
    }

    /// Where in its range a value is, 0 to 1.
    fn share(&self, value: f64) -> f64 {
        let even = if self.logarithmic { value.ln() } else { value };
        ((even - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// The value that a real number stands for.
    pub(super) fn value(&self, number: f64) -> f64 {
        let even = self.low + (self.high - self.low) * 0.5 * (1.0 + number.sin());
        if self.logarithmic { even.exp() } else { even }
    }

    /// The real number that stands for a value.
    pub(super) fn number(&self, value: f64) -> f64 {
        (2.0 * self.share(value) - 1.0).asin()
    }

    /// The middle of the range.
    pub(super) fn middle(&self) -> f64 {
        self.value(0.0)
    }

    /// Whether a value is as good as at a bound.
    pub(super) fn is_at_bound(&self, value: f64) -> bool {
        let share = self.share(value);
        !(AT_BOUND..=1.0 - AT_BOUND).contains(&share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_for_values_between_the_bounds() {
        for logarithmic in [false, true] {
            let parameter = SoughtParameter { name: "a".to_owned(), bounds: [1.0, 100.0], start: None, logarithmic };
            let range = Range::of(&parameter);
            let middle = if logarithmic { 10.0 } else { 50.5 };
            assert!((range.middle() - middle).abs() < 1e-12 * middle);
            // The sine is flat near the bounds: half of the digits are lost there at most.
            for value in [1.0, 2.0, 30.0, 99.0, 100.0] {
                assert!((range.value(range.number(value)) - value).abs() < 1e-7 * value);
            }
            for number in [-40.0, -1.0, 0.3, 17.0] {
                assert!((1.0 - 1e-12..=100.0 + 1e-10).contains(&range.value(number)));
            }
            assert!(range.is_at_bound(100.0) && !range.is_at_bound(50.0));
        }
    }
}
