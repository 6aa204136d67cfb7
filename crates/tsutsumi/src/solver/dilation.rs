use crate::grid::Grid;
use crate::law::BLOCK;
use crate::particles::Particles;
use crate::pressure::StepView;
use crate::tensor::Vector;
use crate::transfer::GatheredBlock;

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
    /// Volume of the particles inside (m³).
    volume: Vec<f64>,
}

impl Dilation {
    pub(super) fn new<const D: usize>(choice: VolumetricStrain, grid: &Grid<D>) -> Self {
        let len = match choice {
            VolumetricStrain::Pointwise => 0,
            VolumetricStrain::CellAveraged => grid.num_cells(),
        };
        Dilation { rate: vec![0.0; len], volume: vec![0.0; len] }
    }

    /// The memory of its fields (bytes).
    pub(super) fn bytes(&self) -> usize {
        (self.rate.capacity() + self.volume.capacity()) * size_of::<f64>()
    }

    /// Sums the cells' means for these velocities of the nodes (m/s).
    pub(super) fn measure<const D: usize>(
        &mut self,
        at: &StepView<D>,
        velocities: &[Vector<D>],
        particles: &Particles<D>,
    ) {
        if self.rate.is_empty() {
            return;
        }
        for &cell in at.active.cells() {
            self.rate[cell as usize] = 0.0;
            self.volume[cell as usize] = 0.0;
        }
        let mut at_particles = GatheredBlock::new();
        for start in (0..particles.len()).step_by(BLOCK) {
            let block = start..particles.len().min(start + BLOCK);
            let places = particles.places().part(block.clone());
            at.transfer.gather_gradients(at.grid, velocities, places, &mut at_particles);
            for (number, p) in block.enumerate() {
                let cell = particles.cell[p] as usize;
                self.rate[cell] += particles.volume[p] * at_particles.at(number).velocity_gradient.trace();
                self.volume[cell] += particles.volume[p];
            }
        }
        for &cell in at.active.cells() {
            self.rate[cell as usize] /= self.volume[cell as usize];
        }
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
