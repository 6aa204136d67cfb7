//! What an element test may say: plain data, no behaviour.
//!
//! The doc comments here are the reference page of the book and the descriptions of the JSON schema.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An element test: one specimen of a law, loaded stage by stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElementTestFile {
    /// A line for people.
    pub title: String,
    /// What the specimen is made of.
    pub material: TestMaterial,
    /// The specimen before the test. By default without stress.
    #[serde(default, skip_serializing_if = "TestInitial::is_default")]
    pub initial: TestInitial,
    /// What is done to it, one after the other: one `[[stages]]` each.
    #[schemars(length(min = 1))]
    pub stages: Vec<Stage>,
    /// Repeats the test with other stress ratios in its last stage, for a liquefaction resistance curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resistance: Option<Resistance>,
    /// Pictures beside those that are drawn anyway: one `[[figures]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<TestFigure>,
    /// What is written.
    #[serde(default)]
    pub output: TestOutput,
    /// What may be left of each condition, relative to the largest stress so far, or to the strain (–).
    #[serde(default = "default_tolerance")]
    #[schemars(range(max = 0.01), extend("exclusiveMinimum" = 0))]
    pub tolerance: f64,
}

/// What may be left of each condition where a file does not say (–).
pub(crate) const DEFAULT_TOLERANCE: f64 = 1e-9;

fn default_tolerance() -> f64 {
    DEFAULT_TOLERANCE
}

/// What the specimen is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestMaterial {
    /// The constitutive law of the effective stress; `tsutsumi laws` lists them.
    pub law: String,
    /// The parameters of the law; `tsutsumi laws` tells which. Empty by default.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub parameters: toml::Table,
}

/// The specimen before the test. Give `mean_stress`, `axial_stress` with `radial_stress`, or `components`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestInitial {
    /// Mean effective stress p' (Pa, positive in compression), the same on all sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_stress: Option<f64>,
    /// Vertical effective stress (Pa, positive in compression).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axial_stress: Option<f64>,
    /// Horizontal effective stress (Pa, positive in compression).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radial_stress: Option<f64>,
    /// The components xx, yy, zz, xy, yz, zx of the effective stress (Pa, positive in tension).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub components: Option<[f64; 6]>,
    /// Void ratio e (–). With it the void ratio is recorded, and drawn in compression tests; the law does not see it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub void_ratio: Option<f64>,
    /// The history of the law, as a run has left it. By default the one that the law gives to a point with this stress.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "serde_json::Value")]
    pub history: Option<toml::Value>,
}

impl TestInitial {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A part of the test. It goes `to` a value, back and forth with an `amplitude`, along `conditions`, or by one increment of `strain`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// How the specimen is held.
    pub kind: StageKind,
    /// Triaxial and simple shear: whether water leaves. By default it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drainage: Option<DrainageKind>,
    /// Where a monotonic stage goes: one quantity with its value at the end, such as `{ axial_strain = 0.1 }`. Strains count from the
    /// start of the stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<Target>,
    /// Triaxial and simple shear: how far a cyclic stage goes to either side of where it began, such as `{ stress_ratio = 0.15 }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<Amplitude>,
    /// Cyclic stages with an amplitude of stress: what is prescribed increment by increment. With `"strain"`, the default, the load turns
    /// where the stress has reached its amplitude; so liquefied ground can be followed as well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driven_by: Option<Driver>,
    /// Monotonic stages: the number of equal increments, 200 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub increments: Option<usize>,
    /// Cyclic stages: the size of an increment, of strain (–) or, driven by stress, of stress (Pa). By default a hundredth of the
    /// amplitude, and 1e-5 where the strain is driven and the stress has the amplitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub increment: Option<f64>,
    /// Cyclic stages: when they end. Required there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<Until>,
    /// The kind `"path"`: six conditions on stress and strain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 6, max = 6))]
    pub conditions: Option<Vec<PathCondition>>,
    /// How long the stage takes (s), in equal parts for its increments: for laws to which time matters. Without it, for ever. Cyclic
    /// stages have a `rate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub duration: Option<f64>,
    /// Cyclic stages: how fast the driven strain (1/s) or stress (Pa/s) changes. Without it, infinitely slowly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: Option<f64>,
    /// The kind `"increment"`: the components xx, yy, zz, xy, yz, zx of the strain increment (–, positive in extension, tensor shear).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain: Option<[f64; 6]>,
    /// The kind `"increment"`: the rotation about x, y and z (rad) that goes with it, half the skew part of the displacement gradient. By
    /// default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<[f64; 3]>,
    /// Counts the strain from the start of this stage on, in all that is written and drawn.
    #[serde(default)]
    pub zero_strain: bool,
}

impl Stage {
    /// A stage of a kind, with nothing said about it yet.
    pub(crate) fn of_kind(kind: StageKind) -> Self {
        Stage {
            kind,
            drainage: None,
            to: None,
            amplitude: None,
            driven_by: None,
            increments: None,
            increment: None,
            until: None,
            conditions: None,
            duration: None,
            rate: None,
            strain: None,
            spin: None,
            zero_strain: false,
        }
    }
}

/// How a specimen is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StageKind {
    /// The three normal stresses change alike. Goes to a `mean_stress` or a `volumetric_strain`.
    Isotropic,
    /// No lateral strain: the oedometer, and consolidation at rest (K₀). Goes to an `axial_stress` or an `axial_strain`.
    Oedometer,
    /// Triaxial compression (positive) and extension (negative) along z. Goes to an `axial_strain` or a `stress_difference`.
    Triaxial,
    /// Horizontal planes slide along x, without horizontal strain. Goes to a `shear_strain` or a `shear_stress`.
    SimpleShear,
    /// Six conditions of your own.
    Path,
    /// One increment as it is, not halved where the law fails: what a run keeps of a point whose law has failed.
    Increment,
}

