//! The results folder: manifest, case, histories, fields.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use tsutsumi::grid::Grid;
use tsutsumi::tensor::{Sym3, Vector};

use crate::folder::{CASE, FAILED_POINT, FIELDS, FIGURES, GRID, HISTORY, MANIFEST, PARTICLES, claim, write_error};
use crate::simulation::{Balances, Simulation};
use crate::vtk::{Collection, Field, Lattice, VtkError, write_cells, write_points};
use crate::{CaseSource, FigureError};

/// Why results could not be written. What was written before stays.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The folder asked for holds a file that a run would replace.
    #[error(
        "`{}` holds `{}` already: choose another folder with --out, or replace the results in it with --force",
        path.display(),
        file.display()
    )]
    Occupied {
        /// The folder.
        path: PathBuf,
        /// The file, within the folder.
        file: PathBuf,
    },
    /// The path asked for is no folder.
    #[error("`{}` is a file, not a folder: choose another one with --out", path.display())]
    NotAFolder {
        /// The path.
        path: PathBuf,
    },
    /// The copy of the case would replace the case itself.
    #[error("the results would replace the case file `{}`: choose another folder with --out", path.display())]
    OverTheCase {
        /// The case file.
        path: PathBuf,
    },
    /// A file or folder could not be written.
    #[error("cannot write `{}`: {source}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        #[source]
        source: io::Error,
    },
    /// A field file could not be written.
    #[error(transparent)]
    Vtk(#[from] VtkError),
    /// A figure could not be written.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "reason")]
pub enum Outcome {
    /// It reached its end.
    Finished,
    /// It was stopped; the results up to then are whole.
    Interrupted,
    /// A step failed for this reason; the results up to then are whole.
    Failed(String),
    /// It has not ended yet, or was killed.
    Running,
}

/// What a run cost.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Performance {
    /// Time steps made.
    pub steps: u64,
    /// Wall time of the step loop (s), without output.
    pub wall_s: f64,
    /// Particles times steps over wall time (1/s).
    pub particle_steps_per_s: f64,
    /// Iterations of the pressure solver in all; 0 with the direct solver.
    pub pressure_iterations: u64,
}

/// `manifest.json`: what was run, where, and how it ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Manifest {
    pub(crate) program: &'static str,
    pub(crate) version: &'static str,
    pub(crate) title: String,
    pub(crate) case: PathBuf,
    pub(crate) overrides: Vec<String>,
    pub(crate) host: Host,
    pub(crate) started_unix_s: u64,
    pub(crate) dimension: usize,
    pub(crate) particles: usize,
    pub(crate) cells: usize,
    pub(crate) outcome: Outcome,
    pub(crate) time: f64,
    pub(crate) balances: Balances,
    pub(crate) performance: Performance,
}

/// The machine of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Host {
    operating_system: &'static str,
    architecture: &'static str,
    cores: usize,
}

impl Host {
    pub(crate) fn this() -> Self {
        Host {
            operating_system: std::env::consts::OS,
            architecture: std::env::consts::ARCH,
            cores: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }
}

/// A results folder that is being written.
pub(crate) struct Results {
    folder: PathBuf,
    history: csv::Writer<BufWriter<File>>,
    particles: Collection,
    grid: Collection,
    frames: usize,
    /// The history in memory, row by row, for the figures.
    pub(crate) rows: Vec<Vec<f64>>,
    pub(crate) names: Vec<String>,
}

impl Results {
    /// Makes the folder, with a copy of the case, and the head of the history.
    pub(crate) fn create(
        source: &CaseSource,
        out: Option<&Path>,
        force: bool,
        names: Vec<String>,
    ) -> Result<Self, ResultsError> {
        let folder = claim(source, out, force)?;
        for below in [FIELDS, FIGURES] {
            let below = folder.join(below);
            fs::create_dir_all(&below).map_err(write_error(&below))?;
        }
        let case = folder.join(CASE);
        fs::write(&case, source.text()).map_err(write_error(&case))?;
        let path = folder.join(HISTORY);
        let file = File::create(&path).map_err(write_error(&path))?;
        let mut history = csv::Writer::from_writer(BufWriter::new(file));
        history.write_record(&names).map_err(|error| write_error(&path)(error.into()))?;
        let particles = Collection::new(folder.join(PARTICLES));
        let grid = Collection::new(folder.join(GRID));
        Ok(Results { folder, history, particles, grid, frames: 0, rows: Vec::new(), names })
    }

    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Appends a row to the history, on disk at once.
    pub(crate) fn write_row(&mut self, row: Vec<f64>) -> Result<(), ResultsError> {
        // `step` is a count; everything else has 17 significant digits.
        let text = row.iter().zip(&self.names).map(|(value, name)| match name.as_str() {
            "step" => format!("{value}"),
            _ => format!("{value:.16e}"),
        });
        let written = self.history.write_record(text).map_err(io::Error::from).and_then(|()| self.history.flush());
        written.map_err(|source| ResultsError::Write { path: self.folder.join(HISTORY), source })?;
        self.rows.push(row);
        Ok(())
    }

