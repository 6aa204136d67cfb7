use crate::law::{LawError, Question};
use crate::particles::{OutsideGrid, Particles};
use crate::pressure::PressureError;

/// Why a step could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// A particle left the grid. The particles are those at the start of the step.
    #[error("at t = {time:.6} s {outside}: enlarge the grid, or take a shorter step or `auto` if the run is unstable")]
    Outside {
        /// The time at the start of the step (s).
        time: f64,
        /// The particle and the grid.
        outside: OutsideGrid,
    },
    /// The pressures could not be solved for. The particles are those at the start of the step.
    #[error(transparent)]
    Pressure(#[from] PressureError),
    /// A law failed. The step is complete but for the stress of the failing particles, which keep their old one.
    #[error(
        "at t = {time:.6} s the law of material `{material}` failed in particle {particle} at {position:.4?} m: {source}"
    )]
    Law {
        /// The name of the material.
        material: String,
        /// The number of the first particle whose law failed.
        particle: usize,
        /// Its position (m).
        position: Vec<f64>,
        /// The time at the end of the step (s).
        time: f64,
        /// What the law was asked; the group still holds the history.
        question: Box<Question>,
        /// The law's reason.
        source: Box<LawError>,
    },
    /// The grid is too narrow for the shape function.
    #[error("the grid has {cells} cell(s) along axis {axis}, but the shape function needs {needed}")]
    NarrowGrid {
        /// The axis, 0 = x.
        axis: usize,
        /// The cells along it.
        cells: usize,
        /// The cells that it needs.
        needed: usize,
    },
    /// A particle was pressed together beyond its pores. The step is complete.
    #[error(
        "at t = {time:.6} s particle {particle} at {position:.4?} m is pressed to a porosity of {porosity:.3}: its grains are \
         incompressible; take a stiffer law, or a shorter step if the run is unstable"
    )]
    ClosedPores {
        /// The number of the first such particle.
        particle: usize,
        /// Its position (m).
        position: Vec<f64>,
        /// The porosity that follows from its volume (–).
        porosity: f64,
        /// The time at the end of the step (s).
        time: f64,
    },
}

/// The first particle, by number, whose grains leave no room for water.
pub(super) fn closed_pores<const D: usize>(particles: &Particles<D>, time: f64) -> Option<StepError> {
    let closed = (0..particles.len()).filter(|&place| particles.porosity[place] < 0.0);
    let place = closed.min_by_key(|&place| particles.number(place))?;
    let position = particles.position[place].iter().copied().collect();
    let (particle, porosity) = (particles.number(place), particles.porosity[place]);
    Some(StepError::ClosedPores { particle, position, porosity, time })
}
