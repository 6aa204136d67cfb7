//! The exact solutions that a study can name: the one place where a word in `solution` becomes a type.
//!
//! A new one is a type with [`Solution`] and one line in [`solutions`].

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use tsutsumi_reference::consolidation::{Layer, Ramp};

use crate::json_schema::SolutionSchema;
use crate::{CaseError, CaseSource, KeyPath};

/// A quantity of an exact solution in time (s), in SI units.
pub type Course = Box<dyn Fn(f64) -> f64 + Send + Sync>;

/// A problem with a known answer. Its fields are the `parameters` of a reference in a study file.
pub trait Solution: DeserializeOwned + JsonSchema + Send + Sync + 'static {
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

    /// The quantity at a time (s), in SI units.
    fn value(&self, quantity: &Self::Quantity, time: f64) -> f64;
}

/// A parameter that makes no sense.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// Its name.
    pub parameter: &'static str,
    /// What it must be.
    pub expected: &'static str,
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
    vec![NamedSolution::new::<Consolidation>("consolidation")]
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
        Ok(Box::new(move |time| solution.value(&quantity, time)))
    }
}

/// One-dimensional consolidation of a layer on an impermeable rigid base, drained and loaded at its top.
///
/// c_v = (k/γ_w) / (1/E_oed + n/K^f); see [`Layer`] for equations and source.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Consolidation {
    /// Thickness of the layer (m).
    height: f64,
    /// Oedometric modulus of the skeleton (Pa): E (1 − ν) / ((1 + ν)(1 − 2ν)).
    modulus: f64,
    /// Hydraulic conductivity k (m/s).
    conductivity: f64,
    /// Unit weight of the water γ_w (N/m³).
    unit_weight: f64,
    /// Porosity n (–).
    porosity: f64,
    /// Bulk modulus of the water K^f (Pa); `inf` for water that cannot be compressed.
    bulk_modulus: f64,
    /// The final load on the top (Pa), positive in compression.
    load: f64,
    /// The time over which the load grows linearly (s); 0 for a load put on at once.
    duration: f64,
}

/// What consolidation gives.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum ConsolidationQuantity {
    /// Settlement of the top (m), positive downwards.
    Settlement,
    /// Pore pressure (Pa) at this depth below the top (m).
    PressureAtDepth(f64),
}

impl Consolidation {
    fn layer(&self) -> Layer {
        Layer {
            height: self.height,
            modulus: self.modulus,
            conductivity: self.conductivity,
            unit_weight: self.unit_weight,
            fluid_compressibility: self.porosity / self.bulk_modulus,
        }
    }

    fn ramp(&self) -> Ramp {
        Ramp { load: self.load, duration: self.duration }
    }
}

impl Solution for Consolidation {
    type Quantity = ConsolidationQuantity;

    fn validate(&self) -> Result<(), Refusal> {
        const POSITIVE: &str = "a finite number greater than 0";
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let checks = [
            ("height", positive(self.height), POSITIVE),
            ("modulus", positive(self.modulus), POSITIVE),
            ("conductivity", positive(self.conductivity), POSITIVE),
            ("unit_weight", positive(self.unit_weight), POSITIVE),
            ("porosity", self.porosity > 0.0 && self.porosity < 1.0, "between 0 and 1"),
            ("bulk_modulus", self.bulk_modulus > 0.0, "greater than 0"),
            ("load", self.load.is_finite(), "a finite number"),
            ("duration", self.duration.is_finite() && self.duration >= 0.0, "a finite number, 0 or more"),
        ];
        match checks.into_iter().find(|(_, is_good, _)| !is_good) {
            Some((parameter, _, expected)) => Err(Refusal { parameter, expected }),
            None => Ok(()),
        }
    }

    fn accepts(&self, quantity: &ConsolidationQuantity) -> Result<(), String> {
        match quantity {
            ConsolidationQuantity::PressureAtDepth(depth) if !(0.0..=self.height).contains(depth) => {
                Err(format!("the depth must lie within the layer, 0 to {} m, not {depth}", self.height))
            }
            _ => Ok(()),
        }
    }

    fn value(&self, quantity: &ConsolidationQuantity, time: f64) -> f64 {
        match quantity {
            ConsolidationQuantity::Settlement => self.layer().settlement(self.ramp(), time),
            ConsolidationQuantity::PressureAtDepth(depth) => self.layer().pressure(self.ramp(), *depth, time),
        }
    }
}
