use std::ops::Range;

use super::checkerboard::Checkerboard;
use super::conjugate_gradient::Breakdown;
use super::envelope::Envelope;
use super::geometry::{FilledBox, Surface, fill_boxes, shrink_boxes, smallest_fill};
use super::particle_pressure::{CellPressure, ParticlePressure};
use super::stencil_matrix::GRAIN;
use super::tied::TiedCells;
use super::wide_system::{Contributions, WideSystem};
use super::{PressureError, PressureReport, PressureScheme, StepView};
use crate::grid::{CellFields, NodeFields, Side};
use crate::parallel;
use crate::particles::Particles;
use crate::tensor::Vector;

/// The pore water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluid {
    /// Density ρ^f (kg/m³).
    pub density: f64,
    /// Bulk modulus K^f (Pa).
    pub bulk_modulus: f64,
    /// Unit weight γ_w (N/m³).
    pub unit_weight: f64,
}

/// Where the volume change, the storage and the conductance of a cell are summed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quadrature {
    /// Over the whole cell, as in the paper. Exact while the surface of the body is on a grid line.
    ///
    /// K_v is an integral then, and the masses stay sums over the particles. With linear functions and boxes the two agree as long
    /// as the particles stand evenly in their cells; with splines they differ next to the ends of the grid by the error of the sums.
    Cell,
    /// Over the material points in the cell: right too where the surface is inside a cell.
    MaterialPoints,
}

/// The paper's scheme: momentum and continuity solved together for the cell pressures.
///
/// # Equation
///
/// ```text
/// m_I a_I − K_v p_w = F_I                                                        Eq. (5)
/// K_vᵀ a_I + (A' − α') p_E + Σ_i α'_i p_Ei
///         = K_vᵀ {v_I + Δt (1−γ) a_I|t} / (k/g − γΔt) + A' p_E|t                 Eq. (9), p = −p_w
/// ```
///
/// solved without dividing by k/g − γΔt (which may be zero) and with a_I eliminated:
///
/// ```text
/// [L + C + c K_vᵀ M⁻¹ K_v] p_w = C p_w|t − K_vᵀ [v_I + c M⁻¹ F] − q_g,           c = γΔt − k/g,  γ = 1
/// C = n V / (K^f Δt)        (L p)_E = Σ_i T_i / γ_w (p_E − p_Ei)       T_i = 1 / (d_E/(k_E b_i) + d_Ei/(k_Ei b_i))
/// ```
///
/// `p_w` is the total pressure. The term q_g = Σ_i T_i / γ_w ρ^f b · (x_Ei − x_E) is Darcy's flow under gravity; it
/// vanishes in full cells inside the body and not at its boundary. A drained side has p_w = 0 at the side itself, an
/// impermeable one has no T. The symmetric matrix is positive definite whenever γΔt ≥ k/g; below it may cease to be, and
/// then the step is refused.
///
/// The term k/g K_vᵀ a_I (inertia of the water relative to the soil) is kept also on impermeable sides: it vanishes there
/// when the side does not accelerate along its normal.
///
/// Where the conductivity varies, c is taken at the nodes, the mean of the cells around: the term is then the discrete
/// form of ∮ (k/g) a · n dS, and the matrix stays symmetric.
///
/// For nodes that move as one ([`NodeFields::ties`]) M⁻¹ is 1 1ᵀ / Σ m_I over them: a matrix of rank one each.
///
/// # Reference
///
/// Goto et al., sec. 2.2; derivation in the book, "The continuity equation".
#[doc(alias = "Eq. (5)")]
#[doc(alias = "Eq. (8)")]
#[doc(alias = "Eq. (9)")]
pub struct Coupled<const D: usize> {
    fluid: Fluid,
    quadrature: Quadrature,
    fluid_inertia: bool,
    particle_pressure: Box<dyn ParticlePressure<D>>,
    topology: Topology<D>,
    /// K_v of every active cell, one stencil after the other.
    divergence: Vec<Vector<D>>,
    boxes: Vec<FilledBox<D>>,
    /// Storage C of each active cell (m³/s per Pa).
    storage: Vec<f64>,
    /// Conductivity k of each active cell (m/s), mean by volume.
    conductivity: Vec<f64>,
    /// Pressure of the particles in each active cell (Pa), mean by volume.
    pressure: Vec<f64>,
    /// The volume of the particles in each active cell (m³).
    volumes: Vec<f64>,
    /// Conductance T/γ_w of the face between each active cell and the one above it, per axis ((m³/s)/Pa); zero where there is none, and in
    /// a row behind them, for cells that have none below.
    conductance: Vec<Vector<D>>,
    /// The flow under gravity q_g through these faces, upwards (m³/s).
    gravity_flow: Vec<Vector<D>>,
    /// Slot, conductance and gravity flow of every drained side.
    drains: Vec<(u32, f64, f64)>,
    /// c / m of every node of the grid, per axis; zero where the node is held or tied (s/kg).
    compliance: Vec<Vector<D>>,
    ties: Vec<TiedCells>,
    checkerboard: Checkerboard,
    matrix: Envelope,
    wide: WideSystem,
    right: Vec<f64>,
    solution: Vec<f64>,
    /// Values by row, for the direct solver.
    rows: Vec<f64>,
    nodal: Vec<Vector<D>>,
}

