//! The entries of L + C + K_vᵀ (c/M) K_v, cell by cell.

use std::ops::Range;

use super::lattice::{Lattice, NO_CELL, Offset, Place};
use super::stencil_matrix::{Columns, GRAIN, StencilMatrix};
use crate::parallel;
use crate::tensor::Vector;

/// What the entries are made of.
#[derive(Clone, Copy)]
pub(super) struct Parts<'a, const D: usize> {
    pub(super) lattice: &'a Lattice,
    /// The number of the cell at every site, [`NO_CELL`] where there is none.
    pub(super) cell_of_site: &'a [u32],
    /// The numbers along the axes of the first node of every cell's stencil.
    pub(super) corners: &'a [Place],
    /// The number of this node.
    pub(super) first_nodes: &'a [u32],
    /// Distance of neighbouring nodes in their numbering.
    pub(super) strides: [usize; D],
    /// K_v of every cell, one stencil after the other.
    pub(super) divergence: &'a [Vector<D>],
    /// c/m of every node.
    pub(super) compliance: &'a [Vector<D>],
    /// Storage C of every cell.
    pub(super) storage: &'a [f64],
    /// Conductances of the faces between every cell and the one above it, per axis, with a row of closed ones behind them.
    pub(super) conductance: &'a [Vector<D>],
    /// Whose upper faces the lower ones of every cell are.
    pub(super) below: &'a [[u32; D]],
}

/// Replaces the entries of a matrix by those of L + C + K_vᵀ (c/M) K_v, for stencils of `width` nodes per axis.
pub(super) fn assemble<const D: usize>(parts: Parts<D>, width: usize, matrix: &mut StencilMatrix<f64>) {
    // Nodes per stencil, entries per row.
    match (D, width) {
        (1, 2) => fill::<D, 2, 2, 2>(parts, matrix),
        (1, 3) => fill::<D, 3, 3, 3>(parts, matrix),
        (1, _) => fill::<D, 4, 4, 4>(parts, matrix),
        (2, 2) => fill::<D, 2, 4, 5>(parts, matrix),
        (2, 3) => fill::<D, 3, 9, 13>(parts, matrix),
        (2, _) => fill::<D, 4, 16, 25>(parts, matrix),
        (_, 2) => fill::<D, 2, 8, 14>(parts, matrix),
        (_, 3) => fill::<D, 3, 27, 63>(parts, matrix),
        (_, _) => fill::<D, 4, 64, 172>(parts, matrix),
    }
}

fn fill<const D: usize, const W: usize, const L: usize, const N: usize>(
    parts: Parts<D>,
    matrix: &mut StencilMatrix<f64>,
) {
    let num_sites = parts.lattice.num_sites();
    let (diagonal, upper) = matrix.entries_mut();
    let mut columns: [&mut [f64]; N] = std::array::from_fn(|_| Default::default());
    columns.iter_mut().zip(upper).for_each(|(column, upper)| *column = upper);
    columns[N - 1] = diagonal;
    // Every lattice reaches at least the next cell along each axis.
    let along: [usize; D] = std::array::from_fn(|axis| {
        parts.lattice.offset_to(std::array::from_fn(|other| i32::from(other == axis))).unwrap_or(0)
    });
    let work = |(columns, sites): (Columns<N>, Range<usize>)| {
        let Columns(mut columns) = columns;
        parts.lattice.visit_runs(&sites, |run, from, len| {
            let mut ahead = [0; N];
            for (ahead, offset) in ahead.iter_mut().zip(parts.lattice.offsets()) {
                *ahead = parts.lattice.shift(run, offset)[0];
            }
            for site in from..from + len {
                let cell = parts.cell_of_site[site] as usize;
                let pushed: [Vector<D>; L] = parts.push::<W, L>(cell);
                let of_cell = &parts.divergence[cell * L..][..L];
                let place = site - sites.start;
                let energy: f64 = pushed.iter().zip(of_cell).map(|(a, b)| a.dot(b)).sum();
                columns[N - 1][place] = parts.storage[cell] + energy + parts.drag(cell);
                let neighbor = |number: usize| parts.cell_of_site[site.wrapping_add_signed(ahead[number])];
                if (D, W) == (2, 2) {
                    let entries = parts.entries_in_plane(std::array::from_fn(neighbor), &pushed);
                    columns.iter_mut().zip(entries).for_each(|(column, entry)| column[place] = entry);
                } else {
                    for (number, offset) in parts.lattice.offsets().iter().enumerate() {
                        columns[number][place] = match neighbor(number) {
                            NO_CELL => 0.0,
                            other => parts.entry::<W, L>(cell, other as usize, offset, &pushed),
                        };
                    }
                }
                for (&along, conductance) in along.iter().zip(&parts.conductance[cell]) {
                    columns[along][place] -= conductance;
                }
            }
        });
    };
    parallel::for_each((Columns(columns), 0..num_sites), GRAIN, &work);
}

