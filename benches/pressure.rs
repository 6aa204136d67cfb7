//! What the pressures of a step cost: `cargo bench -p tsutsumi-benches --bench pressure`.
//!
//! Square bodies of soft ground, half of the top loaded, at half the longest step: all that the scheme does in a step but to give the pressures back.
//! The iterations are printed beside the times.

#![allow(clippy::print_stderr, reason = "a bench reports to the terminal")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use tsutsumi::damping::Damping;
use tsutsumi::pressure::{Coupled, PressureScheme, Quadrature, StepView};
use tsutsumi::shape::Linear;
use tsutsumi::tensor::Vector;
use tsutsumi_testkit::body::{Body, WATER, down};
use tsutsumi_testkit::reading::top;

/// A square of `width` cells after some steps, solved again and again.
fn bench_square(criterion: &mut Criterion, width: usize, direct_up_to: usize, name: &str) {
    let half = 0.5 * width as f64;
    let load = move |x: Vector<2>| if x[0] < half { down(50e3) } else { Vector::zeros() };
    let body = Body::<2>::layer(width as f64, 1.0, width).drained(top::<2>()).load_varying(top::<2>(), load);
    let mut solver = body.build();
    let dt = 0.5 * solver.step_limits().longest();
    for _ in 0..5 {
        if let Err(error) = solver.step(dt) {
            unreachable!("a stable step: {error}");
        }
    }
    let at = StepView {
        grid: solver.grid(),
        active: solver.active(),
        transfer: &Linear,
        gravity: Vector::zeros(),
        damping: Damping::default(),
        dt,
        time: 0.0,
    };
    let (mut cells, mut nodes) = (solver.cells().clone(), solver.nodes().clone());
    let mut scheme = Coupled::new(WATER, Quadrature::MaterialPoints, true).with_direct_solver_up_to(direct_up_to);
    let mut iterations = 0;
    let mut solve = || {
        scheme.particles_to_cells(&at, solver.particles(), &mut cells);
        match scheme.solve(&at, solver.particles(), &mut cells, &mut nodes) {
            Ok(report) => iterations = black_box(report.iterations),
            Err(error) => unreachable!("a sound body: {error}"),
        }
    };
    let mut group = criterion.benchmark_group("pressure");
    group.throughput(Throughput::Elements((width * width) as u64)).sample_size(10);
    group.bench_function(BenchmarkId::new(name, width * width), |bench| bench.iter(&mut solve));
    group.finish();
    eprintln!("{name}, {} cells: {iterations} iterations", width * width);
}

fn squares(criterion: &mut Criterion) {
    for width in [16, 24, 32] {
        bench_square(criterion, width, usize::MAX, "direct");
    }
    for width in [16, 24, 32, 50, 100, 200, 500, 1000] {
        bench_square(criterion, width, 0, "iterative");
    }
}

criterion_group!(benches, squares);
criterion_main!(benches);
