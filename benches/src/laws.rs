//! The laws that are measured, with parameters.

use tsutsumi::law::{LinearElastic, ModifiedCamClay};
use tsutsumi_testkit::soils::MORIKAWA_ASAI_CLAY;

/// Linear elastic ground of the compared block.
pub const LINEAR_ELASTIC: LinearElastic = LinearElastic { young: 1e7, poisson: 0.3 };

/// Soft clay, normally consolidated.
pub const CLAY: ModifiedCamClay = ModifiedCamClay { preconsolidation_pressure: 0.0, ..MORIKAWA_ASAI_CLAY };
