use super::StepView;
use crate::grid::{CellFields, Side};
use crate::parallel;
use crate::particles::Particles;
use crate::tensor::Vector;

/// Particles in a piece of a loop.
const GRAIN: usize = 16_384;

/// How a cell's pressure comes back to its particles (step 11), who take it along when they change cells.
///
/// Whatever the rule, step 5 takes the mean of the particles by volume, and each rule keeps that mean: as long as no particle changes its cell,
/// the cells do not notice which it is.
pub trait ParticlePressure<const D: usize>: Send {
    /// Step 11: pressures of the particles from those of the cells, `cells.pressure` now and `cells.pressure_old` at the start of the step.
    fn cells_to_particles(&mut self, at: &StepView<D>, cells: &CellFields, particles: &mut Particles<D>);
}

/// Every particle takes the pressure of its cell: the paper.
///
/// A particle that moves on brings the old cell's pressure into the new one: pressures spread, as by a diffusivity of up to ½ |v| h for a velocity v
/// through the grid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CellPressure;

impl<const D: usize> ParticlePressure<D> for CellPressure {
    fn cells_to_particles(&mut self, _at: &StepView<D>, cells: &CellFields, particles: &mut Particles<D>) {
        let work = |(pressures, of): (&mut [f64], &[u32])| {
            for (pressure, &cell) in pressures.iter_mut().zip(of) {
                *pressure = cells.pressure[cell as usize];
            }
        };
        parallel::for_each((&mut particles.pressure[..], &particles.cell[..]), GRAIN, &work);
    }
}

/// Every particle takes the change of its cell's pressure.
///
/// # Equation
///
/// ```text
/// p_p ← p_p + (p_E^L − p_E|t)
/// ```
///
/// Nothing spreads: what differs within a cell stays with the particles, noise too (as velocities with MPM①).
///
/// # Reference
///
/// The idea of [`Mpm1`](crate::velocity::Mpm1), on pressures; increments are mapped likewise by Zheng et al. (2021), Comput. Geotech., by patches.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PressureIncrement;

impl<const D: usize> ParticlePressure<D> for PressureIncrement {
    fn cells_to_particles(&mut self, _at: &StepView<D>, cells: &CellFields, particles: &mut Particles<D>) {
        let work = |(pressures, of): (&mut [f64], &[u32])| {
            for (pressure, &cell) in pressures.iter_mut().zip(of) {
                *pressure += cells.pressure[cell as usize] - cells.pressure_old[cell as usize];
            }
        };
        parallel::for_each((&mut particles.pressure[..], &particles.cell[..]), GRAIN, &work);
    }
}

/// Every particle takes the pressure of its cell and the slope around it.
///
/// # Equation
///
/// ```text
/// p_p ← p_E + ∇p_E · (X_p − x_E)      x_E the centroid of the cell's particles
/// ```
///
/// The slope along an axis is that between the neighbours on both sides, or to the one that there is. It spreads smooth pressures only by their second
/// differences, and keeps no noise within a cell.
///
/// # Reference
///
/// After the pressure mapping with gradients (TPIC) of Juel et al. (2026), CMAME 461, 119140, known from notes, not read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PressureGradient<const D: usize> {
    /// Centroid of the particles of every cell of the grid (m).
    centroid: Vec<Vector<D>>,
    /// ∇p of every cell (Pa/m).
    gradient: Vec<Vector<D>>,
}

impl<const D: usize> PressureGradient<D> {
    /// Centroids of the particles of every active cell.
    fn find_centroids(&mut self, at: &StepView<D>, particles: &Particles<D>) {
        let num_cells = at.grid.num_cells();
        self.centroid.resize(num_cells, Vector::zeros());
        self.gradient.resize(num_cells, Vector::zeros());
        at.active.change_cells(&mut self.centroid, |slot, _, centroid| {
            let (mut moment, mut volume) = (Vector::zeros(), 0.0);
            for &p in at.active.particles_of(slot) {
                moment += particles.position[p as usize] * particles.volume[p as usize];
                volume += particles.volume[p as usize];
            }
            *centroid = moment / volume;
        });
    }

    /// Between the neighbours along each axis; a side without one is the cell itself.
    fn find_gradients(&mut self, at: &StepView<D>, pressure: &[f64]) {
        let PressureGradient { centroid, gradient } = self;
        at.active.change_cells(gradient, |slot, _, gradient| {
            let cell = at.active.cells()[slot] as usize;
            for axis in 0..D {
                let neighbor = |upper| {
                    let found = at.grid.neighbor(cell, Side { axis, upper });
                    found.filter(|&other| at.active.slot(other).is_some()).unwrap_or(cell)
                };
                let (lower, upper) = (neighbor(false), neighbor(true));
                let distance = centroid[upper][axis] - centroid[lower][axis];
                let rise = pressure[upper] - pressure[lower];
                gradient[axis] = if distance > 0.0 { rise / distance } else { 0.0 };
            }
        });
    }
}

impl<const D: usize> ParticlePressure<D> for PressureGradient<D> {
    fn cells_to_particles(&mut self, at: &StepView<D>, cells: &CellFields, particles: &mut Particles<D>) {
        self.find_centroids(at, particles);
        self.find_gradients(at, &cells.pressure);
        let Particles { pressure, position, cell, .. } = particles;
        let work = |(pressures, of, positions): (&mut [f64], &[u32], &[Vector<D>])| {
            for ((pressure, &cell), position) in pressures.iter_mut().zip(of).zip(positions) {
                let cell = cell as usize;
                *pressure = cells.pressure[cell] + self.gradient[cell].dot(&(position - self.centroid[cell]));
            }
        };
        parallel::for_each((&mut pressure[..], &cell[..], &position[..]), GRAIN, &work);
    }
}
