//! What a study file may say: plain data, no behaviour.
//!
//! The doc comments here are the reference page of the book and the descriptions of the JSON schema.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A study: variants of a case against references, in one table and in figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// A line for people; it heads the table.
    pub title: String,
    /// The case file of all runs that name none of their own. Paths count from the folder of the study file.
    #[schemars(length(min = 1))]
    pub case: String,
    /// Values set in the case of every run, as `--set` does: `{ "time.step" = "auto" }`.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
    /// The runs that are compared: one `[[variants]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variants: Vec<Variant>,
    /// Grids of variants: one `[[sweeps]]` each. Their variants come after the others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sweeps: Vec<Sweep>,
    /// Problems that variants belong to, where a study has several: one `[[problems]]` each. The table then has one line for each
    /// variant or refinement of a problem: its error, observed order, drift of the energy, noise and cost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub problems: Vec<StudyProblem>,
    /// What the variants are held against: one `[[references]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub references: Vec<Reference>,
    /// Sets of variants that differ in a size, whose orders of convergence are observed: one `[[refinements]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinements: Vec<Refinement>,
    /// What is compared.
    #[serde(default)]
    pub comparison: Comparison,
    /// Names of quantities in the figures: `{ "base.pressure" = "pressure at the base" }`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// Pictures, each with its numbers beside it: one `[[figures]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<Figure>,
}

/// A problem that variants belong to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyProblem {
    /// Its name. Where the name of a variant begins with it, the table shows the rest.
    #[schemars(length(min = 1))]
    pub name: String,
    /// The quantity whose error the table shows, relative to the largest value of the reference: a column of `history.csv` that
    /// a reference stands for, or `"error.displacement"` and its like for cases with an `exact_motion`.
    pub error: String,
    /// The reference. By default the first that stands for the quantity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Which error: the largest or the root mean square over the outputs.
    #[serde(default)]
    pub measure: ErrorMeasure,
    /// The part of the time that is looked at, `[from, to]` (s). By default that of the comparison.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<[f64; 2]>,
}

/// A run that is compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Its name, which is that of its folder under `runs` too.
    #[schemars(length(min = 1))]
    pub name: String,
    /// What figures call it. By default the name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// A case file of its own. By default that of the study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub case: Option<String>,
    /// The name of the problem that it belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
    /// Values set in its case, after those of the study: `{ "method.velocity_update" = "mpm2" }`.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
    /// Whether a fixed time step beyond the stable limit is accepted.
    #[serde(default)]
    pub allow_unstable: bool,
}

/// A grid of variants: every combination of some lists of values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// The pattern of the variants' names, with the values of keys in braces: `"{method.velocity_update}-{grid.spacing}"`.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Tables of lists. The lists of one table advance together; every combination of the tables' entries is a variant.
    /// `[{ "method.velocity_update" = ["mpm1", "mpm2"] }, { "grid.spacing" = [[1.0], [0.5]], "grid.cells" = [[12], [24]] }]`
    /// makes four.
    #[schemars(with = "Vec<BTreeMap<String, Vec<serde_json::Value>>>", length(min = 1))]
    pub lists: Vec<toml::Table>,
    /// A case file of their own. By default that of the study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub case: Option<String>,
    /// The name of the problem that they belong to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
    /// Makes refinements of the variants that differ in a size alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refine: Option<SweepRefinement>,
    /// Values set in all of their cases, before those of the lists.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
    /// Whether fixed time steps beyond the stable limit are accepted.
    #[serde(default)]
    pub allow_unstable: bool,
}

/// Which variants of a sweep differ in a size alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepRefinement {
    /// The key of the lists whose values are the sizes, coarse to fine: numbers, or vectors of which the first number counts.
    pub key: String,
    /// The pattern of the refinements' names, with the values of the other keys in braces.
    #[schemars(length(min = 1))]
    pub name: String,
    /// What the size is, with its unit in round brackets, for the axis of figures.
    #[serde(default = "size_label")]
    pub size_label: String,
}

