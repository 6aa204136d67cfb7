//! Von Mises, Drucker–Prager and Mohr–Coulomb: return maps against projections that know nothing of regions, strengths against closed forms.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test reports by panicking")]

use tsutsumi::law::{
    ClosedPathWork, Cone, ConstitutiveLaw, DruckerPrager, FrictionalState, LawError, LinearElastic, MohrCoulomb,
    VonMises,
};
use tsutsumi::tensor::{Matrix3, Sym3, Vector, rotation};
use tsutsumi_testkit::law::{LawPath, LawViolation, check_law};
use tsutsumi_testkit::noise::Noise;

const SAND: MohrCoulomb = MohrCoulomb {
    young: 20e6,
    poisson: 0.2,
    friction_angle_deg: 33.0,
    cohesion: 2e3,
    dilatancy_angle_deg: 5.0,
    tensile_strength: None,
    friction_angle_residual_deg: None,
    cohesion_residual: None,
    softening_strain: 0.0,
};

const CONE: DruckerPrager = DruckerPrager {
    young: 20e6,
    poisson: 0.2,
    friction_angle_deg: 33.0,
    cohesion: 2e3,
    dilatancy_angle_deg: 5.0,
    cone: Cone::Compression,
    tensile_strength: None,
    friction_angle_residual_deg: None,
    cohesion_residual: None,
    softening_strain: 0.0,
};

const CLAY: VonMises =
    VonMises { young: 10e6, poisson: 0.3, yield_stress: 100e3, hardening: 0.0, yield_stress_residual: 0.0 };

const NUM_TRIALS: usize = 10_000;

fn elastic_strain(elastic: &LinearElastic, stress: Sym3) -> Sym3 {
    Sym3::IDENTITY * (stress.trace() / (9.0 * elastic.bulk_modulus()))
        + stress.deviator() * (0.5 / elastic.shear_modulus())
}

/// √J₂ (Pa).
fn shear(stress: Sym3) -> f64 {
    stress.deviator().norm() * 0.5_f64.sqrt()
}

fn between(noise: &mut Noise, low: f64, high: f64) -> f64 {
    low + 0.5 * (1.0 + noise.number()) * (high - low)
}

/// A rotation about any axis, by a hundred steps.
fn any_rotation(noise: &mut Noise) -> Matrix3 {
    rotation(&(noise.vector::<3>() * 0.8))
}

// ---------------------------------------------------------------- contract

#[test]
fn the_laws_keep_the_contract() {
    let sheared = Sym3 { xx: -60e3, yy: -90e3, zz: -120e3, xy: 20e3, yz: -10e3, zx: 5e3 };
    let far = LawPath { stress: sheared, strain: 5e-3, increments: 80, ..LawPath::default() };
    for hardening in [0.0, 1e6, -1e6] {
        let clay = VonMises { hardening, yield_stress_residual: 60e3, ..CLAY };
        check_law(&clay).unwrap();
        far.check(&clay).unwrap();
    }
    for (dilatancy_angle_deg, tensile_strength, softening_strain) in
        [(0.0, None, 0.0), (33.0, None, 0.0), (5.0, Some(1e3), 0.0), (5.0, Some(0.0), 0.05), (10.0, None, 0.02)]
    {
        let softens = softening_strain > 0.0;
        let friction_angle_residual_deg = softens.then_some(25.0);
        let cohesion_residual = softens.then_some(500.0);
        for cone in [Cone::Compression, Cone::Extension, Cone::PlaneStrain] {
            let law = DruckerPrager {
                dilatancy_angle_deg,
                cone,
                tensile_strength,
                friction_angle_residual_deg,
                cohesion_residual,
                softening_strain,
                ..CONE
            };
            check_law(&law).unwrap();
            far.check(&law).unwrap();
        }
        let law = MohrCoulomb {
            dilatancy_angle_deg,
            tensile_strength,
            friction_angle_residual_deg,
            cohesion_residual,
            softening_strain,
            ..SAND
        };
        check_law(&law).unwrap();
        far.check(&law).unwrap();
    }
    let tresca = MohrCoulomb { friction_angle_deg: 0.0, dilatancy_angle_deg: 0.0, cohesion: 60e3, ..SAND };
    check_law(&tresca).unwrap();
    far.check(&MohrCoulomb { tensile_strength: Some(10e3), ..tresca }).unwrap();
}

