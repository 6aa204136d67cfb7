//! Particle-steps per second of a block of ground, as one line of JSON.
//!
//! ```text
//! cargo run --release -p tsutsumi-benches --bin throughput -- --dim 2 --particles 1000000 --threads 1
//! ```

#![allow(clippy::print_stdout, reason = "it is what the program is for")]

use std::error::Error;
use std::time::Instant;

use clap::Parser;
use serde_json::json;
use tsutsumi::solver::Solver;
use tsutsumi_benches::block::Block;

/// Steps before the clock starts: caches warm, work arrays set aside.
const WARM: usize = 5;

/// Steps a block of ground and says how fast.
#[derive(Debug, Parser)]
struct Arguments {
    /// The dimension of space: 2 or 3.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    dim: u8,
    #[command(flatten)]
    block: Block,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Steps timed at a time.
    #[arg(long, default_value_t = 100)]
    steps: usize,
    /// How often; the median counts.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..))]
    repeats: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build()?;
    let measured = pool.install(|| match arguments.dim {
        2 => measure::<2>(&arguments).map_err(|error| error.to_string()),
        _ => measure::<3>(&arguments).map_err(|error| error.to_string()),
    })?;
    println!("{measured}");
    Ok(())
}

fn measure<const D: usize>(arguments: &Arguments) -> Result<serde_json::Value, Box<dyn Error>> {
    let block = &arguments.block;
    let mut solver = block.build::<D>()?;
    let dt = block.step(&solver);
    advance(&mut solver, dt, WARM)?;
    let mut seconds = Vec::new();
    let mut iterations = 0;
    let cpu_before = cpu_seconds();
    for _ in 0..arguments.repeats {
        let start = Instant::now();
        iterations += advance(&mut solver, dt, arguments.steps)?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    let cpu_taken = cpu_seconds().zip(cpu_before).map(|(after, before)| after - before);
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    let particles = solver.particles().len();
    let rate = |seconds: f64| (particles * arguments.steps) as f64 / seconds;
    let timed = arguments.steps * arguments.repeats as usize;
    Ok(json!({
        "tool": "tsutsumi",
        "dim": D,
        "shape": block.shape,
        "update": block.update,
        "law": block.law,
        "saturated": block.saturated,
        "shuffled": block.shuffled,
        "motion": format!("{:?}", block.motion),
        "threads": arguments.threads,
        "particles": particles,
        "cells": solver.active().cells().len(),
        "steps": arguments.steps,
        "dt": dt,
        "bytes_per_particle": solver.memory().total() as f64 / particles as f64,
        "bytes_per_step": bytes_per_step::<D>(block),
        "particle_steps_per_s": rate(median),
        "particle_steps_per_cpu_s": cpu_taken.map(|taken| (particles * timed) as f64 / taken),
        "rates": seconds.iter().map(|&seconds| rate(seconds)).collect::<Vec<_>>(),
        "ms_per_step": 1e3 * median / arguments.steps as f64,
        "pressure_iterations_per_step": iterations as f64 / timed as f64,
        "check": check(&solver),
    }))
}

/// What the threads of this program have had of the processors so far (s), where the system is a Linux.
fn cpu_seconds() -> Option<f64> {
    /// In these units (1/s), whatever the kernel.
    const TICKS: f64 = 100.0;
    let status = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in brackets, which may hold blanks: time in the program, then in the kernel, are numbers 11 and 12 from 0.
    let (_, numbers) = status.rsplit_once(')')?;
    let times = numbers.split_whitespace().skip(11).take(2).map(str::parse::<f64>);
    Some(times.sum::<Result<f64, _>>().ok()? / TICKS)
}

/// Steps, and the iterations of their pressure solves.
fn advance<const D: usize>(solver: &mut Solver<D>, dt: f64, steps: usize) -> Result<usize, Box<dyn Error>> {
    let mut iterations = 0;
    for _ in 0..steps {
        iterations += solver.step(dt)?.pressure.iterations;
    }
    Ok(iterations)
}

/// The bytes that a step has to move between memory and core for a particle, if no array stays in the caches: the passes of a dry step as they are, each
/// with the arrays that it reads, and those that it writes once more. The nodes' fields, a quarter of a node per particle in 2-D, are not counted.
fn bytes_per_step<const D: usize>(block: &Block) -> usize {
    let number = size_of::<f64>();
    let vector = D * number;
    // In plane strain nobody reads what leaves the plane.
    let stress = if D > 2 { 6 } else { 4 } * number;
    let boxes = if block.shape == "gimp" { vector } else { 0 };
    // Cells are written only where one has changed.
    let locate = vector + size_of::<u32>();
    let to_nodes = size_of::<u32>() + 2 * vector + 2 * number + stress + boxes;
    // Position, velocity, box, stress and volume are changed.
    let from_nodes = 2 * (3 * vector + stress + number) + boxes;
    let moments = if block.update == "apic" { 3 * D * vector } else { 0 };
    locate + to_nodes + from_nodes + moments
}

/// What must be the same in all programs: mean velocity (m/s) and mean stress (Pa) along the last axis.
fn check<const D: usize>(solver: &Solver<D>) -> serde_json::Value {
    let particles = solver.particles();
    let count = particles.len() as f64;
    let velocity: f64 = particles.velocity.iter().map(|velocity| velocity[D - 1]).sum();
    let stress: f64 = particles.stress.iter().map(|stress| [stress.xx, stress.yy, stress.zz][D - 1]).sum();
    json!({ "total_steps": solver.steps(), "mean_v": velocity / count, "probe": stress / count })
}
