//! What one step costs: `cargo bench -p tsutsumi-benches`.
//!
//! - `column`: the paper's column (10 cells, 2 particles per axis and cell), in 1-D, 2-D and 3-D;
//! - `layer`: a saturated layer 10 m high, wider and wider, per step; `dry` the same without water: the difference is the
//!   pressure solve.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use tsutsumi::boundary::History;
use tsutsumi::solver::Solver;
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::reading::top;

/// A loaded, drained layer on rollers, after a hundred steps.
fn layer<const D: usize>(width: usize, dry: bool) -> Solver<D> {
    let body = Body::<D>::layer(10.0, 1.0, width).on_rollers();
    let body = body.load_on_surface(top::<D>(), down(50e3), History::new(vec![[0.0, 0.0], [1.0, 1.0]]));
    let body = if dry { body.dry() } else { body.drained(top::<D>()) };
    let mut solver = body.build();
    for _ in 0..100 {
        advance(&mut solver);
    }
    solver
}

fn advance<const D: usize>(solver: &mut Solver<D>) {
    // A stable layer under a steady load: no step can fail.
    if let Err(error) = black_box(solver.step(1e-3)) {
        unreachable!("{error}");
    }
}

fn bench_column<const D: usize>(criterion: &mut Criterion) {
    let mut solver = layer::<D>(1, false);
    criterion.bench_function(&format!("column/{D}d"), |bench| bench.iter(|| advance(&mut solver)));
}

fn bench_layers(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("layer-2d");
    for width in [10, 100, 1000] {
        for (name, dry) in [("saturated", false), ("dry", true)] {
            let mut solver = layer::<2>(width, dry);
            group.throughput(Throughput::Elements(solver.particles().len() as u64));
            let id = BenchmarkId::new(name, solver.particles().len());
            group.sample_size(20).bench_function(id, |bench| bench.iter(|| advance(&mut solver)));
        }
    }
    group.finish();
}

fn columns(criterion: &mut Criterion) {
    bench_column::<1>(criterion);
    bench_column::<2>(criterion);
    bench_column::<3>(criterion);
}

criterion_group!(benches, columns, bench_layers);
criterion_main!(benches);