/// Not even on edges, in softening, or while axes are searched.
#[test]
fn updates_do_not_allocate() {
    fn allocations<L: ConstitutiveLaw>(law: &L, stress: Sym3) -> u64 {
        let info = allocation_counter::measure(|| {
            law.update(stress, law.initial_state(stress), Sym3::ZERO).unwrap();
        });
        info.count_total
    }
    let mut noise = Noise::new(17);
    for _ in 0..1000 {
        let stress = random_stress(&mut noise);
        let softening = (Some(0.0), Some(500.0), 0.02);
        let (friction_angle_residual_deg, cohesion_residual, softening_strain) = softening;
        let sand = MohrCoulomb { friction_angle_residual_deg, cohesion_residual, softening_strain, ..SAND };
        let cone = DruckerPrager { friction_angle_residual_deg, cohesion_residual, softening_strain, ..CONE };
        assert_eq!(allocations(&sand, stress) + allocations(&cone, stress) + allocations(&CLAY, stress), 0);
    }
}

/// Flow along the normal promises never to give work back. The check would not let flow that opens less pass with that promise.
#[test]
fn only_associated_flow_promises_work() {
    let associated = MohrCoulomb { dilatancy_angle_deg: 33.0, ..SAND };
    assert_eq!(associated.closed_path_work(), ClosedPathWork::NotNegative);
    assert_eq!(DruckerPrager { dilatancy_angle_deg: 33.0, ..CONE }.closed_path_work(), ClosedPathWork::NotNegative);
    assert_eq!(SAND.closed_path_work(), ClosedPathWork::Any);
    let softening = MohrCoulomb { cohesion_residual: Some(0.0), softening_strain: 0.02, ..associated };
    assert_eq!(softening.closed_path_work(), ClosedPathWork::Any);
    for dilatancy_angle_deg in [33.0, 5.0] {
        let law = Associated(MohrCoulomb { dilatancy_angle_deg, ..SAND });
        let far = LawPath { strain: 5e-3, increments: 80, ..LawPath::default() };
        let outcome = far.check(&law);
        let wins = matches!(outcome, Err(LawViolation::ClosedPath { work: ..0.0, .. }));
        assert_eq!(wins, dilatancy_angle_deg < 33.0, "{outcome:?}");
    }
}

/// A law that promises more than it may.
struct Associated(MohrCoulomb);

impl ConstitutiveLaw for Associated {
    type State = FrictionalState;

    fn update(&self, stress: Sym3, state: FrictionalState, strain: Sym3) -> Result<(Sym3, FrictionalState), LawError> {
        self.0.update(stress, state, strain)
    }

    fn p_wave_modulus(&self, stress: Sym3, state: &FrictionalState) -> f64 {
        self.0.p_wave_modulus(stress, state)
    }

    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::NotNegative
    }
}

// ---------------------------------------------------------------- Mohr and Coulomb by brute force

type Three = Vector<3>;

/// normal · σ ≤ strength in principal stresses, in any order; plastic strain along the flow.
struct Plane {
    normal: Three,
    flow: Three,
    strength: f64,
}

/// The six planes of Mohr and Coulomb and the three of the cut-off.
fn planes(law: &MohrCoulomb) -> Vec<Plane> {
    let (sin, cos) = law.friction_angle_deg.to_radians().sin_cos();
    let sin_psi = law.dilatancy_angle_deg.to_radians().sin();
    let mut planes = Vec::new();
    for i in 0..3 {
        for j in (0..3).filter(|&j| j != i) {
            let direction = |sin: f64| {
                let mut vector = Three::zeros();
                (vector[i], vector[j]) = (1.0 + sin, sin - 1.0);
                vector
            };
            planes.push(Plane { normal: direction(sin), flow: direction(sin_psi), strength: 2.0 * law.cohesion * cos });
        }
        if let Some(strength) = law.tensile_strength {
            let direction = Three::ith(i, 1.0);
            planes.push(Plane { normal: direction, flow: direction, strength });
        }
    }
    planes
}

fn stiffness(elastic: &LinearElastic) -> Matrix3 {
    Matrix3::identity() * (2.0 * elastic.shear_modulus()) + Matrix3::repeat(elastic.lame())
}

