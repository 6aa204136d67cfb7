//! What it costs that the parts of a step are chosen by name: the same block stepped by a loop compiled for its parts, by the same loop with parts behind
//! pointers, and by the solver, in turns.
//!
//! ```text
//! cargo run --release -p tsutsumi-benches --bin dispatch -- --particles 100000
//! valgrind --tool=callgrind target/release/dispatch --only static --steps 5    # or boxed, solver: the instructions
//! ```

#![allow(clippy::print_stdout, reason = "it is what the program is for")]

use std::error::Error;
use std::time::Instant;

use clap::{Parser, ValueEnum};
use tsutsumi_benches::block::Block;
use tsutsumi_benches::dispatch::{Boxed, Static, Steps, fingerprint};

/// Compares steps whose parts are known when the program is built with those whose parts are chosen by name.
#[derive(Debug, Parser)]
struct Arguments {
    /// The number of particles wanted.
    #[arg(long, default_value_t = 100_000)]
    particles: usize,
    /// Steps in a turn.
    #[arg(long, default_value_t = 20)]
    steps: usize,
    /// How often each has its turn.
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u64).range(1..))]
    turns: u64,
    /// Does the steps of one of them and times nothing.
    #[arg(long)]
    only: Option<Way>,
}

/// A way of stepping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Way {
    /// The loop compiled for its parts.
    Static,
    /// The loop with parts behind pointers.
    Boxed,
    /// The solver.
    Solver,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    match arguments.only {
        Some(way) => advance(&mut *prepare(way, arguments.particles)?, dt(arguments.particles)?, arguments.steps),
        None => compare(&arguments),
    }
}

fn prepare(way: Way, particles: usize) -> Result<Box<dyn Steps>, Box<dyn Error>> {
    Ok(match way {
        Way::Static => Box::new(Static::new(particles)?),
        Way::Boxed => Box::new(Boxed::new(particles)?),
        Way::Solver => Box::new(Block::linear(particles).build::<2>()?),
    })
}

/// The block's step (s).
fn dt(particles: usize) -> Result<f64, Box<dyn Error>> {
    let block = Block::linear(particles);
    Ok(block.step(&block.build::<2>()?))
}

fn advance(stepping: &mut dyn Steps, dt: f64, steps: usize) -> Result<(), Box<dyn Error>> {
    for _ in 0..steps {
        stepping.step(dt)?;
    }
    Ok(())
}

/// Times all ways in turns and prints their ratios, each taken within a turn.
fn compare(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let dt = dt(arguments.particles)?;
    let mut all = Vec::new();
    for way in [Way::Static, Way::Boxed, Way::Solver] {
        all.push(prepare(way, arguments.particles)?);
    }
    let mut turns = Vec::new();
    for turn in 0..=arguments.turns as usize {
        let mut seconds = [0.0; 3];
        for place in 0..all.len() {
            // None is always the first.
            let number = (place + turn) % all.len();
            let start = Instant::now();
            advance(&mut *all[number], dt, arguments.steps)?;
            seconds[number] = start.elapsed().as_secs_f64();
        }
        turns.push(seconds);
    }
    // In the first turn memory is set aside.
    turns.remove(0);
    let particles = all[0].particles().len();
    let expected = fingerprint(all[0].particles());
    if all.iter().any(|stepping| fingerprint(stepping.particles()) != expected) {
        return Err("the three do not give the same numbers".into());
    }
    let per_particle = 1e9 / (particles * arguments.steps) as f64;
    for (name, number) in [("static", 0), ("boxed", 1), ("solver", 2)] {
        let [median, least, most] = spread(turns.iter().map(|turn| turn[number] * per_particle));
        println!("{name:<7} {median:7.2} ns per particle and step ({least:.2} to {most:.2})");
    }
    let [median, least, most] = spread(turns.iter().map(|turn| turn[1] / turn[0]));
    println!("boxed over static {median:.4} ({least:.4} to {most:.4}), {particles} particles, the same bits");
    let [median, least, most] = spread(turns.iter().map(|turn| turn[2] / turn[0]));
    println!("solver over static {median:.4} ({least:.4} to {most:.4})");
    Ok(())
}

/// Median, least and most.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[0], values[values.len() - 1]]
}
