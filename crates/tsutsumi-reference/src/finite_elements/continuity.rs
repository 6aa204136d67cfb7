//! The continuity equation of the pore water, by finite differences between the element centres.

use super::Parts;
use super::system::System;
use super::unknowns::Unknowns;
use tsutsumi::grid::{ActiveSet, CellFields, Grid, Side, SideSet};
use tsutsumi::particles::Particles;
use tsutsumi::shape::Linear;
use tsutsumi::tensor::Vector;
use tsutsumi::transfer::Transfer;

/// The coefficients of the continuity equation; empty in dry ground. The mesh is fixed, so they never change.
#[derive(Default)]
pub(super) struct Continuity<const D: usize> {
    elements: Vec<Element<D>>,
    /// Sides between two elements.
    inner: Vec<InnerSide>,
    /// Drained sides of the body.
    drained: Vec<DrainedSide>,
    /// k/g of every node (s): the mean of the elements around; zero without the fluid's inertia.
    inertia: Vec<f64>,
}

struct Element<const D: usize> {
    cell: usize,
    /// The nodes, and K_v for each (m²).
    divergence: Vec<(usize, Vector<D>)>,
    /// n V / K^f (m³/Pa).
    storage: f64,
}

struct InnerSide {
    lower: usize,
    upper: usize,
    /// T/γ_w ((m³/s)/Pa).
    conductance: f64,
    /// Flow from lower to upper that gravity drives (m³/s).
    gravity_flow: f64,
}

struct DrainedSide {
    slot: usize,
    cell: usize,
    conductance: f64,
    gravity_flow: f64,
}

/// What an element is filled with, from its points.
#[derive(Clone, Copy, Default)]
struct Filling {
    volume: f64,
    pores: f64,
    conductivity: f64,
    drained: SideSet,
}

fn fillings<const D: usize>(points: &Particles<D>, active: &ActiveSet) -> Vec<Filling> {
    let mut fillings = vec![Filling::default(); active.cells().len()];
    for p in 0..points.len() {
        let Some(slot) = active.slot(points.cell[p] as usize) else { continue };
        let filling = &mut fillings[slot];
        filling.volume += points.volume[p];
        filling.pores += points.volume[p] * points.porosity[p];
        filling.conductivity += points.volume[p] * points.conductivity[p];
        filling.drained = filling.drained.union(points.drained[p]);
    }
    for filling in &mut fillings {
        filling.conductivity /= filling.volume;
    }
    fillings
}

impl<const D: usize> Continuity<D> {
    pub(super) fn new(parts: &Parts<D>, active: &ActiveSet) -> Self {
        let Some(fluid) = parts.fluid else { return Continuity::default() };
        let grid = &parts.grid;
        let fillings = fillings(&parts.points, active);
        let weight = parts.gravity * fluid.density;
        let mut continuity = Continuity { inertia: vec![0.0; grid.num_nodes()], ..Continuity::default() };
        let mut around = vec![0.0; grid.num_nodes()];
        for (slot, &cell) in active.cells().iter().enumerate() {
            let cell = cell as usize;
            let filling = fillings[slot];
            let element =
                Element { cell, divergence: divergence(grid, cell), storage: filling.pores / fluid.bulk_modulus };
            for &(node, _) in &element.divergence {
                continuity.inertia[node] += filling.conductivity * fluid.density / fluid.unit_weight;
                around[node] += 1.0;
            }
            continuity.elements.push(element);
            for side in Side::all::<D>() {
                let half_length = 0.5 * grid.spacing()[side.axis];
                let area = grid.side_area(side.axis) / fluid.unit_weight;
                let beyond = grid.neighbor(cell, side).and_then(|other| active.slot(other));
                match beyond {
                    Some(upper) if side.upper => {
                        let resistance =
                            half_length / filling.conductivity + half_length / fillings[upper].conductivity;
                        let conductance = area / resistance;
                        let gravity_flow = conductance * weight[side.axis] * 2.0 * half_length;
                        continuity.inner.push(InnerSide { lower: slot, upper, conductance, gravity_flow });
                    }
                    None if filling.drained.contains(side) => {
                        let conductance = area * filling.conductivity / half_length;
                        let gravity_flow = conductance * weight[side.axis] * side.sign() * half_length;
                        continuity.drained.push(DrainedSide { slot, cell, conductance, gravity_flow });
                    }
                    _ => {}
                }
            }
        }
        for (inertia, around) in continuity.inertia.iter_mut().zip(around) {
            *inertia = if parts.fluid_inertia && around > 0.0 { *inertia / around } else { 0.0 };
        }
        continuity
    }

