//! The pressure system of wide bodies: an assembled matrix, conjugate gradients, multigrid.

use super::StepView;
use super::assembly::{Parts, assemble};
use super::checkerboard::Checkerboard;
use super::conjugate_gradient::{Breakdown, ConjugateGradient, System};
use super::lattice::{Lattice, Place};
use super::multigrid::{MOST_DIRECT, Multigrid};
use super::stencil_matrix::StencilMatrix;
use super::tied::TiedCells;
use crate::tensor::Vector;

/// What the matrix is made of, by cell.
pub(super) struct Contributions<'a, const D: usize> {
    /// K_v of every cell, one stencil after the other.
    pub(super) divergence: &'a [Vector<D>],
    /// c/m of every node of the grid.
    pub(super) compliance: &'a [Vector<D>],
    /// Storage C of every cell.
    pub(super) storage: &'a [f64],
    /// Conductances of the faces between every cell and the one above it, per axis, with a row of closed ones behind them.
    pub(super) conductance: &'a [Vector<D>],
    /// Whose upper faces the lower ones of every cell are.
    pub(super) below: &'a [[u32; D]],
    /// Cells, conductances (and gravity flows) of drained sides.
    pub(super) drains: &'a [(u32, f64, f64)],
    pub(super) checkerboard: &'a Checkerboard,
}

/// The matrix on its lattice, and what solves with it.
#[derive(Debug, Clone, Default)]
pub(super) struct WideSystem {
    lattice: Lattice,
    cell_of_site: Vec<u32>,
    site_of_cell: Vec<u32>,
    places: Vec<Place>,
    corners: Vec<Place>,
    first_nodes: Vec<u32>,
    width: usize,
    matrix: StencilMatrix<f64>,
    multigrid: Multigrid,
    iteration: ConjugateGradient,
    /// The last solution, by site.
    solution: Vec<f64>,
}

/// The numbers along the axes, as a place.
fn place<const D: usize>(index: [usize; D]) -> Place {
    std::array::from_fn(|axis| if axis < D { index[axis] as i32 } else { 0 })
}

impl WideSystem {
    /// Makes room for the active cells. `stencils` lists the nodes of each.
    pub(super) fn rebuild<const D: usize>(&mut self, at: &StepView<D>, stencils: &[u32]) {
        let stencil_len = at.transfer.stencil_len();
        self.width = (1..stencil_len).find(|width| width.pow(D as u32) == stencil_len).unwrap_or(stencil_len);
        let cells = at.active.cells();
        self.places.clear();
        self.places.extend(cells.iter().map(|&cell| place(at.grid.cell_index(cell as usize))));
        let corner = |stencil: &[u32]| {
            let mut rest = stencil[0] as usize;
            let index = at.grid.cells().map(|count| {
                let index = rest % (count + 1);
                rest /= count + 1;
                index
            });
            place(index)
        };
        self.corners.clear();
        self.corners.extend(stencils.chunks(stencil_len).map(corner));
        self.first_nodes.clear();
        self.first_nodes.extend(stencils.iter().step_by(stencil_len));
        self.lattice.rebuild(D, self.width as i32 - 1, self.places.iter().copied());
        self.number_sites();
        self.matrix.resize(&self.lattice);
        self.multigrid.rebuild(D, MOST_DIRECT, &self.lattice);
        self.iteration.resize(&self.lattice);
        self.solution.clear();
        self.solution.resize(self.lattice.num_sites(), 0.0);
    }

    fn number_sites(&mut self) {
        self.lattice.list_cells(&mut self.cell_of_site);
        self.site_of_cell.clear();
        for run in self.lattice.runs() {
            self.site_of_cell.extend(run.site as u32..(run.site + run.len) as u32);
        }
    }

    /// The sites of the cells, by slot.
    pub(super) fn site_of_cell(&self) -> &[u32] {
        &self.site_of_cell
    }

    /// The number of sites.
    pub(super) fn num_sites(&self) -> usize {
        self.lattice.num_sites()
    }

    /// Fills the matrix and prepares the preconditioner.
    ///
    /// # Errors
    /// The slot and the entry where the diagonal is not positive.
    pub(super) fn measure<const D: usize>(
        &mut self,
        at: &StepView<D>,
        of: &Contributions<D>,
    ) -> Result<(), (usize, f64)> {
        let parts = Parts {
            lattice: &self.lattice,
            cell_of_site: &self.cell_of_site,
            corners: &self.corners,
            first_nodes: &self.first_nodes,
            strides: at.grid.node_strides(),
            divergence: of.divergence,
            compliance: of.compliance,
            storage: of.storage,
            conductance: of.conductance,
            below: of.below,
        };
        assemble(parts, self.width, &mut self.matrix);
        self.add_sides(of);
        let Self { lattice, matrix, multigrid, .. } = self;
        multigrid.measure(lattice, matrix).map_err(|bad| (lattice.slot(bad.site), bad.value))
    }

    /// Adds the conductances of the drained sides and the stabilisation.
    fn add_sides<const D: usize>(&mut self, of: &Contributions<D>) {
        let Self { lattice, site_of_cell, places, matrix, .. } = self;
        let (diagonal, upper) = matrix.entries_mut();
        let site = |cell: u32| site_of_cell[cell as usize] as usize;
        let number = |to: Place| lattice.offset_to(to);
        for &(cell, conductance, _) in of.drains {
            diagonal[site(cell)] += conductance;
        }
        of.checkerboard.visit_entries(|a, b, value| {
            let (from, to) = (places[a as usize], places[b as usize]);
            if a == b {
                diagonal[site(a)] += value;
            } else if let Some(offset) = number(std::array::from_fn(|axis| to[axis] - from[axis])) {
                upper[offset][site(a)] += value;
            }
        });
    }

    /// The next solution is looked for from these values on, by slot.
    pub(super) fn start_from(&mut self, values: &[f64]) {
        self.lattice.spread(values, &mut self.solution);
    }

    /// Solves for `solution`, by slot, starting from the last one. Returns the number of iterations.
    ///
    /// # Errors
    /// The breakdown; its `site` is a slot.
    pub(super) fn solve(
        &mut self,
        ties: &[TiedCells],
        right: &[f64],
        solution: &mut [f64],
    ) -> Result<usize, Breakdown> {
        let Self { lattice, matrix, multigrid, iteration, .. } = self;
        let system = System { lattice, matrix, ties };
        let iterations =
            iteration.solve(system, multigrid, right, &mut self.solution).map_err(|breakdown| match breakdown {
                Breakdown::Indefinite { site, quotient } => {
                    Breakdown::Indefinite { site: lattice.slot(site), quotient }
                }
                Breakdown::NotConverged { site, iterations, residual } => {
                    Breakdown::NotConverged { site: lattice.slot(site), iterations, residual }
                }
            })?;
        lattice.gather(&self.solution, solution);
        Ok(iterations)
    }
}
