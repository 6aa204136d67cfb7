//! What a case file may say: plain data, no behaviour.
//!
//! The doc comments here are the reference page of the book and the descriptions of the JSON schema. SI units; the axes
//! are x in 1-D, x and y in 2-D, x, y and z in 3-D; the last axis is up. Whether the numbers make sense together is
//! checked by [`CaseSource::validate`](crate::CaseSource::validate).

use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroUsize;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// A case: the ground, its water, what is done to it, and what is written down.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// A line for people; it heads the figures.
    pub title: String,
    /// Dimension of space: 1 (uniaxial strain), 2 (plane strain) or 3.
    #[schemars(range(min = 1, max = 3))]
    pub dimension: usize,
    /// Acceleration of gravity (m/s²), one number per axis: `[0.0, -9.81]`. Without it there is no gravity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 3))]
    pub gravity: Option<Vec<f64>>,
    /// The background grid.
    pub grid: Grid,
    /// How long, and in what steps.
    pub time: Time,
    /// Which variant of the method.
    #[serde(default)]
    pub method: Method,
    /// The pore water. Without it the ground is dry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<Fluid>,
    /// The materials, each under a name of your choice: `[materials.soil]`.
    #[schemars(extend("minProperties" = 1))]
    pub materials: BTreeMap<String, Material>,
    /// The bodies of ground, filled with material points: one `[[bodies]]` each.
    #[schemars(length(min = 1))]
    pub bodies: Vec<Body>,
    /// Rollers and fixities: one `[[supports]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supports: Vec<Support>,
    /// Tractions and pressures on the surfaces of bodies: one `[[loads]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<Load>,
    /// Surfaces through which water leaves freely: one `[[drainage]]` each. All others are impervious.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drainage: Vec<Drainage>,
    /// An earthquake: the motion of the base, on which all supports stand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground_motion: Option<GroundMotion>,
    /// A motion that is known exactly. The bodies start with its velocity, its body force acts on them, and `history.csv` tells
    /// how far they are from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exact_motion: Option<ExactMotion>,
    /// Points whose histories are recorded: one `[[probes]]` each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probes: Vec<Probe>,
    /// What is written, and how often.
    pub output: Output,
}

/// The background grid: equal cells, axis by axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// The lower corner (m), one number per axis.
    #[schemars(length(min = 1, max = 3))]
    pub origin: Vec<f64>,
    /// Side lengths of a cell (m), one number per axis.
    #[schemars(length(min = 1, max = 3), extend("items" = { "type": "number", "exclusiveMinimum": 0 }))]
    pub spacing: Vec<f64>,
    /// Number of cells, one number per axis.
    #[schemars(length(min = 1, max = 3), inner(range(min = 1)))]
    pub cells: Vec<usize>,
}

/// How long, and in what steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// When the run ends (s); it begins at 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end: f64,
    /// The time step (s), or `"auto"` for the longest accurate one times `safety`: that is the longest stable one, or a
    /// quarter of it where consolidation governs.
    pub step: Step,
    /// With `step = "auto"`: the fraction of the longest accurate step that is taken, in (0, 1].
    #[serde(default = "default_safety")]
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0))]
    pub safety: f64,
}

/// A time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// The longest accurate step times the safety factor, found anew at every output.
    Auto,
    /// Always this long (s).
    Seconds(f64),
}

