//! Values that a study sets in cases.

use crate::error::quoted;
use crate::{CaseError, CaseSource, KeyPath};

/// A value that the study sets in a case.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setting {
    /// `key=value`.
    pub(super) assignment: String,
    /// Where it stands in the study file; none if it comes from elsewhere.
    pub(super) place: Option<KeyPath>,
}

impl Setting {
    pub(super) fn new(key: &str, value: &toml::Value, place: KeyPath) -> Self {
        Setting { assignment: format!("{key}={value}"), place: Some(place) }
    }
}

/// `time.step = …` without quotes is a table `time` that would replace the case's, and is meant otherwise.
pub(super) fn refuse_unquoted(
    source: &CaseSource,
    place: &KeyPath,
    key: &str,
    value: &toml::Value,
) -> Result<(), CaseError> {
    match value.as_table().and_then(|table| table.keys().next()) {
        Some(inner) if KeyPath::from(key).segments().len() == 1 => {
            let message = format!("this would replace the whole table `{}`", quoted(key));
            let help = format!("paths of keys stand in quotes: \"{}.{}\" = …", quoted(key), quoted(inner));
            Err(source.invalid(place, message, help))
        }
        _ => Ok(()),
    }
}
