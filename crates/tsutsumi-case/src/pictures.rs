//! Which figures a run draws: settlement and pressure in time, and the deformed particles coloured by pore pressure; in ground whose stress
//! at the start is known by depth, also the pore pressure ratio and isochrones of the excess pressure.

use tsutsumi::grid::Grid;

use crate::figures::{Curve, CurveStyle, LineChart, ParticleChart};
use crate::folder::FIGURES;
use crate::results::Results;
use crate::simulation::{Simulation, outlines};
use crate::{Case, ResultsError};

/// The particles at one time, as the picture needs them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Snapshot {
    /// When it was taken (s).
    pub(crate) time: f64,
    /// The largest pore pressure of any cell (Pa).
    pub(crate) largest: f64,
    /// Centres of the particles, across and upwards (m).
    pub(crate) position: Vec<[f64; 2]>,
    /// Half their width and height (m).
    pub(crate) half_size: Vec<[f64; 2]>,
    /// Pore pressure (kPa).
    pub(crate) pressure: Vec<f64>,
}

impl Snapshot {
    /// The particles as they are now. A 3-D body is cut along its first layer of cells across y.
    pub(crate) fn take<const D: usize>(simulation: &Simulation<D>) -> Self {
        let particles = simulation.model().particles();
        let grid = simulation.model().grid();
        let in_cut = |p: &usize| D < 3 || particles.position[*p][1] <= grid.origin()[1] + grid.spacing()[1];
        let shown: Vec<usize> = particles.places_by_number().filter(in_cut).collect();
        // A 1-D column is drawn one cell height wide.
        let width = grid.spacing()[0];
        let up = D - 1;
        let place = |p: usize| match D {
            1 => [0.5 * width, particles.position[p][0]],
            _ => [particles.position[p][0], particles.position[p][up]],
        };
        let half = |p: usize| match D {
            1 => [0.5 * width, particles.half_size[p][0]],
            _ => [particles.half_size[p][0], particles.half_size[p][up]],
        };
        Snapshot {
            time: simulation.model().time(),
            largest: simulation.largest_pressure(),
            position: shown.iter().map(|&p| place(p)).collect(),
            half_size: shown.iter().map(|&p| half(p)).collect(),
            pressure: shown.iter().map(|&p| particles.pressure[p] * 1e-3).collect(),
        }
    }

    /// The largest pore pressure of any cell (Pa).
    pub(crate) fn largest(&self) -> f64 {
        self.largest
    }
}

/// Draws the figures of a run from what it has written so far.
///
/// `peak` is the body when the pore pressure was largest, `last` the body at the end.
pub(crate) fn draw<const D: usize>(
    results: &Results,
    case: &Case,
    simulation: &Simulation<D>,
    peak: &Snapshot,
    last: &Snapshot,
) -> Result<(), ResultsError> {
    let folder = results.folder().join(FIGURES);
    settlement(results, case).save(&folder.join("settlement"))?;
    let pressures = pressures(results, case);
    if !pressures.curves.is_empty() {
        pressures.save(&folder.join("pressure"))?;
    }
    let grid = simulation.model().grid();
    let excesses = excesses(results, case, grid);
    if !excesses.is_empty() {
        pressure_ratios(results, case, &excesses).save(&folder.join("pressure-ratio"))?;
    }
    if excesses.len() > 2 {
        isochrones(results, case, &excesses).save(&folder.join("isochrones"))?;
    }
    particle_chart(case, grid, last).save(&folder.join("particles"))?;
    if case.fluid.is_some() && peak.time < last.time {
        particle_chart(case, grid, peak).save(&folder.join("particles-peak"))?;
    }
    Ok(())
}

/// A column of the history.
fn column(results: &Results, name: &str) -> Option<Vec<f64>> {
    let place = results.names.iter().position(|known| known == name)?;
    Some(results.rows.iter().map(|row| row[place]).collect())
}

fn curve(results: &Results, name: &str, label: &str, factor: f64) -> Option<Curve> {
    let y = column(results, name)?.iter().map(|value| value * factor).collect();
    let x = column(results, "time")?;
    Some(Curve { label: label.to_owned(), x, y, style: CurveStyle::default(), place: None })
}

fn settlement(results: &Results, case: &Case) -> LineChart {
    let curves = [
        curve(results, "settlement.particles", "top particles", 1e3),
        curve(results, "settlement.surface", "surface", 1e3),
    ];
    LineChart {
        title: Some(case.title.clone()),
        x_label: "time (s)".to_owned(),
        y_label: "settlement (mm)".to_owned(),
        y_down: true,
        curves: curves.into_iter().flatten().collect(),
        ..Default::default()
    }
}

fn pressures(results: &Results, case: &Case) -> LineChart {
    let probes = case.probes.iter().filter(|probe| probe.pressure_at.is_some());
    let of_probe = |probe: &crate::Probe| curve(results, &format!("{}.pressure", probe.name), &probe.name, 1e-3);
    LineChart {
        title: Some(case.title.clone()),
        x_label: "time (s)".to_owned(),
        y_label: "pore pressure (kPa)".to_owned(),
        curves: probes.filter_map(of_probe).collect(),
        ..Default::default()
    }
}