    /// The elements' pressures from their points.
    pub(super) fn mean_pressures(&self, points: &Particles<D>, active: &ActiveSet, cells: &mut CellFields) {
        for p in 0..points.len() {
            let cell = points.cell[p] as usize;
            cells.pressure[cell] += points.volume[p] * points.pressure[p];
            cells.volume[cell] += points.volume[p];
        }
        for &cell in active.cells() {
            cells.pressure[cell as usize] /= cells.volume[cell as usize];
        }
    }

    /// The pressures of the elements to their points.
    pub(super) fn pressures_to_points(&self, cells: &CellFields, points: &mut Particles<D>) {
        for (pressure, &cell) in points.pressure.iter_mut().zip(&points.cell) {
            *pressure = cells.pressure[cell as usize];
        }
    }

    /// Calls `push(node, K_v p_w)` for every node of every element.
    pub(super) fn push_nodes(&self, cells: &CellFields, mut push: impl FnMut(usize, Vector<D>)) {
        for element in &self.elements {
            for &(node, divergence) in &element.divergence {
                push(node, divergence * cells.pressure[element.cell]);
            }
        }
    }

    /// −[K_vᵀ (v − k/g a) + C (p_w − p_w|t) + L p_w + q_g] into the rows of the pressures; returns its largest component
    /// over the largest of the parts.
    pub(super) fn residual(
        &self,
        unknowns: &Unknowns<D>,
        cells: &CellFields,
        motion: (&[Vector<D>], &[Vector<D>]),
        dt: f64,
        residual: &mut [f64],
    ) -> f64 {
        let (velocity, acceleration) = motion;
        let mut largest: f64 = 0.0;
        let mut add = |slot: usize, inflow: f64| {
            largest = largest.max(inflow.abs());
            residual[unknowns.of_slot(slot)] += inflow;
        };
        for (slot, element) in self.elements.iter().enumerate() {
            for &(node, divergence) in &element.divergence {
                add(slot, -divergence.dot(&(velocity[node] - acceleration[node] * self.inertia[node])));
            }
            add(slot, -element.storage * (cells.pressure[element.cell] - cells.pressure_old[element.cell]) / dt);
        }
        for side in &self.inner {
            let drop = cells.pressure[self.elements[side.lower].cell] - cells.pressure[self.elements[side.upper].cell];
            let flow = side.conductance * drop + side.gravity_flow;
            add(side.lower, -flow);
            add(side.upper, flow);
        }
        for side in &self.drained {
            add(side.slot, -(side.conductance * cells.pressure[side.cell] + side.gravity_flow));
        }
        let rows = &residual[residual.len() - self.elements.len()..];
        rows.iter().fold(0.0, |most: f64, left| most.max(left.abs())) / largest.max(f64::MIN_POSITIVE)
    }

    /// Adds −K_v to the rows of the displacements, and K_vᵀ (∂v/∂u − k/g ∂a/∂u) + C + L to those of the pressures.
    ///
    /// `rates` are ∂v/∂u (1/s) and ∂a/∂u (1/s²).
    pub(super) fn add_to(&self, system: &mut System, unknowns: &Unknowns<D>, rates: (f64, f64), dt: f64) {
        for (slot, element) in self.elements.iter().enumerate() {
            let pressure = unknowns.of_slot(slot);
            for &(node, divergence) in &element.divergence {
                let rate = rates.0 - self.inertia[node] * rates.1;
                for axis in 0..D {
                    if let Some(row) = unknowns.of_node(node, axis) {
                        system.add(row, pressure, -divergence[axis]);
                        system.add(pressure, row, divergence[axis] * rate);
                    }
                }
            }
            system.add(pressure, pressure, element.storage / dt);
        }
        for side in &self.inner {
            let (lower, upper) = (unknowns.of_slot(side.lower), unknowns.of_slot(side.upper));
            for (row, other) in [(lower, upper), (upper, lower)] {
                system.add(row, row, side.conductance);
                system.add(row, other, -side.conductance);
            }
        }
        for side in &self.drained {
            let row = unknowns.of_slot(side.slot);
            system.add(row, row, side.conductance);
        }
    }

    /// Darcy's outflow through the drained sides (m³/s).
    pub(super) fn outflow_rate(&self, cells: &CellFields) -> f64 {
        self.drained.iter().map(|side| side.conductance * cells.pressure[side.cell] + side.gravity_flow).sum()
    }
}

/// The nodes of an element with their K_v.
fn divergence<const D: usize>(grid: &Grid<D>, cell: usize) -> Vec<(usize, Vector<D>)> {
    let mut values = vec![Vector::zeros(); Transfer::<D>::stencil_len(&Linear)];
    Linear.divergence_of_cell(grid, cell, &mut values);
    let mut nodes = Vec::with_capacity(values.len());
    Linear.visit_stencil(grid, cell, &mut |node| nodes.push(node));
    nodes.into_iter().zip(values).collect()
}
