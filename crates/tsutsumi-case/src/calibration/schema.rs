//! What a calibration may say: plain data, no behaviour.
//!
//! The doc comments here are the reference page of the book and the descriptions of the JSON schema.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A calibration: parameters of a law, such that element tests come near to measured ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationFile {
    /// A line for people.
    pub title: String,
    /// The parameters that are sought: one `[[parameters]]` each. All others stay as the element tests give them.
    #[schemars(length(min = 1))]
    pub parameters: Vec<SoughtParameter>,
    /// What is measured: one `[[measurements]]` each.
    #[schemars(length(min = 1))]
    pub measurements: Vec<Measurement>,
    /// Iterations of the search after which it ends anyway, from each of its starts.
    #[serde(default = "default_iterations")]
    #[schemars(range(min = 1))]
    pub iterations: u64,
    /// The search ends where the misfits of its simplex differ by less than this (–).
    #[serde(default = "default_tolerance")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tolerance: f64,
}

fn default_iterations() -> u64 {
    300
}

fn default_tolerance() -> f64 {
    1e-10
}

/// A parameter of the law that is sought.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SoughtParameter {
    /// Its name, as in `material.parameters`.
    #[schemars(length(min = 1))]
    pub name: String,
    /// The range within which it is sought, `[from, to]`, in its own unit.
    pub bounds: [f64; 2],
    /// Where the search begins. By default the middle of the range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Whether equal ratios count as equal steps, for parameters whose size is not known. The range must be positive.
    #[serde(default)]
    pub logarithmic: bool,
}

/// A measured curve, and the element test that should follow it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// Its name, which is that of its figure: lower-case letters, digits and hyphens.
    #[schemars(regex(pattern = "^[a-z0-9-]+$"))]
    pub name: String,
    /// The file of the element test. Paths count from the folder of the calibration.
    pub test: String,
    /// The measured numbers: comma-separated, with a line of column names; lines that begin with `#` are comments.
    pub data: String,
    /// What is compared at equal values, such as the axial strain. It must grow in the part of the test that is compared.
    pub x: MeasuredColumn,
    /// What is compared.
    pub y: MeasuredColumn,
    /// The stage of the element test that is compared, counted from 1. By default all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<usize>,
    /// How much it counts (–), beside others.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub weight: f64,
}

/// A recorded quantity, and the column of the data that measures it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredColumn {
    /// The column of `element.csv`.
    pub quantity: String,
    /// The column of the data.
    pub column: String,
    /// What the numbers of the data are multiplied by to be in SI units.
    #[serde(default = "one")]
    pub factor: f64,
}

fn one() -> f64 {
    1.0
}