/// The excess pressure of a probe.
struct Excess {
    name: String,
    /// Level of the centre of the probe's cell (m).
    level: f64,
    /// Vertical effective stress at the start (Pa, positive in compression).
    vertical: f64,
    /// In every row of the history (Pa).
    pressure: Vec<f64>,
}

/// The excess pressures of all probes that read one, from the top downwards; none unless the first body has a stress by depth at the start.
fn excesses<const D: usize>(results: &Results, case: &Case, grid: &Grid<D>) -> Vec<Excess> {
    let body = &case.bodies[0];
    let (Some(state), Some(fluid)) = (&body.initial.geostatic, &case.fluid) else { return Vec::new() };
    let up = D - 1;
    let gravity = -case.gravity.as_ref().and_then(|gravity| gravity.get(up)).copied().unwrap_or(0.0);
    let density = case.materials[&body.material].density;
    let of_probe = |probe: &crate::Probe| {
        let level = (probe.pressure_at.as_ref()?.get(up)? - grid.origin()[up]) / grid.spacing()[up];
        let level = grid.origin()[up] + (level.floor() + 0.5) * grid.spacing()[up];
        let pressure = column(results, &format!("{}.pressure", probe.name))?;
        let start = *pressure.first()?;
        let water = body.initial.water_table.map_or(0.0, |table| fluid.density * gravity * (table - level).max(0.0));
        let vertical = density * gravity * (state.surface - level) - water;
        let pressure = pressure.iter().map(|pressure| pressure - start).collect();
        (vertical > 0.0).then(|| Excess { name: probe.name.clone(), level, vertical, pressure })
    };
    let mut excesses: Vec<Excess> = case.probes.iter().filter_map(of_probe).collect();
    excesses.sort_by(|a, b| b.level.total_cmp(&a.level));
    excesses
}

/// r_u = excess pressure over the vertical effective stress at the start.
fn pressure_ratios(results: &Results, case: &Case, excesses: &[Excess]) -> LineChart {
    let time = column(results, "time").unwrap_or_default();
    let curve = |excess: &Excess| Curve {
        label: excess.name.clone(),
        x: time.clone(),
        y: excess.pressure.iter().map(|pressure| pressure / excess.vertical).collect(),
        style: CurveStyle::default(),
        place: None,
    };
    LineChart {
        title: Some(case.title.clone()),
        x_label: "time (s)".to_owned(),
        y_label: "pore pressure ratio (–)".to_owned(),
        curves: excesses.iter().map(curve).collect(),
        ..Default::default()
    }
}

/// How many isochrones are drawn: at the end of the run, at half of it, a quarter and so on.
const ISOCHRONES: i32 = 6;

/// Excess pressure over the level, at a few times.
fn isochrones(results: &Results, case: &Case, excesses: &[Excess]) -> LineChart {
    let time = column(results, "time").unwrap_or_default();
    let end = time.last().copied().unwrap_or(0.0);
    let curve = |halvings: i32| {
        let row = time.partition_point(|time| *time < end * 0.5_f64.powi(halvings) * (1.0 - 1e-9));
        Some(Curve {
            label: format!("{} s", rounded(*time.get(row)?)),
            x: excesses.iter().map(|excess| excess.pressure[row] * 1e-3).collect(),
            y: excesses.iter().map(|excess| excess.level).collect(),
            style: CurveStyle::default(),
            place: None,
        })
    };
    LineChart {
        title: Some(case.title.clone()),
        x_label: "excess pore pressure (kPa)".to_owned(),
        y_label: "level (m)".to_owned(),
        curves: (0..ISOCHRONES).rev().filter_map(curve).collect(),
        ..Default::default()
    }
}

/// The particles over the grid of their case, coloured by pore pressure.
pub(crate) fn particle_chart<const D: usize>(case: &Case, grid: &Grid<D>, snapshot: &Snapshot) -> ParticleChart {
    let lines = |axis: usize| -> Vec<f64> {
        (0..=grid.cells()[axis]).map(|i| grid.origin()[axis] + i as f64 * grid.spacing()[axis]).collect()
    };
    let up = D - 1;
    let (grid_x, outline) = match D {
        1 => (vec![0.0, grid.spacing()[0]], Vec::new()),
        _ => (lines(0), outlines(&case.bodies, grid, 0, up)),
    };
    ParticleChart {
        title: Some(format!("t = {} s", rounded(snapshot.time))),
        x_label: if D == 1 { String::new() } else { "x (m)".to_owned() },
        y_label: ["x (m)", "y (m)", "z (m)"][up].to_owned(),
        value_label: "pore pressure (kPa)".to_owned(),
        position: snapshot.position.clone(),
        half_size: snapshot.half_size.clone(),
        value: snapshot.pressure.clone(),
        value_range: from_zero(&snapshot.pressure),
        grid_x,
        grid_y: lines(up),
        outline,
    }
}

/// A time with at most six significant digits, for a title.
fn rounded(time: f64) -> f64 {
    format!("{time:.5e}").parse().unwrap_or(time)
}

/// The range of a colour bar that shows where zero is; none for values that are all zero.
fn from_zero(values: &[f64]) -> Option<[f64; 2]> {
    let lowest = values.iter().copied().fold(0.0, f64::min);
    let highest = values.iter().copied().fold(0.0, f64::max);
    (lowest < highest).then_some([lowest, highest])
}
