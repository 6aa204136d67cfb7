//! Sums from particles to nodes and back: one pass in each direction.
//!
//! [`Transfer`] is implemented for every [`ShapeFunction`]: the weights of some particles at a time are found in loops that are compiled for it, so that
//! choosing one at run time costs a call per pass. The sums know weights alone. They run cell by cell, in a cell in the order of the particles.

mod bands;
mod chunk;
mod corners;
mod gather;
mod rows;
mod side_by_side;
mod spread;
mod stencil;
mod sums;

use std::ops::Range;

use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::law::BLOCK;
use crate::parallel::{self, FAR, fetch};
use crate::particles::{LocalMotion, Particles, Places};
use crate::shape::{CellOnAxis, ShapeFunction};
use crate::tensor::{Matrix, Vector};
use bands::{Band, Bands, NodeSums};
use chunk::{CHUNK, Further, with_weights};
use gather::{Found, GatherChunk, gather_plainly};
use spread::{NodeNumbers, Sources, SpreadChunk};
use stencil::{Stencil, mean_weights};

/// What a particle finds on the grid at its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gathered<const D: usize> {
    /// Σ_I N_I v_I^L, the grid's velocity after its update (m/s).
    pub velocity: Vector<D>,
    /// Σ_I N_I a_I (m/s²).
    pub acceleration: Vector<D>,
    /// Σ_I v_I^L ⊗ G_Ip, component ij = ∂v_i/∂x_j (1/s).
    pub velocity_gradient: Matrix<D>,
    /// B_p = Σ_I N_I v_I^L ⊗ (x_I − X_p), the first moments of the velocity (m²/s).
    pub moments: Matrix<D>,
}

impl<const D: usize> Default for Gathered<D> {
    fn default() -> Self {
        let (vector, matrix) = (Vector::zeros(), Matrix::zeros());
        Gathered { velocity: vector, acceleration: vector, velocity_gradient: matrix, moments: matrix }
    }
}

/// What [`Transfer::gather_block`] looks for besides velocities and their gradients.
#[derive(Debug, Default)]
pub struct Wanted<'a, const D: usize> {
    /// [`Gathered::acceleration`].
    pub acceleration: bool,
    /// [`Gathered::moments`], to be put here, one for each place; empty where they are not wanted.
    pub moments: &'a mut [Matrix<D>],
}

/// [`Gathered`] of the particles of a block, component by component. Moments are not kept here, see [`Wanted::moments`].
#[derive(Debug, Clone)]
pub struct GatheredBlock<const D: usize> {
    pub(crate) velocity: [[f64; BLOCK]; D],
    pub(crate) acceleration: [[f64; BLOCK]; D],
    /// Component i, axis j.
    pub(crate) velocity_gradient: [[[f64; BLOCK]; D]; D],
}

impl<const D: usize> GatheredBlock<D> {
    /// A block of zeros.
    pub fn new() -> Self {
        let zeros = [0.0; BLOCK];
        GatheredBlock { velocity: [zeros; D], acceleration: [zeros; D], velocity_gradient: [[zeros; D]; D] }
    }

    /// What is found, as plain numbers, with the moments.
    fn found<'a>(&'a mut self, moments: &'a mut [Matrix<D>]) -> Found<'a> {
        let GatheredBlock { velocity, acceleration, velocity_gradient } = self;
        let (velocity_gradient, moments) = (velocity_gradient.as_flattened_mut(), bytemuck::cast_slice_mut(moments));
        Found { velocity, acceleration, velocity_gradient, moments }
    }

    /// What particle number `p` of the block has found.
    #[inline(always)]
    pub fn at(&self, p: usize) -> Gathered<D> {
        let mut at = Gathered::default();
        for i in 0..D {
            at.velocity[i] = self.velocity[i][p];
            at.acceleration[i] = self.acceleration[i][p];
            for j in 0..D {
                at.velocity_gradient[(i, j)] = self.velocity_gradient[i][j][p];
            }
        }
        at
    }
}

impl<const D: usize> Default for GatheredBlock<D> {
    fn default() -> Self {
        GatheredBlock::new()
    }
}

