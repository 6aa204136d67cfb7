//! Soils with the parameters of their laws, each with its source, for tests and benches that want a soil that somebody has used.

use tsutsumi::law::{ModifiedCamClay, OkaCyclic, Sanisand};

/// Clay, normally consolidated up to 600 kPa.
///
/// # Reference
///
/// Morikawa and Asai, their example of modified Cam-Clay, with a porosity of 0.5.
pub const MORIKAWA_ASAI_CLAY: ModifiedCamClay = ModifiedCamClay {
    critical_state_ratio: 1.2,
    lambda: 0.2,
    kappa: 0.05,
    poisson: Some(0.3),
    shear_modulus: None,
    void_ratio: 1.0,
    preconsolidation_pressure: 600e3,
    overconsolidation_ratio: 1.0,
};

/// Toyoura sand.
///
/// # Reference
///
/// Dafalias and Manzari (2004), J. Eng. Mech. 130(6), 622–634, as read in OpenSees; the paper was not at hand. The void ratio,
/// the atmospheric pressure and what follows `fabric_rate` are ours.
pub const TOYOURA_SAND: Sanisand = Sanisand {
    void_ratio: 0.8,
    atmospheric_pressure: 100e3,
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

/// Set A of the book's page on the cyclic law after Oka et al.: no named sand.
///
/// # Reference
///
/// Illustrative: magnitudes as recalled from applications of the law.
pub const CYCLIC_SAND: OkaCyclic = OkaCyclic {
    void_ratio: 0.8,
    compression_index: 0.02,
    swelling_index: 0.002,
    shear_modulus_ratio: 900.0,
    phase_transformation_ratio: 0.91,
    failure_ratio: 1.23,
    hardening: 2000.0,
    hardening_least: 20.0,
    hardening_decay: 1000.0,
    plastic_reference_strain: 0.005,
    elastic_reference_strain: 0.01,
    dilatancy: 2.0,
    dilatancy_exponent: 1.5,
    overconsolidation_ratio: 1.2,
    elastic_radius: 0.005,
    least_pressure: 490.0,
};
