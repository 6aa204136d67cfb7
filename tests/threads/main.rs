//! The number of threads changes nothing, bit by bit, whatever the variant.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::cell::RefCell;

use tsutsumi::law::ConstitutiveLaw;
use tsutsumi::particles::Particles;
use tsutsumi::pressure::Quadrature;
use tsutsumi::solver::Solver;
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi_case::{Method, registry};
use tsutsumi_testkit::body::Body;
use tsutsumi_testkit::noise::Noise;
use tsutsumi_testkit::reading::{run, top};
use tsutsumi_testkit::soils::{MORIKAWA_ASAI_CLAY, TOYOURA_SAND};

/// More cells along an axis than one thread takes: several bands, several pieces of every loop.
const WIDTH: usize = 48;

/// All numbers that particles carry, as bits.
fn bits<const D: usize>(particles: &Particles<D>) -> Vec<u64> {
    let vectors = particles.position.iter().chain(&particles.velocity).chain(&particles.half_size);
    let stresses = particles.stress.iter().flat_map(|s| [s.xx, s.yy, s.zz, s.xy, s.yz, s.zx]);
    let scalars = [&particles.volume, &particles.pressure, &particles.porosity, &particles.conductivity];
    let numbers = vectors.flat_map(|v| v.iter().copied()).chain(stresses).chain(scalars.into_iter().flatten().copied());
    numbers.map(f64::to_bits).collect()
}

/// Runs the body on one thread and on three, with its particles as they stand and sorted in every step.
fn assert_same<const D: usize>(what: &str, steps: usize, build: impl Fn() -> Solver<D> + Sync) {
    assert_same_with(what, steps, &build, |solver, dt| run(solver, dt, 1).unwrap());
    assert_same_with(&format!("{what}, sorted"), steps, &build, |solver, dt| {
        solver.sort_in_next_step();
        run(solver, dt, 1).unwrap();
    });
}

fn assert_same_with<const D: usize>(
    what: &str,
    steps: usize,
    build: &(impl Fn() -> Solver<D> + Sync),
    step: impl Fn(&mut Solver<D>, f64) + Sync,
) {
    let outcome = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = build();
            let dt = 0.2 * solver.step_limits().longest();
            (0..steps).for_each(|_| step(&mut solver, dt));
            (bits(solver.particles()), solver.strain_energy().to_bits(), solver.outflow().to_bits())
        })
    };
    assert!(outcome(1) == outcome(3), "{what}");
}

/// A moving layer of noise: particles change cells, and no two numbers are equal.
fn layer<const D: usize>(width: usize) -> Body<D> {
    let noise = RefCell::new(Noise::new(7));
    let speed = Vector::from_fn(|axis, _| if axis == 0 { 3.0 } else { 0.0 });
    Body::<D>::layer(width as f64, 1.0, width)
        .gravity(9.81)
        .drained(top::<D>())
        .velocity(move |_| speed + noise.borrow_mut().vector::<D>())
}

#[test]
fn every_shape_function_with_every_velocity_update() {
    for (shape, _) in registry::shapes::<2>() {
        for (update, _) in registry::velocity_updates::<2>(&Method::default()) {
            assert_same(&format!("{shape} {update}"), 3, || {
                let boxed = registry::shapes().into_iter().find(|(name, _)| *name == shape).unwrap().1;
                let updates = registry::velocity_updates(&Method::default());
                let boxed_update = updates.into_iter().find(|(name, _)| *name == update).unwrap().1;
                layer::<2>(WIDTH).dry().boxed_shape(boxed).boxed_velocity_update(boxed_update).build()
            });
        }
    }
}

#[test]
fn every_stress_order_and_way_of_the_pressure() {
    for (order, _) in registry::stress_orders() {
        for quadrature in [Quadrature::Cell, Quadrature::MaterialPoints] {
            assert_same(&format!("{order} {quadrature:?}"), 3, || {
                let orders = registry::stress_orders();
                let boxed = orders.into_iter().find(|(name, _)| *name == order).unwrap().1;
                layer::<2>(WIDTH).boxed_stress_order(boxed).quadrature(quadrature).build()
            });
        }
    }
    for (way, _) in registry::particle_pressures::<2>() {
        assert_same(way, 3, || {
            let ways = registry::particle_pressures();
            let boxed = ways.into_iter().find(|(name, _)| *name == way).unwrap().1;
            layer::<2>(WIDTH).boxed_particle_pressure(boxed).build()
        });
    }
}

#[test]
fn volume_changes_of_cells() {
    assert_same("cell-averaged", 3, || layer::<2>(WIDTH).cell_averaged().build());
}

#[test]
fn solids_and_lines() {
    assert_same("3-D", 2, || layer::<3>(11).build());
    assert_same("3-D, dry", 2, || layer::<3>(14).dry().build());
    assert_same("1-D", 2, || layer::<1>(1).particles_per_cell([6000]).dry().build());
}

#[test]
fn laws_with_histories() {
    fn check(what: &str, law: impl ConstitutiveLaw + Copy) {
        let ground = || layer::<2>(WIDTH).dry().law(law).stress(|_| Sym3::IDENTITY * -200e3);
        assert_same(what, 2, || ground().build());
    }
    check("modified-cam-clay", MORIKAWA_ASAI_CLAY);
    check("sanisand", TOYOURA_SAND);
}