/// The passes between particles and grid.
///
/// # Equation
///
/// The weak form whose integrals become sums over the particles, w = Σ_I N_I w_I:
///
/// ```text
/// ∫ ρ w·a dΩ = −∫ ρ σ'^s : ∇w dΩ − ∫ p I : ∇w dΩ + ∫ w·τ dS + ∫ ρ w·b dΩ          Eq. (3)
/// ```
#[doc(alias = "Eq. (3)")]
pub trait Transfer<const D: usize>: Send + Sync {
    /// The number of nodes in the stencil of a cell.
    fn stencil_len(&self) -> usize;

    /// The number of cells that a grid needs along each axis to hold a stencil.
    fn least_cells(&self) -> usize;

    /// How far the boxes of a cell's particles may reach beyond it (spacings), see [`ShapeFunction::REACH`].
    fn reach(&self) -> f64;

    /// Calls `visit` with each node of a cell's stencil, in the order of the local node numbers.
    fn visit_stencil(&self, grid: &Grid<D>, cell: usize, visit: &mut dyn FnMut(usize));

    /// Calls `visit(node, N_I(X_p), ∇N_I(X_p))` with each node of a particle's stencil; gradients in 1/m.
    fn visit_weights(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        particle: usize,
        visit: &mut dyn FnMut(usize, f64, Vector<D>),
    );

    /// Mass, momentum and the force of the effective stress, summed at the nodes.
    ///
    /// # Equation
    ///
    /// ```text
    /// m_I = Σ_p M_p N_I(X_p)      m_I v_I = Σ_p M_p V_p N_I(X_p)                   Eq. (10)
    /// f_I = −Σ_p M_p σ'^s(X_p) G_Ip = −Σ_p Ω_p σ'(X_p) G_Ip                        Eq. (5)
    /// ```
    ///
    /// With a local motion, what [`LocalMotion`] says of it is added to the momenta. What stood in the fields of the active nodes before does not
    /// count; `velocity_old` holds the momentum afterwards.
    #[doc(alias = "Eq. (5)")]
    #[doc(alias = "Eq. (10)")]
    fn particles_to_nodes(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        local_motion: LocalMotion,
        nodes: &mut NodeFields<D>,
    );

    /// What the particles in these places find on the grid.
    fn nodes_to_particles(
        &self,
        grid: &Grid<D>,
        nodes: &NodeFields<D>,
        places: Places<D>,
        at_particles: &mut [Gathered<D>],
    );

    /// The same for at most as many particles as a block holds, several numbers at a time: the same but for rounding. What is not wanted
    /// stays as it is in the block; beyond the last particle stands anything.
    fn gather_block(
        &self,
        grid: &Grid<D>,
        nodes: &NodeFields<D>,
        places: Places<D>,
        wanted: Wanted<D>,
        block: &mut GatheredBlock<D>,
    );

    /// The gradients of a velocity field of the nodes (m/s) in these places, for at most as many particles as a block holds. Its velocities
    /// and accelerations stay as they are.
    fn gather_gradients(&self, grid: &Grid<D>, at_nodes: &[Vector<D>], places: Places<D>, block: &mut GatheredBlock<D>);

    /// A field of the nodes in these places, Σ_I N_I(X_p) f_I, in the unit of the field.
    fn interpolate(&self, grid: &Grid<D>, places: Places<D>, at_nodes: &[Vector<D>], at_particles: &mut [Vector<D>]);

    /// Adds the momenta of the particles, Σ_p M_p V_p N_I(X_p) of Eq. (10) and those of their local motion, to those of the nodes (kg m/s).
    fn spread_momentum(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        local_motion: LocalMotion,
        momentum: &mut [Vector<D>],
    );

    /// The operator node → cell of the volume change, exact over the whole cell (the paper).
    ///
    /// # Equation
    ///
    /// ```text
    /// K_v = ∫_E B_v dΩ,   component I,i: ∫_E ∂N_I/∂x_i dΩ          Eq. (6)
    /// ```
    ///
    /// `divergence` has one vector per node of the stencil (m², 2-D: m, 1-D: –).
    #[doc(alias = "Eq. (6)")]
    fn divergence_of_cell(&self, grid: &Grid<D>, cell: usize, divergence: &mut [Vector<D>]);

    /// The same operator summed over the material points, Σ_p Ω_p ∂N_I/∂x_i, for all active cells.
    ///
    /// `divergence` holds one stencil after the other, in the order of the slots.
    fn divergence_of_particles(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        divergence: &mut [Vector<D>],
    );

