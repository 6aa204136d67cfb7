//! Supports and loads. Drainage is carried by the particles, see [`Particles::drained`].

use std::f64::consts::TAU;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use crate::grid::{ActiveSet, Grid, NodeFields, Side, Tie};
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

/// A factor that varies with time.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    course: Course,
}

#[derive(Debug, Clone, PartialEq)]
enum Course {
    Points(Vec<[f64; 2]>),
    SmoothStep { duration: f64 },
    Sine { angular_frequency: f64, start: f64 },
}

impl History {
    /// A history through points (time in s, factor): linear in between, constant before and after. Times must not decrease;
    /// without points the factor is 1.
    pub fn new(points: Vec<[f64; 2]>) -> Self {
        History { course: Course::Points(points) }
    }

    /// A step from 0 to 1 within a duration (s) from time 0, with a continuous second derivative.
    ///
    /// # Equation
    ///
    /// ```text
    /// f(t) = t/t_r − sin(2π t/t_r) / 2π,  0 ≤ t ≤ t_r
    /// ```
    pub fn smooth_step(duration: f64) -> Self {
        History { course: Course::SmoothStep { duration } }
    }

    /// A sine of an angular frequency ω (rad/s) from time 0, put on by a smooth step of the duration `start` (s; 0: at once).
    ///
    /// # Equation
    ///
    /// ```text
    /// f(t) = s(t) sin(ω t),  t ≥ 0        s: the smooth step
    /// ```
    pub fn sine(angular_frequency: f64, start: f64) -> Self {
        History { course: Course::Sine { angular_frequency, start } }
    }

    /// The factor at a time (s).
    pub fn factor(&self, time: f64) -> f64 {
        match &self.course {
            Course::Points(points) => between_points(points, time),
            Course::SmoothStep { duration } => smooth_step(time, *duration),
            Course::Sine { angular_frequency, start } => smooth_step(time, *start) * (angular_frequency * time).sin(),
        }
    }
}

fn between_points(points: &[[f64; 2]], time: f64) -> f64 {
    let after = points.partition_point(|point| point[0] <= time);
    match (after.checked_sub(1).map(|before| points[before]), points.get(after)) {
        (Some([t0, f0]), Some(&[t1, f1])) => f0 + (f1 - f0) * (time - t0) / (t1 - t0),
        (Some([_, factor]), None) | (None, Some(&[_, factor])) => factor,
        (None, None) => 1.0,
    }
}

