//! Waves in a saturated column with inertia.

use schemars::JsonSchema;
use serde::Deserialize;
use tsutsumi_reference::laplace::Complex64;
use tsutsumi_reference::waves::{Column, Model, SmoothLoad};

use super::coupled::{SOUND, is_sound};
use super::{FINITE, POSITIVE, Refusal, Solution, is_positive, refuse_first, within};

/// The steady state of a saturated column on a rigid impermeable base under a load q sin ωt on its drained top.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HarmonicWave {
    /// The column.
    column: Column,
    /// How the water's inertia enters; `"up"` is what this program solves.
    model: Model,
    /// The amplitude q of the load (Pa), positive in compression.
    load: f64,
    /// The angular frequency ω (rad/s).
    angular_frequency: f64,
}

/// A saturated column on a rigid impermeable base under a smooth step of load on its drained top.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SmoothWave {
    /// The column.
    column: Column,
    /// How the water's inertia enters; `"up"` is what this program solves.
    model: Model,
    /// The load: q (t/d − sin(2πt/d)/2π) until the duration d, then q.
    load: SmoothLoad,
}

/// What a column gives.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum WaveQuantity {
    /// Settlement of the top (m), positive downwards.
    Settlement,
    /// Pore pressure (Pa) at this depth below the top (m).
    PressureAtDepth(f64),
}

impl WaveQuantity {
    fn depth(&self) -> f64 {
        match *self {
            WaveQuantity::Settlement => 0.0,
            WaveQuantity::PressureAtDepth(depth) => depth,
        }
    }

    fn is_within(&self, column: &Column) -> Result<(), String> {
        within("depth", self.depth(), column.height)
    }
}

fn refuse_column(column: &Column) -> Result<(), Refusal> {
    let is_good = is_sound(&column.ground)
        && is_positive(column.height)
        && is_positive(column.density)
        && is_positive(column.fluid_density);
    match is_good {
        true => Ok(()),
        false if !is_sound(&column.ground) => Err(Refusal { parameter: "column", expected: SOUND }),
        false => Err(Refusal { parameter: "column", expected: "one with a positive height and positive densities" }),
    }
}

impl Solution for HarmonicWave {
    type Quantity = WaveQuantity;

    fn validate(&self) -> Result<(), Refusal> {
        refuse_column(&self.column)?;
        refuse_first(&[
            ("load", self.load.is_finite(), FINITE),
            ("angular_frequency", is_positive(self.angular_frequency), POSITIVE),
        ])
    }

    fn accepts(&self, quantity: &WaveQuantity) -> Result<(), String> {
        quantity.is_within(&self.column)
    }

    fn values(&self, quantity: &WaveQuantity, times: &[f64]) -> Vec<f64> {
        let all = self.column.harmonic(self.model, self.load, self.angular_frequency, quantity.depth());
        let amplitude = match quantity {
            WaveQuantity::Settlement => all.displacement,
            WaveQuantity::PressureAtDepth(_) => all.pressure,
        };
        let value = |&time: &f64| (amplitude * Complex64::cis(self.angular_frequency * time)).im;
        times.iter().map(value).collect()
    }
}

impl Solution for SmoothWave {
    type Quantity = WaveQuantity;

    fn validate(&self) -> Result<(), Refusal> {
        refuse_column(&self.column)?;
        let is_good = self.load.load.is_finite() && is_positive(self.load.duration);
        refuse_first(&[("load", is_good, "finite, with a duration greater than 0")])
    }

    fn accepts(&self, quantity: &WaveQuantity) -> Result<(), String> {
        quantity.is_within(&self.column)
    }

    fn values(&self, quantity: &WaveQuantity, times: &[f64]) -> Vec<f64> {
        let motion = self.column.smooth(self.model, self.load, quantity.depth(), times);
        match quantity {
            WaveQuantity::Settlement => motion.iter().map(|at| at.displacement).collect(),
            WaveQuantity::PressureAtDepth(_) => motion.iter().map(|at| at.pressure).collect(),
        }
    }
}