    /// Adds a force (N) that acts on a box around a point to the nodes, τ_I of Eq. (7). `cell` is that of the particle which
    /// carries it, `half_size` half the edges of the box (m; 0 along the normal of a face).
    ///
    /// A point that the boxes of the cell's particles cannot reach acts at the nearest one that they can, so that no force is
    /// lost on nodes without mass. Where a spline still reaches such nodes from a surface inside a cell, the others take over.
    fn spread_force(
        &self,
        grid: &Grid<D>,
        cell: usize,
        point: &Vector<D>,
        half_size: &Vector<D>,
        force: &Vector<D>,
        nodes: &mut NodeFields<D>,
    );

    /// Adds forces per mass (m/s²) on the particles, by their places, to those of the nodes.
    ///
    /// # Equation
    ///
    /// ```text
    /// f_I = Σ_p M_p b_p N_I(X_p)
    /// ```
    fn spread_body_force(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        of_particle: &(dyn Fn(usize) -> Vector<D> + Sync),
        nodes: &mut NodeFields<D>,
    );

    /// Adds the forces of a fluid that presses all round on a body, the particles at the places `of`, to the nodes.
    ///
    /// # Equation
    ///
    /// ```text
    /// f_I = −∮ q n N_I dS = −q ∫ ∇N_I dΩ = −q Σ_p Ω_p ∇N_I(X_p)
    /// ```
    ///
    /// by the divergence theorem: no surface has to be found. `pressure` q in Pa, positive in compression. The sum is over the
    /// particles whatever the quadrature of the pore pressure, as that of the effective stress is: a uniform σ' = −q I is in
    /// equilibrium with q to round-off.
    fn spread_pressure(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        of: Range<usize>,
        pressure: f64,
        nodes: &mut NodeFields<D>,
    );
}

/// Particles that one thread takes at a time.
pub(crate) const GRAIN: usize = 32 * BLOCK;

/// Calls `add(nodes, particle, stencil)` for all particles, band by band.
fn for_each_particle<S: ShapeFunction, const D: usize>(
    shape: &S,
    grid: &Grid<D>,
    active: &ActiveSet,
    places: Places<D>,
    nodes: NodeSums<D>,
    add: impl Fn(&mut NodeSums<D>, usize, &Stencil<D>) + Sync,
) {
    Bands::new(shape, grid, active).sum(nodes, &|band: Band, mut nodes: NodeSums<D>| {
        for &p in band.slots.flat_map(|slot| active.particles_of(slot)) {
            let p = p as usize;
            add(&mut nodes, p, &Stencil::of_particle(shape, grid, places, p));
        }
    });
}

/// Calls `add(nodes, node - nodes.first, particle, N, ∇N)` for all particles and the nodes of their stencils, band by band.
fn scatter<S: ShapeFunction, const D: usize>(
    shape: &S,
    grid: &Grid<D>,
    active: &ActiveSet,
    places: Places<D>,
    nodes: NodeSums<D>,
    add: impl Fn(&mut NodeSums<D>, usize, usize, f64, Vector<D>) + Sync,
) {
    for_each_particle(shape, grid, active, places, nodes, |nodes, p, stencil| {
        stencil.visit::<S>(|_, node, value, gradient| {
            let node = node - nodes.first;
            add(nodes, node, p, value, Vector::from(gradient));
        });
    });
}

/// What a block of particles finds of a velocity, and of an acceleration if it is not empty, chunk by chunk.
fn gather<S: ShapeFunction, const D: usize>(
    shape: &S,
    grid: &Grid<D>,
    [velocity, acceleration]: [&[Vector<D>]; 2],
    places: Places<D>,
    moments: &mut [Matrix<D>],
    gradients_only: bool,
    block: &mut GatheredBlock<D>,
) {
    let len = places.position.len().min(if moments.is_empty() { BLOCK } else { moments.len().min(BLOCK) });
    let (velocity, acceleration) = (bytemuck::cast_slice(velocity), bytemuck::cast_slice(acceleration));
    let further = if moments.is_empty() { Further::Nothing } else { Further::Arms };
    with_weights(|weights| {
        for start in (0..len).step_by(CHUNK) {
            weights.find(shape, grid, places, further, start..len.min(start + CHUNK));
            let found = block.found(moments);
            GatherChunk { weights, velocity, acceleration, gradients_only, start, found }.run();
        }
    });
}

