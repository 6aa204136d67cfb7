//! Laws of flow: grains by μ(I), Newtonian and Bingham fluids, against their own equations in simple shear and in changes of volume.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test reports by panicking")]

use tsutsumi::law::{Bingham, ConstitutiveLaw, Increment, LawError, MuI, Newtonian};
use tsutsumi::tensor::{Matrix3, Sym3};
use tsutsumi_testkit::check_law;
use tsutsumi_testkit::law::LawPath;

/// Glass beads after Jop, Forterre and Pouliquen (2006), recalled; the stiffness of the packing is a choice.
const BEADS: MuI = MuI {
    young: 1e8,
    poisson: 0.3,
    friction_static: 0.382,
    friction_limit: 0.643,
    inertial_number: 0.279,
    grain_diameter: 0.53e-3,
    grain_density: 2450.0,
};

const WATER: Newtonian = Newtonian { bulk_modulus: 2.2e9, viscosity: 1e-3, tait_exponent: 7.0, bears_tension: false };

const MUD: Bingham = Bingham {
    bulk_modulus: 1e6,
    shear_modulus: 1e5,
    yield_stress: 40.0,
    viscosity: 5.0,
    tait_exponent: 0.0,
    bears_tension: false,
};

/// Simple shear by γ: a change of ε_xy by ½ γ.
fn shear(by: f64) -> Sym3 {
    Sym3 { xy: 0.5 * by, ..Sym3::ZERO }
}

/// The shear stress (Pa) of a law after so many steps of simple shear at a rate (1/s), from an isotropic pressure (Pa).
fn steady<L: ConstitutiveLaw>(law: &L, pressure: f64, rate: f64, step: f64, count: usize) -> f64 {
    let start = Sym3::IDENTITY * -pressure;
    let (stress, _) = (0..count).fold((start, law.initial_state(start)), |(stress, state), _| {
        law.update_within(stress, state, shear(rate * step), step).unwrap()
    });
    // Shear changes neither volume nor pressure.
    assert!((stress.trace() / 3.0 + pressure).abs() <= 1e-12 * pressure);
    stress.xy
}

#[test]
fn the_contract_of_laws_is_kept() {
    check_law(&BEADS).unwrap();
    check_law(&WATER).unwrap();
    check_law(&Newtonian { tait_exponent: 0.0, bears_tension: true, ..WATER }).unwrap();
    check_law(&MUD).unwrap();
    // Steps of a millisecond: rates of 0.1 per second.
    let path = LawPath { duration: 1e-3, ..LawPath::default() };
    path.check(&BEADS).unwrap();
    path.check(&WATER).unwrap();
    path.check(&MUD).unwrap();
}

/// I = γ̇ d √(ρ_s/p) over five decades and steps over three: friction is μ(I), half way between its ends at I₀.
#[test]
fn grains_in_steady_shear_have_the_friction_of_their_rate() {
    let pressure = 1e3;
    for inertial_number in [1e-4, 1e-2, 0.279, 1.0, 10.0] {
        let rate = inertial_number / (BEADS.grain_diameter * (BEADS.grain_density / pressure).sqrt());
        let expected = 0.382 + (0.643 - 0.382) * inertial_number / (0.279 + inertial_number);
        for strain in [1e-5, 1e-4, 1e-2] {
            let friction = steady(&BEADS, pressure, rate, strain / rate, 2000) / pressure;
            assert!((friction / expected - 1.0).abs() < 1e-10, "I {inertial_number}: {friction}, not {expected}");
        }
        assert!((BEADS.friction(inertial_number) / expected - 1.0).abs() < 1e-15);
    }
    assert!((BEADS.friction(0.279) - 0.5125).abs() < 1e-15);
}

#[test]
fn grains_that_have_all_the_time_flow_at_the_friction_of_rest() {
    let start = Sym3::IDENTITY * -1e3;
    let (stress, state) = BEADS.update(start, BEADS.initial_state(start), shear(1e-3)).unwrap();
    assert!((stress.xy - 382.0).abs() < 1e-9);
    // γ less the elastic part μ_s p/G.
    let shear_modulus = 1e8 / 2.6;
    assert!((state.plastic_shear - (1e-3 - 382.0 / shear_modulus)).abs() < 1e-15);
}