    /// Writes the particles and the grid as they are now.
    pub(crate) fn write_fields<const D: usize>(&mut self, simulation: &Simulation<D>) -> Result<(), ResultsError> {
        let time = simulation.model().time();
        let number = self.frames;
        let particles = format!("{FIELDS}/particles-{number:06}.vtu");
        let grid = format!("{FIELDS}/grid-{number:06}.vtu");
        write_particles(&self.folder.join(&particles), time, simulation)?;
        write_grid(&self.folder.join(&grid), time, simulation)?;
        self.particles.push(time, &particles)?;
        self.grid.push(time, &grid)?;
        self.frames += 1;
        Ok(())
    }

    /// Writes the element test of a point whose law has failed; its path.
    pub(crate) fn write_failed_point(&self, text: &str) -> Result<PathBuf, ResultsError> {
        let path = self.folder.join(FAILED_POINT);
        fs::write(&path, text).map_err(write_error(&path))?;
        Ok(path)
    }

    /// Replaces the manifest; a reader never sees half of it.
    pub(crate) fn write_manifest(&self, manifest: &Manifest) -> Result<(), ResultsError> {
        let path = self.folder.join(MANIFEST);
        replace_with_json(&path, manifest).map_err(|source| ResultsError::Write { path, source })
    }
}

/// Writes a JSON file under another name and then moves it to its place.
pub(crate) fn replace_with_json(path: &Path, content: &impl Serialize) -> io::Result<()> {
    let temporary = path.with_extension("json.tmp");
    let mut file = File::create(&temporary)?;
    serde_json::to_writer_pretty(&mut file, content)?;
    file.write_all(b"\n")?;
    fs::rename(&temporary, path)
}

/// A vector of space with zeros for the missing axes.
fn pad<const D: usize>(vector: &Vector<D>) -> [f64; 3] {
    std::array::from_fn(|axis| if axis < D { vector[axis] } else { 0.0 })
}

/// All particles in the order of their numbers, whatever their places are by now: a point of a file keeps its line from file to file.
pub(crate) fn write_particles<const D: usize>(
    path: &Path,
    time: f64,
    simulation: &Simulation<D>,
) -> Result<(), VtkError> {
    let particles = simulation.model().particles();
    let places: Vec<usize> = particles.places_by_number().collect();
    let vectors = |values: &[Vector<D>]| -> Vec<[f64; 3]> { places.iter().map(|&p| pad(&values[p])).collect() };
    let scalars = |values: &[f64]| -> Vec<f64> { places.iter().map(|&p| values[p]).collect() };
    let components = |s: Sym3| [s.xx, s.yy, s.zz, s.xy, s.yz, s.zx];
    let points = vectors(&particles.position);
    let displacement: Vec<[f64; 3]> = places.iter().map(|&p| pad(&simulation.displacement(p))).collect();
    let velocity = vectors(&particles.velocity);
    let stress: Vec<[f64; 6]> = places.iter().map(|&p| components(particles.stress.at(p))).collect();
    let half_size = vectors(&particles.half_size);
    let mut body = vec![0.0; particles.len()];
    for (number, group) in simulation.model().groups().iter().enumerate() {
        body[group.particles()].fill(number as f64);
    }
    let mut fields = vec![
        Field::scalar("pressure", scalars(&particles.pressure)),
        Field::vector("displacement", &displacement),
        Field::vector("velocity", &velocity),
        Field::symmetric_tensor("stress", &stress),
        Field::scalar("volume", scalars(&particles.volume)),
        Field::vector("half_size", &half_size),
        Field::scalar("porosity", scalars(&particles.porosity)),
        Field::scalar("body", &body),
    ];
    let outputs = law_outputs(simulation);
    fields.extend(outputs.iter().map(|(name, values)| Field::scalar(name, values)));
    write_points(path, time, &points, &fields)
}

/// The laws' own output quantities by the numbers of the particles, NaN where a particle's law has no such quantity.
fn law_outputs<const D: usize>(simulation: &Simulation<D>) -> Vec<(&'static str, Vec<f64>)> {
    let particles = simulation.model().particles();
    let mut columns: Vec<(&'static str, Vec<f64>)> = Vec::new();
    for group in simulation.model().groups() {
        let names = group.outputs();
        let mut values = vec![0.0; names.len()];
        for (i, p) in group.particles().enumerate() {
            group.write_outputs(i, particles.stress.at(p), &mut values);
            for (&name, &value) in names.iter().zip(&values) {
                let column = match columns.iter().position(|(known, _)| *known == name) {
                    Some(column) => column,
                    None => {
                        columns.push((name, vec![f64::NAN; particles.len()]));
                        columns.len() - 1
                    }
                };
                columns[column].1[particles.number(p)] = value;
            }
        }
    }
    columns
}

fn write_grid<const D: usize>(path: &Path, time: f64, simulation: &Simulation<D>) -> Result<(), VtkError> {
    let solver = simulation.model();
    let grid: &Grid<D> = solver.grid();
    let lattice = Lattice { dimension: D, origin: pad(&grid.origin()), spacing: pad(&grid.spacing()) };
    let active = solver.active().cells();
    let place = |cell: u32| {
        let index = grid.cell_index(cell as usize);
        std::array::from_fn(|axis| if axis < D { index[axis] } else { 0 })
    };
    let cells: Vec<[usize; 3]> = active.iter().map(|&cell| place(cell)).collect();
    let pressure: Vec<f64> = active.iter().map(|&cell| solver.cells().pressure[cell as usize]).collect();
    write_cells(path, time, &lattice, &cells, &[Field::scalar("pressure", pressure)])
}