/// The range of numbers that follow each other: particles that lie in the order of their cells, whose fields are read in vectors.
#[inline(always)]
fn consecutive(numbers: &[u32]) -> Option<Range<usize>> {
    let first = *numbers.first()?;
    let gaps = (first..).zip(numbers).fold(0, |bits, (expected, &number)| bits | (expected ^ number));
    (gaps == 0).then(|| first as usize..first as usize + numbers.len())
}

/// Where these particles stand, if they are near each other in memory: worth asking for.
#[inline(always)]
fn standing_together(numbers: &[u32]) -> Range<usize> {
    match (numbers.first(), numbers.last()) {
        (Some(&first), Some(&last)) if (first..first + 2 * CHUNK as u32).contains(&last) => {
            first as usize..last as usize + 1
        }
        _ => 0..0,
    }
}

/// Adds N_I A (x_I − X_p) of a point to the nodes from number `first` on; A stands column by column.
#[inline(always)]
fn add_affine<S: ShapeFunction, const D: usize>(
    stencil: &Stencil<D>,
    spacing: &Vector<D>,
    columns: &[[f64; D]; D],
    first: usize,
    nodes: &mut [Vector<D>],
) {
    stencil.visit::<S>(|local, node, value, _| {
        let arm = stencil.arm::<S>(spacing, local);
        let at_node = &mut nodes[node - first];
        for (j, column) in columns.iter().enumerate() {
            let weighted = arm[j] * value;
            for (i, component) in column.iter().enumerate() {
                at_node[i] += component * weighted;
            }
        }
    });
}

impl<S: ShapeFunction, const D: usize> Transfer<D> for S {
    fn stencil_len(&self) -> usize {
        S::WIDTH.pow(D as u32)
    }

    fn least_cells(&self) -> usize {
        S::WIDTH - 1
    }

    fn reach(&self) -> f64 {
        S::REACH
    }

    fn visit_stencil(&self, grid: &Grid<D>, cell: usize, visit: &mut dyn FnMut(usize)) {
        let center = grid.cell_center(cell);
        Stencil::of_point(self, grid, cell, &center).visit::<S>(|_, node, _, _| visit(node));
    }

    fn visit_weights(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        particle: usize,
        visit: &mut dyn FnMut(usize, f64, Vector<D>),
    ) {
        let stencil = Stencil::of_particle(self, grid, particles.places(), particle);
        stencil.visit::<S>(|_, node, value, gradient| visit(node, value, Vector::from(gradient)));
    }

    fn particles_to_nodes(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        local_motion: LocalMotion,
        nodes: &mut NodeFields<D>,
    ) {
        let NodeFields { mass, velocity_old: momentum, force, .. } = nodes;
        let nodes = NodeSums { first: 0, mass, momentum, force };
        let further = match local_motion {
            LocalMotion::Nothing => Further::Nothing,
            LocalMotion::Gradient => Further::Arms,
            LocalMotion::Moments => Further::ArmsAndSpreads,
        };
        let is_far = particles.len() >= FAR;
        let sources = Sources::new(particles, local_motion);
        Bands::new(self, grid, active).sum(nodes, &|band: Band, mut nodes: NodeSums<D>| {
            active.runs_in(band.new_nodes).for_each(|run| nodes.clear(run));
            with_weights(|weights| {
                let mut chunks = active.particles_in(band.slots).chunks(CHUNK).peekable();
                while let Some(numbers) = chunks.next() {
                    let next = chunks.peek().filter(|_| is_far).map_or(0..0, |next| standing_together(next));
                    fetch(&particles.position, next.clone());
                    fetch(&particles.velocity, next.clone());
                    if S::REACH > 0.0 {
                        fetch(&particles.half_size_at_start, next.clone());
                    }
                    match consecutive(numbers) {
                        Some(range) => weights.find(self, grid, particles.places(), further, range),
                        None => {
                            let particles_of_chunk = numbers.iter().map(|&p| p as usize);
                            weights.find(self, grid, particles.places(), further, particles_of_chunk);
                        }
                    }
                    fetch(&particles.mass, next.clone());
                    fetch(&particles.volume, next.clone());
                    particles.stress.fetch(next);
                    let nodes = NodeNumbers {
                        first: nodes.first,
                        mass: &mut *nodes.mass,
                        momentum: bytemuck::cast_slice_mut(&mut *nodes.momentum),
                        force: bytemuck::cast_slice_mut(&mut *nodes.force),
                    };
                    SpreadChunk { weights, numbers, sources, nodes }.run();
                }
            });
        });
    }