/// Who neighbours whom: rebuilt when the active set changes.
#[derive(Debug, Clone, Default)]
struct Topology<const D: usize> {
    generation: u64,
    stencil_len: usize,
    /// The nodes of every active cell's stencil.
    stencils: Vec<u32>,
    /// The place of every active node among the active ones; one value per node of the grid.
    place_of_node: Vec<u32>,
    /// The cells that touch each active node: entries `node_start[i]..node_start[i + 1]` are places in `stencils`.
    node_start: Vec<u32>,
    node_entries: Vec<u32>,
    /// The slot of each of these.
    node_slots: Vec<u32>,
    /// The slots of the cells above and below each active cell, per axis; the number of active cells where there is none.
    above: Vec<[u32; D]>,
    below: Vec<[u32; D]>,
    surface: Surface,
    /// The row of each slot in the direct solver's matrix.
    row_of_slot: Vec<u32>,
    slot_of_row: Vec<u32>,
    /// The first column of each row: the smallest row among the cells that share a node with it.
    first_column: Vec<u32>,
    direct: bool,
    /// What the nodes add to the direct solver's matrix, node by node.
    products: Vec<NodeProduct>,
    /// Mean square half bandwidth up to which the direct solver is used.
    widest_direct: usize,
}

/// K_vᵀ c/m K_v of two cells at a node: a part of an entry of the direct solver's matrix.
#[derive(Debug, Clone, Copy)]
struct NodeProduct {
    node: u32,
    /// Where the cells' K_v of this node stand.
    cells: [u32; 2],
    /// The entry; 32 bits hold places in 34 GB.
    entry: u32,
}

/// Mean square of the matrix's half bandwidth up to which the direct solver is used: there both cost the same (squares of 23 cells, one thread).
const DIRECT_MEAN_SQUARE_WIDTH: usize = 500;

impl<const D: usize> Coupled<D> {
    /// The scheme for this pore water.
    ///
    /// `fluid_inertia` keeps the term with k/g; without it the scheme can be compared with programs that drop it.
    pub fn new(fluid: Fluid, quadrature: Quadrature, fluid_inertia: bool) -> Self {
        Coupled {
            fluid,
            quadrature,
            fluid_inertia,
            particle_pressure: Box::new(CellPressure),
            topology: Topology { widest_direct: DIRECT_MEAN_SQUARE_WIDTH, ..Topology::default() },
            divergence: Vec::new(),
            boxes: Vec::new(),
            storage: Vec::new(),
            conductivity: Vec::new(),
            pressure: Vec::new(),
            volumes: Vec::new(),
            conductance: Vec::new(),
            gravity_flow: Vec::new(),
            drains: Vec::new(),
            compliance: Vec::new(),
            ties: Vec::new(),
            checkerboard: Checkerboard::default(),
            matrix: Envelope::default(),
            wide: WideSystem::default(),
            right: Vec::new(),
            solution: Vec::new(),
            rows: Vec::new(),
            nodal: Vec::new(),
        }
    }

    /// The same scheme with another way for the cells' pressures to come back to the particles; it starts with the paper's,
    /// [`CellPressure`].
    #[must_use]
    pub fn with_particle_pressure(mut self, particle_pressure: Box<dyn ParticlePressure<D>>) -> Self {
        self.particle_pressure = particle_pressure;
        self
    }

    /// The same scheme with the pressure's checkerboard stabilised: in it the water is 1 + 16 θ times as compressible as elsewhere,
    /// where θ = `softening` (–, not negative). 30 is recommended; 0, the start, leaves every bit as it is.
    ///
    /// # Equation
    ///
    /// ```text
    /// + S t_c (t·Δp_w)  in continuity, for each 2×2 block     t = (+1, −1, −1, +1)     S = θ n V / (K^f Δt)
    /// ```
    ///
    /// Pressures that vary along one axis only or linearly are not touched, nor is steady flow. A wave oblique to the grid sees a
    /// bulk modulus of the water that is 1 + 16 θ sin²(φ_x/2) sin²(φ_y/2) times smaller, φ the phase from cell to cell.
    #[must_use]
    pub fn stabilised(mut self, softening: f64) -> Self {
        self.checkerboard = Checkerboard::new(softening);
        self
    }

    /// The same scheme with another limit for the direct solver: it is used where the mean square half bandwidth of the matrix, in cells, is
    /// at most this, conjugate gradients elsewhere. With 0 there is no direct solver but for cells apart: to compare the two.
    #[must_use]
    pub fn with_direct_solver_up_to(mut self, mean_square_width: usize) -> Self {
        self.topology.widest_direct = mean_square_width;
        self
    }

