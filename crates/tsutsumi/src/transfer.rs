//! Sums from particles to nodes and back: one pass in each direction.
//!
//! [`Transfer`] is implemented for every [`ShapeFunction`]; its loops are compiled for the concrete shape function, so
//! that choosing one at run time costs a call per pass. Sums run in the order of the particles.

use std::ops::Range;

use crate::grid::{ActiveSet, Grid, NodeFields};
use crate::particles::Particles;
use crate::shape::{CellOnAxis, ShapeFunction, Weights};
use crate::tensor::{Matrix, Vector};

/// Particles handled by one virtual call: few enough for the cache, many enough to hide the call.
pub(crate) const BLOCK: usize = 64;

/// What a particle finds on the grid at its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gathered<const D: usize> {
    /// Σ_I N_I v_I^L, the grid's velocity after its update (m/s).
    pub velocity: Vector<D>,
    /// Σ_I N_I a_I (m/s²).
    pub acceleration: Vector<D>,
    /// Σ_I v_I^L ⊗ G_Ip, component ij = ∂v_i/∂x_j (1/s).
    pub velocity_gradient: Matrix<D>,
}

impl<const D: usize> Default for Gathered<D> {
    fn default() -> Self {
        Gathered { velocity: Vector::zeros(), acceleration: Vector::zeros(), velocity_gradient: Matrix::zeros() }
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
    /// The fields must be cleared before; `velocity_old` holds the momentum afterwards.
    #[doc(alias = "Eq. (5)")]
    #[doc(alias = "Eq. (10)")]
    fn particles_to_nodes(&self, grid: &Grid<D>, particles: &Particles<D>, nodes: &mut NodeFields<D>);

    /// What the particles `block` find on the grid at their positions.
    fn nodes_to_particles(
        &self,
        grid: &Grid<D>,
        nodes: &NodeFields<D>,
        particles: &Particles<D>,
        block: Range<usize>,
        at_particles: &mut [Gathered<D>],
    );

    /// The gradients of a velocity field of the nodes (m/s) at the particles `block`; velocity and acceleration are left as they are.
    fn velocity_gradients(
        &self,
        grid: &Grid<D>,
        at_nodes: &[Vector<D>],
        particles: &Particles<D>,
        block: Range<usize>,
        at_particles: &mut [Gathered<D>],
    );

    /// A field of the nodes at the positions of all particles, Σ_I N_I(X_p) f_I, in the unit of the field.
    fn interpolate(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        at_nodes: &[Vector<D>],
        at_particles: &mut [Vector<D>],
    );

    /// Adds the momenta of the particles, Σ_p M_p V_p N_I(X_p) of Eq. (10), to those of the nodes (kg m/s).
    fn spread_momentum(&self, grid: &Grid<D>, particles: &Particles<D>, momentum: &mut [Vector<D>]);

    /// The first moments of a velocity (m/s) of the nodes around all particles (m²/s).
    ///
    /// # Equation
    ///
    /// ```text
    /// B_p = Σ_I N_I(X_p) v_I ⊗ (x_I − X_p)
    /// ```
    fn velocity_moments(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        at_nodes: &[Vector<D>],
        moments: &mut [Matrix<D>],
    );

    /// Adds the momenta of motions with these moments (m²/s) around the particles to those of the nodes (kg m/s).
    ///
    /// # Equation
    ///
    /// ```text
    /// Σ_p M_p N_I(X_p) B_p D_p⁻¹ (x_I − X_p)      D_p = Σ_I N_I(X_p) (x_I − X_p) ⊗ (x_I − X_p)
    /// ```
    ///
    /// D_p is diagonal, since the shape functions are products over the axes that reproduce linear fields. Along an axis where
    /// a particle lies on a grid line, and linear shape functions leave it no nodes to both sides, it has no moment to give.
    fn spread_moments(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        moments: &[Matrix<D>],
        momentum: &mut [Vector<D>],
    );

    /// Adds the momenta of motions with these gradients (1/s, component ij = ∂v_i/∂x_j) around the particles to those of the
    /// nodes (kg m/s).
    ///
    /// # Equation
    ///
    /// ```text
    /// Σ_p M_p N_I(X_p) ∇v_p (x_I − X_p)
    /// ```
    fn spread_gradients(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        gradients: &[Matrix<D>],
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
        particles: &Particles<D>,
        active: &ActiveSet,
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

    /// Adds forces per mass (m/s²) on the particles, by their numbers, to those of the nodes.
    ///
    /// # Equation
    ///
    /// ```text
    /// f_I = Σ_p M_p b_p N_I(X_p)
    /// ```
    fn spread_body_force(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        of_particle: &dyn Fn(usize) -> Vector<D>,
        nodes: &mut NodeFields<D>,
    );

    /// Adds the forces of a fluid that presses all round on a body, the particles `of`, to the nodes.
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
        particles: &Particles<D>,
        of: Range<usize>,
        pressure: f64,
        nodes: &mut NodeFields<D>,
    );
}

/// A point's weights in its cell's stencil.
struct Stencil<const D: usize> {
    first_node: usize,
    strides: [usize; D],
    weights: [Weights; D],
    inverse_spacing: Vector<D>,
}

impl<const D: usize> Stencil<D> {
    /// The stencil of a point of the cell with these numbers; the point and half size in spacings.
    #[inline(always)]
    fn new<S: ShapeFunction>(
        shape: &S,
        grid: &Grid<D>,
        index: [usize; D],
        place: Vector<D>,
        half_size: Vector<D>,
    ) -> Self {
        let strides = grid.node_strides();
        let on_axis = |axis: usize| CellOnAxis { cell: index[axis], num_cells: grid.cells()[axis] };
        let first_node = (0..D).map(|axis| shape.first_node(on_axis(axis)) * strides[axis]).sum();
        let weights = std::array::from_fn(|axis| shape.weights(on_axis(axis), place[axis], half_size[axis]));
        Stencil { first_node, strides, weights, inverse_spacing: grid.inverse_spacing() }
    }

