use std::ops::Range;

use crate::grid::{Grid, vec_bytes};
use crate::law::BLOCK;
use crate::parallel;
use crate::particles::Particles;
use crate::pressure::StepView;
use crate::tensor::Vector;
use crate::transfer::{GRAIN, GatheredBlock};

/// Where the volume change of a particle comes from.
///
/// # Equation
///
/// ```text
/// ∇v_p ← ∇v_p + 1/D (d_E − tr ∇v_p) I        d_E = Σ_{p∈E} Ω_p tr ∇v_p / Σ_{p∈E} Ω_p,  cell-averaged
/// ```
///
/// A cell with linear shape functions cannot follow more than one volume change without getting stiff: skeletons with ν → ½ lock.
/// With the mean of the cell, laws, volumes and pores see one volume change per cell, and the shear that each particle has. The
/// nodal forces are not changed: where the mean stress is the same all over the cell, as for a linear law, they already are the
/// derivative of the energy.
///
/// # Reference
///
/// Hughes (1980), Int. J. Numer. Meth. Engng 15, 1413–1418, B-bar with a mean over the cell (cited from memory).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VolumetricStrain {
    /// The gradient at the particle itself, as in the paper.
    #[default]
    Pointwise,
    /// The mean over the particles of its cell, weighted by volume.
    CellAveraged,
}

/// The mean rates of volume change of the cells; empty where every particle keeps its own.
pub(super) struct Dilation {
    /// d_E of every cell of the grid (1/s).
    rate: Vec<f64>,
    /// tr ∇v_p of every particle (1/s).
    rate_of_particle: Vec<f64>,
}

impl Dilation {
    pub(super) fn new<const D: usize>(choice: VolumetricStrain, grid: &Grid<D>, particles: &Particles<D>) -> Self {
        let (cells, particles) = match choice {
            VolumetricStrain::Pointwise => (0, 0),
            VolumetricStrain::CellAveraged => (grid.num_cells(), particles.len()),
        };
        Dilation { rate: vec![0.0; cells], rate_of_particle: vec![0.0; particles] }
    }

    /// The memory that grows with the cells (bytes).
    pub(super) fn bytes_of_cells(&self) -> usize {
        vec_bytes(&self.rate)
    }

    /// The memory that grows with the particles (bytes).
    pub(super) fn bytes_of_particles(&self) -> usize {
        vec_bytes(&self.rate_of_particle)
    }

    /// Finds the cells' means for these velocities of the nodes (m/s).
    pub(super) fn measure<const D: usize>(
        &mut self,
        at: &StepView<D>,
        velocities: &[Vector<D>],
        particles: &Particles<D>,
    ) {
        let Dilation { rate, rate_of_particle } = self;
        if rate.is_empty() {
            return;
        }
        let of_particles = |(rates, range): (&mut [f64], Range<usize>)| {
            let mut at_particles = GatheredBlock::new();
            for (rates, start) in rates.chunks_mut(BLOCK).zip(range.step_by(BLOCK)) {
                let places = particles.places().part(start..start + rates.len());
                at.transfer.gather_gradients(at.grid, velocities, places, &mut at_particles);
                for (p, rate) in rates.iter_mut().enumerate() {
                    *rate = at_particles.at(p).velocity_gradient.trace();
                }
            }
        };
        parallel::for_each((&mut rate_of_particle[..], 0..particles.len()), GRAIN, &of_particles);

        at.active.change_cells(rate, |slot, _, rate| {
            let (mut change, mut volume) = (0.0, 0.0);
            for &p in at.active.particles_of(slot) {
                change += particles.volume[p as usize] * rate_of_particle[p as usize];
                volume += particles.volume[p as usize];
            }
            *rate = change / volume;
        });
    }

    /// Gives the particles of these cells the cells' means.
    pub(super) fn impose<const D: usize>(&self, cells: &[u32], at_particles: &mut GatheredBlock<D>) {
        if self.rate.is_empty() {
            return;
        }
        for (p, &cell) in cells.iter().enumerate() {
            let mut trace = 0.0;
            for axis in 0..D {
                trace += at_particles.velocity_gradient[axis][axis][p];
            }
            let missing = (self.rate[cell as usize] - trace) / D as f64;
            for axis in 0..D {
                at_particles.velocity_gradient[axis][axis][p] += missing;
            }
        }
    }
}
