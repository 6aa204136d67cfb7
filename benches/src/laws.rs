//! The laws that are measured, with parameters.

use tsutsumi::law::{LinearElastic, ModifiedCamClay, Sanisand};

/// Linear elastic ground of the compared block.
pub const LINEAR_ELASTIC: LinearElastic = LinearElastic { young: 1e7, poisson: 0.3 };

/// Soft clay, normally consolidated (chosen).
pub const CLAY: ModifiedCamClay = ModifiedCamClay {
    critical_state_ratio: 1.2,
    lambda: 0.2,
    kappa: 0.05,
    poisson: Some(0.3),
    shear_modulus: None,
    void_ratio: 1.0,
    preconsolidation_pressure: 0.0,
    overconsolidation_ratio: 1.0,
};

/// Toyoura sand, `materials/toyoura-sanisand.toml`.
pub const TOYOURA: Sanisand = Sanisand {
    void_ratio: 0.8,
    atmospheric_pressure: 101e3,
    shear_modulus_number: 125.0,
    poisson: 0.05,
    critical_stress_ratio: 1.25,
    extension_ratio: 0.712,
    critical_void_ratio: 0.934,
    critical_slope: 0.019,
    critical_exponent: 0.7,
    yield_opening: 0.01,
    hardening_number: 7.05,
    hardening_void_ratio: 0.968,
    bounding_exponent: 1.1,
    dilatancy_number: 0.704,
    dilatancy_exponent: 3.5,
    fabric_limit: 4.0,
    fabric_rate: 600.0,
    residual_pressure: 1000.0,
    sub_step_tolerance: 1e-4,
    smallest_sub_step: 1e-6,
};