/// The point of the polyhedron nearest to `trial` in the energy norm, by Hildreth's method: one multiplier after the other, again and again.
fn nearest(trial: Three, planes: &[Plane], stiffness: &Matrix3) -> Three {
    let mut multipliers = vec![0.0; planes.len()];
    let mut stress = trial;
    for _ in 0..200_000 {
        let mut largest_change = 0.0_f64;
        for (plane, multiplier) in planes.iter().zip(&mut multipliers) {
            let push = stiffness * plane.normal;
            let excess = plane.normal.dot(&stress) - plane.strength;
            let new = f64::max(0.0, *multiplier + excess / plane.normal.dot(&push));
            stress -= push * (new - *multiplier);
            largest_change = largest_change.max((new - *multiplier).abs() * push.norm());
            *multiplier = new;
        }
        if largest_change < 1e-12 * trial.norm() {
            return stress;
        }
    }
    panic!("the projection did not converge");
}

fn random_law(noise: &mut Noise, associated: bool) -> MohrCoulomb {
    let friction_angle_deg = between(noise, 0.0, 50.0);
    let share = match associated {
        true => 1.0,
        // A quarter of the laws without any dilatancy.
        false => between(noise, -0.33, 1.0).max(0.0),
    };
    let cohesion = between(noise, 1e3, 20e3);
    let cut_off = noise.number() > 0.0;
    MohrCoulomb {
        poisson: between(noise, 0.0, 0.45),
        friction_angle_deg,
        cohesion,
        dilatancy_angle_deg: share * friction_angle_deg,
        tensile_strength: cut_off.then(|| between(noise, 0.0, 20e3)),
        ..SAND
    }
}

/// Principal trial stresses about the apex, one in three with two of them equal.
fn random_principal(noise: &mut Noise) -> Three {
    let mut principal = noise.vector::<3>() * 100e3 + Three::repeat(between(noise, -150e3, 60e3));
    if noise.number() > 0.33 {
        principal[1] = principal[0];
    }
    principal
}

/// The return of a trial stress with these principal values, in a frame of its own.
fn returned<L: ConstitutiveLaw<State = FrictionalState>>(law: &L, trial: Sym3) -> (Sym3, FrictionalState) {
    law.update(trial, FrictionalState::default(), Sym3::ZERO).unwrap()
}

/// Associated: the result is *the* nearest admissible stress, whichever plane, edge or corner that is on.
#[test]
fn mohr_coulomb_returns_to_the_nearest_stress() {
    let mut noise = Noise::new(7);
    let mut by_num_active = [0; 7];
    for _ in 0..NUM_TRIALS {
        let law = random_law(&mut noise, true);
        let elastic = LinearElastic { young: law.young, poisson: law.poisson };
        let (principal, axes) = (random_principal(&mut noise), any_rotation(&mut noise));
        let trial = Sym3::diagonal(principal[0], principal[1], principal[2]).rotated(&axes);
        let (stress, _) = returned(&law, trial);

        let planes = planes(&law);
        let expected = nearest(principal, &planes, &stiffness(&elastic));
        let off = stress - Sym3::diagonal(expected[0], expected[1], expected[2]).rotated(&axes);
        // Hildreth's method ends when its steps are 1e-12, and converges linearly: what is left may be a hundred times as much.
        assert!(off.norm() < 1e-10 * principal.norm(), "{law:?} {principal}: {off}");
        let active = |plane: &&Plane| plane.normal.dot(&expected) > plane.strength - 1e-6 * principal.norm();
        by_num_active[planes.iter().filter(active).count().min(6)] += 1;
    }
    // Inside, on a plane, on an edge, where planes and cut-offs meet, at the apex: each was there.
    assert!([0, 1, 2, 3, 4, 6].iter().all(|&count| by_num_active[count] > 100), "{by_num_active:?}");
}

/// How much of a vector (in parts of its length) no sum of these directions with positive factors reaches: by coordinate descent.
fn out_of_reach(target: Three, directions: &[Three]) -> f64 {
    let mut rest = target;
    let mut factors = vec![0.0; directions.len()];
    for _ in 0..100_000 {
        let mut largest_change = 0.0_f64;
        for (direction, factor) in directions.iter().zip(&mut factors) {
            let new = f64::max(0.0, *factor + direction.dot(&rest) / direction.norm_squared());
            rest -= direction * (new - *factor);
            largest_change = largest_change.max((new - *factor).abs());
            *factor = new;
        }
        if largest_change < 1e-13 * target.norm() {
            break;
        }
    }
    rest.norm() / target.norm()
}

