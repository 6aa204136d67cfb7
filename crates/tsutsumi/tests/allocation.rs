//! A step allocates nothing once the first few have set memory aside.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::num::NonZeroUsize;

use tsutsumi::boundary::History;
use tsutsumi::damping::Damping;
use tsutsumi::pressure::Quadrature;
use tsutsumi::solver::{Solver, StressFirst, StressModifiedLast};
use tsutsumi::tensor::Vector;
use tsutsumi::velocity::{Apic, Fmpm, Mpm1, Mpm2, Tpic, VelocityUpdate, Xpic};
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::reading::{run, top};

/// The allocations of `steps` steps of `dt` (s), within a pool of threads: a call from outside waits in a queue of the pool's, which is set aside.
fn allocations<const D: usize>(solver: &mut Solver<D>, dt: f64, steps: usize) -> u64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    pool.install(|| {
        run(solver, dt, 1).unwrap();
        allocation_counter::measure(|| run(solver, dt, steps).unwrap()).count_total
    })
}

/// The cell of every particle.
fn cells<const D: usize>(solver: &Solver<D>) -> Vec<u32> {
    solver.particles().cell.clone()
}

fn a_loaded_layer_allocates_nothing<const D: usize>(width: usize, height: f64, iterates: bool) {
    let layer = || {
        Body::<D>::layer(height, 1.0, width).gravity(9.8).drained(top::<D>()).load_on_surface(
            top::<D>(),
            down(50e3),
            History::new(vec![[0.0, 0.0], [1.0, 1.0]]),
        )
    };
    stepping_allocates_nothing(layer().build(), iterates);
    stepping_allocates_nothing(layer().plate(top::<D>()).build(), iterates);
    stepping_allocates_nothing(layer().stress_order(StressFirst).build(), iterates);
    stepping_allocates_nothing(layer().stress_order(StressModifiedLast).build(), iterates);
    let damping = Damping { local: 0.7, mass: 1.0, stiffness: 1e-3 };
    stepping_allocates_nothing(
        layer().plate(top::<D>()).damping(damping).cell_averaged().pressure_stabilisation(30.0).build(),
        iterates,
    );
}

fn stepping_allocates_nothing<const D: usize>(mut solver: Solver<D>, iterates: bool) {
    run(&mut solver, 0.002, 3).unwrap();
    assert_eq!(solver.step(0.002).unwrap().pressure.iterations > 0, iterates, "the solver chosen");
    assert_eq!(allocations(&mut solver, 0.002, 20), 0);
    // A step of another length changes nothing of it.
    assert_eq!(allocations(&mut solver, 0.001, 20), 0);
}

#[test]
fn a_loaded_layer_allocates_nothing_in_1d_2d_and_3d() {
    a_loaded_layer_allocates_nothing::<1>(1, 10.0, false);
    a_loaded_layer_allocates_nothing::<2>(3, 10.0, false);
    a_loaded_layer_allocates_nothing::<3>(3, 4.0, false);
    a_loaded_layer_allocates_nothing::<2>(44, 44.0, true);
    a_loaded_layer_allocates_nothing::<3>(9, 9.0, true);
}

/// A body that flies through the grid, three cells per axis; it covers four from time to time.
fn a_flying_body_allocates_nothing<const D: usize>(dry: bool) {
    let body = Body::<D>::free(Vector::repeat(0.75), Vector::repeat(3.25), 1.0, [12; D])
        .particles_per_cell([4; D])
        .velocity(|_| Vector::from_fn(|axis, _| [20.0, 19.0, 18.5][axis]));
    let mut solver = if dry { body.dry() } else { body }.build();
    // Two cells far, so that every number of cells that it covers has been seen.
    let dt = 2.5e-4;
    run(&mut solver, dt, 400).unwrap();
    let before = cells(&solver);
    assert_eq!(allocations(&mut solver, dt, 600), 0);
    assert!(before.iter().zip(cells(&solver)).all(|(&before, after)| before != after), "particles change cells");
}

#[test]
fn a_flying_dry_body_allocates_nothing_in_1d_2d_and_3d() {
    a_flying_body_allocates_nothing::<1>(true);
    a_flying_body_allocates_nothing::<2>(true);
    a_flying_body_allocates_nothing::<3>(true);
}

#[test]
fn a_flying_wet_body_allocates_nothing_in_1d_2d_and_3d() {
    a_flying_body_allocates_nothing::<1>(false);
    a_flying_body_allocates_nothing::<2>(false);
    a_flying_body_allocates_nothing::<3>(false);
}

#[test]
fn sorting_allocates_nothing_after_the_first_time() {
    let damping = Damping { local: 0.0, mass: 0.0, stiffness: 1e-4 };
    let mut solver = Body::<2>::free(Vector::repeat(0.75), Vector::repeat(3.25), 1.0, [12; 2])
        .particles_per_cell([4; 2])
        .velocity(|x| Vector::from([20.0 - 4.0 * x[1], 19.0 + 4.0 * x[0]]))
        .damping(damping)
        .dry()
        .build();
    let mut sort_and_step = |steps| {
        for _ in 0..steps {
            solver.sort_in_next_step();
            solver.step(2.5e-4).unwrap();
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    pool.install(|| {
        sort_and_step(2);
        assert_eq!(allocation_counter::measure(|| sort_and_step(200)).count_total, 0);
    });
}

/// A flying body in 2-D, dry (without a quadrature) or wet. As it deforms a little, cells at its corners come and go: the same
/// number of cells has more open sides at one time than at another.
fn an_update_allocates_nothing(update: impl VelocityUpdate<2> + 'static, quadrature: Option<Quadrature>) {
    let body = Body::<2>::free(Vector::repeat(0.75), Vector::repeat(3.25), 1.0, [12; 2])
        .particles_per_cell([4; 2])
        .velocity(|_| Vector::from_fn(|axis, _| [20.0, 19.0][axis]))
        .velocity_update(update);
    let mut solver = match quadrature {
        Some(quadrature) => body.quadrature(quadrature),
        None => body.dry(),
    }
    .build();
    let dt = 2.5e-4;
    run(&mut solver, dt, 400).unwrap();
    assert_eq!(allocations(&mut solver, dt, 600), 0);
}

#[test]
fn no_update_allocates_anything() {
    let order = NonZeroUsize::new(5).unwrap();
    for quadrature in [None, Some(Quadrature::Cell), Some(Quadrature::MaterialPoints)] {
        an_update_allocates_nothing(Mpm1, quadrature);
        an_update_allocates_nothing(Mpm2, quadrature);
        an_update_allocates_nothing(Apic, quadrature);
        an_update_allocates_nothing(Tpic, quadrature);
        an_update_allocates_nothing(Xpic::new(order), quadrature);
        an_update_allocates_nothing(Fmpm::new(order), quadrature);
    }
}
