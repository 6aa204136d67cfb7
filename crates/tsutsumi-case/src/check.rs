//! What a case amounts to before it is run: derived numbers, limits, size.

use std::fmt;

use tsutsumi::solver::{Memory, StepLimits};
use tsutsumi::tensor::Vector;

use crate::build::build;
use crate::fill::bounds;
use crate::run::{Steps, read_case, refuse_unstable, significant};
use crate::{Case, CaseError, CaseSource, Registry};

/// The numbers that follow from a case.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckReport {
    /// The title of the case.
    pub title: String,
    /// The dimension of space.
    pub dimension: usize,
    /// The bodies.
    pub bodies: Vec<BodyNumbers>,
    /// The limits of the time step; `None` for implicit finite elements.
    pub limits: Option<StepLimits>,
    /// The step at the start (s).
    pub step: f64,
    /// Estimated number of steps.
    pub steps: u64,
    /// Cells of the grid, and those that hold particles.
    pub cells: [usize; 2],
    /// Particles.
    pub particles: usize,
    /// Memory from step to step (bytes), with the particles' places at the start; without that of the pressure solve.
    pub memory: Memory,
    /// Estimated memory of the pressure solve (bytes); none in dry ground.
    pub pressure_memory: Option<usize>,
    /// True when the case runs only with `--allow-unstable`.
    pub unstable: bool,
}

/// The derived numbers of a body's material.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyNumbers {
    /// The name of the body.
    pub name: String,
    /// The law.
    pub law: String,
    /// Oedometric modulus at the start (Pa).
    pub modulus: f64,
    /// Drained compression wave speed (m/s).
    pub drained_speed: f64,
    /// Undrained compression wave speed (m/s); none in dry ground.
    pub undrained_speed: Option<f64>,
    /// Coefficient of consolidation with the fluid's compressibility (m²/s); none in dry ground.
    pub consolidation: Option<f64>,
    /// H²/c_v (s), with the height of the body; none in dry ground.
    pub consolidation_time: Option<f64>,
}

/// Checks a case and works out its numbers.
///
/// # Errors
/// Everything that is wrong with the case. A fixed step beyond the stable limit is one, unless `allow_unstable`.
pub fn check(source: &CaseSource, registry: &Registry, allow_unstable: bool) -> Result<CheckReport, CaseError> {
    let case = read_case(source)?;
    match case.dimension {
        1 => check_in::<1>(source, &case, registry, allow_unstable),
        2 => check_in::<2>(source, &case, registry, allow_unstable),
        _ => check_in::<3>(source, &case, registry, allow_unstable),
    }
}

fn check_in<const D: usize>(
    source: &CaseSource,
    case: &Case,
    registry: &Registry,
    allow_unstable: bool,
) -> Result<CheckReport, CaseError> {
    let simulation = build::<D>(source, case, registry)?;
    let model = simulation.model();
    let stable = refuse_unstable(source, case, model);
    let unstable = stable.is_err();
    if !allow_unstable {
        stable?;
    }
    let first = Steps::up_to(case.output.every.min(case.time.end), case, model);
    let grid = model.grid();
    let (memory, places) = (model.memory(), model.particles().len() * size_of::<Vector<D>>());
    let numbers = |(index, body): (usize, &crate::Body)| {
        let group = &model.groups()[index];
        let (modulus, _) = group.wave_moduli(&mut model.particles().stress.within(group.particles()));
        let (lower, upper) = bounds(&body.shape, grid);
        body_numbers(case, body, modulus, upper[D - 1] - lower[D - 1])
    };
    Ok(CheckReport {
        title: case.title.clone(),
        dimension: D,
        bodies: case.bodies.iter().enumerate().map(numbers).collect(),
        limits: model.step_limits(),
        step: first.dt,
        steps: (case.time.end / first.dt).round() as u64,
        cells: [grid.num_cells(), model.active().cells().len()],
        particles: model.particles().len(),
        memory: Memory { particles: memory.particles + places, ..memory },
        pressure_memory: case
            .fluid
            .as_ref()
            .map(|_| pressure_bytes::<D>(grid.num_nodes(), model.active().cells().len(), 1 << D)),
        unstable,
    })
}

fn body_numbers(case: &Case, body: &crate::Body, modulus: f64, height: f64) -> BodyNumbers {
    let material = &case.materials[&body.material];
    let wet = case.fluid.as_ref().zip(material.porosity).zip(material.conductivity);
    let undrained =
        wet.map(|((fluid, porosity), _)| ((modulus + fluid.bulk_modulus / porosity) / material.density).sqrt());
    let consolidation = wet.map(|((fluid, porosity), conductivity)| {
        conductivity / fluid.unit_weight / (1.0 / modulus + porosity / fluid.bulk_modulus)
    });
    BodyNumbers {
        name: body.name().to_owned(),
        law: material.law.clone(),
        modulus,
        drained_speed: (modulus / material.density).sqrt(),
        undrained_speed: undrained,
        consolidation,
        consolidation_time: consolidation.map(|c_v| height * height / c_v),
    }
}