    /// Rebuilds what depends on which cells are active.
    fn update_topology(&mut self, at: &StepView<D>) {
        if self.topology.generation == at.active.generation() {
            return;
        }
        self.topology.rebuild(at);
        self.checkerboard.rebuild(at);
        let size = at.active.cells().len();
        let stencil_len = self.topology.stencil_len;
        self.divergence.resize(size * stencil_len, Vector::zeros());
        if self.quadrature == Quadrature::Cell {
            for (&cell, of_cell) in at.active.cells().iter().zip(self.divergence.chunks_mut(stencil_len)) {
                at.transfer.divergence_of_cell(at.grid, cell as usize, of_cell);
            }
        }
        for nodal in [&mut self.compliance, &mut self.nodal] {
            nodal.resize(at.grid.num_nodes(), Vector::zeros());
        }
        for work in [&mut self.right, &mut self.solution, &mut self.rows] {
            work.resize(size, 0.0);
        }
        // Capacity for the most that so many cells can need, so that later steps do not allocate.
        fill_boxes(at, &mut self.boxes);
        for of_faces in [&mut self.conductance, &mut self.gravity_flow] {
            of_faces.clear();
            of_faces.resize(size + 1, Vector::zeros());
        }
        self.drains.clear();
        self.drains.reserve(2 * D * size);
        if self.topology.direct {
            self.matrix.set_shape(self.topology.first_column.iter().copied());
            self.topology.list_products(at.active.nodes(), &self.matrix);
        } else {
            self.wide.rebuild(at, &self.topology.stencils);
        }
    }

    /// Step 6 of the algorithm, see [`PressureScheme::solve`].
    fn solve_step(
        &mut self,
        at: &StepView<D>,
        particles: &Particles<D>,
        cells: &mut CellFields,
        nodes: &mut NodeFields<D>,
    ) -> Result<PressureReport, PressureError> {
        self.update_topology(at);
        if self.quadrature == Quadrature::MaterialPoints {
            shrink_boxes(at, particles, &self.topology.surface, &mut self.boxes);
            at.transfer.divergence_of_particles(at.grid, at.active, particles, &mut self.divergence);
        }
        self.measure_faces(at);
        self.measure_drains(at, particles);
        self.checkerboard.measure(|slot| self.storage[slot]);
        self.relax_nodes(at, nodes);
        match self.topology.direct {
            true => self.factorize(at)?,
            false => self.measure_wide(at)?,
        }
        let mut iterations = 0;
        if !at.damping.is_off() {
            iterations += self.damp(at, nodes)?;
        }
        iterations += self.solve_for_pressures(at, nodes)?;

        at.active.change_cells(&mut cells.pressure, |slot, _, pressure| *pressure = self.solution[slot]);
        self.force_out_of_balance(at, nodes);
        nodes.forces_to_accelerations(at.active);
        let flow =
            |&(slot, conductance, gravity): &(u32, f64, f64)| conductance * self.solution[slot as usize] + gravity;
        Ok(PressureReport { iterations, outflow_rate: self.drains.iter().map(flow).sum() })
    }

    /// Volume, storage, conductivity and pressure of the active cells, from their particles.
    fn sum_particles(&mut self, at: &StepView<D>, particles: &Particles<D>) {
        let Coupled { volumes, storage, conductivity, pressure, .. } = self;
        let size = at.active.cells().len();
        for of_cells in [&mut *volumes, storage, conductivity, pressure] {
            of_cells.resize(size, 0.0);
        }
        let per_volume = 1.0 / (self.fluid.bulk_modulus * at.dt);
        let whole = (self.quadrature == Quadrature::Cell).then(|| at.grid.cell_volume());
        let work = |((volumes, storage), (conductivity, pressure), slots): CellPieces| {
            let means = storage.iter_mut().zip(conductivity.iter_mut().zip(pressure));
            for ((volume, (storage, (conductivity, pressure))), slot) in volumes.iter_mut().zip(means).zip(slots) {
                let sums = CellSums::of_particles(particles, at.active.particles_of(slot));
                let filled = whole.map_or(1.0, |whole| whole / sums.volume);
                *volume = sums.volume;
                *storage = sums.pores * filled * per_volume;
                *conductivity = sums.conductivity / sums.volume;
                *pressure = sums.pressure / sums.volume;
            }
        };
        let pieces = ((&mut volumes[..], &mut storage[..]), (&mut conductivity[..], &mut pressure[..]), 0..size);
        parallel::for_each(pieces, GRAIN, &work);
    }

    /// Conductances of inner faces, with the flow that gravity drives through them.
    ///
    /// # Equation
    ///
    /// ```text
    /// T = 1 / (d_1/(k_1 b_1) + d_2/(k_2 b_2)) = k_1 b_1 k_2 b_2 / (d_1 k_2 b_2 + d_2 k_1 b_1)        α'_i of Eq. (9), undivided: T_i / γ_w
    /// ```
    ///
    /// `d` is the distance from a cell's centre to the face (m), `b` the wetted area on its side (m²).
    fn measure_faces(&mut self, at: &StepView<D>) {
        let weight = at.gravity * self.fluid.density;
        let Coupled { boxes, conductivity, conductance, gravity_flow, topology, fluid, .. } = self;
        let size = boxes.len();
        let width = |slot: usize, axis: usize| conductivity[slot] * boxes[slot].side_area(axis);
        let work = |(conductance, gravity_flow, slots): (&mut [Vector<D>], &mut [Vector<D>], Range<usize>)| {
            for ((conductance, gravity_flow), slot) in conductance.iter_mut().zip(gravity_flow).zip(slots) {
                for axis in 0..D {
                    let above = topology.above[slot][axis] as usize;
                    if above == size {
                        continue;
                    }
                    let (own, other) = (width(slot, axis), width(above, axis));
                    let narrow = boxes[slot].half_extent(axis) * other + boxes[above].half_extent(axis) * own;
                    // Two cells that let nothing through: no flow, not 0/0.
                    conductance[axis] = own * other / (fluid.unit_weight * narrow).max(f64::MIN_POSITIVE);
                    let between = boxes[above].center() - boxes[slot].center();
                    gravity_flow[axis] = conductance[axis] * weight.dot(&between);
                }
            }
        };
        parallel::for_each((&mut conductance[..size], &mut gravity_flow[..size], 0..size), GRAIN, &work);
    }