    fn nodes_to_particles(
        &self,
        grid: &Grid<D>,
        nodes: &NodeFields<D>,
        places: Places<D>,
        at_particles: &mut [Gathered<D>],
    ) {
        for (p, at) in at_particles.iter_mut().enumerate() {
            *at = gather_plainly(self, grid, nodes, places, p);
        }
    }

    fn gather_block(
        &self,
        grid: &Grid<D>,
        nodes: &NodeFields<D>,
        places: Places<D>,
        wanted: Wanted<D>,
        block: &mut GatheredBlock<D>,
    ) {
        let acceleration = if wanted.acceleration { &nodes.acceleration[..] } else { &[] };
        gather(self, grid, [&nodes.velocity, acceleration], places, wanted.moments, false, block);
    }

    fn gather_gradients(
        &self,
        grid: &Grid<D>,
        at_nodes: &[Vector<D>],
        places: Places<D>,
        block: &mut GatheredBlock<D>,
    ) {
        gather(self, grid, [at_nodes, &[]], places, &mut [], true, block);
    }

    fn interpolate(&self, grid: &Grid<D>, places: Places<D>, at_nodes: &[Vector<D>], at_particles: &mut [Vector<D>]) {
        parallel::for_each((at_particles, 0..places.position.len()), GRAIN, &|(at_particles, range): (
            &mut [Vector<D>],
            Range<usize>,
        )| {
            for (p, at) in range.zip(at_particles) {
                *at = Vector::zeros();
                Stencil::of_particle(self, grid, places, p)
                    .visit::<S>(|_, node, value, _| *at += at_nodes[node] * value);
            }
        });
    }

    fn spread_momentum(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        local_motion: LocalMotion,
        momentum: &mut [Vector<D>],
    ) {
        let spacing = grid.spacing();
        let nodes = NodeSums::of_momentum(momentum);
        for_each_particle(self, grid, active, particles.places(), nodes, |nodes, p, stencil| {
            let (mass, velocity) = (particles.mass[p], particles.velocity[p]);
            stencil.visit::<S>(|_, node, value, _| nodes.momentum[node - nodes.first] += velocity * (mass * value));
            let per_spread = match local_motion {
                LocalMotion::Nothing => return,
                LocalMotion::Gradient => [1.0; D],
                LocalMotion::Moments => stencil.inverse_spread::<S>(&spacing),
            };
            let motion = &particles.local_motion[p];
            let column = |j: usize| std::array::from_fn(|i| motion[(i, j)] * (mass * per_spread[j]));
            add_affine::<S, D>(stencil, &spacing, &std::array::from_fn(column), nodes.first, nodes.momentum);
        });
    }

    fn divergence_of_cell(&self, grid: &Grid<D>, cell: usize, divergence: &mut [Vector<D>]) {
        let index = grid.cell_index(cell);
        let weights = std::array::from_fn(|axis| {
            mean_weights(self, CellOnAxis { cell: index[axis], num_cells: grid.cells()[axis] })
        });
        // The mean of a product over the axes is the product of the means.
        let mut stencil = Stencil::of_point(self, grid, cell, &grid.cell_center(cell));
        stencil.weights = weights;
        stencil.visit::<S>(|local, _, _, gradient| divergence[local] = Vector::from(gradient) * grid.cell_volume());
    }

    fn divergence_of_particles(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        divergence: &mut [Vector<D>],
    ) {
        let stencil_len = Transfer::<D>::stencil_len(self);
        let places = particles.places();
        let stencils = parallel::Rows::new(divergence, stencil_len);
        let slots = 0..active.cells().len();
        parallel::for_each((slots, stencils), GRAIN, &|(slots, stencils): (
            Range<usize>,
            parallel::Rows<Vector<D>>,
        )| {
            for (slot, of_cell) in slots.zip(stencils.iter_mut()) {
                // The compiler then knows the length.
                let of_cell = &mut of_cell[..S::WIDTH.pow(D as u32)];
                of_cell.fill(Vector::zeros());
                let of_slot = active.particles_of(slot);
                let Some(&first) = of_slot.first() else { continue };
                let index = grid.index_of(&grid.in_spacings(&places.position[first as usize]));
                for &p in of_slot {
                    let p = p as usize;
                    let volume = particles.volume[p];
                    Stencil::of_particle_in(self, grid, index, places, p)
                        .visit::<S>(|local, _, _, gradient| of_cell[local] += Vector::from(gradient) * volume);
                }
            }
        });
    }