/// Not associated: admissible, and the plastic strain is a sum of the flow directions of the planes it is on. At the apex it may open besides.
#[test]
fn mohr_coulomb_flows_along_its_potential() {
    let mut noise = Noise::new(11);
    let mut num_plastic = 0;
    for _ in 0..NUM_TRIALS {
        let law = random_law(&mut noise, false);
        let elastic = LinearElastic { young: law.young, poisson: law.poisson };
        let principal = random_principal(&mut noise);
        let (stress, state) = returned(&law, Sym3::diagonal(principal[0], principal[1], principal[2]));
        // Axes that were equal may turn into each other: diagonal stresses have none to turn.
        assert!(stress.xy == 0.0 && stress.yz == 0.0 && stress.zx == 0.0);
        let stress = Three::new(stress.xx, stress.yy, stress.zz);
        let planes = planes(&law);
        let margin = 1e-9 * (principal.norm() + law.cohesion);
        let excess = |plane: &Plane| plane.normal.dot(&stress) - plane.strength;
        assert!(planes.iter().all(|plane| excess(plane) < margin), "{law:?} {principal} {stress}");
        if !state.yielding {
            assert_eq!(stress, principal);
            continue;
        }
        num_plastic += 1;
        let plastic = stiffness(&elastic).try_inverse().unwrap() * (principal - stress);
        let mut flows: Vec<Three> =
            planes.iter().filter(|plane| excess(plane) > -margin).map(|plane| plane.flow).collect();
        if flows.len() >= 6 {
            flows.push(Three::repeat(1.0));
        }
        let lost = out_of_reach(plastic, &flows);
        // Small plastic strains are a difference of large stresses.
        let rounding = 1e-14 * principal.norm() / (principal - stress).norm();
        assert!(lost < 1e-10 + rounding, "{law:?} {principal} {stress}: {lost}");
        assert!((state.plastic_volumetric_strain - plastic.sum()).abs() < 1e-9 * plastic.norm() + 1e-17);
    }
    assert!(num_plastic > NUM_TRIALS / 2, "{num_plastic}");
}

// ---------------------------------------------------------------- Drucker and Prager by brute force

/// The cone of a law, its dilatancy and cut-off: q, k, q_ψ, σ_t (infinite where there is none).
struct Meridian {
    slope: f64,
    strength: f64,
    flow_slope: f64,
    tension: f64,
}

fn meridian(law: &DruckerPrager) -> Meridian {
    // Written out once more, with √3 where the table has it.
    let [friction, dilatancy] = [law.friction_angle_deg, law.dilatancy_angle_deg].map(f64::to_radians);
    let root = 3.0_f64.sqrt();
    let slope = |angle: f64| match law.cone {
        Cone::Compression => 6.0 * angle.sin() / (root * (3.0 - angle.sin())),
        Cone::Extension => 6.0 * angle.sin() / (root * (3.0 + angle.sin())),
        Cone::PlaneStrain => 3.0 * angle.tan() / (9.0 + 12.0 * angle.tan().powi(2)).sqrt(),
    };
    let strength = match law.cone {
        Cone::Compression => 6.0 * law.cohesion * friction.cos() / (root * (3.0 - friction.sin())),
        Cone::Extension => 6.0 * law.cohesion * friction.cos() / (root * (3.0 + friction.sin())),
        Cone::PlaneStrain => 3.0 * law.cohesion / (9.0 + 12.0 * friction.tan().powi(2)).sqrt(),
    };
    let tension = law.tensile_strength.unwrap_or(f64::INFINITY).min(strength / slope(friction));
    Meridian { slope: slope(friction), strength, flow_slope: slope(dilatancy), tension }
}

fn random_cone(noise: &mut Noise, associated: bool) -> DruckerPrager {
    let law = random_law(noise, associated);
    let cones = [Cone::Compression, Cone::Extension, Cone::PlaneStrain];
    as_cone(law, cones[(1.5 * (1.0 + noise.number())) as usize % 3])
}

fn as_cone(law: MohrCoulomb, cone: Cone) -> DruckerPrager {
    DruckerPrager {
        young: law.young,
        poisson: law.poisson,
        friction_angle_deg: law.friction_angle_deg,
        cohesion: law.cohesion,
        dilatancy_angle_deg: law.dilatancy_angle_deg,
        cone,
        tensile_strength: law.tensile_strength,
        friction_angle_residual_deg: law.friction_angle_residual_deg,
        cohesion_residual: law.cohesion_residual,
        softening_strain: law.softening_strain,
    }
}

