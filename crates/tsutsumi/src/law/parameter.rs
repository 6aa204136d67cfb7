use super::LawError;

/// Refuses a parameter that breaks its rule.
pub(super) fn require(holds: bool, name: &'static str, value: f64, expected: &'static str) -> Result<(), LawError> {
    if holds { Ok(()) } else { Err(LawError::Parameter { name, value, expected }) }
}

/// Refuses a parameter that is not a positive, finite number.
pub(super) fn require_positive(name: &'static str, value: f64, expected: &'static str) -> Result<(), LawError> {
    require(value > 0.0 && value.is_finite(), name, value, expected)
}