    fn spread_force(
        &self,
        grid: &Grid<D>,
        cell: usize,
        point: &Vector<D>,
        half_size: &Vector<D>,
        force: &Vector<D>,
        nodes: &mut NodeFields<D>,
    ) {
        let lowest = (grid.cell_origin(cell) - grid.spacing() * S::REACH).sup(&grid.origin());
        let highest = (grid.cell_origin(cell) + grid.spacing() * (1.0 + S::REACH)).inf(&grid.end());
        let inside = Vector::from_fn(|axis, _| point[axis].clamp(lowest[axis], highest[axis]));
        let half_size = half_size.component_mul(&grid.inverse_spacing());
        let stencil = Stencil::new(self, grid, grid.cell_index(cell), grid.in_spacings(&inside), half_size);
        let (mut reached, mut missed) = (0.0, 0.0);
        stencil.visit::<S>(|_, node, value, _| {
            let has_mass = nodes.mass[node] > f64::MIN_POSITIVE;
            *(if has_mass { &mut reached } else { &mut missed }) += value;
        });
        let share = if reached > 0.0 && missed > 0.0 { 1.0 / reached } else { 1.0 };
        stencil.visit::<S>(|_, node, value, _| nodes.force[node] += force * (value * share));
    }

    fn spread_body_force(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        of_particle: &(dyn Fn(usize) -> Vector<D> + Sync),
        nodes: &mut NodeFields<D>,
    ) {
        let nodes = NodeSums::of_force(&mut nodes.force);
        for_each_particle(self, grid, active, particles.places(), nodes, |nodes, p, stencil| {
            let force = of_particle(p) * particles.mass[p];
            stencil.visit::<S>(|_, node, value, _| nodes.force[node - nodes.first] += force * value);
        });
    }