/// About the apex, often with little shear.
fn random_stress(noise: &mut Noise) -> Sym3 {
    noise.tensor() * (60e3 * between(noise, 0.0, 1.0).powi(4)) + Sym3::IDENTITY * between(noise, -150e3, 80e3)
}

/// Associated: no admissible stress is nearer. The nearest on the boundary is searched by golden section, and two hundred random admissible stresses y lie
/// behind the plane through the result: (σ_tr − σ) : C⁻¹ : (y − σ) ≤ 0, which is what makes σ the nearest of a convex set.
#[test]
fn drucker_prager_returns_to_the_nearest_stress() {
    let mut noise = Noise::new(5);
    let mut regions = [0; 4];
    for _ in 0..NUM_TRIALS {
        let law = random_cone(&mut noise, true);
        let elastic = LinearElastic { young: law.young, poisson: law.poisson };
        let trial = random_stress(&mut noise);
        let (stress, state) = returned(&law, trial);
        let Meridian { slope, strength, tension, .. } = meridian(&law);
        let mean = stress.trace() / 3.0;
        let margin = 1e-12 * (trial.norm() + strength);
        assert!(shear(stress) + slope * mean <= strength + margin && mean <= tension + margin);
        if !state.yielding {
            assert_eq!(stress, trial);
            regions[0] += 1;
            continue;
        }
        let on_cone = shear(stress) + slope * mean > strength - margin;
        regions[if !on_cone {
            1
        } else if mean < tension - margin {
            2
        } else {
            3
        }] += 1;

        let energy = |y: Sym3| (trial - y).double_dot(elastic_strain(&elastic, trial - y));
        let direction = trial.deviator() * (1.0 / shear(trial));
        let lowest = (-4.0 * trial.norm() - 2.0 * strength, tension.min(trial.norm()));
        let nearest = golden_section(lowest, |mean: f64| {
            let height = (strength - slope * mean).max(0.0).min(shear(trial));
            energy(Sym3::IDENTITY * mean + direction * height)
        });
        assert!(energy(stress) <= nearest * (1.0 + 1e-9), "{law:?} {trial}: {} {nearest}", energy(stress));

        let plastic = elastic_strain(&elastic, trial - stress);
        for _ in 0..200 {
            let mean = tension.min(trial.norm()) - between(&mut noise, 0.0, 2.0).powi(4) * 20e3;
            let deviator = noise.tensor().deviator();
            let height = (strength - slope * mean).max(0.0) * between(&mut noise, 0.9, 1.0);
            let other = Sym3::IDENTITY * mean + deviator * (height / shear(deviator));
            let ahead = plastic.double_dot(other - stress);
            assert!(ahead <= 1e-12 * plastic.norm() * trial.norm(), "{law:?} {trial}: {ahead}");
        }
    }
    assert!(regions.iter().all(|&count| count > 100), "{regions:?}");
}

/// The smallest value of a function with one minimum.
fn golden_section((mut low, mut high): (f64, f64), function: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..100 {
        let (left, right) = (high - ratio * (high - low), low + ratio * (high - low));
        if function(left) < function(right) { high = right } else { low = left }
    }
    function(low).min(function(high))
}

/// Not associated: Δε^p = λ₁ (s/2√J₂ + q_ψ I/3) + λ₂ I/3 with λ₁, λ₂ ≥ 0, and λ₂ only at the cut-off or the apex.
#[test]
fn drucker_prager_flows_along_its_potential() {
    let mut noise = Noise::new(13);
    for _ in 0..NUM_TRIALS {
        let law = random_cone(&mut noise, false);
        let elastic = LinearElastic { young: law.young, poisson: law.poisson };
        let trial = random_stress(&mut noise);
        let (stress, state) = returned(&law, trial);
        if !state.yielding {
            continue;
        }
        let Meridian { slope, strength, flow_slope, tension } = meridian(&law);
        let (mean, margin) = (stress.trace() / 3.0, 1e-12 * (trial.norm() + strength));
        let plastic = elastic_strain(&elastic, trial - stress);
        let by_cone = 2.0 * shear(plastic.deviator());
        let by_opening = plastic.trace() - flow_slope * by_cone;
        let rounding = margin / elastic.shear_modulus();
        assert!(by_opening > -rounding, "{law:?} {trial}: {by_opening}");
        assert!(by_opening < rounding || mean > tension - margin, "{law:?} {trial}: {by_opening}");
        assert!(by_cone < rounding || shear(stress) + slope * mean > strength - margin);
        // The deviatoric part lies along s: |a||b| = a : b.
        let along = plastic.deviator().double_dot(stress.deviator());
        assert!(along > plastic.deviator().norm() * stress.deviator().norm() * (1.0 - 1e-9) - rounding * stress.norm());
        assert!((state.plastic_volumetric_strain - plastic.trace()).abs() < rounding);
        assert!((state.plastic_deviatoric_strain - by_cone / 3.0_f64.sqrt()).abs() < rounding);
    }
}