    /// Conductances of the sides that a particle drains, from the centre of its cell, with the flow that gravity drives through them.
    fn measure_drains(&mut self, at: &StepView<D>, particles: &Particles<D>) {
        let weight = at.gravity * self.fluid.density;
        let Coupled { drains, topology, boxes, conductivity, fluid, .. } = self;
        drains.clear();
        for &(number, side) in &topology.surface.sides {
            let slot = number as usize;
            if at.active.particles_of(slot).iter().any(|&p| particles.drained[p as usize].contains(side)) {
                let half_extent = boxes[slot].half_extent(side.axis);
                let width = conductivity[slot] * boxes[slot].side_area(side.axis);
                let conductance = width / (half_extent * fluid.unit_weight);
                drains.push((number, conductance, conductance * weight[side.axis] * side.sign() * half_extent));
            }
        }
    }

    /// k/g over k (s²/m).
    fn inertia(&self) -> f64 {
        if self.fluid_inertia { self.fluid.density / self.fluid.unit_weight } else { 0.0 }
    }

    /// c/m at the active nodes.
    fn relax_nodes(&mut self, at: &StepView<D>, nodes: &NodeFields<D>) {
        let inertia = self.inertia();
        let Coupled { topology, conductivity, compliance, .. } = self;
        at.active.change_nodes(compliance, |i, node, value| {
            *value = nodes.mobility[node] * (at.dt - inertia * topology.mean_around(i, conductivity));
        });
        self.relax_ties(at, nodes);
    }

    /// One c for all nodes that move as one, and their part of the matrix.
    fn relax_ties(&mut self, at: &StepView<D>, nodes: &NodeFields<D>) {
        let inertia = self.inertia();
        let Coupled { conductivity, compliance, ties, topology, divergence, wide, .. } = self;
        ties.resize_with(nodes.ties.len(), TiedCells::default);
        for (tied, tie) in ties.iter_mut().zip(&nodes.ties) {
            let axis = tie.axis();
            let members = || tie.nodes().iter().map(|&node| node as usize);
            let relaxation = |node: usize| {
                at.dt - inertia * topology.mean_around(topology.place_of_node[node] as usize, conductivity)
            };
            let mobility = members().next().map_or(0.0, |node| nodes.mobility[node][axis]);
            let mass: f64 = members().map(|node| nodes.mass[node]).sum();
            let weighted: f64 = members().map(|node| nodes.mass[node] * relaxation(node)).sum();
            members().for_each(|node| compliance[node][axis] = 0.0);
            let strength = if mobility > 0.0 { mobility * weighted / mass } else { 0.0 };
            let (size, place_of): (usize, &dyn Fn(usize) -> usize) = match topology.direct {
                true => (at.active.cells().len(), &|slot| slot),
                false => (wide.num_sites(), &|slot| wide.site_of_cell()[slot] as usize),
            };
            tied.resize(size);
            tied.measure(at, tie, strength, divergence, |place| topology.cells_of_node(place), place_of);
        }
    }

    /// Adds the damping to the nodes' forces. The force out of balance is that of a step without damping, for which the pressures
    /// are solved for first.
    ///
    /// With the pressures of the start of the step in it, coarse ground would be unstable at any step: there the pressure
    /// follows the acceleration, ρ^f/(ρ−ρ^f) times the force, and a resistance would feed that of the next step.
    fn damp(&mut self, at: &StepView<D>, nodes: &mut NodeFields<D>) -> Result<usize, PressureError> {
        let mut iterations = 0;
        if at.damping.needs_force_out_of_balance() {
            iterations = self.solve_for_pressures(at, nodes)?;
            self.force_out_of_balance(at, nodes);
        }
        at.damping.resist(at.active, nodes);
        Ok(iterations)
    }

    /// F + K_v p_w of the solution, into the nodes' accelerations (N).
    fn force_out_of_balance(&self, at: &StepView<D>, nodes: &mut NodeFields<D>) {
        let Coupled { topology, divergence, solution, .. } = self;
        let force = &nodes.force;
        at.active.change_nodes(&mut nodes.acceleration, |i, node, value| {
            *value = force[node] + topology.push_node(i, divergence, solution);
        });
    }

