//! Modules form floors: each uses only those above it.

use std::fs;

use crate::{files, read, root};

/// The modules of the core, from the table in its documentation.
fn floors() -> Vec<String> {
    let text = read("crates/tsutsumi/src/lib.rs");
    let rows = text.lines().filter_map(|line| line.strip_prefix("//! | "));
    // Private rooms are not linked.
    let names = rows.filter_map(|row| row.trim_start_matches('[').strip_prefix('`'));
    names.map(|row| row.split('`').next().unwrap().to_owned()).collect()
}

#[test]
fn the_core_uses_only_the_rooms_above() {
    let floors = floors();
    let floor_of = |name: &str| floors.iter().position(|floor| floor == name);
    let source = root().join("crates/tsutsumi/src");
    for file in files("crates/tsutsumi/src", "rs") {
        let room = file.strip_prefix(&source).unwrap().iter().next().unwrap().to_string_lossy().replace(".rs", "");
        let Some(here) = floor_of(&room) else {
            assert_eq!(room, "lib", "{} is on no floor of the table in lib.rs", file.display());
            continue;
        };
        let text = fs::read_to_string(&file).unwrap();
        let code = text
            .lines()
            .take_while(|line| !line.starts_with("#[cfg(test)]"))
            .filter(|line| !line.trim().starts_with("//"));
        for used in code.flat_map(|line| line.split("crate::").skip(1)) {
            let name: String = used.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let there = floor_of(&name).unwrap_or_else(|| panic!("{}: unknown room `{name}`", file.display()));
            assert!(there <= here, "{}: `{room}` uses `{name}`, which is below it", file.display());
        }
    }
}

#[test]
fn crates_depend_only_on_those_above() {
    let order = ["tsutsumi", "tsutsumi-reference", "tsutsumi-case", "tsutsumi-cli"];
    for (here, name) in order.iter().enumerate() {
        let manifest = read(format!("crates/{name}/Cargo.toml"));
        let dependencies = manifest.split("[dependencies]").nth(1).unwrap().split("\n[").next().unwrap();
        for below in &order[here + 1..] {
            let uses = dependencies.lines().any(|line| line.split(['.', ' ', '=']).next() == Some(below));
            assert!(!uses, "{name} depends on {below}");
        }
    }
}

/// The names of variants live in the registry alone.
#[test]
fn the_core_names_no_variants() {
    for file in files("crates/tsutsumi/src", "rs") {
        let text = fs::read_to_string(&file).unwrap();
        let code = text.lines().filter(|line| !line.trim().starts_with("//"));
        for line in code {
            for name in ["\"linear\"", "\"mpm1\"", "\"mpm2\"", "\"linear-elastic\""] {
                assert!(!line.contains(name), "{}: {line}", file.display());
            }
        }
    }
}
