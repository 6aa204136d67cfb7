//! Supports and loads. Drainage is carried by the particles, see [`Particles::drained`].

use crate::grid::{ActiveSet, Grid, NodeFields, Side};
use crate::particles::Particles;
use crate::tensor::Vector;
use crate::transfer::Transfer;

/// Set of axes along which a node is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AxisSet(u8);

impl AxisSet {
    /// Adds an axis, 0 = x.
    pub fn insert(&mut self, axis: usize) {
        self.0 |= 1 << axis;
    }

    /// True when the axis is in the set.
    pub fn contains(self, axis: usize) -> bool {
        self.0 >> axis & 1 == 1
    }
}

/// A factor that varies with time: linear between its points, constant before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    points: Vec<[f64; 2]>,
}

impl History {
    /// A history through points (time in s, factor). Times must not decrease; without points the factor is 1.
    pub fn new(points: Vec<[f64; 2]>) -> Self {
        History { points }
    }

    /// The factor at a time (s).
    pub fn factor(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] <= time);
        match (after.checked_sub(1).map(|before| self.points[before]), self.points.get(after)) {
            (Some([t0, f0]), Some(&[t1, f1])) => f0 + (f1 - f0) * (time - t0) / (t1 - t0),
            (Some([_, factor]), None) | (None, Some(&[_, factor])) => factor,
            (None, None) => 1.0,
        }
    }
}

/// Where a load acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AppliedTo {
    /// At the particles, as in the paper: half a particle below the surface.
    Particles,
    /// At this side of the particles' boxes: the true surface, which moves with the material.
    Surface(Side),
}

/// A load carried by particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Load<const D: usize> {
    /// The loaded particles and the force on each (N) where the history is 1.
    pub forces: Vec<(usize, Vector<D>)>,
    /// How the forces vary with time.
    pub history: History,
    /// Where on the particles they act.
    pub applied_to: AppliedTo,
}

/// What holds and pushes the body (steps 2 and 4 of the algorithm).
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary<const D: usize> {
    fixed: Vec<AxisSet>,
    loads: Vec<Load<D>>,
}

impl<const D: usize> Boundary<D> {
    /// No support and no load.
    pub fn free(grid: &Grid<D>) -> Self {
        Boundary { fixed: vec![AxisSet::default(); grid.num_nodes()], loads: Vec::new() }
    }

    /// Holds the nodes for which `holds(position)` is true along the given axes.
    pub fn fix(&mut self, grid: &Grid<D>, axes: AxisSet, holds: impl Fn(Vector<D>) -> bool) {
        for (node, fixed) in self.fixed.iter_mut().enumerate() {
            if holds(grid.node_position(node)) {
                fixed.0 |= axes.0;
            }
        }
    }

    /// Holds the nodes of a side of the grid along the given axes.
    pub fn fix_side(&mut self, grid: &Grid<D>, side: Side, axes: AxisSet) {
        let stride = grid.node_strides()[side.axis];
        let last = grid.cells()[side.axis];
        let wanted = if side.upper { last } else { 0 };
        for (node, fixed) in self.fixed.iter_mut().enumerate() {
            if node / stride % (last + 1) == wanted {
                fixed.0 |= axes.0;
            }
        }
    }

    /// Adds a load.
    pub fn push_load(&mut self, load: Load<D>) {
        self.loads.push(load);
    }

    /// The loads.
    pub fn loads(&self) -> &[Load<D>] {
        &self.loads
    }

    /// Adds the loads at a time (s) to the nodal forces.
    ///
    /// # Equation
    ///
    /// ```text
    /// τ_I = ∫ τ̄ N_I dS = Σ_p τ̄ S_p N_I(x_p)          Eq. (7)
    /// ```
    ///
    /// `x_p` is the particle, as in the paper, or its face on the true surface; `S_p` the area it stands for.
    #[doc(alias = "Eq. (7)")]
    pub fn add_loads(
        &self,
        grid: &Grid<D>,
        transfer: &dyn Transfer<D>,
        particles: &Particles<D>,
        time: f64,
        nodes: &mut NodeFields<D>,
    ) {
        for load in &self.loads {
            let factor = load.history.factor(time);
            for &(p, force) in &load.forces {
                let mut point = particles.position[p];
                if let AppliedTo::Surface(side) = load.applied_to {
                    point[side.axis] += side.sign() * particles.half_size[p][side.axis];
                }
                transfer.spread_force(grid, particles.cell[p] as usize, &point, &(force * factor), nodes);
            }
        }
    }

    /// Takes the mobility 1/m_I from the nodes' masses, zero where a support holds or there is no mass to move.
    pub fn hold(&self, active: &ActiveSet, nodes: &mut NodeFields<D>) {
        for &node in active.nodes() {
            let node = node as usize;
            let mass = nodes.mass[node];
            // A subnormal mass has no usable inverse; such a node is a particle exactly on the opposite grid line.
            let inverse = if mass > f64::MIN_POSITIVE { 1.0 / mass } else { 0.0 };
            let fixed = self.fixed[node];
            nodes.mobility[node] = Vector::from_fn(|axis, _| if fixed.contains(axis) { 0.0 } else { inverse });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_are_linear_in_between_and_constant_outside() {
        let ramp = History::new(vec![[1.0, 0.0], [3.0, 4.0]]);
        assert_eq!([0.0, 1.0, 1.5, 3.0, 9.0].map(|t| ramp.factor(t)), [0.0, 0.0, 1.0, 4.0, 4.0]);
        assert_eq!(History::new(vec![]).factor(2.0), 1.0);
        let jump = History::new(vec![[0.0, 1.0], [1.0, 1.0], [1.0, 2.0]]);
        assert_eq!([0.5, 1.0].map(|t| jump.factor(t)), [1.0, 2.0]);
    }

    #[test]
    fn supports_hold_the_nodes_of_a_side() {
        let grid = Grid::new(Vector::<2>::zeros(), Vector::<2>::repeat(1.0), [2, 1]).unwrap();
        let mut boundary = Boundary::free(&grid);
        let mut x = AxisSet::default();
        x.insert(0);
        boundary.fix_side(&grid, Side { axis: 0, upper: true }, x);
        boundary.fix(&grid, x, |position| position == Vector::<2>::zeros());
        let held: Vec<bool> = boundary.fixed.iter().map(|fixed| fixed.contains(0)).collect();
        assert_eq!(held, [true, false, true, false, false, true]);
    }
}
