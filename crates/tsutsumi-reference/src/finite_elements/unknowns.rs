//! The numbering of the unknowns: displacements that no support holds, then the elements' pressures.

use tsutsumi::grid::{ActiveSet, Grid, NodeFields};
use tsutsumi::tensor::Vector;

/// Which row belongs to which displacement and pressure.
pub(super) struct Unknowns<const D: usize> {
    /// One number per node and axis; [`HELD`] where there is no unknown.
    of_node: Vec<[u32; D]>,
    displacements: usize,
    pressures: usize,
}

const HELD: u32 = u32::MAX;

impl<const D: usize> Unknowns<D> {
    /// Numbers the displacements with mobility and, in saturated ground, the pressures of the active cells.
    pub(super) fn new(grid: &Grid<D>, active: &ActiveSet, nodes: &NodeFields<D>, saturated: bool) -> Self {
        let mut of_node = vec![[HELD; D]; grid.num_nodes()];
        // Nodes that move as one share the unknown of the first of them.
        let tied_before = |node: u32, axis: usize| {
            let tie = nodes.ties.iter().find(|tie| tie.axis() == axis && tie.nodes().contains(&node))?;
            tie.nodes().iter().copied().min().filter(|&first| first < node)
        };
        let mut count = 0;
        for &node in active.nodes() {
            of_node[node as usize] = std::array::from_fn(|axis| match tied_before(node, axis) {
                Some(first) => of_node[first as usize][axis],
                None if nodes.mobility[node as usize][axis] > 0.0 => {
                    count += 1;
                    count - 1
                }
                None => HELD,
            });
        }
        let pressures = if saturated { active.cells().len() } else { 0 };
        Unknowns { of_node, displacements: count as usize, pressures }
    }

    /// The number of unknowns.
    pub(super) fn count(&self) -> usize {
        self.displacements + self.pressures
    }

    /// A vector with a zero per unknown.
    pub(super) fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.count()]
    }

    /// The row of a displacement; `None` where a support holds.
    pub(super) fn of_node(&self, node: usize, axis: usize) -> Option<usize> {
        let row = self.of_node[node][axis];
        (row != HELD).then_some(row as usize)
    }

    /// The row of a pressure.
    pub(super) fn of_slot(&self, slot: usize) -> usize {
        self.displacements + slot
    }

    /// Adds nodal forces to the rows of the displacements.
    pub(super) fn gather_forces(&self, active: &ActiveSet, force: &[Vector<D>], residual: &mut [f64]) {
        for &node in active.nodes() {
            for (axis, component) in force[node as usize].iter().enumerate() {
                if let Some(row) = self.of_node(node as usize, axis) {
                    residual[row] += component;
                }
            }
        }
    }

    /// The largest force in the rows of the displacements.
    pub(super) fn largest_force(&self, residual: &[f64]) -> f64 {
        residual[..self.displacements].iter().fold(0.0, |largest: f64, force| largest.max(force.abs()))
    }

    /// Adds a solution to displacements and pressures.
    pub(super) fn correct(
        &self,
        active: &ActiveSet,
        solution: &[f64],
        displacement: &mut [Vector<D>],
        pressure: &mut [f64],
    ) {
        for &node in active.nodes() {
            for (axis, component) in displacement[node as usize].iter_mut().enumerate() {
                if let Some(row) = self.of_node(node as usize, axis) {
                    *component += solution[row];
                }
            }
        }
        for (&cell, correction) in active.cells().iter().zip(&solution[self.displacements..]) {
            pressure[cell as usize] += correction;
        }
    }
}
