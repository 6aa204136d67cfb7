//! A guard that noise cannot fool: instructions of the kernels, counted by valgrind's callgrind and held against those in `benches/instructions.json`.
//!
//! valgrind emulates one processor, so that counts do not depend on the machine or its load. They depend on the compiler: with another one than that of the
//! baseline, changes are reported but are no failure. callgrind is called directly. gungraun, which does so too, needs a second program of exactly its own
//! version (four minutes of compiling), keeps its baselines under `target` and knows nothing of compilers.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// How far a count may rise above its baseline (per cent).
pub const LIMIT: u64 = 3;

/// The instructions of every kernel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// The compiler and its target.
    pub compiler: String,
    /// Instructions by kernel.
    pub instructions: BTreeMap<String, u64>,
}

/// What became of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// Within the limit.
    None,
    /// Slower by more than the limit.
    Slower,
    /// Faster by more than the limit: the baseline should follow.
    Faster,
    /// Not in the baseline.
    New,
}

/// A kernel's count against its baseline.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The kernel.
    pub kernel: String,
    /// Instructions now.
    pub now: u64,
    /// Instructions in the baseline.
    pub baseline: Option<u64>,
}

impl Verdict {
    /// What became of the kernel.
    pub fn change(&self) -> Change {
        let Some(baseline) = self.baseline else { return Change::New };
        if self.now * 100 > baseline * (100 + LIMIT) {
            Change::Slower
        } else if self.now * 100 < baseline * (100 - LIMIT) {
            Change::Faster
        } else {
            Change::None
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Verdict { kernel, now, baseline } = self;
        write!(f, "{kernel:<24} {now:>12} instructions")?;
        if let Some(baseline) = baseline {
            let percent = 100.0 * (*now as f64 / *baseline as f64 - 1.0);
            write!(f, ", baseline {baseline:>12}, {percent:+.2} %")?;
        }
        match self.change() {
            Change::None => Ok(()),
            Change::Slower => write!(f, ": more than the {LIMIT} % allowed"),
            Change::Faster => write!(f, ": faster, lower the baseline"),
            Change::New => write!(f, ": new, add it to the baseline"),
        }
    }
}

impl Counts {
    /// Every kernel against its baseline.
    pub fn against(&self, baseline: &Counts) -> Vec<Verdict> {
        let verdict = |(kernel, &now): (&String, &u64)| Verdict {
            kernel: kernel.clone(),
            now,
            baseline: baseline.instructions.get(kernel).copied(),
        };
        self.instructions.iter().map(verdict).collect()
    }
}

/// The count in what callgrind prints, `==1234== Collected : 5678`.
pub fn collected(messages: &str) -> Option<u64> {
    let line = messages.lines().find_map(|line| line.split_once("Collected :"))?;
    line.1.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(kernels: &[(&str, u64)]) -> Counts {
        let instructions = kernels.iter().map(|&(name, count)| (name.to_owned(), count)).collect();
        Counts { compiler: "rustc".to_owned(), instructions }
    }

    #[test]
    fn three_per_cent_more_is_within_the_limit_and_a_hair_more_is_not() {
        let baseline = counts(&[("a", 1000), ("b", 1000), ("c", 1000), ("d", 1000)]);
        let now = counts(&[("a", 1030), ("b", 1031), ("c", 969), ("d", 970), ("e", 1)]);
        let changes: Vec<Change> = now.against(&baseline).iter().map(Verdict::change).collect();
        assert_eq!(changes, [Change::None, Change::Slower, Change::Faster, Change::None, Change::New]);
    }

    #[test]
    fn a_verdict_names_the_kernel_and_both_counts() {
        let verdict = Verdict { kernel: "linear-2d".to_owned(), now: 1100, baseline: Some(1000) };
        let expected = "linear-2d                        1100 instructions, baseline         1000, +10.00 %: more than the 3 % allowed";
        assert_eq!(verdict.to_string(), expected);
    }

    #[test]
    fn the_count_is_read_from_what_callgrind_prints() {
        let messages = "==7== Callgrind, a call-graph generator\n==7== Events    : Ir\n==7== Collected : 8145\n==7==\n";
        assert_eq!(collected(messages), Some(8145));
        assert_eq!(collected("==7== Events    : Ir\n"), None);
    }
}