impl<const D: usize> Parts<'_, D> {
    /// (c/M) K_v of one cell.
    #[inline(always)]
    fn push<const W: usize, const L: usize>(&self, cell: usize) -> [Vector<D>; L] {
        let of_cell = &self.divergence[cell * L..][..L];
        std::array::from_fn(|local| {
            let mut rest = local;
            let mut node = self.first_nodes[cell] as usize;
            for stride in self.strides {
                node += rest % W * stride;
                rest /= W;
            }
            of_cell[local].component_mul(&self.compliance[node])
        })
    }

    /// The same as [`Parts::entry`] for the four neighbours at (1, 0), (−1, 1), (0, 1) and (1, 1), with linear functions in 2-D.
    #[inline(always)]
    fn entries_in_plane<const L: usize>(&self, neighbors: [u32; 4], pushed: &[Vector<D>; L]) -> [f64; 4] {
        let product = |neighbor: usize, shared: &[(usize, usize)]| match neighbors[neighbor] {
            NO_CELL => 0.0,
            other => {
                let of_other = &self.divergence[other as usize * L..][..L];
                shared.iter().map(|&(own, other)| pushed[own].dot(&of_other[other])).sum()
            }
        };
        [product(0, &[(1, 0), (3, 2)]), product(1, &[(2, 1)]), product(2, &[(2, 0), (3, 1)]), product(3, &[(3, 0)])]
    }

    /// The conductance of all faces of a cell.
    #[inline(always)]
    fn drag(&self, cell: usize) -> f64 {
        let of_axis = |axis: usize| {
            let below = self.below[cell][axis] as usize;
            self.conductance[cell][axis] + self.conductance[below][axis]
        };
        (0..D).map(of_axis).sum()
    }

    /// The product of two cells over the nodes that both touch. Stencils move on by one node per cell, but not where they would
    /// reach beyond the grid.
    #[inline(always)]
    fn entry<const W: usize, const L: usize>(
        &self,
        cell: usize,
        other: usize,
        offset: &Offset,
        pushed: &[Vector<D>; L],
    ) -> f64 {
        let apart: Place = std::array::from_fn(|axis| match W {
            _ if axis >= D => 0,
            2 => offset.to[axis],
            _ => self.corners[other][axis] - self.corners[cell][axis],
        });
        let of_other = &self.divergence[other * L..][..L];
        let shared = |axis: usize| {
            let width = if axis < D { W as i32 } else { 1 };
            apart[axis].max(0) as usize..(width + apart[axis].min(0)).max(0) as usize
        };
        let back = apart[0] + W as i32 * (apart[1] + W as i32 * apart[2]);
        let mut sum = 0.0;
        for z in shared(2) {
            for y in shared(1) {
                for x in shared(0) {
                    let local = x + W * (y + W * z);
                    sum += pushed[local].dot(&of_other[local.wrapping_add_signed(-back as isize)]);
                }
            }
        }
        sum
    }
}
