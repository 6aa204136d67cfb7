//! `check` states the memory that a case takes.

use tsutsumi_case::{CaseSource, Registry, build::build, check};

const DRY_SQUARE: &str = r#"
title = "Dry square"
dimension = 2
gravity = [0.0, -9.8]
[grid]
origin = [0.0, 0.0]
spacing = [0.1, 0.1]
cells = [60, 61]
[time]
end = 1.0
step = 1e-4
[materials.soil]
law = "linear-elastic"
parameters = { young = 1e7, poisson = 0.3 }
density = 1600.0
[[bodies]]
material = "soil"
shape = { box = { min = [0.0, 0.0], max = [6.0, 6.0] } }
particles_per_cell = [2, 2]
[output]
every = 0.5
"#;

/// Two steps set aside all memory of dry ground. What is not counted are names, lists of loads and the like: 2 % at most.
#[test]
fn check_states_what_a_dry_case_takes() {
    let source = CaseSource::from_text("dry.toml", DRY_SQUARE);
    let registry = Registry::built_in();
    let stated = check(&source, &registry, false).unwrap();
    assert_eq!(stated.pressure_memory, None);

    let case = source.parse().unwrap();
    let mut kept = None;
    let measured = allocation_counter::measure(|| {
        let mut simulation = build::<2>(&source, &case, &registry).unwrap();
        (0..2).for_each(|_| assert!(simulation.model_mut().step(1e-4).is_ok()));
        kept = Some(simulation);
    });
    let (stated, measured) = (stated.memory.total() as f64, measured.bytes_current as f64);
    assert!((stated / measured - 1.0).abs() < 0.02, "{stated} bytes stated, {measured} measured");
}
