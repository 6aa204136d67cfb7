//! Snapshots of numbers: a figure's curves, kept as text and compared with a tolerance.

use insta::Comparator;
use insta::internals::SnapshotContents;

/// Compares snapshots word by word: numbers within a relative tolerance, everything else to the letter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers {
    /// The largest difference over the larger of the two numbers (–).
    pub relative: f64,
}

impl Numbers {
    /// True when two texts are the same but for the last digits of their numbers.
    pub fn agree(&self, reference: &str, test: &str) -> bool {
        let (mut reference, mut test) = (reference.split_whitespace(), test.split_whitespace());
        loop {
            match (reference.next(), test.next()) {
                (None, None) => return true,
                (Some(one), Some(other)) if self.words_agree(one, other) => {}
                _ => return false,
            }
        }
    }

    fn words_agree(&self, one: &str, other: &str) -> bool {
        match (one.parse::<f64>(), other.parse::<f64>()) {
            (Ok(a), Ok(b)) => a == b || (a - b).abs() <= self.relative * a.abs().max(b.abs()),
            _ => one == other,
        }
    }

    /// The settings under which `insta` compares so: `Numbers { relative: 1e-6 }.settings().bind(|| …)`.
    pub fn settings(self) -> insta::Settings {
        let mut settings = insta::Settings::clone_current();
        settings.set_comparator(Box::new(self));
        settings
    }
}

impl Comparator for Numbers {
    fn matches(&self, reference: &insta::Snapshot, test: &insta::Snapshot) -> bool {
        match (reference.contents(), test.contents()) {
            (SnapshotContents::Text(one), SnapshotContents::Text(other)) => {
                self.agree(&one.to_string(), &other.to_string())
            }
            _ => false,
        }
    }

    fn dyn_clone(&self) -> Box<dyn Comparator> {
        Box::new(*self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_may_differ_in_their_last_digits_and_words_may_not() {
        let numbers = Numbers { relative: 1e-3 };
        assert!(numbers.agree("t 100.00 mm", "t  100.05\nmm"));
        assert!(!numbers.agree("t 100.0 mm", "t 100.2 mm"));
        assert!(!numbers.agree("t 100.0 mm", "t 100.0 cm"));
        assert!(!numbers.agree("1 2", "1 2 3"));
        assert!(!numbers.agree("1", "NaN") && !numbers.agree("0.0", "1e-9"));
    }
}