    /// The stencil of a particle that is inside the grid.
    #[inline(always)]
    fn of_particle<S: ShapeFunction>(shape: &S, grid: &Grid<D>, particles: &Particles<D>, p: usize) -> Self {
        let place = grid.in_spacings(&particles.position[p]);
        let half_size = if S::BOX_STRETCHES { particles.half_size[p] } else { particles.half_size_at_start[p] };
        let half_size = half_size.component_mul(&grid.inverse_spacing());
        Stencil::new(shape, grid, grid.index_of(&place), place, half_size)
    }

    /// The stencil of a point (m) of a cell.
    #[inline(always)]
    fn of_point<S: ShapeFunction>(shape: &S, grid: &Grid<D>, cell: usize, point: &Vector<D>) -> Self {
        Stencil::new(shape, grid, grid.cell_index(cell), grid.in_spacings(point), Vector::zeros())
    }

    /// Calls `visit(local, node, N, ∇N)` for each node of the stencil.
    #[inline(always)]
    fn visit<S: ShapeFunction>(&self, mut visit: impl FnMut(usize, usize, f64, Vector<D>)) {
        for local in 0..S::WIDTH.pow(D as u32) {
            let mut rest = local;
            let mut node = self.first_node;
            let mut value = 1.0;
            let mut gradient = self.inverse_spacing;
            for axis in 0..D {
                let k = rest % S::WIDTH;
                rest /= S::WIDTH;
                node += k * self.strides[axis];
                let weights = &self.weights[axis];
                value *= weights.value[k];
                for other in 0..D {
                    gradient[other] *= if other == axis { weights.gradient[k] } else { weights.value[k] };
                }
            }
            visit(local, node, value, gradient);
        }
    }
}

/// The weights of points, averaged over a cell.
///
/// Two Gauss points in each half of the cell: exact for functions that are cubic there. Quadratic splines have their knots half
/// way between the nodes; two points in the whole cell would be 15 % off in the outer nodes.
fn mean_weights<S: ShapeFunction>(shape: &S, at: CellOnAxis) -> Weights {
    let offset = 0.25 / 3.0_f64.sqrt();
    let mut mean = Weights::default();
    for xi in [0.25 - offset, 0.25 + offset, 0.75 - offset, 0.75 + offset] {
        let weights = shape.weights(at, at.cell as f64 + xi, 0.0);
        for k in 0..S::WIDTH {
            mean.value[k] += 0.25 * weights.value[k];
            mean.gradient[k] += 0.25 * weights.gradient[k];
        }
    }
    mean
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
        let stencil = Stencil::of_particle(self, grid, particles, particle);
        stencil.visit::<S>(|_, node, value, gradient| visit(node, value, gradient));
    }

    fn particles_to_nodes(&self, grid: &Grid<D>, particles: &Particles<D>, nodes: &mut NodeFields<D>) {
        for p in 0..particles.len() {
            let mass = particles.mass[p];
            let momentum = particles.velocity[p] * mass;
            let volume = particles.volume[p];
            let stress = particles.stress[p];
            Stencil::of_particle(self, grid, particles, p).visit::<S>(|_, node, value, gradient| {
                nodes.mass[node] += mass * value;
                nodes.velocity_old[node] += momentum * value;
                nodes.force[node] -= stress.dot(&gradient) * volume;
            });
        }
    }

    fn nodes_to_particles(
        &self,
        grid: &Grid<D>,
        nodes: &NodeFields<D>,
        particles: &Particles<D>,
        block: Range<usize>,
        at_particles: &mut [Gathered<D>],
    ) {
        for (p, at) in block.zip(at_particles) {
            *at = Gathered::default();
            Stencil::of_particle(self, grid, particles, p).visit::<S>(|_, node, value, gradient| {
                let velocity = nodes.velocity[node];
                at.velocity += velocity * value;
                at.acceleration += nodes.acceleration[node] * value;
                at.velocity_gradient += velocity * gradient.transpose();
            });
        }
    }