// ---------------------------------------------------------------- softening

/// Whatever the step, its end is the return of a law that keeps the strength of that end, and its plastic strain is what took the stress there.
#[test]
fn softened_states_are_those_of_the_strength_they_end_with() {
    let mut noise = Noise::new(23);
    let mut num_softening = 0;
    for _ in 0..NUM_TRIALS {
        let peak = random_law(&mut noise, false);
        let elastic = LinearElastic { young: peak.young, poisson: peak.poisson };
        let residual_angle = between(&mut noise, 0.0, peak.friction_angle_deg);
        let residual_cohesion = between(&mut noise, 0.1, 1.0) * peak.cohesion;
        // Over 5 % and more: steeper ones have several answers.
        let over = between(&mut noise, 0.05, 0.2);
        let strength = |strain: f64| {
            let share = f64::max(1.0 - strain / over, 0.0);
            let angle = residual_angle + share * (peak.friction_angle_deg - residual_angle);
            (angle, residual_cohesion + share * (peak.cohesion - residual_cohesion))
        };
        let softening = MohrCoulomb {
            friction_angle_residual_deg: Some(residual_angle),
            cohesion_residual: Some(residual_cohesion),
            softening_strain: over,
            ..peak
        };
        let cone = [Cone::Compression, Cone::Extension, Cone::PlaneStrain][num_softening % 3];
        let trial = random_stress(&mut noise) * 3.0;

        let kept = |state: FrictionalState| {
            let (friction_angle_deg, cohesion) = strength(state.plastic_deviatoric_strain);
            let dilatancy_angle_deg = peak.dilatancy_angle_deg.min(friction_angle_deg);
            MohrCoulomb { friction_angle_deg, cohesion, dilatancy_angle_deg, ..peak }
        };
        let (stress, state) = returned(&softening, trial);
        assert_same(stress, returned(&kept(state), trial).0, trial.norm());
        assert_plastic_strain(state, elastic_strain(&elastic, trial - stress));

        let (stress, state) = returned(&as_cone(softening, cone), trial);
        assert_same(stress, returned(&as_cone(kept(state), cone), trial).0, trial.norm());
        assert_plastic_strain(state, elastic_strain(&elastic, trial - stress));
        num_softening += usize::from(state.plastic_deviatoric_strain > 0.0);
    }
    assert!(num_softening > NUM_TRIALS / 3, "{num_softening}");
}

fn assert_same(stress: Sym3, expected: Sym3, size: f64) {
    assert!((stress - expected).norm() < 1e-10 * size, "{stress} {expected}");
}

/// The history counts this plastic strain: to round-off of strains of 1 %.
fn assert_plastic_strain(state: FrictionalState, strain: Sym3) {
    let expected = (2.0_f64 / 3.0).sqrt() * strain.deviator().norm();
    assert!((state.plastic_deviatoric_strain - expected).abs() < 1e-12, "{expected}");
}

// ---------------------------------------------------------------- strengths in closed form