/// What variants are held against: an exact solution, a table of numbers, or another run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    { "required": ["solution"] },
    { "required": ["file"] },
    { "anyOf": [{ "required": ["set"] }, { "required": ["case"] }] }
]))]
pub struct Reference {
    /// Its name; if it is a run, that of its folder under `runs` too.
    #[schemars(length(min = 1))]
    pub name: String,
    /// What figures call it. By default the name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// The name of the problem whose variants it stands for. By default all variants.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
    /// The name of an exact solution. Give this, `file`, or `set` or `case`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solution: Option<String>,
    /// The parameters of the exact solution.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub parameters: toml::Table,
    /// A file of comma-separated numbers, with a line of column names; lines that begin with `#` are comments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The column of the file that holds the time, with the factor that makes it seconds: `{ column = "t (d)", factor = 86400.0 }`,
    /// or the name of the column alone. By default `"time"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<ColumnChoice>")]
    pub time: Option<toml::Value>,
    /// The case file of a reference run. By default that of the study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub case: Option<String>,
    /// Values set in the case of a reference run, after those of the study.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub set: Option<toml::Table>,
    /// Which quantity of the variants is held against what of the reference. With a solution: one of its quantities, such as
    /// `{ "base.pressure" = { pressure_at_depth = 9.5 } }`. With a file: a column, `"p"` or `{ column = "p", factor = 1000.0 }`.
    /// With a run: a column of its history; by default every column is held against the one of the same name.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub quantities: toml::Table,
    /// With a run: whether a fixed time step beyond the stable limit is accepted.
    #[serde(default)]
    pub allow_unstable: bool,
}

/// A column of a file, and the factor that makes its numbers SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// The name of the column.
    pub column: String,
    /// What the numbers are multiplied by.
    #[serde(default = "one")]
    pub factor: f64,
}

fn one() -> f64 {
    1.0
}

/// A column alone, or with a factor: for the JSON schema only.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "describes what is read as either of the two")]
enum ColumnChoice {
    Name(String),
    Column(Column),
}

/// Variants that differ in a size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refinement {
    /// Its name.
    #[schemars(length(min = 1))]
    pub name: String,
    /// What figures call it. By default the name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// The variants, coarse to fine.
    #[schemars(length(min = 2))]
    pub variants: Vec<String>,
    /// The size of each of them, such as the spacing of the grid.
    #[schemars(length(min = 2))]
    pub sizes: Vec<f64>,
    /// What the size is, with its unit in round brackets, for the axis of figures.
    #[serde(default = "size_label")]
    pub size_label: String,
}

fn size_label() -> String {
    "size".to_owned()
}

/// What is compared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// The quantities: columns of `history.csv`, and `rate(column)`, their change from output to output over time. By default
    /// all that the references name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantities: Option<Vec<String>>,
    /// The part of the time that is looked at, `[from, to]` (s). By default all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<[f64; 2]>,
}

/// A picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Its name, which is that of its files under `figures`.
    #[schemars(length(min = 1))]
    pub name: String,
    /// What it shows.
    pub kind: FigureKind,
    /// A line above it. Particles show the time by default, other figures nothing: captions belong into the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Lines: the variants. By default all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variants: Option<Vec<String>>,
    /// Lines and convergence: the references. By default all that have the quantities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub references: Option<Vec<String>>,
    /// Lines: the quantities drawn against time. Convergence: those whose errors are drawn, by default all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantities: Option<Vec<String>>,
    /// Lines: quantities of a second panel below the first, over the same time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub below: Vec<String>,
    /// Lines: quantities on a second axis at the right of the first panel.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub right: Vec<String>,
    /// Lines: the part of the time that is drawn, `[from, to]` (s). By default all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<[f64; 2]>,
    /// Particles: the variant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variant: Option<String>,
    /// Particles: the time (s); the fields written nearest to it are drawn, and their time is told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Particles: what displacements are multiplied by; told in the picture unless it is 1, the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub magnification: Option<f64>,
    /// Convergence: the refinements. By default all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refinements: Option<Vec<String>>,
    /// Convergence: which error. By default the largest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorMeasure>,
    /// Title of the horizontal axis, with its unit in round brackets. Found by itself otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x_label: Option<String>,
    /// Title of the vertical axis, with its unit in round brackets. Found by itself otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_label: Option<String>,
    /// Title of the vertical axis of the second panel or at the right. Found by itself otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_label: Option<String>,
}

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FigureKind {
    /// Quantities of variants and references against time.
    Lines,
    /// The deformed particles of a variant at a time, coloured by pore pressure.
    Particles,
    /// Errors against size on logarithmic axes, with the observed order.
    Convergence,
}

/// A measure of the difference between two curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorMeasure {
    /// The largest difference.
    #[default]
    Max,
    /// The root of the mean square of the differences.
    Rms,
}