    /// v + c M⁻¹ F of the nodes, into `nodal` (m/s).
    fn find_tendency(&mut self, at: &StepView<D>, nodes: &NodeFields<D>) {
        let Coupled { nodal, compliance, ties, .. } = self;
        let NodeFields { force, velocity_old, .. } = nodes;
        at.active.change_runs(nodal, |run, tendencies| {
            let of_nodes = velocity_old[run.clone()].iter().zip(force[run.clone()].iter().zip(&compliance[run]));
            for (tendency, (velocity, (force, compliance))) in tendencies.iter_mut().zip(of_nodes) {
                for axis in 0..D {
                    tendency[axis] = velocity[axis] + force[axis] * compliance[axis];
                }
            }
        });
        for (tied, tie) in ties.iter().zip(&nodes.ties) {
            let members = || tie.nodes().iter().map(|&node| node as usize);
            let change = tied.strength() * members().map(|node| force[node][tie.axis()]).sum::<f64>();
            members().for_each(|node| nodal[node][tie.axis()] += change);
        }
    }

    /// C p|t − K_vᵀ [v + c M⁻¹ F] − q_g, into `right`.
    fn fill_right_side(&mut self, at: &StepView<D>, nodes: &NodeFields<D>) {
        self.find_tendency(at, nodes);
        let Coupled { nodal, topology, divergence, gravity_flow, right, storage, pressure, .. } = self;
        let work = |(right, slots): (&mut [f64], Range<usize>)| {
            for (right, slot) in right.iter_mut().zip(slots) {
                let below = topology.below[slot];
                let outflow = |axis: usize| gravity_flow[slot][axis] - gravity_flow[below[axis] as usize][axis];
                let gravity: f64 = (0..D).map(outflow).sum();
                *right = storage[slot] * pressure[slot] - topology.divergence_of(slot, divergence, nodal) - gravity;
            }
        };
        let size = pressure.len();
        parallel::for_each((&mut right[..], 0..size), GRAIN, &work);
        self.checkerboard.add_product(&self.pressure, &mut self.right);
        for &(slot, _, flow) in &self.drains {
            self.right[slot as usize] -= flow;
        }
    }

    /// The pressures for the forces that stand in `nodes`, into `solution`; the matrix is ready, and the iteration starts from the last
    /// solution.
    fn solve_for_pressures(&mut self, at: &StepView<D>, nodes: &NodeFields<D>) -> Result<usize, PressureError> {
        self.fill_right_side(at, nodes);
        Self::check_finite(at, &self.right)?;
        let iterations = if self.topology.direct { self.solve_directly() } else { self.solve_iteratively(at)? };
        Self::check_finite(at, &self.solution)?;
        Ok(iterations)
    }

    /// Solves with the factor.
    fn solve_directly(&mut self) -> usize {
        let Coupled { topology, matrix, rows, solution, right, ties, .. } = self;
        solution.copy_from_slice(right);
        topology.solve_rows(matrix, rows, solution);
        ties.iter().for_each(|tie| tie.correct(solution));
        0
    }

    /// Assembles and factorises the matrix: for small and narrow systems.
    fn factorize(&mut self, at: &StepView<D>) -> Result<(), PressureError> {
        let topology = &self.topology;
        let row = |slot: u32| topology.row_of_slot[slot as usize] as usize;
        self.matrix.clear_values();
        for (slot, &storage) in self.storage.iter().enumerate() {
            self.matrix.add(row(slot as u32), row(slot as u32), storage);
        }
        let size = self.storage.len();
        for (slot, (conductances, above)) in self.conductance.iter().zip(&topology.above).enumerate() {
            for (&conductance, &above) in conductances.iter().zip(above).filter(|(_, above)| **above as usize != size) {
                let (a, b) = (row(slot as u32), row(above));
                self.matrix.add(a, a, conductance);
                self.matrix.add(b, b, conductance);
                self.matrix.add(a.max(b), a.min(b), -conductance);
            }
        }
        for &(slot, conductance, _) in &self.drains {
            self.matrix.add(row(slot), row(slot), conductance);
        }
        let matrix = &mut self.matrix;
        self.checkerboard.visit_entries(|a, b, value| {
            if row(b) <= row(a) {
                matrix.add(row(a), row(b), value);
            }
        });
        let entries = self.matrix.entries_mut();
        for &NodeProduct { node, cells: [e, f], entry } in &topology.products {
            let pushed = self.divergence[e as usize].component_mul(&self.compliance[node as usize]);
            entries[entry as usize] += pushed.dot(&self.divergence[f as usize]);
        }
        self.matrix.factorize().map_err(|bad| {
            let slot = topology.slot_of_row[bad.row] as usize;
            match bad.pivot.is_finite() {
                true => self.not_positive_definite(at, slot, bad.pivot),
                false => PressureError::NotFinite { time: at.time, cell: at.cell_index_of_slot(slot) },
            }
        })?;
        self.factorize_ties().map_err(|(slot, pivot)| self.not_positive_definite(at, slot, pivot))
    }