    fn spread_pressure(
        &self,
        grid: &Grid<D>,
        active: &ActiveSet,
        particles: &Particles<D>,
        of: Range<usize>,
        pressure: f64,
        nodes: &mut NodeFields<D>,
    ) {
        let nodes = NodeSums::of_force(&mut nodes.force);
        scatter(self, grid, active, particles.places(), nodes, |nodes, node, p, _, gradient| {
            if of.contains(&p) {
                nodes.force[node] -= gradient * (pressure * particles.volume[p]);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::corners::SpreadCorners;
    use super::gather::Gather;
    use super::side_by_side::GatherSideBySide;
    use super::spread::Spread;
    use super::*;
    use crate::lanes::{Kernel, Portable};
    use crate::particles::Particle;
    use crate::shape::{CubicBSpline, Gimp, Linear, QuadraticBSpline};
    use crate::tensor::Sym3;

    #[test]
    fn only_neighbours_in_memory_are_asked_for() {
        let listed: Vec<u32> = (100..200).collect();
        assert_eq!(standing_together(&listed[..CHUNK]), 100..100 + CHUNK);
        assert_eq!(standing_together(&listed[97..]), 197..200);
        assert_eq!(standing_together(&[7, 9, 8, 70]), 7..71);
        for apart in [&[][..], &[7, 72], &[7, 6]] {
            assert!(standing_together(apart).is_empty());
        }
    }

    /// Particles at odds with a grid of four cells along each axis, with some motion around them.
    fn ground<const D: usize>(grid: &Grid<D>) -> Particles<D> {
        let mut particles = Particles::default();
        for p in 0..40_u32 {
            let odd = |factor: f64| (f64::from(p + 1) * factor).sin();
            particles.push(Particle {
                position: Vector::from_fn(|axis, _| 2.0 + 1.9 * odd(1.3 + axis as f64)),
                half_size: Vector::repeat(0.25),
                velocity: Vector::from_fn(|axis, _| odd(2.7 * (1.0 + axis as f64))),
                density: 2.0 + odd(0.7),
                stress: Sym3 { xx: odd(3.1), yy: odd(4.1), zz: odd(5.1), xy: odd(6.1), yz: odd(7.1), zx: odd(8.1) },
                pressure: 0.0,
                porosity: 0.0,
                conductivity: 0.0,
            });
        }
        particles.keep(LocalMotion::Moments);
        for (p, motion) in particles.local_motion.iter_mut().enumerate() {
            *motion = Matrix::from_fn(|i, j| (1.0 + p as f64 + 0.3 * i as f64 + 0.7 * j as f64).cos());
        }
        particles.locate(grid).unwrap();
        particles
    }

    /// Sums on the processor at hand and with the vectors that every processor has.
    fn the_same_on_every_processor<const D: usize, const WIDTH: usize>(shape: impl ShapeFunction + Copy) {
        let grid = Grid::new(Vector::<D>::zeros(), Vector::repeat(1.0), [4; D]).unwrap();
        let particles = ground(&grid);
        let mut active = ActiveSet::new(&grid);
        active.update(particles.located(), |cell, visit| shape.visit_stencil(&grid, cell, visit));
        let (mut at_hand, mut portable) = (NodeFields::new(&grid), NodeFields::new(&grid));
        shape.particles_to_nodes(&grid, &active, &particles, LocalMotion::Moments, &mut at_hand);
        let sources = Sources::new(&particles, LocalMotion::Moments);
        with_weights(|weights| {
            for numbers in active.particles().chunks(CHUNK) {
                weights.find(
                    &shape,
                    &grid,
                    particles.places(),
                    Further::ArmsAndSpreads,
                    numbers.iter().map(|&p| p as usize),
                );
                let nodes = NodeNumbers {
                    first: 0,
                    mass: &mut portable.mass,
                    momentum: bytemuck::cast_slice_mut(&mut portable.velocity_old),
                    force: bytemuck::cast_slice_mut(&mut portable.force),
                };
                let chunk = SpreadChunk { weights, numbers, sources, nodes };
                match WIDTH {
                    2 => SpreadCorners::<D, true>(chunk).run(Portable),
                    _ => Spread::<D, WIDTH, true>(chunk).run(Portable),
                }
            }
        });
        assert_eq!(at_hand.mass, portable.mass);
        assert_eq!((&at_hand.velocity_old, &at_hand.force), (&portable.velocity_old, &portable.force));

        let (mut found, mut plainly) = (GatheredBlock::new(), GatheredBlock::new());
        let mut moments = [vec![Matrix::zeros(); particles.len()], vec![Matrix::zeros(); particles.len()]];
        let wanted = Wanted { acceleration: true, moments: &mut moments[0] };
        let nodes =
            NodeFields { velocity: at_hand.velocity_old.clone(), acceleration: at_hand.force.clone(), ..at_hand };
        shape.gather_block(&grid, &nodes, particles.places(), wanted, &mut found);
        with_weights(|weights| {
            for start in (0..particles.len()).step_by(CHUNK) {
                weights.find(&shape, &grid, particles.places(), Further::Arms, start..particles.len());
                let chunk = GatherChunk {
                    weights,
                    velocity: bytemuck::cast_slice(&nodes.velocity),
                    acceleration: bytemuck::cast_slice(&nodes.acceleration),
                    gradients_only: false,
                    start,
                    found: plainly.found(&mut moments[1]),
                };
                match WIDTH {
                    3 => Gather::<D, true, true>(chunk).run(Portable),
                    _ => GatherSideBySide::<D, WIDTH, true, true>(chunk).run(Portable),
                }
            }
        });
        for p in 0..particles.len() {
            assert_eq!(found.at(p), plainly.at(p));
        }
        assert_eq!(moments[0], moments[1]);
    }

    #[test]
    fn every_processor_gives_the_same_sums() {
        the_same_on_every_processor::<1, 2>(Linear);
        the_same_on_every_processor::<2, 2>(Linear);
        the_same_on_every_processor::<3, 2>(Linear);
        the_same_on_every_processor::<2, 4>(Gimp);
        the_same_on_every_processor::<2, 3>(QuadraticBSpline);
        the_same_on_every_processor::<3, 3>(QuadraticBSpline);
        the_same_on_every_processor::<3, 4>(CubicBSpline);
    }
}