    fn velocity_gradients(
        &self,
        grid: &Grid<D>,
        at_nodes: &[Vector<D>],
        particles: &Particles<D>,
        block: Range<usize>,
        at_particles: &mut [Gathered<D>],
    ) {
        for (p, at) in block.zip(at_particles) {
            at.velocity_gradient = Matrix::zeros();
            Stencil::of_particle(self, grid, particles, p).visit::<S>(|_, node, _, gradient| {
                at.velocity_gradient += at_nodes[node] * gradient.transpose();
            });
        }
    }

    fn interpolate(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        at_nodes: &[Vector<D>],
        at_particles: &mut [Vector<D>],
    ) {
        for (p, at) in at_particles.iter_mut().enumerate() {
            *at = Vector::zeros();
            Stencil::of_particle(self, grid, particles, p)
                .visit::<S>(|_, node, value, _| *at += at_nodes[node] * value);
        }
    }

    fn spread_momentum(&self, grid: &Grid<D>, particles: &Particles<D>, momentum: &mut [Vector<D>]) {
        for p in 0..particles.len() {
            let of_particle = particles.velocity[p] * particles.mass[p];
            Stencil::of_particle(self, grid, particles, p)
                .visit::<S>(|_, node, value, _| momentum[node] += of_particle * value);
        }
    }

    fn velocity_moments(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        at_nodes: &[Vector<D>],
        moments: &mut [Matrix<D>],
    ) {
        for (p, moment) in moments.iter_mut().enumerate() {
            *moment = Matrix::zeros();
            Stencil::of_particle(self, grid, particles, p).visit::<S>(|_, node, value, _| {
                let arm = grid.node_position(node) - particles.position[p];
                *moment += at_nodes[node] * arm.transpose() * value;
            });
        }
    }

    fn spread_moments(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        moments: &[Matrix<D>],
        momentum: &mut [Vector<D>],
    ) {
        // Nearer than this to a grid line (squared spacings) the moment is lost in round-off.
        let least = grid.spacing().component_mul(&grid.spacing()) * 1e-12;
        for (p, moment) in moments.iter().enumerate() {
            let stencil = Stencil::of_particle(self, grid, particles, p);
            let mut spread = Vector::<D>::zeros();
            stencil.visit::<S>(|_, node, value, _| {
                let arm = grid.node_position(node) - particles.position[p];
                spread += arm.component_mul(&arm) * value;
            });
            let inverse = Vector::from_fn(|axis, _| if spread[axis] > least[axis] { 1.0 / spread[axis] } else { 0.0 });
            let moment = moment * particles.mass[p];
            stencil.visit::<S>(|_, node, value, _| {
                let arm = grid.node_position(node) - particles.position[p];
                momentum[node] += moment * arm.component_mul(&inverse) * value;
            });
        }
    }

    fn spread_gradients(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        gradients: &[Matrix<D>],
        momentum: &mut [Vector<D>],
    ) {
        for (p, gradient) in gradients.iter().enumerate() {
            let gradient = gradient * particles.mass[p];
            Stencil::of_particle(self, grid, particles, p).visit::<S>(|_, node, value, _| {
                momentum[node] += gradient * (grid.node_position(node) - particles.position[p]) * value;
            });
        }
    }

    fn divergence_of_cell(&self, grid: &Grid<D>, cell: usize, divergence: &mut [Vector<D>]) {
        let index = grid.cell_index(cell);
        let weights = std::array::from_fn(|axis| {
            mean_weights(self, CellOnAxis { cell: index[axis], num_cells: grid.cells()[axis] })
        });
        // The mean of a product over the axes is the product of the means.
        let mut stencil = Stencil::of_point(self, grid, cell, &grid.cell_center(cell));
        stencil.weights = weights;
        stencil.visit::<S>(|local, _, _, gradient| divergence[local] = gradient * grid.cell_volume());
    }

    fn divergence_of_particles(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        active: &ActiveSet,
        divergence: &mut [Vector<D>],
    ) {
        divergence.fill(Vector::zeros());
        let stencil_len = Transfer::<D>::stencil_len(self);
        for p in 0..particles.len() {
            let cell = particles.cell[p] as usize;
            let Some(slot) = active.slot(cell) else { continue };
            let volume = particles.volume[p];
            let of_cell = &mut divergence[slot * stencil_len..][..stencil_len];
            Stencil::of_particle(self, grid, particles, p)
                .visit::<S>(|local, _, _, gradient| of_cell[local] += gradient * volume);
        }
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
        particles: &Particles<D>,
        of_particle: &dyn Fn(usize) -> Vector<D>,
        nodes: &mut NodeFields<D>,
    ) {
        for p in 0..particles.len() {
            let force = of_particle(p) * particles.mass[p];
            Stencil::of_particle(self, grid, particles, p)
                .visit::<S>(|_, node, value, _| nodes.force[node] += force * value);
        }
    }

    fn spread_pressure(
        &self,
        grid: &Grid<D>,
        particles: &Particles<D>,
        of: Range<usize>,
        pressure: f64,
        nodes: &mut NodeFields<D>,
    ) {
        for p in of {
            let strength = pressure * particles.volume[p];
            Stencil::of_particle(self, grid, particles, p)
                .visit::<S>(|_, node, _, gradient| nodes.force[node] -= gradient * strength);
        }
    }
}