fn smooth_step(time: f64, duration: f64) -> f64 {
    let part = time / duration;
    if time < 0.0 {
        0.0
    } else if part < 1.0 {
        part - (TAU * part).sin() / TAU
    } else {
        1.0
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
    /// The loaded particles, by number, and the force on each (N) where the history is 1.
    pub forces: Vec<(usize, Vector<D>)>,
    /// How the forces vary with time.
    pub history: History,
    /// Where on the particles they act.
    pub applied_to: AppliedTo,
}

/// A fluid that presses on a body from outside, all round, normal to its surface as it is at the time.
///
/// It acts on every side of the body, also where another body or a support touches it; a support takes up the force there.
#[derive(Debug, Clone, PartialEq)]
pub struct FluidLoad {
    /// The particles of the body, by number; a solver keeps their places in the same range.
    pub particles: Range<usize>,
    /// The pressure where the history is 1 (Pa, positive in compression).
    pub pressure: f64,
    /// How the pressure varies with time.
    pub history: History,
}

/// A force per mass that follows the material, beside gravity: what makes a motion that was chosen beforehand an exact solution.
pub trait BodyForce<const D: usize>: Debug + Send + Sync {
    /// The force per mass (m/s²) on the material that started at `start` (m), at a time (s).
    fn force(&self, start: &Vector<D>, time: f64) -> Vector<D>;
}

/// The motion of a rigid base, seen from the base: supports stand still, and all that rests on them feels the opposite acceleration.
///
/// # Equation
///
/// ```text
/// b(t) = −a f(t),  t ≤ t_end        displacements and velocities are those relative to the base
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct GroundMotion<const D: usize> {
    /// The acceleration of the base (m/s²) where the history is 1.
    pub acceleration: Vector<D>,
    /// How it varies with time.
    pub history: History,
    /// The time (s) after which the base moves steadily; infinite if it never does.
    pub end: f64,
}

impl<const D: usize> BodyForce<D> for GroundMotion<D> {
    fn force(&self, _start: &Vector<D>, time: f64) -> Vector<D> {
        if time > self.end { Vector::zeros() } else { self.acceleration * -self.history.factor(time) }
    }
}

/// A body force, and where the particles it acts on started.
#[derive(Debug, Clone)]
struct FollowingForce<const D: usize> {
    force: Arc<dyn BodyForce<D>>,
    /// By number.
    starts: Vec<Vector<D>>,
}

/// What holds and pushes the body (steps 2 and 4 of the algorithm).
#[derive(Debug, Clone)]
pub struct Boundary<const D: usize> {
    fixed: Vec<AxisSet>,
    /// The nodes that move as one, wherever the body is.
    ties: Vec<Tie>,
    loads: Vec<Load<D>>,
    /// The places of the loaded particles, load by load; none as long as they are their numbers.
    places: Vec<Vec<u32>>,
    fluid_loads: Vec<FluidLoad>,
    body_forces: Vec<FollowingForce<D>>,
}

impl<const D: usize> Boundary<D> {
    /// No support and no load.
    pub fn free(grid: &Grid<D>) -> Self {
        Boundary {
            fixed: vec![AxisSet::default(); grid.num_nodes()],
            ties: Vec::new(),
            loads: Vec::new(),
            places: Vec::new(),
            fluid_loads: Vec::new(),
            body_forces: Vec::new(),
        }
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
        for (node, fixed) in self.fixed.iter_mut().enumerate() {
            if is_on_side(grid, side, node) {
                fixed.0 |= axes.0;
            }
        }
    }

    /// Makes the nodes for which `belongs(position)` is true move as one along an axis: a rigid plate. Only those with
    /// material take part.
    ///
    /// # Equation
    ///
    /// ```text
    /// a = Σ F_I / Σ m_I      v = Σ m_I v_I / Σ m_I          over the nodes of the plate
    /// ```
    ///
    /// Where it shares a node with an earlier tie of the same axis, the two become one. A tie with a fixed node is held as a
    /// whole.
    pub fn tie(&mut self, grid: &Grid<D>, axis: usize, belongs: impl Fn(Vector<D>) -> bool) {
        self.tie_nodes(grid, axis, |node| belongs(grid.node_position(node)));
    }

    /// Makes the nodes of a side of the grid move as one along an axis, see [`Boundary::tie`].
    pub fn tie_side(&mut self, grid: &Grid<D>, side: Side, axis: usize) {
        self.tie_nodes(grid, axis, |node| is_on_side(grid, side, node));
    }

    fn tie_nodes(&mut self, grid: &Grid<D>, axis: usize, belongs: impl Fn(usize) -> bool) {
        let mut nodes: Vec<u32> = (0..grid.num_nodes()).filter(|&node| belongs(node)).map(|node| node as u32).collect();
        self.ties.retain(|tie| {
            let is_apart = tie.axis() != axis || tie.nodes().iter().all(|node| nodes.binary_search(node).is_err());
            if !is_apart {
                nodes.extend(tie.nodes());
                nodes.sort_unstable();
                nodes.dedup();
            }
            is_apart
        });
        let mut tie = Tie::with_capacity(axis, nodes.len());
        tie.set_nodes(nodes.into_iter());
        self.ties.push(tie);
    }

    /// Adds a load.
    pub fn push_load(&mut self, load: Load<D>) {
        self.loads.push(load);
    }

    /// Adds a fluid that presses on a body all round.
    pub fn push_fluid_load(&mut self, load: FluidLoad) {
        self.fluid_loads.push(load);
    }

    /// Adds a body force on all particles, which start at `starts` (m), by number.
    pub fn push_body_force(&mut self, force: Arc<dyn BodyForce<D>>, starts: Vec<Vector<D>>) {
        self.body_forces.push(FollowingForce { force, starts });
    }

    /// Follows the loaded particles to their places, which are listed by number.
    pub(crate) fn follow(&mut self, places: &[u32]) {
        let Boundary { loads, places: of_loads, .. } = self;
        if of_loads.is_empty() {
            *of_loads = loads.iter().map(|load| vec![0; load.forces.len()]).collect();
        }
        for (load, of_load) in loads.iter().zip(of_loads) {
            for (place, &(number, _)) in of_load.iter_mut().zip(&load.forces) {
                *place = places[number];
            }
        }
    }

    /// The places of the particles of a load, each with the force on it (N) where the history is 1.
    fn loaded(&self, load: usize) -> impl Iterator<Item = (usize, Vector<D>)> + '_ {
        let places = self.places.get(load);
        let place = move |carrier: usize, number: usize| places.map_or(number, |places| places[carrier] as usize);
        self.loads[load]
            .forces
            .iter()
            .enumerate()
            .map(move |(carrier, &(number, force))| (place(carrier, number), force))
    }

    /// The fluids that press on bodies.
    pub fn fluid_loads(&self) -> &[FluidLoad] {
        &self.fluid_loads
    }

    /// The loads carried by particles.
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
        active: &ActiveSet,
        transfer: &dyn Transfer<D>,
        particles: &Particles<D>,
        time: f64,
        nodes: &mut NodeFields<D>,
    ) {
        for (number, load) in self.loads.iter().enumerate() {
            let factor = load.history.factor(time);
            for (p, force) in self.loaded(number) {
                let (mut point, mut half_size) = (particles.position[p], particles.half_size[p]);
                if let AppliedTo::Surface(side) = load.applied_to {
                    point[side.axis] += side.sign() * half_size[side.axis];
                    half_size[side.axis] = 0.0;
                }
                let cell = particles.cell[p] as usize;
                transfer.spread_force(grid, cell, &point, &half_size, &(force * factor), nodes);
            }
        }
        for load in &self.fluid_loads {
            let pressure = load.pressure * load.history.factor(time);
            transfer.spread_pressure(grid, active, particles, load.particles.clone(), pressure, nodes);
        }
        for FollowingForce { force, starts } in &self.body_forces {
            let of_particle = |p: usize| force.force(&starts[particles.number(p)], time);
            transfer.spread_body_force(grid, active, particles, &of_particle, nodes);
        }
    }

    /// Takes the mobility 1/m_I from the nodes' masses, zero where a support holds or there is no mass to move.
    pub fn hold(&self, active: &ActiveSet, nodes: &mut NodeFields<D>) {
        let masses = &nodes.mass;
        active.change_runs(&mut nodes.mobility, |nodes, mobilities| {
            let (masses, fixed) = (&masses[nodes.clone()], &self.fixed[nodes]);
            for (mobility, (&mass, fixed)) in mobilities.iter_mut().zip(masses.iter().zip(fixed)) {
                // A subnormal mass has no usable inverse; such a node is a particle exactly on the opposite grid line.
                let inverse = if mass > f64::MIN_POSITIVE { 1.0 / mass } else { 0.0 };
                for axis in 0..D {
                    mobility[axis] = if fixed.contains(axis) { 0.0 } else { inverse };
                }
            }
        });
        self.tie_active(active, nodes);
    }

    /// Lists the tied nodes that have mass, and gives them the mobility of their whole.
    fn tie_active(&self, active: &ActiveSet, nodes: &mut NodeFields<D>) {
        if nodes.ties.len() != self.ties.len() {
            nodes.ties = self.ties.iter().map(|tie| Tie::with_capacity(tie.axis(), tie.nodes().len())).collect();
        }
        let NodeFields { ties, mass, mobility, .. } = nodes;
        for (whole, tie) in self.ties.iter().zip(ties) {
            let has_mass = |node: &u32| active.has_node(*node as usize) && mass[*node as usize] > f64::MIN_POSITIVE;
            tie.set_nodes(whole.nodes().iter().copied().filter(has_mass));
            let is_held = whole.nodes().iter().any(|&node| self.fixed[node as usize].contains(tie.axis()));
            let total: f64 = tie.nodes().iter().map(|&node| mass[node as usize]).sum();
            for &node in tie.nodes() {
                mobility[node as usize][tie.axis()] = if is_held { 0.0 } else { 1.0 / total };
            }
        }
    }
}

