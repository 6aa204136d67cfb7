//! The exact solutions that a study can name: the one place where a word in `solution` becomes a type.
//!
//! A new one is a type with the trait `Solution` and one line in [`solutions`].

mod consolidation;
mod coupled;
mod waves;

use std::sync::Arc;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;
use tsutsumi_reference::cryer::Cryer;
use tsutsumi_reference::de_leeuw::DeLeeuw;
use tsutsumi_reference::large_strain::LargeStrainLayer;
use tsutsumi_reference::mandel::Mandel;

use self::consolidation::Consolidation;
use self::waves::{HarmonicWave, SmoothWave};
use crate::json_schema::SolutionSchema;
use crate::{CaseError, CaseSource, KeyPath};

/// A quantity of an exact solution at some times (s), in SI units.
pub(crate) type Course = Box<dyn Fn(&[f64]) -> Vec<f64> + Send + Sync>;

/// A problem with a known answer. Its fields are the `parameters` of a reference in a study file.
pub(crate) trait Solution: DeserializeOwned + JsonSchema + Send + Sync + 'static {
    /// What it gives: in the file a word, or a table with one key for what needs numbers, such as a depth.
    type Quantity: DeserializeOwned + JsonSchema + Send + Sync + 'static;

    /// Says which parameter makes no sense, and why.
    ///
    /// # Errors
    /// The name of the parameter and what it must be.
    fn validate(&self) -> Result<(), Refusal>;

    /// Says why it cannot give a quantity.
    ///
    /// # Errors
    /// What is wrong with the quantity.
    fn accepts(&self, quantity: &Self::Quantity) -> Result<(), String>;

    /// The quantity at some times (s), in SI units.
    fn values(&self, quantity: &Self::Quantity, times: &[f64]) -> Vec<f64>;
}

/// A parameter that makes no sense.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Refusal {
    /// Its name.
    pub(crate) parameter: &'static str,
    /// What it must be.
    pub(crate) expected: &'static str,
}

/// An exact solution that a study file can name.
pub struct NamedSolution {
    /// Its name in study files.
    pub name: &'static str,
    parameters: Value,
    quantity: Value,
    open: Open,
}

/// Reads a solution's parameters from the reference at a place in a study file.
type Open = fn(&CaseSource, &KeyPath) -> Result<Box<dyn OpenSolution>, CaseError>;

/// The exact solutions by name.
pub fn solutions() -> Vec<NamedSolution> {
    vec![
        NamedSolution::new::<Consolidation>("consolidation"),
        NamedSolution::new::<LargeStrainLayer>("large-strain-consolidation"),
        NamedSolution::new::<Mandel>("mandel"),
        NamedSolution::new::<DeLeeuw>("de-leeuw"),
        NamedSolution::new::<Cryer>("cryer"),
        NamedSolution::new::<HarmonicWave>("harmonic-wave"),
        NamedSolution::new::<SmoothWave>("smooth-wave"),
    ]
}

impl NamedSolution {
    fn new<S: Solution>(name: &'static str) -> Self {
        NamedSolution {
            name,
            parameters: schemars::schema_for!(S).to_value(),
            quantity: schemars::schema_for!(S::Quantity).to_value(),
            open: open::<S>,
        }
    }

    /// Reads the parameters of the reference at `reference` in a study file.
    pub(super) fn open(&self, source: &CaseSource, reference: &KeyPath) -> Result<Box<dyn OpenSolution>, CaseError> {
        (self.open)(source, reference)
    }

    pub(crate) fn schema(self) -> SolutionSchema {
        SolutionSchema { name: self.name, parameters: self.parameters, quantity: self.quantity }
    }
}

/// A solution with its parameters, which reads its quantities from the study file.
pub(super) trait OpenSolution {
    fn course(&self, source: &CaseSource, place: &KeyPath) -> Result<Course, CaseError>;
}

fn open<S: Solution>(source: &CaseSource, reference: &KeyPath) -> Result<Box<dyn OpenSolution>, CaseError> {
    let place = reference.clone().key("parameters");
    let solution: S = source.parse_at(&place)?;
    solution.validate().map_err(|refusal| {
        let key = place.key(refusal.parameter);
        source.invalid(key.clone(), format!("`{key}` must be {}", refusal.expected), "")
    })?;
    Ok(Box::new(Opened(Arc::new(solution))))
}

struct Opened<S>(Arc<S>);

impl<S: Solution> OpenSolution for Opened<S> {
    fn course(&self, source: &CaseSource, place: &KeyPath) -> Result<Course, CaseError> {
        let quantity: S::Quantity = source.parse_at(place)?;
        self.0.accepts(&quantity).map_err(|why| source.invalid(place, format!("`{place}`: {why}"), ""))?;
        let solution = Arc::clone(&self.0);
        Ok(Box::new(move |times| solution.values(&quantity, times)))
    }
}

/// What a length, modulus or rate must be.
const POSITIVE: &str = "a finite number greater than 0";
/// What a load must be.
const FINITE: &str = "a finite number";
/// What a duration must be.
const NOT_NEGATIVE: &str = "a finite number, 0 or more";

fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

fn is_not_negative(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

/// Refuses the first parameter that is not good: name, whether it is, what it must be.
fn refuse_first(checks: &[(&'static str, bool, &'static str)]) -> Result<(), Refusal> {
    match checks.iter().find(|(_, is_good, _)| !is_good) {
        Some(&(parameter, _, expected)) => Err(Refusal { parameter, expected }),
        None => Ok(()),
    }
}

/// Refuses a place outside the body.
fn within(what: &str, place: f64, end: f64) -> Result<(), String> {
    match (0.0..=end).contains(&place) {
        true => Ok(()),
        false => Err(format!("the {what} must lie within the body, 0 to {end} m, not {place}")),
    }
}
