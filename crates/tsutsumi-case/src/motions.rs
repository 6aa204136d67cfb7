//! The exact motions that a case can name: the one place where a word in `exact_motion.solution` becomes a type.
//!
//! A new one is a type with the trait [`Motion`] and one line in [`motions`].

use std::fmt::Debug;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use tsutsumi::boundary::BodyForce;
use tsutsumi::tensor::Vector;
use tsutsumi_reference::elastic_column::{BarEnds, VibratingBar};
use tsutsumi_reference::heavy_column::HeavyColumn;
use tsutsumi_reference::vortex::Vortex;

use crate::registry::choose;
use crate::schema::{Axis, ExactMotion};
use crate::{CaseError, CaseSource, KeyPath};

/// A motion of the material that is known exactly. Points are named by where they start (m).
pub(crate) trait Motion<const D: usize>: Debug + Send + Sync {
    /// Displacement (m) at a time (s).
    fn displacement(&self, start: &Vector<D>, time: f64) -> Vector<D>;

    /// Velocity (m/s) at a time (s).
    fn velocity(&self, start: &Vector<D>, time: f64) -> Vector<D>;

    /// What has to act on the material beside gravity and loads.
    fn body_force(&self) -> Option<Arc<dyn BodyForce<D>>> {
        None
    }

    /// What errors are divided by.
    fn scales(&self) -> Scales;

    /// Kinetic, strain and potential energy together (J) at a time (s), where [`Scales::energy`] is given.
    fn energy(&self, _time: f64) -> f64 {
        f64::NAN
    }

    /// Why it cannot be had with these parameters.
    ///
    /// # Errors
    /// A parameter, or none where all of them together are wrong, and what is wrong.
    fn validate(&self) -> Result<(), (Option<&'static str>, String)>;
}

/// The sizes that errors of a motion are divided by; none where it has no such error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scales {
    /// Largest displacement (m).
    pub(crate) displacement: f64,
    /// Largest velocity (m/s).
    pub(crate) velocity: Option<f64>,
    /// Largest energy without that of being carried along (J).
    pub(crate) energy: Option<f64>,
}

/// A motion by its name, before its parameters are read.
type Named<const D: usize> = (&'static str, (Value, Open<D>));
type Open<const D: usize> = fn(&CaseSource, &KeyPath) -> Result<Arc<dyn Motion<D>>, CaseError>;

/// The exact motions by name.
fn motions<const D: usize>() -> Vec<Named<D>> {
    vec![
        named::<CarriedBar, D>("vibrating-bar"),
        named::<StandingColumn, D>("heavy-column"),
        named::<Vortex, D>("vortex"),
    ]
}

fn named<M: Motion<D> + DeserializeOwned + JsonSchema + 'static, const D: usize>(name: &'static str) -> Named<D> {
    (name, (schemars::schema_for!(M).to_value(), open::<M, D>))
}

fn open<M: Motion<D> + DeserializeOwned + 'static, const D: usize>(
    source: &CaseSource,
    place: &KeyPath,
) -> Result<Arc<dyn Motion<D>>, CaseError> {
    let motion: M = source.parse_at(place)?;
    motion.validate().map_err(|(parameter, why)| {
        let key = parameter.map_or_else(|| place.clone(), |parameter| place.clone().key(parameter));
        source.invalid(key.clone(), format!("`{key}` {why}"), "")
    })?;
    Ok(Arc::new(motion))
}

/// The names of the exact motions with the JSON schemas of their parameters.
pub(crate) fn motion_schemas() -> Vec<(&'static str, Value)> {
    motions::<2>().into_iter().map(|(name, (schema, _))| (name, schema)).collect()
}

/// Opens the motion that a case names.
pub(crate) fn open_motion<const D: usize>(
    source: &CaseSource,
    wanted: &ExactMotion,
) -> Result<Arc<dyn Motion<D>>, CaseError> {
    let place = KeyPath::root().key("exact_motion");
    let key = place.clone().key("solution");
    let (_, open) = choose(source, key, "exact motion", &wanted.solution, motions::<D>())?;
    open(source, &place.key("parameters"))
}

/// A standing axial wave in an elastic bar, at rest or carried along at a constant velocity.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CarriedBar {
    /// The bar. Strains must be small.
    bar: VibratingBar,
    /// The axis along which it lies.
    #[serde(default = "first_axis")]
    along: Axis,
    /// Where it begins along the axis (m).
    #[serde(default)]
    from: f64,
    /// The velocity (m/s) along the axis with which a bar with free ends is carried.
    #[serde(default)]
    carried: f64,
    /// Its cross-section (m² in 3-D, m in 2-D, 1 in 1-D), which the energy is taken over.
    #[serde(default = "one")]
    area: f64,
}

fn first_axis() -> Axis {
    Axis::X
}

fn one() -> f64 {
    1.0
}