fn is_on_side<const D: usize>(grid: &Grid<D>, side: Side, node: usize) -> bool {
    let last = grid.cells()[side.axis];
    node / grid.node_strides()[side.axis] % (last + 1) == if side.upper { last } else { 0 }
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

    /// At 0, 1/4, 1/2 and the end the smooth step is 0, 1/4 − 1/2π, 1/2 and 1; its slope vanishes at both ends.
    #[test]
    fn smooth_steps_begin_and_end_without_a_kink() {
        let step = History::smooth_step(4.0);
        let expected = [0.0, 0.0, 0.25 - 0.5 / std::f64::consts::PI, 0.5, 1.0, 1.0];
        for (time, expected) in [-1.0, 0.0, 1.0, 2.0, 4.0, 9.0].into_iter().zip(expected) {
            assert!((step.factor(time) - expected).abs() < 1e-16, "at {time} s");
        }
        // f ≈ 2π² s³ / 3 near the ends.
        let early = 2.0 / 3.0 * std::f64::consts::PI.powi(2) * 0.01_f64.powi(3);
        assert!((step.factor(0.04) - early).abs() < 1e-3 * early);
        assert!((1.0 - step.factor(3.96) - early).abs() < 1e-3 * early);
    }

    #[test]
    fn sines_start_at_once_or_smoothly() {
        let at_once = History::sine(3.0, 0.0);
        assert_eq!([-1.0, 0.0].map(|t| at_once.factor(t)), [0.0, 0.0]);
        assert_eq!(at_once.factor(0.5), (1.5_f64).sin());
        let smooth = History::sine(3.0, 2.0);
        assert!((smooth.factor(1.0) - 0.5 * (3.0_f64).sin()).abs() < 1e-16);
        assert_eq!(smooth.factor(2.5), (7.5_f64).sin());
    }

    #[test]
    fn ties_that_share_a_node_become_one() {
        let grid = Grid::new(Vector::<2>::zeros(), Vector::<2>::repeat(1.0), [3, 1]).unwrap();
        let mut boundary = Boundary::free(&grid);
        let between = |from: f64, to: f64| move |x: Vector<2>| x[1] == 1.0 && (from..=to).contains(&x[0]);
        boundary.tie(&grid, 1, between(0.0, 1.0));
        boundary.tie(&grid, 0, between(0.0, 1.0));
        boundary.tie(&grid, 1, between(3.0, 3.0));
        boundary.tie(&grid, 1, between(1.0, 2.0));
        let ties: Vec<(usize, &[u32])> = boundary.ties.iter().map(|tie| (tie.axis(), tie.nodes())).collect();
        assert_eq!(ties, [(0, &[4, 5][..]), (1, &[7]), (1, &[4, 5, 6])]);
        boundary.tie_side(&grid, Side { axis: 1, upper: true }, 1);
        assert_eq!(boundary.ties[1].nodes(), [4, 5, 6, 7]);
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

    /// b = −a f, and nothing once the base moves steadily.
    #[test]
    fn ground_motion_pushes_against_the_acceleration_until_its_end() {
        let acceleration = Vector::<2>::from([3.0, -1.0]);
        let motion = GroundMotion { acceleration, history: History::new(vec![[0.0, 2.0]]), end: 1.0 };
        let force = |time| motion.force(&Vector::zeros(), time);
        assert_eq!(force(0.5), acceleration * -2.0);
        assert_eq!(force(1.0), acceleration * -2.0);
        assert_eq!(force(1.001), Vector::<2>::zeros());
    }
}
