//! Consolidation in one dimension, at small and at large strains.

use schemars::JsonSchema;
use serde::Deserialize;
use tsutsumi_reference::consolidation::{Layer, Ramp};
use tsutsumi_reference::large_strain::LargeStrainLayer;

use super::{FINITE, NOT_NEGATIVE, POSITIVE, Refusal, Solution, is_not_negative, is_positive, refuse_first, within};

/// One-dimensional consolidation of a layer on an impermeable rigid base, drained and loaded at its top.
///
/// c_v = (k/γ_w) / (1/E_oed + n/K^f); see [`Layer`] for equations and source.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Consolidation {
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
pub(crate) enum ConsolidationQuantity {
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
        refuse_first(&[
            ("height", is_positive(self.height), POSITIVE),
            ("modulus", is_positive(self.modulus), POSITIVE),
            ("conductivity", is_positive(self.conductivity), POSITIVE),
            ("unit_weight", is_positive(self.unit_weight), POSITIVE),
            ("porosity", self.porosity > 0.0 && self.porosity < 1.0, "between 0 and 1"),
            ("bulk_modulus", self.bulk_modulus > 0.0, "greater than 0"),
            ("load", self.load.is_finite(), FINITE),
            ("duration", is_not_negative(self.duration), NOT_NEGATIVE),
        ])
    }

    fn accepts(&self, quantity: &ConsolidationQuantity) -> Result<(), String> {
        match quantity {
            ConsolidationQuantity::Settlement => Ok(()),
            ConsolidationQuantity::PressureAtDepth(depth) => within("depth", *depth, self.height),
        }
    }

    fn values(&self, quantity: &ConsolidationQuantity, times: &[f64]) -> Vec<f64> {
        let (layer, ramp) = (self.layer(), self.ramp());
        let value = |&time: &f64| match quantity {
            ConsolidationQuantity::Settlement => layer.settlement(ramp, time),
            ConsolidationQuantity::PressureAtDepth(depth) => layer.pressure(ramp, *depth, time),
        };
        times.iter().map(value).collect()
    }
}

/// What consolidation at large strains gives.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum LargeStrainQuantity {
    /// Settlement of the top (m), positive downwards.
    Settlement,
    /// Excess pore pressure (Pa) of the material that was at this depth below the top (m) before the load.
    PressureAtDepth(f64),
}

impl Solution for LargeStrainLayer {
    type Quantity = LargeStrainQuantity;

    fn validate(&self) -> Result<(), Refusal> {
        refuse_first(&[
            ("height", is_positive(self.height), POSITIVE),
            ("modulus", is_positive(self.modulus), POSITIVE),
            ("conductivity", is_positive(self.conductivity), POSITIVE),
            ("unit_weight", is_positive(self.unit_weight), POSITIVE),
            ("load", is_positive(self.load), POSITIVE),
        ])
    }

    fn accepts(&self, quantity: &LargeStrainQuantity) -> Result<(), String> {
        match quantity {
            LargeStrainQuantity::Settlement => Ok(()),
            LargeStrainQuantity::PressureAtDepth(depth) => within("depth", *depth, self.height),
        }
    }

    fn values(&self, quantity: &LargeStrainQuantity, times: &[f64]) -> Vec<f64> {
        let value = |&time: &f64| match quantity {
            LargeStrainQuantity::Settlement => LargeStrainLayer::settlement(self, 0.0, time),
            LargeStrainQuantity::PressureAtDepth(depth) => self.pressure(*depth, time),
        };
        times.iter().map(value).collect()
    }
}
