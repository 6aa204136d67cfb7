//! Time per step of the paper's column, as one line of JSON.
//!
//! ```text
//! cargo run --release -p tsutsumi-benches --bin column -- --cells 10
//! ```

#![allow(clippy::print_stdout, reason = "it is what the program is for")]

use std::error::Error;
use std::time::Instant;

use clap::Parser;
use serde_json::json;
use tsutsumi::boundary::History;
use tsutsumi::pressure::Quadrature;
use tsutsumi::solver::Solver;
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::reading::{outermost, surface, top};

/// The paper's step (s).
const STEP: f64 = 5e-4;

/// The height (m), the load (Pa) and the end of its ramp (s).
const HEIGHT: f64 = 10.0;
const LOAD: f64 = 50e3;
const RAMP: f64 = 1000.0;

/// Steps the paper's column, 10 m high, and says how long a step takes.
#[derive(Debug, Parser)]
struct Arguments {
    /// Cells above each other, four particles in each; the paper's column has 10.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    cells: u32,
    /// Steps timed at a time.
    #[arg(long, default_value_t = 20_000)]
    steps: usize,
    /// How often; the median counts.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    repeats: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let mut solver = column(arguments.cells);
    advance(&mut solver, STEP, 5)?;
    let mut seconds = Vec::new();
    for _ in 0..arguments.repeats {
        let start = Instant::now();
        advance(&mut solver, STEP, arguments.steps)?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    let us_per_step = 1e6 * seconds[seconds.len() / 2] / arguments.steps as f64;
    let settlement = settlement(arguments.cells)?;
    let check = json!({ "settlement": settlement });
    println!("{}", json!({ "tool": "tsutsumi", "cells": arguments.cells, "us_per_step": us_per_step, "check": check }));
    Ok(())
}

fn column(cells: u32) -> Solver<2> {
    let ramp = History::new(vec![[0.0, 0.0], [RAMP, 1.0]]);
    let body = Body::<2>::column(HEIGHT, HEIGHT / f64::from(cells)).quadrature(Quadrature::Cell);
    body.drained(top::<2>()).load_on_surface(top::<2>(), down(LOAD), ramp).build()
}

fn advance(solver: &mut Solver<2>, dt: f64, steps: usize) -> Result<(), Box<dyn Error>> {
    for _ in 0..steps {
        solver.step(dt)?;
    }
    Ok(())
}

/// The fall of the surface at the end of loading (m), in steps as long as they may be: it is the right problem.
fn settlement(cells: u32) -> Result<f64, Box<dyn Error>> {
    let mut solver = column(cells);
    let top_particles = outermost(solver.particles(), top::<2>());
    let steps = (RAMP / (0.9 * solver.step_limits().longest())).ceil();
    advance(&mut solver, RAMP / steps, steps as usize)?;
    Ok(HEIGHT - surface(solver.particles(), &top_particles, top::<2>()))
}
