//! Drained bodies in which the pressure rises before it falls: Mandel, de Leeuw, Cryer.

use schemars::JsonSchema;
use serde::Deserialize;
use tsutsumi_reference::cryer::Cryer;
use tsutsumi_reference::de_leeuw::DeLeeuw;
use tsutsumi_reference::ground::Ground;
use tsutsumi_reference::mandel::Mandel;

use super::{FINITE, NOT_NEGATIVE, POSITIVE, Refusal, Solution, is_not_negative, is_positive, refuse_first, within};

/// What Mandel's problem gives.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum MandelQuantity {
    /// Settlement of the plate against the plane of symmetry (m), positive downwards.
    Settlement,
    /// Displacement of the drained side (m), positive outwards.
    SideDisplacement,
    /// Pore pressure (Pa) at this distance from the middle (m).
    PressureAt(f64),
}

/// What a ball or cylinder gives.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum RadialQuantity {
    /// Pore pressure (Pa) at this distance from the centre (m).
    PressureAt(f64),
    /// Displacement (m), positive outwards, at this distance from the centre (m).
    DisplacementAt(f64),
}

pub(super) fn is_sound(ground: &Ground) -> bool {
    is_positive(ground.young)
        && ground.poisson > -1.0
        && ground.poisson < 0.5
        && is_positive(ground.conductivity)
        && is_positive(ground.unit_weight)
        && ground.porosity > 0.0
        && ground.porosity < 1.0
        && ground.fluid_modulus > 0.0
}

pub(super) const SOUND: &str = "a ground with positive moduli, conductivity and unit weight, Poisson's ratio above -1 and below 0.5, and a \
                     porosity between 0 and 1";

impl Solution for Mandel {
    type Quantity = MandelQuantity;

    fn validate(&self) -> Result<(), Refusal> {
        refuse_first(&[
            ("ground", is_sound(&self.ground), SOUND),
            ("half_width", is_positive(self.half_width), POSITIVE),
            ("half_height", is_positive(self.half_height), POSITIVE),
            ("force", self.force.is_finite(), FINITE),
            ("ramp", is_not_negative(self.ramp), NOT_NEGATIVE),
        ])
    }

    fn accepts(&self, quantity: &MandelQuantity) -> Result<(), String> {
        match quantity {
            MandelQuantity::PressureAt(distance) => within("distance", *distance, self.half_width),
            MandelQuantity::Settlement | MandelQuantity::SideDisplacement => Ok(()),
        }
    }

    fn values(&self, quantity: &MandelQuantity, times: &[f64]) -> Vec<f64> {
        let value = |&time: &f64| match quantity {
            MandelQuantity::Settlement => -self.vertical_displacement(self.half_height, time),
            MandelQuantity::SideDisplacement => self.horizontal_displacement(self.half_width, time),
            MandelQuantity::PressureAt(distance) => self.pressure(*distance, time),
        };
        times.iter().map(value).collect()
    }
}

/// A radial problem: the cylinder and the ball have the same parameters and quantities.
macro_rules! radial {
    ($problem:ty) => {
        impl Solution for $problem {
            type Quantity = RadialQuantity;

            fn validate(&self) -> Result<(), Refusal> {
                refuse_first(&[
                    ("ground", is_sound(&self.ground), SOUND),
                    ("radius", is_positive(self.radius), POSITIVE),
                    ("load", self.load.is_finite(), FINITE),
                    ("ramp", is_not_negative(self.ramp), NOT_NEGATIVE),
                ])
            }

            fn accepts(&self, quantity: &RadialQuantity) -> Result<(), String> {
                let (RadialQuantity::PressureAt(distance) | RadialQuantity::DisplacementAt(distance)) = quantity;
                within("distance", *distance, self.radius)
            }

            fn values(&self, quantity: &RadialQuantity, times: &[f64]) -> Vec<f64> {
                let value = |&time: &f64| match quantity {
                    RadialQuantity::PressureAt(distance) => self.pressure(*distance, time),
                    RadialQuantity::DisplacementAt(distance) => self.displacement(*distance, time),
                };
                times.iter().map(value).collect()
            }
        }
    };
}

radial!(DeLeeuw);
radial!(Cryer);
