//! Elasticity that follows the pressure: derivative of its energy, powers of its moduli, closed paths.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::law::{ConstitutiveLaw, LawError, PressureElastic};
use tsutsumi::tensor::Sym3;
use tsutsumi_testkit::law::{LawPath, check_law};
use tsutsumi_testkit::noise::Noise;

const SAND: PressureElastic =
    PressureElastic { bulk_modulus: 60e6, shear_modulus: 45e6, reference_pressure: 100e3, exponent: 0.5 };

const SHEARED: Sym3 = Sym3 { xx: -60e3, yy: -90e3, zz: -120e3, xy: 20e3, yz: -10e3, zx: 5e3 };

fn with(exponent: f64) -> PressureElastic {
    PressureElastic { exponent, ..SAND }
}

fn after(law: &PressureElastic, stress: Sym3, strain: Sym3) -> Sym3 {
    law.update(stress, (), strain).unwrap().0
}

#[test]
fn the_law_keeps_the_contract() {
    for exponent in [0.0, 0.3, 0.5, 2.0 / 3.0, 0.9] {
        check_law(&with(exponent)).unwrap();
        LawPath { stress: SHEARED, strain: 5e-5, increments: 60, ..LawPath::default() }.check(&with(exponent)).unwrap();
    }
}

/// σ' = ∂W/∂ε in every direction: central differences over strains of 1e-7, of stresses that change by 1e-4 over them.
#[test]
fn the_stress_is_the_derivative_of_the_energy() {
    let mut noise = Noise::new(3);
    for exponent in [0.0, 0.3, 0.5, 0.9] {
        let law = with(exponent);
        for _ in 0..50 {
            let strain = noise.tensor() * 1e-7;
            let [forward, backward] = [strain, -strain].map(|strain| law.energy(after(&law, SHEARED, strain)));
            let power = SHEARED.double_dot(strain);
            let expected = 0.5 * (forward - backward);
            assert!((power - expected).abs() < 1e-6 * SHEARED.norm() * 1e-7, "{exponent}: {power} {expected}");
        }
    }
}

/// K = K_ref (p/p_ref)^m and G = G_ref (p/p_ref)^m where there is no shear; differences over strains of 1e-9.
#[test]
fn moduli_follow_a_power_of_the_pressure() {
    for exponent in [0.0, 0.3, 0.5, 0.9] {
        for pressure in [1e3, 100e3, 2e6] {
            let (law, stress) = (with(exponent), Sym3::IDENTITY * -pressure);
            let factor = (pressure / 100e3).powf(exponent);
            let [denser, looser] = [-1e-9, 1e-9].map(|strain| after(&law, stress, Sym3::IDENTITY * strain));
            let bulk_modulus = (looser.xx - denser.xx) / 6e-9;
            assert!((bulk_modulus / (60e6 * factor) - 1.0).abs() < 1e-5, "{exponent} {pressure}: {bulk_modulus}");
            let shear_modulus = after(&law, stress, Sym3 { xy: 1e-9, ..Sym3::ZERO }).xy / 2e-9;
            assert!((shear_modulus / (45e6 * factor) - 1.0).abs() < 1e-5, "{exponent} {pressure}: {shear_modulus}");
        }
    }
}

/// Isotropic compression integrated by hand: (p/p_ref)^(1−m) grows by k (1−m) ε_v, in one step.
#[test]
fn isotropic_compression_has_its_closed_form() {
    for exponent in [0.0, 0.3, 0.5, 0.9] {
        let stress = after(&with(exponent), Sym3::IDENTITY * -50e3, Sym3::IDENTITY * (-2e-3 / 3.0));
        let power = 0.5_f64.powf(1.0 - exponent) + 600.0 * (1.0 - exponent) * 2e-3;
        let expected = 100e3 * power.powf(1.0 / (1.0 - exponent));
        assert!((stress.xx / -expected - 1.0).abs() < 1e-12, "{exponent}: {stress} {expected}");
    }
}

/// Round a rectangle of strains and back to the start, in few steps or many: the stress returns, and with it the energy. Trapezoids sum the work to second
/// order in the step.
#[test]
fn closed_paths_lose_no_work() {
    let (volume, shear) = (Sym3::IDENTITY * -2e-4, Sym3 { xy: 3e-4, ..Sym3::diagonal(1e-4, 1e-4, -2e-4) });
    let work = |steps: u32| {
        let (mut stress, mut work) = (SHEARED, 0.0);
        for side in [shear, volume, -shear, -volume] {
            let strain = side * (1.0 / f64::from(steps));
            for _ in 0..steps {
                let new = after(&SAND, stress, strain);
                work += 0.5 * (stress + new).double_dot(strain);
                stress = new;
            }
        }
        assert!((stress - SHEARED).norm() < 1e-10 * SHEARED.norm());
        work
    };
    let (coarse, fine) = (work(10), work(100));
    assert!(fine.abs() < 1.1e-2 * coarse.abs() && fine.abs() < 1e-4, "{coarse} {fine}");
}

#[test]
fn tension_is_refused() {
    let opened = SAND.update(Sym3::IDENTITY * -1e3, (), Sym3::IDENTITY * 1e-3).unwrap_err();
    let slack = SAND.update(Sym3::ZERO, (), Sym3::ZERO).unwrap_err();
    for error in [opened, slack] {
        assert!(matches!(error, LawError::NoCompression { pressure } if pressure <= 0.0), "{error}");
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let error = with(1.0).validate().unwrap_err();
    assert!(matches!(error, LawError::Parameter { name: "exponent", .. }));
    assert!(PressureElastic { reference_pressure: 0.0, ..SAND }.validate().is_err());
}