/// Which variant of the method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Method {
    /// What carries the soil skeleton. `shape`, `velocity_update`, `pressure_quadrature` and `particles_per_cell` mean
    /// nothing to finite elements.
    pub solver: SolverKind,
    /// Shape function of the grid: `"linear"`, as in the paper; for ground that moves through cells `"gimp"`, which averages over
    /// the points' boxes as they were at the start, `"cpgimp"`, over boxes that stretch with the ground, or the B-splines
    /// `"bspline2"` and `"bspline3"`. All but `"linear"` need three cells along each axis.
    pub shape: String,
    /// How particle velocities follow the grid: `"mpm1"` by the nodal acceleration, `"mpm2"` by the nodal velocity, `"flip"` by a
    /// blend of the two, `"apic"` by the nodal velocity and how it varies around them, `"tpic"` by the nodal velocity and its
    /// gradient, `"xpic"` by the nodal acceleration, with a filter for what the grid cannot see, `"fmpm"` by the nodal velocity of a
    /// full mass matrix.
    pub velocity_update: String,
    /// The share of `"mpm1"` in `"flip"` (–); the rest is `"mpm2"`. Other updates do not use it.
    #[schemars(range(min = 0, max = 1))]
    pub flip_share: f64,
    /// The order m of `"xpic"` (–): 1 is `"mpm2"`, a larger one damps less. Other updates do not use it.
    #[schemars(range(min = 1))]
    pub xpic_order: NonZeroUsize,
    /// When in a step the stresses follow the strains: `"last"`, after the nodes have moved, as in the paper; `"first"`, before the forces;
    /// `"modified-last"`, after the new velocities of the points have been mapped to the nodes once more (MUSL).
    pub stress_order: String,
    /// The order k of `"fmpm"` (–): 1 is `"mpm2"`, a larger one damps less. Other updates do not use it.
    #[schemars(range(min = 1))]
    pub fmpm_order: NonZeroUsize,
    /// Where the volume and storage of a pressure cell are taken from.
    pub pressure_quadrature: PressureQuadrature,
    /// How the pressure of a cell comes back to its points, who take it along into other cells: `"cell"` as it is, as in the paper;
    /// `"increment"`, its change in the step; `"gradient"`, with the slope between the neighbours. For ground that moves through cells.
    pub particle_pressure: String,
    /// The Newmark parameters of the coupled solution.
    pub newmark: Newmark,
    /// Whether the acceleration of the mixture enters Darcy's law.
    pub fluid_inertia: bool,
    /// Stabilisation of the pressure (–): in a checkerboard the water is 1 + 16 times this number as compressible as elsewhere. 0, by
    /// default, is none; 30 is recommended for nearly impermeable ground whose cells show a checkerboard.
    #[schemars(range(min = 0))]
    pub pressure_stabilisation: f64,
    /// Damping, for problems of which only the state of rest is wanted. None by default.
    pub damping: Damping,
    /// Where the volume change of a material point comes from: `"cell-averaged"` against locking of nearly incompressible ground.
    pub volumetric_strain: VolumetricStrain,
}

/// What carries the soil skeleton.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SolverKind {
    /// Material points that move through the grid.
    #[default]
    Mpm,
    /// Finite elements fixed to the body, the paper's reference: every cell that a body fills is an element. Implicit in time;
    /// for small displacements and boxes between grid lines.
    Fem,
}

/// Where the volume and storage of a pressure cell are taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PressureQuadrature {
    /// The whole cell, as in the paper.
    #[default]
    Cell,
    /// The material points in the cell: better where a surface moves through cells, and with B-splines.
    MaterialPoints,
}

/// Where the volume change of a material point comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumetricStrain {
    /// The motion of the grid at the point itself, as in the paper.
    #[default]
    Pointwise,
    /// The mean over the points of its cell (B-bar).
    CellAveraged,
}

/// Damping of the nodes' motion. It changes the way to the state of rest, not the state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Damping {
    /// The part of the force out of balance, pore pressure included, that is turned against the motion of a node: from 0 to 1,
    /// 1 excluded; 0.7 is usual. For states of rest only: ground that falls freely falls too slowly.
    #[schemars(range(min = 0), extend("exclusiveMaximum" = 1))]
    pub local: f64,
    /// Resistance per mass and velocity (1/s): a mode of f Hz has the damping ratio of this number over 4πf.
    #[schemars(range(min = 0))]
    pub mass: f64,
    /// Viscosity of the skeleton, a time (s): a mode of f Hz has the damping ratio of π f times this number. It takes out noise of
    /// high frequency, also of waves, and shortens the longest stable step.
    #[schemars(range(min = 0))]
    pub stiffness: f64,
}