impl CarriedBar {
    fn along<const D: usize>(&self, value: f64) -> Vector<D> {
        Vector::from_fn(|axis, _| if axis == self.along.index() { value } else { 0.0 })
    }

    fn place<const D: usize>(&self, start: &Vector<D>) -> f64 {
        start[self.along.index()] - self.from
    }
}

impl<const D: usize> Motion<D> for CarriedBar {
    fn displacement(&self, start: &Vector<D>, time: f64) -> Vector<D> {
        self.along(self.bar.displacement(self.place(start), time) + self.carried * time)
    }

    fn velocity(&self, start: &Vector<D>, time: f64) -> Vector<D> {
        self.along(self.bar.velocity(self.place(start), time) + self.carried)
    }

    fn scales(&self) -> Scales {
        Scales {
            displacement: self.bar.amplitude(),
            velocity: Some(self.bar.velocity),
            energy: Some(self.area * self.bar.energy()),
        }
    }

    fn energy(&self, _time: f64) -> f64 {
        let of_carrying = 0.5 * self.bar.density * self.bar.length * self.carried * self.carried;
        self.area * (self.bar.energy() + of_carrying)
    }

    fn validate(&self) -> Result<(), (Option<&'static str>, String)> {
        let VibratingBar { length, modulus, density, velocity, mode, ends } = self.bar;
        if ![length, modulus, density, velocity].into_iter().all(is_positive) || mode == 0 {
            return Err((Some("bar"), "must have positive numbers".to_owned()));
        }
        if self.along.index() >= D {
            return Err((Some("along"), format!("must be an axis of the {D} dimension(s) of the case")));
        }
        if !is_positive(self.area) {
            return Err((Some("area"), "must be greater than 0".to_owned()));
        }
        match self.carried != 0.0 && ends != BarEnds::FreeFree {
            true => Err((Some("carried"), "must be 0 for a bar that is held".to_owned())),
            false => Ok(()),
        }
    }
}

/// A column at rest under its own weight, pressed together at large strains. Only the state of rest is exact.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StandingColumn {
    /// The column.
    column: HeavyColumn,
    /// The level of its base (m, on the last axis).
    #[serde(default)]
    base: f64,
}

impl<const D: usize> Motion<D> for StandingColumn {
    fn displacement(&self, start: &Vector<D>, _time: f64) -> Vector<D> {
        let fall = self.column.displacement(start[D - 1] - self.base);
        Vector::from_fn(|axis, _| if axis == D - 1 { fall } else { 0.0 })
    }

    fn velocity(&self, _start: &Vector<D>, _time: f64) -> Vector<D> {
        Vector::zeros()
    }

    fn scales(&self) -> Scales {
        let displacement = self.column.displacement(self.column.height).abs();
        Scales { displacement, velocity: None, energy: None }
    }

    fn validate(&self) -> Result<(), (Option<&'static str>, String)> {
        let HeavyColumn { height, modulus, density, gravity } = self.column;
        match [height, modulus, density, gravity].into_iter().all(is_positive) {
            true => Ok(()),
            false => Err((Some("column"), "must have positive numbers".to_owned())),
        }
    }
}

/// In the plane of the first two axes.
impl<const D: usize> Motion<D> for Vortex {
    fn displacement(&self, start: &Vector<D>, time: f64) -> Vector<D> {
        in_space(Vortex::displacement(self, in_plane(start), time))
    }

    fn velocity(&self, start: &Vector<D>, time: f64) -> Vector<D> {
        in_space(Vortex::velocity(self, in_plane(start), time))
    }

    fn body_force(&self) -> Option<Arc<dyn BodyForce<D>>> {
        Some(Arc::new(*self))
    }

    fn scales(&self) -> Scales {
        Scales {
            displacement: self.largest_displacement(),
            velocity: Some(self.largest_velocity()),
            energy: Some(self.largest_energy()),
        }
    }

    fn energy(&self, time: f64) -> f64 {
        Vortex::energy(self, time)
    }

    fn validate(&self) -> Result<(), (Option<&'static str>, String)> {
        if D != 2 {
            return Err((None, format!("describe a motion in 2 dimensions, but the case has {D}")));
        }
        for (name, value) in [
            ("inner", self.inner),
            ("outer", self.outer),
            ("angle", self.angle),
            ("duration", self.duration),
            ("shear_modulus", self.shear_modulus),
            ("density", self.density),
        ] {
            if !is_positive(value) {
                return Err((Some(name), "must be greater than 0".to_owned()));
            }
        }
        match self.inner < self.outer {
            true => Ok(()),
            false => Err((Some("inner"), "must be less than `outer`".to_owned())),
        }
    }
}

fn in_plane<const D: usize>(point: &Vector<D>) -> [f64; 2] {
    std::array::from_fn(|axis| point.get(axis).copied().unwrap_or(0.0))
}

fn in_space<const D: usize>(vector: [f64; 2]) -> Vector<D> {
    Vector::from_fn(|axis, _| vector.get(axis).copied().unwrap_or(0.0))
}

fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}
