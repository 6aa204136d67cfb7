//! What a run writes does not show that its particles change their places in memory.

use std::fs;
use std::path::PathBuf;

use crate::build::build;
use crate::pictures::Snapshot;
use crate::results::write_particles;
use crate::simulation::Simulation;
use crate::{CaseSource, Registry};

/// Two bodies that turn and shear as they fly, one of a law with a history, with a load, water around and all that is read off.
const CASE: &str = r#"
title = "Two bodies that fly and turn"
dimension = 2
gravity = [0.0, -9.8]
grid = { origin = [0.0, 0.0], spacing = [1.0, 1.0], cells = [16, 12] }
time = { end = 0.1, step = 1.0e-3 }

[materials.clay]
law = "modified-cam-clay"
density = 1800.0
parameters = { critical_state_ratio = 1.2, lambda = 0.2, kappa = 0.05, poisson = 0.3, void_ratio = 1.0, preconsolidation_pressure = 600.0e3 }

[materials.rock]
law = "linear-elastic"
parameters = { young = 2.0e6, poisson = 0.2 }
density = 2000.0

[[bodies]]
name = "lower"
material = "clay"
shape = { box = { min = [3.0, 3.0], max = [7.0, 5.0] } }
particles_per_cell = [2, 2]
initial = { velocity = [12.0, 6.0], geostatic = { surface = 12.0, k0 = 0.7 } }

[[bodies]]
name = "upper"
material = "rock"
shape = { box = { min = [3.0, 5.0], max = [7.0, 7.0] } }
particles_per_cell = [2, 2]
initial = { velocity = [4.0, 6.0] }

[[loads]]
on = { of = "upper", surface = "y-max" }
pressure = 3.0e3
history = [[0.0, 0.0], [0.05, 1.0]]

[[loads]]
on = { of = "lower", surface = "all" }
pressure = 1.0e3
history = [[0.0, 1.0]]

[[probes]]
name = "corner"
displacement_at = [6.9, 6.9]
pressure_at = [5.0, 5.0]

[output]
every = 0.05
"#;

/// A simulation as the case says, after some steps; the particles are sorted in each of them or never.
fn after(text: &str, steps: usize, sorted: bool) -> Simulation<2> {
    let source = CaseSource::from_text("case.toml", text);
    let mut simulation = build::<2>(&source, &source.parse().unwrap(), &Registry::built_in()).unwrap();
    for _ in 0..steps {
        if sorted {
            simulation.model_mut().sort_in_next_step();
        }
        simulation.model_mut().step(1e-3).unwrap();
    }
    assert_eq!(simulation.model().particles().numbers().is_empty(), !sorted);
    simulation
}

#[test]
fn readings_files_and_pictures_are_the_same() {
    let [plain, sorted] = [false, true].map(|sorted| after(CASE, 100, sorted));
    let numbers = sorted.model().particles().numbers();
    assert!(!numbers.is_sorted(), "particles have changed places");
    let readings = plain.readings().into_iter().zip(sorted.readings());
    for (name, (one, other)) in plain.reading_names().into_iter().zip(readings) {
        // Sums over 64 particles in another order, and over 100 steps: round-off. The rest is the same in every bit.
        let is_sum = ["energy", "noise", "angular"].iter().any(|sum| name.starts_with(sum));
        let tolerance = if is_sum { 1e-11 * one.abs() } else { 0.0 };
        assert!((one - other).abs() <= tolerance || (one.is_nan() && other.is_nan()), "{name}: {one} and {other}");
    }
    let written = [&plain, &sorted].map(|simulation| {
        let path: PathBuf = std::env::temp_dir().join(format!("tsutsumi-order-{}.vtu", std::process::id()));
        write_particles(&path, 0.0, simulation).unwrap();
        let bytes = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        bytes
    });
    assert!(written[0] == written[1], "particles in the order of their numbers");
    let [one, other] = [&plain, &sorted].map(Snapshot::take);
    assert_eq!((one.position, one.half_size, one.pressure), (other.position, other.half_size, other.pressure));
}