/// The Newmark parameters of the coupled solution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Newmark {
    /// Weight of the new acceleration in Newmark's displacement, in [0, 1]. It is given in the paper but enters none of its
    /// equations: particles move with the velocity, and it changes nothing. Finite elements use it.
    #[schemars(range(min = 0, max = 1))]
    pub beta: f64,
    /// Weight of the new acceleration in the velocity: 1 for material points, from 0.5 to 1 for finite elements.
    #[schemars(range(min = 0.5, max = 1))]
    pub gamma: f64,
}

/// The pore water.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density ρ^f (kg/m³); water: 1000.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density: f64,
    /// Bulk modulus K^f (Pa); water: 2.2e9.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub bulk_modulus: f64,
    /// Unit weight γ_w (N/m³), which turns conductivity into Darcy's law; water: 9800.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub unit_weight: f64,
}

/// A kind of ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// The constitutive law of the effective stress; `tsutsumi laws` lists them.
    pub law: String,
    /// The parameters of the law; `tsutsumi laws` tells which. Empty by default.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub parameters: toml::Table,
    /// Density of the mixture, soil and water together (kg/m³).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density: f64,
    /// Porosity n at the start, the volume of the pores over the whole, in (0, 1). Required if there is a `[fluid]`. It follows
    /// the volume: the grains are incompressible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub porosity: Option<f64>,
    /// Hydraulic conductivity k at the start (m/s). Required if there is a `[fluid]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub conductivity: Option<f64>,
    /// How the conductivity follows the porosity n, or the void ratio e = n/(1−n): `"constant"` not at all, `"xie-leo"` as (1+e)²,
    /// `"kozeny-carman"` as n³/(1−n)².
    #[serde(default = "default_conductivity_law")]
    pub conductivity_law: String,
}

/// A body of ground, filled with material points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// What loads and drainage call it. By default the name of its material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub name: Option<String>,
    /// The name of its material.
    pub material: String,
    /// The region it fills at the start.
    pub shape: BodyShape,
    /// Material points per grid cell, one number per axis: `[2, 2]`.
    #[schemars(length(min = 1, max = 3), inner(range(min = 1)))]
    pub particles_per_cell: Vec<usize>,
    /// Its state at the start: by default at rest, without stress and without water pressure.
    #[serde(default, skip_serializing_if = "Initial::is_default")]
    pub initial: Initial,
}

impl Body {
    /// What loads and drainage call the body: its own name, or that of its material.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.material)
    }
}

/// The region that a body fills at the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum BodyShape {
    /// A box along the axes: `{ box = { min = [0.0, 0.0], max = [1.0, 10.0] } }`.
    Box(BoxShape),
    /// A ball in 3-D, a disc in 2-D: `{ sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }`. The ends of the grid cut it: with
    /// the centre in a corner of the grid, an eighth of a ball remains.
    Sphere(SphereShape),
}

/// A ball in 3-D, a disc in 2-D.
///
/// Its points stand on the lattice of the grid. Those that the surface cuts stand in the centroid of what is inside, with its
/// volume; slivers are dropped and their volume is given to the others at the surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereShape {
    /// The centre (m), one number per axis. It may lie outside the grid.
    #[schemars(length(min = 2, max = 3))]
    pub center: Vec<f64>,
    /// The radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
    /// A box to which the body is confined. By default that of the grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<BoxShape>,
}

/// A box along the axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxShape {
    /// The lower corner (m), one number per axis.
    #[schemars(length(min = 1, max = 3))]
    pub min: Vec<f64>,
    /// The upper corner (m), one number per axis.
    #[schemars(length(min = 1, max = 3))]
    pub max: Vec<f64>,
}

/// The state of a body at the start.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// Velocity (m/s), one number per axis. At rest by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 3))]
    pub velocity: Option<Vec<f64>>,
    /// Level of the water table (m, on the last axis): hydrostatic pressure below, none above. No pressure by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_table: Option<f64>,
    /// Stress from the weight of the ground. None by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geostatic: Option<Geostatic>,
}