/// Strains along z with x and y kept at `lateral` (Pa), or y kept in plane strain: the stress at the end.
fn compressed<L: ConstitutiveLaw>(law: &L, lateral: f64, plane_strain: bool, step: f64, steps: usize) -> Sym3 {
    let mut stress = Sym3::IDENTITY * lateral;
    let mut state = law.initial_state(stress);
    for _ in 0..steps {
        let after = |x: f64| {
            let strain = Sym3::diagonal(x, if plane_strain { 0.0 } else { x }, step);
            law.update(stress, state, strain).unwrap()
        };
        let (mut a, mut b) = (0.0, -0.3 * step);
        let (mut off_a, mut off_b) = (after(a).0.xx - lateral, after(b).0.xx - lateral);
        for _ in 0..60 {
            if off_b == off_a || off_b.abs() < 1e-9 * lateral.abs() {
                break;
            }
            (a, b, off_a) = (b, b - off_b * (b - a) / (off_b - off_a), off_b);
            off_b = after(b).0.xx - lateral;
        }
        assert!(off_b.abs() < 1e-6 * (1.0 + lateral.abs()), "the lateral stress is {off_b} off");
        (stress, state) = after(b);
    }
    stress
}

/// σ_z/σ_x at failure, from Mohr's circle: σ_z = σ_x tan²(45° ± φ/2) ∓ 2 c tan(45° ± φ/2).
#[test]
fn triaxial_and_plane_tests_fail_on_mohrs_circle() {
    const LATERAL: f64 = -100e3;
    let tan = (0.25 * std::f64::consts::PI + 0.5 * 33.0_f64.to_radians()).tan();
    let (active, passive) = (LATERAL / (tan * tan) + 2.0 * 2e3 / tan, LATERAL * tan * tan - 2.0 * 2e3 * tan);
    // Perfectly plastic: at the limit to the precision with which the lateral stress is kept.
    let close = |stress: Sym3, expected: f64| assert!((stress.zz / expected - 1.0).abs() < 1e-7, "{stress} {expected}");
    for dilatancy_angle_deg in [0.0, 5.0, 33.0] {
        let sand = MohrCoulomb { dilatancy_angle_deg, ..SAND };
        let cone = DruckerPrager { dilatancy_angle_deg, ..CONE };
        close(compressed(&sand, LATERAL, false, -1e-3, 100), passive);
        close(compressed(&sand, LATERAL, false, 1e-3, 100), active);
        close(compressed(&sand, LATERAL, true, -1e-3, 100), passive);
        close(compressed(&cone, LATERAL, false, -1e-3, 100), passive);
        close(compressed(&DruckerPrager { cone: Cone::Extension, ..cone }, LATERAL, false, 1e-3, 100), active);
    }
    // In plane strain the intermediate stress takes its time to find its place.
    let associated = DruckerPrager { dilatancy_angle_deg: 33.0, cone: Cone::PlaneStrain, ..CONE };
    close(compressed(&associated, LATERAL, true, -1e-3, 400), passive);
}

/// Uniaxial: E up to σ_y, then the slope E H/(E + H), then the residual stress.
#[test]
fn von_mises_bars_follow_their_line() {
    for (hardening, residual) in [(2e6, 0.0), (0.0, 0.0), (-1e6, 90e3)] {
        let clay = VonMises { hardening, yield_stress_residual: residual, ..CLAY };
        let slope = 10e6 * hardening / (10e6 + hardening);
        for (steps, strain) in [(5, 0.005), (20, 0.02), (60, 0.06)] {
            let stress = compressed(&clay, 0.0, false, -1e-3, steps);
            let expected: f64 = if strain < 0.01 { 10e6 * strain } else { 100e3 + slope * (strain - 0.01) };
            let expected = expected.max(residual.min(10e6 * strain));
            // The lateral stress is zero to 1e-6 Pa or so.
            assert!((stress.zz + expected).abs() < 1e-4, "{hardening} {strain}: {} {expected}", stress.zz);
        }
    }
}

/// Tresca's strength in triaxial compression (σ_y = 2 c_u) and in simple shear (σ_y = √3 c_u), without drainage.
#[test]
fn von_mises_meets_an_undrained_strength() {
    let undrained = |law: &VonMises, strain: Sym3| {
        let (stress, _) = law.update(Sym3::IDENTITY * -50e3, law.initial_state(Sym3::ZERO), strain).unwrap();
        assert!((stress.trace() + 150e3).abs() < 1e-9);
        stress
    };
    let triaxial = VonMises { yield_stress: 2.0 * 20e3, ..CLAY };
    let stress = undrained(&triaxial, Sym3::diagonal(0.01, 0.01, -0.02));
    assert!((stress.xx - stress.zz - 2.0 * 20e3).abs() < 1e-8);
    let plane = VonMises { yield_stress: 3.0_f64.sqrt() * 20e3, ..CLAY };
    let stress = undrained(&plane, Sym3 { xy: 0.02, ..Sym3::ZERO });
    assert!((stress.xy - 20e3).abs() < 1e-8);
}

