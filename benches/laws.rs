//! What an update of each law costs: `cargo bench -p tsutsumi-benches --bench laws`.
//!
//! A material point under cyclic simple shear at constant volume between ±0.2 %, in strain increments of 1e-5, from 100 kPa: an update is one increment,
//! elastic or plastic as it comes. OpenSees, driven point by point from Python, was seen to take 17 to 110 µs for a step of such a test.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use tsutsumi::law::{ConstitutiveLaw, Group, Increment, LinearElastic, MaterialGroup, MohrCoulomb};
use tsutsumi::tensor::Sym3;
use tsutsumi_benches::laws::CLAY;
use tsutsumi_testkit::soils::{CYCLIC_SAND, TOYOURA_SAND};

/// Points in a call: a block of the solver.
const POINTS: usize = 64;

/// Half the amplitude of γ over the increment of γ.
const INCREMENTS: usize = 200;

fn bench_law(criterion: &mut Criterion, name: &str, law: impl ConstitutiveLaw) {
    let mut stresses = vec![Sym3::diagonal(-100e3, -100e3, -100e3); POINTS];
    let group = Group::new(name, law, 0..POINTS, stresses.iter().copied());
    let volumes = vec![1.0; POINTS];
    let mut step = 0;
    let mut bench = criterion.benchmark_group("law-update");
    bench.throughput(criterion::Throughput::Elements(POINTS as u64));
    bench.bench_function(name, |bench| {
        bench.iter(|| {
            // A triangle wave between ±INCREMENTS.
            let forward = ((step + INCREMENTS) / (2 * INCREMENTS)).is_multiple_of(2);
            let strain = Sym3 { xy: if forward { 0.5e-5 } else { -0.5e-5 }, ..Sym3::ZERO };
            let increments = [Increment { strain, ..Increment::default() }; POINTS];
            let outcome = group.update_block(0, &mut stresses, black_box(&increments), &volumes);
            assert!(outcome.failure.is_none(), "{name}: {:?}", outcome.failure);
            step += 1;
        });
    });
    bench.finish();
}

fn laws(criterion: &mut Criterion) {
    bench_law(criterion, "linear-elastic", LinearElastic { young: 50e6, poisson: 0.3 });
    let mohr_coulomb = MohrCoulomb {
        young: 50e6,
        poisson: 0.3,
        friction_angle_deg: 33.0,
        cohesion: 1e3,
        dilatancy_angle_deg: 0.0,
        tensile_strength: None,
        friction_angle_residual_deg: None,
        cohesion_residual: None,
        softening_strain: 0.0,
    };
    bench_law(criterion, "mohr-coulomb", mohr_coulomb);

    bench_law(criterion, "modified-cam-clay", CLAY);
    bench_law(criterion, "sanisand", TOYOURA_SAND);
    bench_law(criterion, "oka-cyclic", CYCLIC_SAND);
}

criterion_group!(benches, laws);
criterion_main!(benches);
