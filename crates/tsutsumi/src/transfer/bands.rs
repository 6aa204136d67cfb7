//! Sums from particles to nodes on all threads, always in the same order.
//!
//! The cells are cut into bands of layers along the last axis. Two bands that are not neighbours have no node in common: all even ones are
//! summed at the same time, then all odd ones. A node gets its sums in the order of the bands, and within one in that of the cells. Who comes
//! first sets its sums to zero, while they are near.

use std::ops::Range;

use crate::grid::{ActiveSet, Grid};
use crate::shape::{CellOnAxis, ShapeFunction};
use crate::tensor::Vector;

/// Bodies of fewer particles are one band: nothing would be gained by more threads.
const LEAST_PARTICLES: usize = 4096;
/// The most bands.
const MOST_BANDS: usize = 64;

/// Fields of the nodes from number `first` on, to be summed up. Fields that a sum does not need are empty.
pub(super) struct NodeSums<'a, const D: usize> {
    pub(super) first: usize,
    /// Mass (kg).
    pub(super) mass: &'a mut [f64],
    /// Momentum (kg m/s).
    pub(super) momentum: &'a mut [Vector<D>],
    /// Force (N).
    pub(super) force: &'a mut [Vector<D>],
}

impl<'a, const D: usize> NodeSums<'a, D> {
    pub(super) fn of_momentum(momentum: &'a mut [Vector<D>]) -> Self {
        NodeSums { first: 0, mass: &mut [], momentum, force: &mut [] }
    }

    pub(super) fn of_force(force: &'a mut [Vector<D>]) -> Self {
        NodeSums { first: 0, mass: &mut [], momentum: &mut [], force }
    }

    /// Sets the sums of these nodes to zero.
    pub(super) fn clear(&mut self, nodes: Range<usize>) {
        let nodes = nodes.start - self.first..nodes.end - self.first;
        self.mass[nodes.clone()].fill(0.0);
        self.momentum[nodes.clone()].fill(Vector::zeros());
        self.force[nodes].fill(Vector::zeros());
    }

    fn reborrow(&mut self) -> NodeSums<'_, D> {
        let NodeSums { first, mass, momentum, force } = self;
        NodeSums { first: *first, mass, momentum, force }
    }

    /// The nodes before number `node`, and the others.
    fn cut(self, node: usize) -> (Self, Self) {
        fn halves<T>(values: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
            values.split_at_mut(at.min(values.len()))
        }
        let at = node - self.first;
        let ((mass, mass_after), (momentum, momentum_after)) = (halves(self.mass, at), halves(self.momentum, at));
        let (force, force_after) = halves(self.force, at);
        let before = NodeSums { first: self.first, mass, momentum, force };
        (before, NodeSums { first: node, mass: mass_after, momentum: momentum_after, force: force_after })
    }
}

/// Cells whose sums one thread makes.
pub(super) struct Band {
    /// The active ones, by their slots.
    pub(super) slots: Range<usize>,
    /// Those of their nodes to which no band has come before.
    pub(super) new_nodes: Range<usize>,
}

/// The active cells, cut into bands.
pub(super) struct Bands<'a, S, const D: usize> {
    shape: &'a S,
    grid: &'a Grid<D>,
    active: &'a ActiveSet,
    layers: usize,
    /// The first layer of the first band.
    first_layer: usize,
    num_bands: usize,
}

impl<'a, S: ShapeFunction, const D: usize> Bands<'a, S, D> {
    pub(super) fn new(shape: &'a S, grid: &'a Grid<D>, active: &'a ActiveSet) -> Self {
        let per_layer = cells_per_layer(grid);
        let ends = active.cells().first().zip(active.cells().last());
        let (first, last) =
            ends.map_or((0, 0), |(&first, &last)| (first as usize / per_layer, last as usize / per_layer));
        let num_layers = last + 1 - first;
        // In bands of so many layers the stencils of every other one are apart, though at the ends of the grid they move inwards by a node.
        let least = 2 * S::WIDTH - 3;
        let layers = match active.particles().len() < LEAST_PARTICLES {
            true => num_layers,
            false => num_layers.div_ceil(MOST_BANDS).max(least),
        };
        Bands { shape, grid, active, layers, first_layer: first, num_bands: num_layers.div_ceil(layers) }
    }

    /// Calls `sum(band, nodes)` for each band, with all nodes of its stencils.
    pub(super) fn sum(&self, mut nodes: NodeSums<D>, sum: &(impl Fn(Band, NodeSums<D>) + Sync)) {
        if self.num_bands == 1 {
            return sum(Band { slots: 0..self.active.cells().len(), new_nodes: 0..self.grid.num_nodes() }, nodes);
        }
        for color in 0..2 {
            self.sum_some(color..self.num_bands, nodes.reborrow(), sum);
        }
    }