    /// Prepares the corrections for the nodes that move as one, one set after the other.
    ///
    /// # Errors
    /// The slot and the pivot where the matrix is not positive definite.
    fn factorize_ties(&mut self) -> Result<(), (usize, f64)> {
        let Coupled { topology, matrix, rows, ties, .. } = self;
        for number in 0..ties.len() {
            let (before, rest) = ties.split_at_mut(number);
            let solve = |x: &mut [f64]| {
                topology.solve_rows(matrix, rows, x);
                before.iter().for_each(|tie| tie.correct(x));
            };
            rest[0].factorize(solve).map_err(|pivot| (rest[0].main_slot(), pivot))?;
        }
        Ok(())
    }

    fn not_positive_definite(&self, at: &StepView<D>, slot: usize, pivot: f64) -> PressureError {
        let relaxation = |i: usize| at.dt - self.inertia() * self.topology.mean_around(i, &self.conductivity);
        let short_step = (0..at.active.nodes().len()).any(|i| relaxation(i) < 0.0);
        PressureError::NotPositiveDefinite { time: at.time, cell: at.cell_index_of_slot(slot), pivot, short_step }
    }

    /// Fills the matrix of a wide system, whose solution is looked for from the pressures of the particles on.
    fn measure_wide(&mut self, at: &StepView<D>) -> Result<(), PressureError> {
        let Coupled { topology, divergence, compliance, storage, conductance, drains, checkerboard, wide, .. } = self;
        wide.start_from(&self.pressure);
        let below = &topology.below;
        let contributions = Contributions { divergence, compliance, storage, conductance, below, drains, checkerboard };
        let outcome = wide.measure(at, &contributions);
        outcome.map_err(|(slot, entry)| self.not_positive_definite(at, slot, entry))
    }

    /// Solves by conjugate gradients, started from the last solution.
    fn solve_iteratively(&mut self, at: &StepView<D>) -> Result<usize, PressureError> {
        let outcome = self.wide.solve(&self.ties, &self.right, &mut self.solution);
        outcome.map_err(|breakdown| match breakdown {
            Breakdown::Indefinite { site, quotient } => self.not_positive_definite(at, site, quotient),
            Breakdown::NotConverged { site, iterations, residual } => {
                let cell = at.cell_index_of_slot(site);
                PressureError::NotConverged { time: at.time, cell, iterations, residual }
            }
        })
    }

    /// The first value that is not finite becomes an error that names its cell.
    fn check_finite(at: &StepView<D>, values: &[f64]) -> Result<(), PressureError> {
        let work = |(values, slots): (&[f64], Range<usize>)| {
            values.iter().zip(slots).find(|(value, _)| !value.is_finite()).map(|(_, slot)| slot)
        };
        match parallel::fold((values, 0..values.len()), GRAIN, &work, &Option::or) {
            Some(slot) => Err(PressureError::NotFinite { time: at.time, cell: at.cell_index_of_slot(slot) }),
            None => Ok(()),
        }
    }
}

impl<const D: usize> StepView<'_, D> {
    fn cell_index_of_slot(&self, slot: usize) -> Vec<usize> {
        self.grid.cell_index(self.active.cells()[slot] as usize).to_vec()
    }
}

impl<const D: usize> Topology<D> {
    fn rebuild(&mut self, at: &StepView<D>) {
        self.generation = at.active.generation();
        self.stencil_len = at.transfer.stencil_len();
        self.stencils.clear();
        let size = at.active.cells().len();
        self.above.clear();
        self.below.clear();
        self.below.resize(size, [size as u32; D]);
        for (slot, &cell) in at.active.cells().iter().enumerate() {
            let cell = cell as usize;
            at.transfer.visit_stencil(at.grid, cell, &mut |node| self.stencils.push(node as u32));
            let above: [Option<usize>; D] = std::array::from_fn(|axis| {
                at.grid.neighbor(cell, Side { axis, upper: true }).and_then(|other| at.active.slot(other))
            });
            self.above.push(above.map(|above| above.unwrap_or(size) as u32));
            for (axis, above) in above.into_iter().enumerate() {
                if let Some(above) = above {
                    self.below[above][axis] = slot as u32;
                }
            }
        }
        self.surface.rebuild(at);
        self.list_cells_of_nodes(at);
        self.order_rows(at);
    }

    /// Inverts `stencils`: counts, then fills, both in ascending order.
    fn list_cells_of_nodes(&mut self, at: &StepView<D>) {
        let nodes = at.active.nodes();
        self.place_of_node.resize(at.grid.num_nodes(), 0);
        for (place, &node) in nodes.iter().enumerate() {
            self.place_of_node[node as usize] = place as u32;
        }
        // Every node of a stencil is active: the set was made from these very stencils.
        let place = |node: u32| self.place_of_node[node as usize] as usize;
        self.node_start.clear();
        self.node_start.resize(nodes.len() + 1, 0);
        for &node in &self.stencils {
            self.node_start[place(node) + 1] += 1;
        }
        for i in 0..nodes.len() {
            self.node_start[i + 1] += self.node_start[i];
        }
        self.node_entries.clear();
        self.node_entries.resize(self.stencils.len(), 0);
        for (entry, &node) in self.stencils.iter().enumerate() {
            let start = &mut self.node_start[place(node)];
            self.node_entries[*start as usize] = entry as u32;
            *start += 1;
        }
        let stencil_len = self.stencil_len as u32;
        self.node_slots.clear();
        self.node_slots.extend(self.node_entries.iter().map(|entry| entry / stencil_len));
        // The fill has moved each start to the next one's: shift back.
        self.node_start.copy_within(0..nodes.len(), 1);
        self.node_start[0] = 0;
    }