impl Initial {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Stress from the weight of the ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Geostatic {
    /// Level of the ground surface (m, on the last axis), where the stress is zero.
    pub surface: f64,
    /// Coefficient of earth pressure at rest: horizontal over vertical effective stress.
    #[schemars(range(min = 0))]
    pub k0: f64,
}

/// A roller, fixity or rigid plate: some components of the velocity are zero, or the same for all nodes, on a face of the
/// grid or in a region.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "oneOf" = [{ "required": ["face"] }, { "required": ["region"] }],
    "anyOf" = [{ "required": ["fix"] }, { "required": ["together"] }]
))]
pub struct Support {
    /// A face of the grid. Give this or `region`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<Face>,
    /// The nodes in a box. Give this or `face`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<BoxShape>,
    /// The axes along which nothing moves: `["x"]` on a vertical face is a roller. Give this or `together`, or both.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(min = 1))]
    pub fix: Vec<Axis>,
    /// The axes along which the nodes with ground move as one, with their common mass: `["y"]` on a horizontal surface is a
    /// rigid plate, smooth and without mass of its own. The nodes stay in space: the ground must not leave them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(min = 1))]
    pub together: Vec<Axis>,
}

/// A face of the grid, or the side of a body that looks the same way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Face {
    /// Where x is least.
    XMin,
    /// Where x is greatest.
    XMax,
    /// Where y is least: the base in 2-D.
    YMin,
    /// Where y is greatest: the top in 2-D.
    YMax,
    /// Where z is least: the base in 3-D.
    ZMin,
    /// Where z is greatest: the top in 3-D.
    ZMax,
}

impl Face {
    /// All faces, in the order of the axes.
    pub const ALL: [Self; 6] = [Self::XMin, Self::XMax, Self::YMin, Self::YMax, Self::ZMin, Self::ZMax];

    /// The axis the face is normal to.
    pub fn axis(self) -> Axis {
        match self {
            Self::XMin | Self::XMax => Axis::X,
            Self::YMin | Self::YMax => Axis::Y,
            Self::ZMin | Self::ZMax => Axis::Z,
        }
    }

    /// Whether the face lies where its coordinate is greatest.
    pub fn is_max(self) -> bool {
        matches!(self, Self::XMax | Self::YMax | Self::ZMax)
    }

    /// The word in the case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::XMin => "x-min",
            Self::XMax => "x-max",
            Self::YMin => "y-min",
            Self::YMax => "y-max",
            Self::ZMin => "z-min",
            Self::ZMax => "z-max",
        }
    }
}

/// A part of the surface of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Surface {
    /// Where x is least.
    XMin,
    /// Where x is greatest.
    XMax,
    /// Where y is least: the base in 2-D.
    YMin,
    /// Where y is greatest: the top in 2-D.
    YMax,
    /// Where z is least: the base in 3-D.
    ZMin,
    /// Where z is greatest: the top in 3-D.
    ZMax,
    /// All round the body, but where an end of the grid or the box of a sphere cuts it.
    All,
}

impl Surface {
    /// The face, if it is one.
    pub fn face(self) -> Option<Face> {
        match self {
            Self::XMin => Some(Face::XMin),
            Self::XMax => Some(Face::XMax),
            Self::YMin => Some(Face::YMin),
            Self::YMax => Some(Face::YMax),
            Self::ZMin => Some(Face::ZMin),
            Self::ZMax => Some(Face::ZMax),
            Self::All => None,
        }
    }
}

/// An axis of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The first axis; up in 1-D.
    X,
    /// The second axis; up in 2-D.
    Y,
    /// The third axis; up in 3-D.
    Z,
}

impl Axis {
    /// All axes, in order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Position in a vector, from 0.
    pub fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }

    /// The word in the case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}

