//! Can others read what a run writes? Each dimension's fields are read with VTK (which is ParaView's reader) and with
//! meshio, two readers that share no code with ours, and what they see must agree bit for bit.
//!
//! The two are Python packages, with the versions of `requirements.txt`. The test puts them into a virtual environment
//! under cargo's target folder, once. Where that cannot be done (no Python, no network) it says so on the standard error
//! and looks at the files only roughly; with the environment variable `CI` set it fails instead, so that nobody believes
//! a check that was not made.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test reports by panicking")]

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tsutsumi_case::{CaseSource, Registry, RunOptions, Silent, run};

const REQUIREMENTS: &str = include_str!("requirements.txt");

/// What the test may write to, kept between runs.
fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// A saturated block, 4 m high, with other numbers of cells and particles along each axis.
fn block(dimension: usize) -> String {
    let last = |all: &[&str]| format!("[{}]", all[3 - dimension..].join(", "));
    let axes = &["x", "y", "z"][..dimension];
    let up = axes[dimension - 1];
    let rollers: String = axes[..dimension - 1]
        .iter()
        .flat_map(|axis| {
            ["min", "max"].map(|end| format!("[[supports]]\nface = \"{axis}-{end}\"\nfix = [\"{axis}\"]\n"))
        })
        .collect();
    format!(
        r#"
title = "Block in {dimension}-D"
dimension = {dimension}
grid = {{ origin = {origin}, spacing = {spacing}, cells = {cells} }}
time = {{ end = 20.0, step = "auto" }}
fluid = {{ density = 1000.0, bulk_modulus = 2.2e9, unit_weight = 9800.0 }}
output = {{ every = 10.0, figures = false }}

[materials.soil]
law = "linear-elastic"
parameters = {{ young = 4.35e6, poisson = 0.45 }}
density = 1500.0
porosity = 0.4
conductivity = 5.52e-5

[[bodies]]
material = "soil"
shape = {{ box = {{ min = {origin}, max = {top} }} }}
particles_per_cell = {particles}

{rollers}
[[supports]]
face = "{up}-min"
fix = ["{up}"]

[[loads]]
on = {{ surface = "{up}-max", of = "soil" }}
traction = {traction}
history = [[0.0, 0.0], [20.0, 1.0]]

[[drainage]]
on = {{ surface = "{up}-max", of = "soil" }}
"#,
        origin = last(&["-1.0", "0.0", "0.5"]),
        spacing = last(&["0.5", "1.0", "1.0"]),
        cells = last(&["4", "3", "5"]),
        top = last(&["1.0", "3.0", "4.5"]),
        particles = last(&["1", "3", "2"]),
        traction = last(&["0.0", "0.0", "-50.0e3"]),
    )
}

/// The particles of [`block`], counted by hand.
const NUM_PARTICLES: [usize; 3] = [4 * 2, 4 * 2 * (3 * 3), 4 * 2 * (3 * 3) * 4];
/// At 0, 10 and 20 s.
const NUM_OUTPUTS: usize = 3;

/// Runs the block and gives its results folder.
fn results_of_block(dimension: usize, name: &str) -> PathBuf {
    let folder = scratch(name);
    let source = CaseSource::from_text("block.toml", block(dimension));
    let options = RunOptions { out: Some(folder.clone()), force: true, ..RunOptions::default() };
    run(&source, &Registry::built_in(), &options, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    folder
}

/// The interpreter of an environment with the readers in it, or why there is none.
fn python() -> Result<PathBuf, String> {
    let environment = scratch("readers");
    // Two test runs at a time must not both make it.
    let lock = File::create(scratch("readers.lock")).unwrap();
    lock.lock().unwrap();
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    // Written last: without it the environment is unfinished or of other versions.
    let done = environment.join("installed.txt");
    if fs::read_to_string(&done).is_ok_and(|installed| installed == REQUIREMENTS) {
        return Ok(python);
    }
    let requirements = scratch("requirements.txt");
    fs::write(&requirements, REQUIREMENTS).unwrap();
    let base = if cfg!(windows) { "python" } else { "python3" };
    succeed(Command::new(base).args(["-m", "venv", "--clear"]).arg(&environment))?;
    succeed(Command::new(&python).args(["-m", "pip", "install", "--quiet", "-r"]).arg(&requirements))?;
    fs::write(done, REQUIREMENTS).unwrap();
    Ok(python)
}

/// Runs a program to its end; gives what it printed, or what went wrong.
fn succeed(command: &mut Command) -> Result<String, String> {
    let output = command.stdin(Stdio::null()).output().map_err(|error| format!("{command:?}: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    match output.status.success() {
        true => Ok(text(&output.stdout)),
        false => Err(format!("{command:?}: {}\n{}", output.status, text(&output.stderr))),
    }
}

#[test]
fn vtk_and_meshio_read_the_fields() {
    let python = match python() {
        Ok(python) => python,
        Err(reason) if std::env::var_os("CI").is_some() => panic!("no readers: {reason}"),
        Err(reason) => {
            // Past the capture of the test harness, which shows nothing of a test that passes.
            let _ = writeln!(std::io::stderr(), "\nWARNING: the fields were NOT read with VTK and meshio: {reason}\n");
            return;
        }
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("readers/check_vtk.py");
    for dimension in 1..=3 {
        let folder = results_of_block(dimension, &format!("block-{dimension}d"));
        let particles = NUM_PARTICLES[dimension - 1].to_string();
        let said = succeed(Command::new(&python).arg(&script).arg(&folder).args(["--expect-points", &particles]))
            .unwrap_or_else(|error| panic!("{dimension}-D: {error}"));
        // A file of particles and one of cells for each output.
        assert!(said.starts_with(&format!("{} files, ", 2 * NUM_OUTPUTS)) && said.ends_with("ok"), "{said}");
    }
}

/// What can be seen without a reader: XML up to the binary part, the numbers of points in it, all files there.
#[test]
fn the_fields_are_well_formed() {
    let dimension = 2;
    let folder = results_of_block(dimension, "block-well-formed");
    for (collection, expected) in [("particles.pvd", NUM_PARTICLES[dimension - 1]), ("grid.pvd", 4 * 5)] {
        let text = fs::read_to_string(folder.join(collection)).unwrap();
        let files = files_of_collection(&text);
        assert_eq!(files.len(), NUM_OUTPUTS, "{collection}");
        for file in files {
            assert_eq!(num_points(&folder.join(&file)), expected, "{file}");
        }
    }
}

fn files_of_collection(text: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(text).unwrap();
    let entries = document.descendants().filter(|node| node.has_tag_name("DataSet"));
    entries.map(|node| node.attribute("file").unwrap().to_owned()).collect()
}

/// The number of points that a `.vtu` announces.
fn num_points(file: &Path) -> usize {
    let bytes = fs::read(file).unwrap();
    assert!(bytes.ends_with(b"\n</AppendedData>\n</VTKFile>\n"), "{}", file.display());
    let tag = b"<AppendedData";
    let end = bytes.windows(tag.len()).position(|window| window == tag).unwrap();
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap() + "</VTKFile>";
    let document = roxmltree::Document::parse(&head).unwrap();
    let piece = document.descendants().find(|node| node.has_tag_name("Piece")).unwrap();
    piece.attribute("NumberOfPoints").unwrap().parse().unwrap()
}
