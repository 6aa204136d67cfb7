//! Grids of variants from lists of values.

use super::schema::{Sweep, SweepRefinement};
use super::setting::{Setting, refuse_unquoted};
use crate::error::quoted;
use crate::source::list;
use crate::{CaseError, CaseSource, KeyPath, did_you_mean};

/// More variants than anybody means.
const MAX_VARIANTS: usize = 1000;

/// A value of a list, and where it stands.
#[derive(Clone)]
struct Choice<'a> {
    key: &'a str,
    value: &'a toml::Value,
    place: KeyPath,
}

/// A variant of a sweep.
pub(super) struct SweptVariant {
    pub(super) name: String,
    /// What it sets.
    pub(super) settings: Vec<Setting>,
    pub(super) step: Option<RefinementStep>,
}

/// A variant's place in a refinement.
pub(super) struct RefinementStep {
    /// The name of the refinement.
    pub(super) refinement: String,
    pub(super) size: f64,
    pub(super) size_label: String,
}

/// The variants of a sweep; the last table of lists changes fastest.
pub(super) fn expanded(source: &CaseSource, place: &KeyPath, sweep: &Sweep) -> Result<Vec<SweptVariant>, CaseError> {
    let lists = place.clone().key("lists");
    let mut combinations: Vec<Vec<Choice>> = vec![Vec::new()];
    for (index, table) in sweep.lists.iter().enumerate() {
        let rows = zipped(source, &lists.clone().index(index), table)?;
        if combinations.len() * rows.len() > MAX_VARIANTS {
            let help = format!("up to {MAX_VARIANTS} are possible");
            return Err(source.invalid(&lists, "the lists make too many variants", help));
        }
        let pairs = combinations.iter().flat_map(|combination| rows.iter().map(move |row| [&combination[..], row]));
        combinations = pairs.map(|pair| pair.concat()).collect();
    }
    let variant = |choices: Vec<Choice>| {
        let name = named(source, place.clone().key("name"), &sweep.name, &choices)?;
        let step = match &sweep.refine {
            Some(refine) => Some(refinement_step(source, &place.clone().key("refine"), refine, &choices)?),
            None => None,
        };
        let setting = |choice: Choice| Setting::new(choice.key, choice.value, choice.place);
        Ok(SweptVariant { name, settings: choices.into_iter().map(setting).collect(), step })
    };
    combinations.into_iter().map(variant).collect()
}

/// Where a variant stands in the refinement of its sweep.
fn refinement_step(
    source: &CaseSource,
    place: &KeyPath,
    refine: &SweepRefinement,
    choices: &[Choice],
) -> Result<RefinementStep, CaseError> {
    let key = place.clone().key("key");
    let Some(choice) = choices.iter().find(|choice| choice.key == refine.key) else {
        let keys: Vec<&str> = choices.iter().map(|choice| choice.key).collect();
        let help = format!("the lists have {}", list(&keys));
        return Err(source.invalid(key, format!("there is no list for `{}`", quoted(&refine.key)), help));
    };
    let number = choice.value.as_array().and_then(|vector| vector.first()).unwrap_or(choice.value);
    let size = number.as_float().or_else(|| number.as_integer().map(|whole| whole as f64));
    let Some(size) = size else {
        let message = format!("`{}` is no size: its values are not numbers", quoted(&refine.key));
        return Err(source.invalid(key, message, ""));
    };
    let others: Vec<Choice> = choices.iter().filter(|choice| choice.key != refine.key).cloned().collect();
    let refinement = named(source, place.clone().key("name"), &refine.name, &others)?;
    Ok(RefinementStep { refinement, size, size_label: refine.size_label.clone() })
}

/// The rows of a table of lists that advance together.
fn zipped<'a>(source: &CaseSource, place: &KeyPath, table: &'a toml::Table) -> Result<Vec<Vec<Choice<'a>>>, CaseError> {
    let mut rows: Vec<Vec<Choice>> = Vec::new();
    for (number, (key, value)) in table.iter().enumerate() {
        let place = place.clone().key(key);
        refuse_unquoted(source, &place, key, value)?;
        let Some(values) = value.as_array().filter(|values| !values.is_empty()) else {
            let help = "the values stand in brackets: [1.0, 0.5]; lists of vectors in two: [[1.0], [0.5]]";
            return Err(source.invalid(&place, format!("`{place}` must be a list of values"), help));
        };
        if number == 0 {
            rows.resize_with(values.len(), Vec::new);
        } else if values.len() != rows.len() {
            let message = format!("`{place}` is {} long, the lists beside it are {}", values.len(), rows.len());
            return Err(source.invalid(&place, message, "lists of one table advance together"));
        }
        for (index, (row, value)) in rows.iter_mut().zip(values).enumerate() {
            row.push(Choice { key, value, place: place.clone().index(index) });
        }
    }
    match rows.is_empty() {
        true => Err(source.invalid(place, format!("`{place}` has no list"), "")),
        false => Ok(rows),
    }
}

/// The name of a variant: the pattern at a place with the values of the keys in braces.
fn named(source: &CaseSource, place: KeyPath, pattern: &str, choices: &[Choice]) -> Result<String, CaseError> {
    let mut name = String::new();
    let mut rest = pattern;
    while let Some((before, after)) = rest.split_once('{') {
        let (key, after) = after.split_once('}').unwrap_or((after, ""));
        let Some(choice) = choices.iter().find(|choice| choice.key == key.trim()) else {
            let keys: Vec<&str> = choices.iter().map(|choice| choice.key).collect();
            let help = match did_you_mean(key, keys.iter().copied()) {
                Some(near) => format!("did you mean `{{{near}}}`?"),
                None => format!("the lists have {}", list(&keys)),
            };
            return Err(source.invalid(place, format!("there is no list for `{{{key}}}`"), help));
        };
        name += before;
        name += &in_name(choice.value);
        rest = after;
    }
    Ok(name + rest)
}

/// A value as part of a name: vectors with `x` between their numbers.
fn in_name(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        toml::Value::Float(number) => number.to_string(),
        toml::Value::Array(values) => values.iter().map(in_name).collect::<Vec<_>>().join("x"),
        other => other.to_string(),
    }
}