/// Sheared at constant volume and without dilatancy, the mean stress stays, τ = c cos φ − σ_m sin φ on the plane of Mohr and Coulomb and
/// τ = k − q σ_m on the cone, with c and φ at the plastic strain ε^p = 2/√3 e^p_xy that is left: τ = 2 G (e_xy − e^p_xy).
#[test]
fn strengths_fall_along_their_line() {
    const MEAN: f64 = -80e3;
    let softened = |peak: f64, residual: f64, strain: f64| peak + (residual - peak) * (strain / 0.05).min(1.0);
    let sand = MohrCoulomb {
        dilatancy_angle_deg: 0.0,
        friction_angle_residual_deg: Some(20.0),
        cohesion_residual: Some(0.5e3),
        softening_strain: 0.05,
        ..SAND
    };
    let cone = DruckerPrager {
        dilatancy_angle_deg: 0.0,
        friction_angle_residual_deg: Some(20.0),
        cohesion_residual: Some(0.5e3),
        softening_strain: 0.05,
        ..CONE
    };
    let shear_modulus = 20e6 / 2.4;
    for step in [1e-4, 2e-2] {
        let (mut plane, mut round) =
            ((Sym3::IDENTITY * MEAN, FrictionalState::default()), (Sym3::IDENTITY * MEAN, FrictionalState::default()));
        let steps = (0.08 / step) as usize;
        for n in 1..=steps {
            let increment = Sym3 { xy: step, ..Sym3::ZERO };
            plane = sand.update(plane.0, plane.1, increment).unwrap();
            round = cone.update(round.0, round.1, increment).unwrap();
            let total = n as f64 * step;
            for ((stress, state), cone) in [(plane, None), (round, Some(Cone::Compression))] {
                let strain = state.plastic_deviatoric_strain;
                let (angle, cohesion) = (softened(33.0, 20.0, strain).to_radians(), softened(2e3, 0.5e3, strain));
                let strength = match cone {
                    None => cohesion * angle.cos() - MEAN * angle.sin(),
                    Some(cone) => cone.strength(angle, cohesion) - MEAN * cone.slope(angle),
                };
                // 800 steps that round 240 kPa.
                assert!((stress.trace() - 3.0 * MEAN).abs() < 1e-7);
                let left = 2.0 * shear_modulus * (total - 0.75_f64.sqrt() * strain);
                // Sums of 800 increments.
                assert!((stress.xy - left).abs() < 1e-9 * strength, "{} {left}", stress.xy);
                if state.yielding {
                    assert!((stress.xy - strength).abs() < 1e-9 * strength, "{} {strength}", stress.xy);
                }
            }
        }
        // The end is the residual state.
        assert!(plane.1.plastic_deviatoric_strain > 0.05 && round.1.plastic_deviatoric_strain > 0.05);
    }
}

// ---------------------------------------------------------------- parameters

#[test]
fn parameters_out_of_range_are_named() {
    fn named<L: ConstitutiveLaw>(law: &L) -> &'static str {
        match law.validate() {
            Err(LawError::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(named(&VonMises { hardening: -3.0 * 10e6 / 2.6, ..CLAY }), "hardening");
    assert_eq!(named(&VonMises { yield_stress_residual: 101e3, ..CLAY }), "yield_stress_residual");
    assert_eq!(named(&MohrCoulomb { friction_angle_deg: 90.0, ..SAND }), "friction_angle_deg");
    assert_eq!(named(&MohrCoulomb { dilatancy_angle_deg: 34.0, ..SAND }), "dilatancy_angle_deg");
    assert_eq!(named(&MohrCoulomb { cohesion_residual: Some(3e3), ..SAND }), "cohesion_residual");
    assert_eq!(named(&MohrCoulomb { cohesion_residual: Some(1e3), ..SAND }), "softening_strain");
    assert_eq!(named(&DruckerPrager { tensile_strength: Some(-1.0), ..CONE }), "tensile_strength");
    let fluid = DruckerPrager { cohesion: 0.0, friction_angle_deg: 0.0, dilatancy_angle_deg: 0.0, ..CONE };
    assert_eq!(named(&fluid), "cohesion");
    assert!(SAND.validate().is_ok() && CONE.validate().is_ok() && CLAY.validate().is_ok());
}