    /// Numbers the rows along the shortest axes of the body first, which keeps the matrix narrow, and chooses the solver.
    fn order_rows(&mut self, at: &StepView<D>) {
        let cells = at.active.cells();
        let mut lowest = [usize::MAX; D];
        let mut highest = [0; D];
        for &cell in cells {
            let index = at.grid.cell_index(cell as usize);
            for axis in 0..D {
                lowest[axis] = lowest[axis].min(index[axis]);
                highest[axis] = highest[axis].max(index[axis]);
            }
        }
        let mut axes: [usize; D] = std::array::from_fn(|axis| axis);
        let extent = |axis: usize| highest[axis].saturating_sub(lowest[axis]) + 1;
        axes.sort_by_key(|&axis| std::cmp::Reverse(extent(axis)));
        // A matrix is about as wide as the body has cells across its longest axis. Far beyond the limit the order need not be known.
        let across = cells.len() / extent(axes[0]);
        if across * across / 16 > self.widest_direct {
            self.direct = false;
            return;
        }
        self.slot_of_row.clear();
        self.slot_of_row.extend(0..cells.len() as u32);
        self.slot_of_row.sort_unstable_by_key(|&slot| {
            let index = at.grid.cell_index(cells[slot as usize] as usize);
            axes.map(|axis| index[axis])
        });
        self.row_of_slot.clear();
        self.row_of_slot.resize(cells.len(), 0);
        for (row, &slot) in self.slot_of_row.iter().enumerate() {
            self.row_of_slot[slot as usize] = row as u32;
        }
        self.find_first_columns();
        let width = |(row, &first): (usize, &u32)| row - first as usize;
        let square_widths: usize = self.first_column.iter().enumerate().map(|row| width(row).pow(2)).sum();
        self.direct = square_widths <= self.widest_direct.saturating_mul(cells.len().max(1));
    }

    /// Solves with the factor of the direct solver, for values by slot; `rows` is a work array.
    fn solve_rows(&self, factor: &Envelope, rows: &mut [f64], values: &mut [f64]) {
        for (slot, &row) in self.row_of_slot.iter().enumerate() {
            rows[row as usize] = values[slot];
        }
        factor.solve(rows);
        for (slot, &row) in self.row_of_slot.iter().enumerate() {
            values[slot] = rows[row as usize];
        }
    }

    fn find_first_columns(&mut self) {
        self.first_column.clear();
        self.first_column.extend(0..self.slot_of_row.len() as u32);
        for around in self.node_start.windows(2) {
            let slots = &self.node_slots[around[0] as usize..around[1] as usize];
            let rows = || slots.iter().map(|&slot| self.row_of_slot[slot as usize]);
            let first = rows().min().unwrap_or(0);
            for row in rows() {
                let column = &mut self.first_column[row as usize];
                *column = first.min(*column);
            }
        }
    }

    fn list_products(&mut self, nodes: &[u32], matrix: &Envelope) {
        let mut products = std::mem::take(&mut self.products);
        products.clear();
        for (i, &node) in nodes.iter().enumerate() {
            let around = || self.cells_of_node(i).iter().zip(self.slots_of_node(i));
            for ((&e, &slot_e), (&f, &slot_f)) in around().flat_map(|e| around().map(move |f| (e, f))) {
                let [row, column] = [slot_e, slot_f].map(|slot| self.row_of_slot[slot as usize] as usize);
                if column <= row {
                    products.push(NodeProduct { node, cells: [e, f], entry: matrix.place(row, column) as u32 });
                }
            }
        }
        self.products = products;
    }

    /// The entries (slot × stencil length + local node) that meet at the active node number `i`.
    #[inline]
    fn cells_of_node(&self, i: usize) -> &[u32] {
        &self.node_entries[self.node_start[i] as usize..self.node_start[i + 1] as usize]
    }

    /// The slots of these entries.
    #[inline]
    fn slots_of_node(&self, i: usize) -> &[u32] {
        &self.node_slots[self.node_start[i] as usize..self.node_start[i + 1] as usize]
    }

    /// The mean of a field over the cells around the active node number `i`.
    #[inline]
    fn mean_around(&self, i: usize, of_cells: &[f64]) -> f64 {
        let around = self.slots_of_node(i);
        around.iter().map(|&slot| of_cells[slot as usize]).sum::<f64>() / around.len() as f64
    }

    /// K_vᵀ of a nodal field, for one cell.
    fn divergence_of(&self, slot: usize, divergence: &[Vector<D>], nodal: &[Vector<D>]) -> f64 {
        let entries = slot * self.stencil_len..(slot + 1) * self.stencil_len;
        let nodes = &self.stencils[entries.clone()];
        nodes.iter().zip(&divergence[entries]).map(|(&node, k)| k.dot(&nodal[node as usize])).sum()
    }

