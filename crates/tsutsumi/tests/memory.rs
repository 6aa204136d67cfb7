//! The memory that a body takes: within a budget, and as the solver says.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::law::ModifiedCamClay;
use tsutsumi::shape::QuadraticBSpline;
use tsutsumi::solver::Solver;
use tsutsumi::tensor::Sym3;
use tsutsumi::velocity::Apic;
use tsutsumi_testkit::body::Body;

/// A solver after two steps and a sort of its particles, and the memory (bytes) that it holds by then.
fn measured<const D: usize>(build: impl Fn() -> Solver<D> + Sync) -> (Solver<D>, f64) {
    // Allocations are counted by thread: all of them are made in the only one of a pool, which is nobody's body.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut solvers = Vec::with_capacity(1);
    let allocations = pool.install(|| {
        allocation_counter::measure(|| {
            let mut solver = build();
            solver.step(1e-4).unwrap();
            solver.sort_in_next_step();
            solver.step(1e-4).unwrap();
            solvers.push(solver);
        })
    });
    (solvers.remove(0), allocations.bytes_current as f64)
}

/// The memory per particle (bytes); what the solver says must agree with it, before particles are sorted too where they may be.
fn per_particle<const D: usize>(build: impl Fn() -> Solver<D> + Sync) -> f64 {
    let (solver, measured) = measured(build);
    let stated = solver.memory().total() as f64;
    // Blocks of particles, names and the like are not counted: some 30 kB. Nothing that grows with the body may be missing.
    let uncounted = measured - stated;
    assert!((0.0..0.01 * measured + 4e4).contains(&uncounted), "{measured} measured, {stated} stated");
    measured / solver.particles().len() as f64
}

fn dry_layer<const D: usize>(width: usize) -> Body<D> {
    Body::<D>::layer(width as f64, 1.0, width).dry()
}

/// Budgets: 200 B in 2-D and 300 B in 3-D for elastic ground, grid included.
#[test]
fn elastic_ground_stays_within_the_budget_of_memory() {
    let plane = per_particle(|| dry_layer::<2>(100).build());
    assert!(plane <= 200.0, "{plane} bytes per particle in 2-D");
    let space = per_particle(|| dry_layer::<3>(20).build());
    assert!(space <= 300.0, "{space} bytes per particle in 3-D");
}

#[test]
fn histories_and_affine_motions_are_counted() {
    let clay = ModifiedCamClay {
        critical_state_ratio: 1.2,
        lambda: 0.2,
        kappa: 0.05,
        poisson: Some(0.3),
        shear_modulus: None,
        void_ratio: 1.0,
        preconsolidation_pressure: 0.0,
        overconsolidation_ratio: 1.5,
    };
    let plain = per_particle(|| dry_layer::<2>(40).build());
    let body = || dry_layer::<2>(40).law(clay).stress(|_| Sym3::IDENTITY * -1e5).shape(QuadraticBSpline);
    let rich = per_particle(|| body().velocity_update(Apic).build());
    // Four numbers and a flag of history, 40 bytes, and a 2×2 matrix.
    assert!((rich - plain - 72.0).abs() < 2.0, "{plain} and {rich} bytes per particle");
}