/// A traction or a pressure on the surface of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["traction"] }, { "required": ["pressure"] }]))]
pub struct Load {
    /// The surface: `{ surface = "y-max", of = "soil" }`.
    pub on: BodySurface,
    /// Force per area (Pa), one number per axis; `[0.0, -50.0e3]` presses down in 2-D. Give this or `pressure`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 3))]
    pub traction: Option<Vec<f64>>,
    /// Pressure of a fluid outside (Pa), positive in compression. On a face it is a traction along the face's axis. On `"all"`
    /// it acts on the true surface all round, as it moves, and also where supports hold the body. Give this or `traction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
    /// The factor on the load over time: points `[[time (s), factor], …]`, linear in between, constant before and after; or one
    /// of the courses below. By default the full load from the start.
    #[serde(default)]
    pub history: History,
    /// What carries the load on a face.
    #[serde(default)]
    pub applied_to: AppliedTo,
}

/// How a load varies over time.
#[derive(Debug, Clone, PartialEq)]
pub enum History {
    /// Points (time in s, factor), linear in between, constant before and after.
    Points(Vec<[f64; 2]>),
    /// A smooth step.
    SmoothStep(SmoothStep),
    /// A sine.
    Sine(Sine),
}

/// A course of a load over time, by its name. Give one.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[schemars(extend("oneOf" = [{ "required": ["smooth-step"] }, { "required": ["sine"] }]))]
struct Course {
    /// A step from 0 to 1 without a kink, t/t_r − sin(2π t/t_r)/2π: `{ smooth-step = { duration = 0.1 } }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    smooth_step: Option<SmoothStep>,
    /// A sine, sin(ω t): `{ sine = { angular_frequency = 10.0 } }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sine: Option<Sine>,
}

/// A step from 0 to 1 without a kink.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SmoothStep {
    /// Its duration t_r (s), from time 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub duration: f64,
}

/// A sine from time 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Its angular frequency ω (rad/s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub angular_frequency: f64,
    /// Duration of the smooth step that puts it on (s). By default it starts at once.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub start: f64,
}

/// What carries a load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AppliedTo {
    /// The material points next to the surface, as in the paper.
    #[default]
    Particles,
    /// The true surface, half a particle above them.
    Surface,
}

/// A surface of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodySurface {
    /// Which way the surface looks. A sphere has only `"all"`.
    pub surface: Surface,
    /// The name of the body.
    pub of: String,
}

/// A surface through which water leaves freely.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drainage {
    /// The surface: `{ surface = "y-max", of = "soil" }`.
    pub on: BodySurface,
    /// Sides of the surface's cells that drain. By default the surface itself; not with `"all"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub sides: Option<Vec<Face>>,
}

/// The motion of the base, seen from the base: all displacements and velocities are relative to it, and the ground feels the opposite
/// acceleration. Saturated ground must be one cell wide along it: the share of the water beside walls is not followed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroundMotion {
    /// Acceleration of the base (m/s²), one number per axis.
    #[schemars(length(min = 1, max = 3))]
    pub acceleration: Vec<f64>,
    /// The factor on it over time, as for loads.
    #[serde(default)]
    pub history: History,
    /// When the shaking ends (s). By default it does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
}

/// A motion that is known exactly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExactMotion {
    /// Its name.
    pub solution: String,
    /// Its parameters.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub parameters: toml::Table,
}

/// A point whose history is recorded. Give one of the two points, or both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("anyOf" = [{ "required": ["pressure_at"] }, { "required": ["displacement_at"] }]))]
pub struct Probe {
    /// Its name, which heads its columns in `history.csv`: no dots, commas or blanks.
    #[schemars(regex(pattern = r"^[^.,\s]+$"))]
    pub name: String,
    /// Where the pore pressure is read (m): that of the cell which holds the point. The point stays in space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 3))]
    pub pressure_at: Option<Vec<f64>>,
    /// Where the material point starts whose displacement and velocity are followed (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 3))]
    pub displacement_at: Option<Vec<f64>>,
}

/// What is written, and how often.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Time between two rows of `history.csv` (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub every: f64,
    /// Time between two VTK files of the fields (s). By default as often as `every`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fields_every: Option<f64>,
    /// Whether figures are drawn at the end.
    #[serde(default = "default_figures")]
    pub figures: bool,
}

impl Output {
    /// Time between two VTK files of the fields (s).
    pub fn fields_every(&self) -> f64 {
        self.fields_every.unwrap_or(self.every)
    }
}

