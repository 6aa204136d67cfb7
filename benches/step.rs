//! What one step costs: `cargo bench -p tsutsumi-benches --bench step -- FILTER`.
//!
//! - `column`: the paper's column (10 cells, 2 particles per axis and cell), in 1-D, 2-D and 3-D;
//! - `layer`: a saturated layer 10 m high, wider and wider, per step; `dry` the same without water: the difference is the
//!   pressure solve;
//! - `size`, `shape`, `update`, `law`, `threads`: the compared block, one thing changed at a time;
//! - `start`: a case from its file to its first step.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::{ThreadPool, ThreadPoolBuilder};
use tsutsumi::boundary::History;
use tsutsumi::solver::Solver;
use tsutsumi_benches::block::Block;
use tsutsumi_case::{CaseSource, Registry, build::build};
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::reading::top;

/// A loaded, drained layer on rollers, after a hundred steps.
fn layer<const D: usize>(width: usize, dry: bool) -> Solver<D> {
    let body = Body::<D>::layer(10.0, 1.0, width).on_rollers();
    let body = body.load_on_surface(top::<D>(), down(50e3), History::new(vec![[0.0, 0.0], [1.0, 1.0]]));
    let body = if dry { body.dry() } else { body.drained(top::<D>()) };
    let mut solver = body.build();
    for _ in 0..100 {
        advance(&mut solver, 1e-3);
    }
    solver
}

fn advance<const D: usize>(solver: &mut Solver<D>, dt: f64) {
    // Stable ground under a steady load: no step can fail.
    if let Err(error) = black_box(solver.step(dt)) {
        unreachable!("{error}");
    }
}

fn pool(threads: usize) -> ThreadPool {
    match ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool,
        Err(error) => unreachable!("{threads} threads: {error}"),
    }
}

fn bench_column<const D: usize>(criterion: &mut Criterion) {
    criterion.bench_function(&format!("column/{D}d"), |bench| {
        let mut solver = layer::<D>(1, false);
        bench.iter(|| advance(&mut solver, 1e-3));
    });
}

fn columns(criterion: &mut Criterion) {
    bench_column::<1>(criterion);
    bench_column::<2>(criterion);
    bench_column::<3>(criterion);
}

fn layers(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("layer-2d");
    for width in [10, 100, 1000] {
        for (name, dry) in [("saturated", false), ("dry", true)] {
            let particles = 40 * width as u64;
            group.throughput(Throughput::Elements(particles));
            group.sample_size(20).bench_function(BenchmarkId::new(name, particles), |bench| {
                let mut solver = layer::<2>(width, dry);
                bench.iter(|| advance(&mut solver, 1e-3));
            });
        }
    }
    group.finish();
}

/// A step of a block. It is built only if the filter lets it run.
fn bench_block<const D: usize>(criterion: &mut Criterion, group: &str, name: &str, block: &Block, threads: usize) {
    let mut group = criterion.benchmark_group(group);
    let count = (2 * block.cells_per_axis(D)).pow(D as u32) as u64;
    group.throughput(Throughput::Elements(count));
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    group.bench_function(BenchmarkId::new(name, format!("{D}d")), |bench| {
        let mut solver = match block.build::<D>() {
            Ok(solver) => solver,
            Err(error) => unreachable!("{error}"),
        };
        let dt = block.step(&solver);
        pool(threads).install(|| bench.iter(|| advance(&mut solver, dt)));
    });
    group.finish();
}

fn blocks(criterion: &mut Criterion) {
    let linear = || Block::linear(100_000);
    for (name, count) in [("100k", 100_000), ("1M", 1_000_000), ("4M", 4_000_000)] {
        bench_block::<2>(criterion, "size", name, &Block::linear(count), 1);
        bench_block::<3>(criterion, "size", name, &Block::linear(count), 1);
    }
    for shape in ["linear", "gimp", "bspline2"] {
        let block = Block { shape: shape.to_owned(), ..linear() };
        bench_block::<2>(criterion, "shape", shape, &block, 1);
        bench_block::<3>(criterion, "shape", shape, &block, 1);
    }
    for update in ["mpm1", "mpm2", "flip", "apic"] {
        bench_block::<2>(criterion, "update", update, &Block { update: update.to_owned(), ..linear() }, 1);
    }
    for law in ["linear-elastic", "modified-cam-clay", "sanisand"] {
        bench_block::<2>(criterion, "law", law, &linear().of(law), 1);
    }
    for threads in [1, 2, 4] {
        bench_block::<2>(criterion, "threads", &threads.to_string(), &Block::linear(1_000_000), threads);
        bench_block::<3>(criterion, "threads", &threads.to_string(), &Block::spline(100_000), threads);
    }
}

/// The paper's column, read, checked and built.
fn start(criterion: &mut Criterion) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../paper-cases/poroelastic-column/case.toml");
    let registry = Registry::built_in();
    let started = || -> Result<_, tsutsumi_case::CaseError> {
        let source = CaseSource::read(path)?;
        let case = source.parse()?;
        source.validate(&case)?;
        build::<2>(&source, &case, &registry)
    };
    criterion.bench_function("start/column-2d", |bench| {
        bench.iter(|| match started() {
            Ok(simulation) => simulation,
            Err(error) => unreachable!("{error}"),
        });
    });
}

criterion_group!(benches, columns, layers, blocks, start);
criterion_main!(benches);
