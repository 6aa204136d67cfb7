//! The direct solver of the multigrid cycle's last level.

use super::envelope::{BadPivot, Envelope};
use super::lattice::{Lattice, NO_CELL};
use super::stencil_matrix::StencilMatrix;

/// A matrix on a small lattice, factorised.
#[derive(Debug, Clone, Default)]
pub(super) struct Coarsest {
    factor: Envelope,
    /// The cell at each site, [`NO_CELL`] where there is none.
    cell_of_site: Vec<u32>,
    /// Work array, by cell.
    values: Vec<f64>,
}

impl Coarsest {
    /// Makes room for the cells of a lattice.
    pub(super) fn rebuild(&mut self, lattice: &Lattice) {
        lattice.list_cells(&mut self.cell_of_site);
        self.values.clear();
        self.values.resize(lattice.num_cells(), 0.0);
        let Coarsest { factor, cell_of_site, .. } = self;
        let first_column = |number: usize, site: usize| {
            let below =
                lattice.offsets().iter().map(|offset| site.wrapping_add_signed(lattice.shift(number, offset)[1]));
            below.map(|site| cell_of_site[site]).fold(cell_of_site[site], u32::min)
        };
        let sites = lattice
            .runs()
            .iter()
            .enumerate()
            .flat_map(|(number, run)| (run.site..run.site + run.len).map(move |site| (number, site)));
        factor.set_shape(sites.map(|(number, site)| first_column(number, site)));
    }

    /// Factorises a matrix on the lattice.
    ///
    /// # Errors
    /// The cell and the pivot where it is not positive definite.
    pub(super) fn measure(&mut self, lattice: &Lattice, matrix: &StencilMatrix<f64>) -> Result<(), BadPivot> {
        let Coarsest { factor, cell_of_site, .. } = self;
        factor.clear_values();
        for (number, run) in lattice.runs().iter().enumerate() {
            for site in run.site..run.site + run.len {
                let cell = cell_of_site[site] as usize;
                factor.add(cell, cell, matrix.diagonal()[site]);
                for (entries, offset) in lattice.offsets().iter().enumerate() {
                    let below = site.wrapping_add_signed(lattice.shift(number, offset)[1]);
                    if cell_of_site[below] != NO_CELL {
                        factor.add(cell, cell_of_site[below] as usize, matrix.upper(entries)[below]);
                    }
                }
            }
        }
        factor.factorize()
    }

    /// Solves, by site.
    pub(super) fn solve(&mut self, lattice: &Lattice, right: &[f32], solution: &mut [f32]) {
        for run in lattice.runs() {
            let right = &right[run.site..][..run.len];
            self.values[run.slot..][..run.len].iter_mut().zip(right).for_each(|(value, &b)| *value = f64::from(b));
        }
        self.factor.solve(&mut self.values);
        for run in lattice.runs() {
            let solution = &mut solution[run.site..][..run.len];
            solution.iter_mut().zip(&self.values[run.slot..]).for_each(|(x, &value)| *x = value as f32);
        }
    }
}