impl Default for Method {
    fn default() -> Self {
        Self {
            solver: SolverKind::default(),
            shape: "linear".to_owned(),
            velocity_update: "mpm1".to_owned(),
            flip_share: 0.95,
            // In `const`, so that a zero would be an error of the compiler.
            xpic_order: const { NonZeroUsize::new(5).unwrap() },
            fmpm_order: const { NonZeroUsize::new(4).unwrap() },
            pressure_quadrature: PressureQuadrature::default(),
            newmark: Newmark::default(),
            fluid_inertia: true,
            pressure_stabilisation: 0.0,
            damping: Damping::default(),
            volumetric_strain: VolumetricStrain::default(),
            stress_order: "last".into(),
            particle_pressure: "cell".into(),
        }
    }
}

impl Default for Newmark {
    fn default() -> Self {
        Self { beta: 0.5, gamma: 1.0 }
    }
}

fn default_conductivity_law() -> String {
    "constant".to_owned()
}

fn default_safety() -> f64 {
    0.9
}

impl Default for History {
    fn default() -> Self {
        Self::Points(vec![[0.0, 1.0]])
    }
}

fn default_figures() -> bool {
    true
}

impl Serialize for Step {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Seconds(seconds) => serializer.serialize_f64(*seconds),
        }
    }
}

impl<'de> Deserialize<'de> for Step {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StepVisitor)
    }
}

struct StepVisitor;

impl de::Visitor<'_> for StepVisitor {
    type Value = Step;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a number of seconds or the word \"auto\"")
    }

    fn visit_f64<E: de::Error>(self, seconds: f64) -> Result<Step, E> {
        Ok(Step::Seconds(seconds))
    }

    fn visit_i64<E: de::Error>(self, seconds: i64) -> Result<Step, E> {
        Ok(Step::Seconds(seconds as f64))
    }

    fn visit_u64<E: de::Error>(self, seconds: u64) -> Result<Step, E> {
        Ok(Step::Seconds(seconds as f64))
    }

    fn visit_str<E: de::Error>(self, word: &str) -> Result<Step, E> {
        match word {
            "auto" => Ok(Step::Auto),
            _ => Err(E::invalid_value(de::Unexpected::Str(word), &self)),
        }
    }
}

impl JsonSchema for Step {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Step".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number of seconds, or \"auto\".",
            "oneOf": [{ "type": "number", "exclusiveMinimum": 0 }, { "const": "auto" }]
        })
    }
}

impl Serialize for History {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut course = Course::default();
        match self {
            Self::Points(points) => return points.serialize(serializer),
            Self::SmoothStep(step) => course.smooth_step = Some(step.clone()),
            Self::Sine(sine) => course.sine = Some(sine.clone()),
        }
        course.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for History {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(HistoryVisitor)
    }
}

struct HistoryVisitor;

impl<'de> de::Visitor<'de> for HistoryVisitor {
    type Value = History;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("points [[time, factor], …] or a table such as { smooth-step = { duration = 1.0 } }")
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, points: A) -> Result<History, A::Error> {
        Vec::deserialize(de::value::SeqAccessDeserializer::new(points)).map(History::Points)
    }

    fn visit_map<A: de::MapAccess<'de>>(self, table: A) -> Result<History, A::Error> {
        let course = Course::deserialize(de::value::MapAccessDeserializer::new(table))?;
        match (course.smooth_step, course.sine) {
            (Some(step), None) => Ok(History::SmoothStep(step)),
            (None, Some(sine)) => Ok(History::Sine(sine)),
            _ => Err(de::Error::custom("must have just one of the keys `smooth-step`, `sine`")),
        }
    }
}

impl JsonSchema for History {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "History".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut points = generator.subschema_for::<Vec<[f64; 2]>>();
        points.insert("minItems".to_owned(), 1.into());
        json_schema!({
            "description": "Points [[time (s), factor], …], or a table with one course.",
            "oneOf": [points, generator.subschema_for::<Course>()]
        })
    }
}