/// Memory that the pressure solve takes (bytes), about: without the matrix of the direct solver, which narrow grounds have.
fn pressure_bytes<const D: usize>(nodes: usize, cells: usize, stencil: usize) -> usize {
    let (vector, number, index) = (size_of::<Vector<D>>(), size_of::<f64>(), size_of::<u32>());
    // Relaxation, compliance and a work field; the cells around a node.
    let of_node = 3 * vector + index;
    // The divergence with its places; box and coefficients; inner faces and sides that may open or drain; unknowns and work arrays.
    let of_cell = stencil * (vector + 2 * index)
        + 2 * vector
        + 5 * number
        + D * (2 * number + 3 * index)
        + 2 * D * 6 * number
        + 8 * number
        + 3 * index;
    nodes * of_node + cells * of_cell
}

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} ({}-D)", self.title, self.dimension)?;
        for body in &self.bodies {
            writeln!(f, "\nbody `{}`, {}", body.name, body.law)?;
            line(f, "oedometric modulus", body.modulus, "Pa")?;
            line(f, "drained wave speed", body.drained_speed, "m/s")?;
            if let Some(speed) = body.undrained_speed {
                line(f, "undrained wave speed", speed, "m/s")?;
            }
            if let Some(c_v) = body.consolidation {
                line(f, "coefficient of consolidation c_v", c_v, "m²/s")?;
            }
            if let Some(time) = body.consolidation_time {
                line(f, "consolidation time H²/c_v", time, "s")?;
            }
        }
        writeln!(f, "\ntime step")?;
        match &self.limits {
            Some(limits) => write_limits(f, limits)?,
            None => writeln!(f, "  {:<34} none: implicit", "limit")?,
        }
        line(f, "step", self.step, "s")?;
        writeln!(f, "  {:<34} {}", "steps", self.steps)?;
        if self.unstable {
            writeln!(f, "  the step is longer than the limit: it runs only with --allow-unstable")?;
        }
        writeln!(f, "\nsize")?;
        writeln!(f, "  {:<34} {} ({} with particles)", "cells", self.cells[0], self.cells[1])?;
        writeln!(f, "  {:<34} {}", "particles", self.particles)?;
        self.write_memory(f)
    }
}

impl CheckReport {
    fn write_memory(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Memory { particles, histories, velocity_update, grid } = self.memory;
        let of_each = |bytes: usize| format!("{:.0} B per particle", bytes as f64 / self.particles as f64);
        let total = self.memory.total() + self.pressure_memory.unwrap_or(0);
        writeln!(f, "  {:<34} {}, {}", "memory", size(total), of_each(total))?;
        writeln!(f, "  {:<34} {}", "  particles", of_each(particles))?;
        for (name, bytes) in [("  histories of the laws", histories), ("  velocity update", velocity_update)] {
            if bytes > 0 {
                writeln!(f, "  {name:<34} {}", of_each(bytes))?;
            }
        }
        write!(f, "  {:<34} {}", "  grid", size(grid))?;
        match self.pressure_memory {
            Some(bytes) => write!(f, "\n  {:<34} {}, about", "  pressure solve", size(bytes)),
            None => Ok(()),
        }
    }
}

/// A number of bytes in a unit that suits it.
fn size(bytes: usize) -> String {
    let (size, unit) = match bytes as f64 {
        bytes if bytes < 1e6 => (bytes / 1024.0, "KiB"),
        bytes if bytes < 1e9 => (bytes / 1024.0_f64.powi(2), "MiB"),
        bytes => (bytes / 1024.0_f64.powi(3), "GiB"),
    };
    format!("{size:.1} {unit}")
}

fn write_limits(f: &mut fmt::Formatter<'_>, limits: &StepLimits) -> fmt::Result {
    line(f, "limit: consolidation", limits.consolidation, "s")?;
    let skeleton = if limits.consolidation.is_finite() { "limit: hourglass modes" } else { "limit: compression wave" };
    line(f, skeleton, limits.skeleton, "s")?;
    line(f, "limit: shear wave", limits.shear, "s")?;
    writeln!(f, "  {:<34} {}", "governs", limits.governing)
}

fn line(f: &mut fmt::Formatter<'_>, name: &str, value: f64, unit: &str) -> fmt::Result {
    match value.is_finite() {
        true => writeln!(f, "  {name:<34} {} {unit}", significant(value)),
        false => writeln!(f, "  {name:<34} none"),
    }
}