    /// Every other band of a range, from the first on.
    fn sum_some(&self, bands: Range<usize>, nodes: NodeSums<D>, sum: &(impl Fn(Band, NodeSums<D>) + Sync)) {
        if bands.len() <= 2 {
            return sum(self.band(bands.start), nodes);
        }
        let middle = bands.start + bands.len().div_ceil(4) * 2;
        let (before, after) = nodes.cut(self.first_node(middle));
        rayon::join(
            || self.sum_some(bands.start..middle, before, sum),
            || self.sum_some(middle..bands.end, after, sum),
        );
    }

    fn band(&self, band: usize) -> Band {
        // Even bands come first.
        let new_nodes = match band % 2 {
            0 => self.first_node(band)..self.end_of_nodes(band),
            _ if band + 1 == self.num_bands => self.end_of_nodes(band - 1)..self.end_of_nodes(band),
            _ => self.end_of_nodes(band - 1)..self.first_node(band + 1),
        };
        Band { slots: self.first_slot(band)..self.first_slot(band + 1), new_nodes }
    }

    fn first_slot(&self, band: usize) -> usize {
        let first_cell = (self.first_layer + band * self.layers) * cells_per_layer(self.grid);
        self.active.cells().partition_point(|&cell| (cell as usize) < first_cell)
    }

    /// The first node of a band's stencils.
    fn first_node(&self, band: usize) -> usize {
        self.first_layer_of_nodes(self.first_layer + band * self.layers) * self.nodes_per_layer()
    }

    /// The one after the last.
    fn end_of_nodes(&self, band: usize) -> usize {
        let last = self.first_layer + (band + 1) * self.layers - 1;
        (self.first_layer_of_nodes(last) + S::WIDTH) * self.nodes_per_layer()
    }

    /// The first layer of nodes that the stencils of a layer of cells have; that of the last layer where the grid ends before.
    fn first_layer_of_nodes(&self, layer: usize) -> usize {
        let num_cells = self.grid.cells()[D - 1];
        self.shape.first_node(CellOnAxis { cell: layer.min(num_cells - 1), num_cells })
    }

    fn nodes_per_layer(&self) -> usize {
        self.grid.node_strides()[D - 1]
    }
}

fn cells_per_layer<const D: usize>(grid: &Grid<D>) -> usize {
    grid.cells()[..D - 1].iter().product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Located;
    use crate::shape::{CubicBSpline, Linear};

    /// Every cell of a grid adds 1 to each node of its stencil, on several threads; the sums are known.
    fn count<S: ShapeFunction>(shape: &S, cells: usize) -> Vec<f64> {
        let grid = Grid::new(Vector::<1>::zeros(), Vector::<1>::repeat(1.0), [cells]).unwrap();
        let mut active = ActiveSet::new(&grid);
        let occupied: Vec<u32> = (0..LEAST_PARTICLES).map(|p| (p % cells) as u32).collect();
        active.update(Located { cells: &occupied, numbers: &[] }, |cell, visit| {
            let first = shape.first_node(CellOnAxis { cell, num_cells: cells });
            (first..first + S::WIDTH).for_each(visit);
        });
        // What stood here before does not count.
        let mut mass = vec![7.0; grid.num_nodes()];
        let bands = Bands::new(shape, &grid, &active);
        assert!(bands.num_bands > 4);
        let nodes = NodeSums { first: 0, mass: &mut mass, momentum: &mut [], force: &mut [] };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        pool.install(|| {
            bands.sum(nodes, &|band: Band, nodes: NodeSums<1>| {
                nodes.mass[band.new_nodes.start - nodes.first..band.new_nodes.end - nodes.first].fill(0.0);
                for cell in band.slots {
                    let first = shape.first_node(CellOnAxis { cell, num_cells: cells }) - nodes.first;
                    nodes.mass[first..first + S::WIDTH].iter_mut().for_each(|mass| *mass += 1.0);
                }
            });
        });
        mass
    }

    #[test]
    fn every_cell_reaches_all_nodes_of_its_stencil_once() {
        let linear = count(&Linear, 100);
        assert_eq!((linear[0], linear[50], linear[100]), (1.0, 2.0, 1.0));
        assert_eq!(linear.iter().sum::<f64>(), 200.0);
        // The stencils of the end cells are those of their neighbours.
        let cubic = count(&CubicBSpline, 101);
        assert_eq!(cubic[..5], [2.0, 3.0, 4.0, 5.0, 4.0]);
        assert_eq!(cubic.iter().sum::<f64>(), 404.0);
    }
}
