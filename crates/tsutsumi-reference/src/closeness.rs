//! How near numbers must be in the tests of this crate.

/// Asserts |value − expected| ≤ tolerance. NaN is never close.
#[track_caller]
pub(crate) fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected} ± {tolerance}");
}