/// Whether water leaves the specimen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DrainageKind {
    /// The radial effective stress stays in triaxial tests, the vertical one in simple shear.
    Drained,
    /// The volume stays. The total radial stress (triaxial) or total vertical stress (simple shear) stays as well, which gives the pore
    /// pressure.
    Undrained,
    /// The mean effective stress stays.
    ConstantMeanStress,
}

/// What is prescribed increment by increment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Driver {
    /// The strain.
    Strain,
    /// The stress.
    Stress,
}

/// One quantity with its value at the end of a stage, positive in compression.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1, "maxProperties" = 1))]
pub struct Target {
    /// Mean effective stress p' (Pa).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_stress: Option<f64>,
    /// Vertical effective stress (Pa).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axial_stress: Option<f64>,
    /// Axial less radial stress, q (Pa).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress_difference: Option<f64>,
    /// Shear stress τ_zx on horizontal planes (Pa).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear_stress: Option<f64>,
    /// Volumetric strain (–), from the start of the stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volumetric_strain: Option<f64>,
    /// Axial strain (–), from the start of the stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axial_strain: Option<f64>,
    /// Engineering shear strain γ_zx (–), from the start of the stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear_strain: Option<f64>,
}

/// The amplitude of a cyclic stage: one of these.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1, "maxProperties" = 1))]
pub struct Amplitude {
    /// Cyclic stress ratio (–): τ/σ'_v in simple shear, q/2σ'_r in triaxial tests, with the vertical or radial effective stress at the
    /// start of the stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stress_ratio: Option<f64>,
    /// Shear stress τ, or stress difference q (Pa).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stress: Option<f64>,
    /// Shear strain γ, or axial strain (–).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub strain: Option<f64>,
}

/// When a cyclic stage ends: at the first of these.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Until {
    /// After so many cycles (–). One cycle ends where the load is back in the middle on its way up.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cycles: f64,
    /// Single amplitude: when shear or axial strain is so far from that at the start of the stage (–).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub single_strain: Option<f64>,
    /// Double amplitude: when shear or axial strain is so far from that where the load turned last (–).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub double_strain: Option<f64>,
    /// Undrained: when the pore pressure ratio r_u is this large (–).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pore_pressure_ratio: Option<f64>,
}

/// A linear combination of stress and strain components that goes to a value, by a change, or stays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PathCondition {
    /// What the components of the effective stress (Pa, positive in tension) are multiplied by: `{ zz = 1.0 }`, or `{ xx = 1.0, yy = -1.0 }`
    /// for their difference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress: Option<Coefficients>,
    /// What the components of the strain (–, positive in extension, tensor shear) are multiplied by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain: Option<Coefficients>,
    /// The value at the end of the stage. Without `to` and `by` it stays as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// The change of the value in the stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<f64>,
}

/// Coefficients of tensor components; those that are not given are 0.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Coefficients {
    /// Of the component xx (–).
    pub xx: f64,
    /// Of the component yy (–).
    pub yy: f64,
    /// Of the component zz, the axial or vertical one (–).
    pub zz: f64,
    /// Of the component xy (–).
    pub xy: f64,
    /// Of the component yz (–).
    pub yz: f64,
    /// Of the component zx (–).
    pub zx: f64,
}

/// The test again with other stress ratios in its last stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resistance {
    /// The cyclic stress ratios (–); the last stage must be cyclic.
    #[schemars(length(min = 1), extend("items" = { "type": "number", "exclusiveMinimum": 0 }))]
    pub stress_ratios: Vec<f64>,
    /// What counts as liquefaction, each with a curve of its own: one of the limits of `until` each, such as
    /// `[{ pore_pressure_ratio = 0.95 }, { double_strain = 0.075 }]`.
    #[schemars(length(min = 1))]
    pub criteria: Vec<LiquefactionCriterion>,
}

/// What counts as liquefaction: one of these.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1, "maxProperties" = 1))]
pub struct LiquefactionCriterion {
    /// Single amplitude of shear or axial strain (–).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub single_strain: Option<f64>,
    /// Double amplitude of shear or axial strain (–).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub double_strain: Option<f64>,
    /// Pore pressure ratio r_u (–).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pore_pressure_ratio: Option<f64>,
}

/// A picture of one recorded quantity against another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestFigure {
    /// Its name, which is that of its files under `figures`: letters, digits and hyphens.
    #[schemars(regex(pattern = "^[a-z0-9-]+$"))]
    pub name: String,
    /// The column of `element.csv` along the horizontal axis.
    pub x: String,
    /// The column of `element.csv` along the vertical axis.
    pub y: String,
    /// Whether the horizontal axis is logarithmic.
    #[serde(default)]
    pub x_log: bool,
    /// Whether the vertical axis grows downwards.
    #[serde(default)]
    pub y_down: bool,
    /// The stages that are drawn, counted from 1. By default all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<usize>>,
}

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TestOutput {
    /// Every how many increments a row is written. Ends of stages and turns of cyclic loads are always written.
    #[schemars(range(min = 1))]
    pub every: usize,
    /// Whether figures are drawn.
    pub figures: bool,
}

impl Default for TestOutput {
    fn default() -> Self {
        TestOutput { every: 1, figures: true }
    }
}