    /// K_v p at the active node number `i`.
    #[inline]
    fn push_node(&self, i: usize, divergence: &[Vector<D>], pressure: &[f64]) -> Vector<D> {
        let around = self.cells_of_node(i).iter().zip(self.slots_of_node(i));
        around.map(|(&entry, &slot)| divergence[entry as usize] * pressure[slot as usize]).sum()
    }
}

/// Volumes and storages, conductivities and pressures, and slots of some cells.
type CellPieces<'a> = ((&'a mut [f64], &'a mut [f64]), (&'a mut [f64], &'a mut [f64]), Range<usize>);

/// Sums over the particles of a cell.
#[derive(Default)]
struct CellSums {
    /// Volume, and that of the pores (m³).
    volume: f64,
    pores: f64,
    /// Conductivity (m/s) and pressure (Pa), times volume.
    conductivity: f64,
    pressure: f64,
}

impl CellSums {
    #[inline(always)]
    fn of_particles<const D: usize>(particles: &Particles<D>, of_cell: &[u32]) -> Self {
        let mut sums = CellSums::default();
        for &p in of_cell {
            let p = p as usize;
            let volume = particles.volume[p];
            sums.volume += volume;
            sums.pores += volume * particles.porosity[p];
            sums.conductivity += volume * particles.conductivity[p];
            sums.pressure += volume * particles.pressure[p];
        }
        sums
    }
}

impl<const D: usize> PressureScheme<D> for Coupled<D> {
    /// The mean of the particles' pressures, weighted by volume.
    fn particles_to_cells(&mut self, at: &StepView<D>, particles: &Particles<D>, cells: &mut CellFields) {
        self.sum_particles(at, particles);
        let Coupled { pressure, volumes, .. } = self;
        at.active.change_cells(&mut cells.pressure_old, |slot, _, of_cell| *of_cell = pressure[slot]);
        at.active.change_cells(&mut cells.volume, |slot, _, volume| *volume = volumes[slot]);
    }

    fn solve(
        &mut self,
        at: &StepView<D>,
        particles: &Particles<D>,
        cells: &mut CellFields,
        nodes: &mut NodeFields<D>,
    ) -> Result<PressureReport, PressureError> {
        match at.active.cells().len() > GRAIN {
            true => parallel::within_pool(|| self.solve_step(at, particles, cells, nodes)),
            false => self.solve_step(at, particles, cells, nodes),
        }
    }

    fn cells_to_particles(&mut self, at: &StepView<D>, cells: &CellFields, particles: &mut Particles<D>) {
        self.particle_pressure.cells_to_particles(at, cells, particles);
    }

    /// The stabilised checkerboard lets the water give way in short waves: the skeleton alone carries them.
    fn holds_short_waves(&self) -> bool {
        self.checkerboard.is_off()
    }

    /// Explicit skeleton, implicit water, γ = 1:
    ///
    /// ```text
    /// Δt ≤ (1 + √(1 + 2 τ r)) / r      r = 2 c_v/h² (1 + 3φ) / (φ² (1 + φ))      c_v = k E_oed / γ_w
    /// τ = k (ρ − ρ^f) / γ_w, without the fluid's inertia k ρ / γ_w
    /// ```
    ///
    /// `φ` is the smallest filled part of a cell along an axis, 1 with whole cells: then r = 4 c_v/h², the shortest wave
    /// of the grid. Neither a stiff fluid nor a small conductivity makes it shorter. The bound is Gershgorin's; it holds
    /// whatever share of the grid's accelerations the particles see.
    ///
    /// Damping makes it shorter, with T = k ρ/γ_w and for a resistance that stands along the force:
    ///
    /// ```text
    /// r (Δt² + 2 β Δt) (1 + α_l T/(τ + Δt)) ≤ 2 (τ + Δt) + 2 min(0, τ − T Δt [α_m + α_l/(τ + Δt)])
    /// ```
    ///
    /// In tight ground rounding comes first: velocities are Δt/ρ times the difference of two forces that nearly cancel, and
    /// must stay exact to 1e-4 of Darcy's k/γ_w times either: Δt ≤ 1e-4/ε · ρ k/γ_w, with ε the machine precision.
    fn consolidation_limit(
        &self,
        at: &StepView<D>,
        particles: &Particles<D>,
        group: Range<usize>,
        modulus: f64,
    ) -> Option<f64> {
        let fill = smallest_fill(self.quadrature, at, particles);
        let h = at.grid.spacing().min();
        let shortness = 2.0 * (1.0 + 3.0 * fill) / (fill * fill * (1.0 + fill)) / (h * h);
        let limit = |p: usize| {
            let mobility = particles.conductivity[p] / self.fluid.unit_weight;
            let density = particles.mass[p] / particles.volume[p];
            let inertial = if self.fluid_inertia { density - self.fluid.density } else { density };
            let tau = mobility * inertial.max(0.0);
            let rate = mobility * modulus * shortness;
            let undamped = (1.0 + (1.0 + 2.0 * tau * rate).sqrt()) / rate;
            let stable = at.damping.shorten_consolidation(undamped, rate, tau, mobility * density);
            stable.min(1e-4 / f64::EPSILON * density * mobility)
        };
        Some(group.map(limit).fold(f64::INFINITY, f64::min))
    }
}