/// Apart there is no stress; closed again, the pressure is that of the volume, and shear begins from nothing.
#[test]
fn grains_come_apart_and_meet_again() {
    let bulk_modulus = 1e8 / (3.0 * 0.4);
    let start = Sym3::IDENTITY * -1e3;
    let sheared = BEADS.update_within(start, BEADS.initial_state(start), shear(1e-2), 1e-2).unwrap();
    let mut now = BEADS.update_within(sheared.0, sheared.1, Sym3::IDENTITY * 1e-3, 1e-2).unwrap();
    assert_eq!(now.0, Sym3::ZERO);
    now = BEADS.update_within(now.0, now.1, Sym3::IDENTITY * -0.9e-3, 1e-2).unwrap();
    assert_eq!(now.0, Sym3::ZERO);
    now = BEADS.update_within(now.0, now.1, Sym3::IDENTITY * -0.2e-3, 1e-2).unwrap();
    let pressure = 1e3 + bulk_modulus * 3.0 * 0.1e-3;
    assert!((now.0.xx + pressure).abs() < 1e-9 * pressure && now.0.xy == 0.0);
}

#[test]
fn a_newtonian_fluid_in_shear_has_its_viscosity() {
    // Whatever the shear stress was before.
    let start = Sym3 { xy: 5.0, ..Sym3::IDENTITY * -1e4 };
    for (strain, duration) in [(1e-6, 1e-3), (0.3, 0.1), (2.0, 1e-4)] {
        let gradient = Matrix3::new(0.0, strain, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let motion = Increment::of(&gradient).within(duration);
        let (stress, _) = WATER.deform(start, WATER.initial_state(start), &motion).unwrap();
        assert!((stress.xy / (1e-3 * strain / duration) - 1.0).abs() < 1e-14);
        // The pressure comes back from its ln J of 5e-6, to 1e-16 of a ratio of 1.
        assert!((stress.xx + 1e4).abs() < 1e-15 * WATER.bulk_modulus);
    }
}

/// Tait at J = 0.99 by hand: 2.2e9/7 (0.99⁻⁷ − 1); and −K ln J. J is det F, stretched and sheared.
#[test]
fn the_pressure_of_a_fluid_is_that_of_its_volume() {
    let stretch = Matrix3::new(0.1, 0.05, 0.0, -0.02, -0.1, 0.0, 0.0, 0.0, 0.0);
    let volume = (Matrix3::identity() + stretch).determinant();
    assert!((volume - 0.991).abs() < 1e-15);
    let linear = Newtonian { tait_exponent: 0.0, ..WATER };
    for (law, expected) in [(WATER, 2.2e9 / 7.0 * (volume.powi(-7) - 1.0)), (linear, -2.2e9 * volume.ln())] {
        let (stress, state) = law.deform(Sym3::ZERO, law.initial_state(Sym3::ZERO), &Increment::of(&stretch)).unwrap();
        assert!((stress.pressure() / expected - 1.0).abs() < 1e-12, "{stress}");
        // And back: the same pressure at the start belongs to this volume.
        assert!((law.initial_state(stress).log_volume_ratio - state.log_volume_ratio).abs() < 1e-15);
    }
    let (stress, _) = MUD.update(Sym3::ZERO, MUD.initial_state(Sym3::ZERO), Sym3::IDENTITY * -0.01).unwrap();
    assert!((stress.xx + 0.03e6).abs() < 1e-9);
}

#[test]
fn a_fluid_comes_apart_unless_it_bears_tension() {
    let apart = |law: Newtonian| {
        let first = law.update(Sym3::ZERO, law.initial_state(Sym3::ZERO), Sym3::IDENTITY * 1e-3).unwrap();
        let (closing, _) = law.update(first.0, first.1, Sym3::IDENTITY * -0.5e-3).unwrap();
        (first.0.xx, closing.xx)
    };
    let linear = Newtonian { tait_exponent: 0.0, ..WATER };
    assert_eq!(apart(linear), (0.0, 0.0));
    let (open, closing) = apart(Newtonian { bears_tension: true, ..linear });
    // K ln J with J = 1.001³, then (1.001 · 0.9995)³.
    assert!((open / (2.2e9 * 3.0 * 1.001_f64.ln()) - 1.0).abs() < 1e-12);
    assert!((closing / (2.2e9 * 3.0 * (1.001 * 0.9995_f64).ln()) - 1.0).abs() < 1e-12);
}

#[test]
fn a_bingham_fluid_in_steady_shear_has_yield_stress_and_viscosity() {
    for rate in [1e-2, 1.0, 100.0] {
        for step in [1e-4, 1e-2, 1.0] {
            // The approach goes with (1 + G Δt/η)⁻ⁿ = 3⁻ⁿ or faster.
            let stress = steady(&MUD, 1e3, rate, step, 20_000);
            assert!((stress / (40.0 + 5.0 * rate) - 1.0).abs() < 1e-10, "{rate} {step}: {stress}");
        }
    }
}

/// From the yield stress on, τ = τ_y + η γ̇ (1 − exp(−G t/η)): halving the step halves the error of the implicit step.
#[test]
fn a_bingham_fluid_starts_to_flow_in_its_time() {
    let (rate, time) = (10.0, MUD.viscosity / MUD.shear_modulus);
    let at_yield = Sym3 { xy: MUD.yield_stress, ..Sym3::ZERO };
    let error = |count: usize| {
        let step = time / count as f64;
        let (stress, _) = (0..count).fold((at_yield, MUD.initial_state(at_yield)), |(stress, state), _| {
            MUD.update_within(stress, state, shear(rate * step), step).unwrap()
        });
        stress.xy - (40.0 + 50.0 * (1.0 - (-1.0_f64).exp()))
    };
    // Leading error of the implicit step after one relaxation time: −η γ̇ e⁻¹ / 2n.
    let leading = -50.0 * (-1.0_f64).exp() / 2.0 / 1000.0;
    assert!((error(1000) / leading - 1.0).abs() < 1e-2, "{}", error(1000) / leading);
    assert!((error(1000) / error(2000) - 2.0).abs() < 1e-2);
}

/// It relaxes to the yield stress and no further: mud at rest on a slope stays.
#[test]
fn a_bingham_fluid_at_rest_keeps_its_yield_stress() {
    let fast = Sym3 { xy: 300.0, ..Sym3::ZERO };
    let (rest, _) = (0..200).fold((fast, MUD.initial_state(fast)), |(stress, state), _| {
        MUD.update_within(stress, state, Sym3::ZERO, 1e-3).unwrap()
    });
    assert!((rest.xy - 40.0).abs() < 1e-10);
    let slow = Sym3 { xy: 39.0, ..Sym3::ZERO };
    let (kept, _) = MUD.update_within(slow, MUD.initial_state(slow), Sym3::ZERO, 1e6).unwrap();
    assert_eq!(kept.xy, 39.0);
}

#[test]
fn parameters_out_of_range_are_named() {
    fn name(outcome: Result<(), LawError>) -> &'static str {
        match outcome {
            Err(LawError::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(name(MuI { friction_limit: 0.3, ..BEADS }.validate()), "friction_limit");
    assert_eq!(name(MuI { grain_diameter: 0.0, ..BEADS }.validate()), "grain_diameter");
    assert_eq!(name(MuI { young: -1.0, ..BEADS }.validate()), "young");
    assert_eq!(name(Newtonian { viscosity: -1.0, ..WATER }.validate()), "viscosity");
    assert_eq!(name(Newtonian { bulk_modulus: f64::INFINITY, ..WATER }.validate()), "bulk_modulus");
    assert_eq!(name(Bingham { tait_exponent: f64::NAN, ..MUD }.validate()), "tait_exponent");
    assert_eq!(name(Bingham { shear_modulus: 0.0, ..MUD }.validate()), "shear_modulus");
    assert_eq!(name(Bingham { yield_stress: -1.0, ..MUD }.validate()), "yield_stress");
}
