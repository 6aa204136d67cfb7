//! The parameter sets under `materials/` are what a case takes.

use std::fs;

use tsutsumi_case::{CaseSource, Registry, check};

use crate::files;

/// A box of ground of each material, in plane strain.
const GROUND: &str = r#"
title = "Ground"
dimension = 2
[grid]
origin = [0.0, 0.0]
spacing = [1.0, 1.0]
cells = [1, 1]
[time]
end = 1.0
step = "auto"
[output]
every = 1.0
"#;

/// What a parameter set leaves to the case.
const OF_THE_CASE: &str = "density = 1900.0\nporosity = 0.45\nconductivity = 1.0e-4\n";

#[test]
fn parameter_sets_are_accepted_as_they_stand() {
    let sets = files("materials", "toml");
    assert!(!sets.is_empty());
    for path in sets {
        let set = fs::read_to_string(&path).unwrap();
        let mut case = GROUND.to_owned();
        for line in set.lines() {
            case += &format!("{line}\n");
            if line.starts_with("law = ") {
                case += OF_THE_CASE;
            }
        }
        for name in set.lines().filter_map(|line| line.strip_prefix("[materials.")?.strip_suffix(".parameters]")) {
            case += &format!("[[bodies]]\nmaterial = \"{name}\"\nparticles_per_cell = [1, 1]\n");
            case += "shape = { box = { min = [0.0, 0.0], max = [1.0, 1.0] } }\n";
        }
        let source = CaseSource::from_text(path.clone(), &case);
        check(&source, &Registry::built_in(), true).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
}
