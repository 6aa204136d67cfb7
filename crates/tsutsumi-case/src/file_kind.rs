//! What a file describes, and how large it may be.

use crate::json_schema::{CALIBRATION_KEYS, CASE_KEYS, ELEMENT_TEST_KEYS, Keys, STUDY_KEYS};

/// Largest case file that is read (bytes).
pub const SIZE_LIMIT: u64 = 4 * 1024 * 1024;

/// What a file describes: which keys it may have, and what messages call it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A case.
    Case,
    /// A study.
    Study,
    /// An element test.
    ElementTest,
    /// A calibration.
    Calibration,
}

impl FileKind {
    pub(crate) fn keys(self) -> &'static Keys {
        match self {
            Self::Case => &CASE_KEYS,
            Self::Study => &STUDY_KEYS,
            Self::ElementTest => &ELEMENT_TEST_KEYS,
            Self::Calibration => &CALIBRATION_KEYS,
        }
    }

    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Case => "case",
            Self::Study => "study",
            Self::ElementTest => "element test",
            Self::Calibration => "calibration",
        }
    }
}
