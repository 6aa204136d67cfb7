//! Nothing may depend on how many dimensions a layer is run in: one test worth ten, over every combination that a case can name.
//!
//! ```text
//!       ↓ q(t)                ↓ ↓ ↓ q(t)
//!       │                   ┌───────┐ drained
//!       │   1-D           ○ │  2-D  │ ○           3-D
//!       ▒                   └───○───┘
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::boundary::History;
use tsutsumi::pressure::Quadrature;
use tsutsumi::solver::Solver;
use tsutsumi::tensor::Vector;
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::VelocityUpdate;
use tsutsumi_case::{Method, registry};
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::compare::assert_close;
use tsutsumi_testkit::reading::{cell_pressures, run, top};

/// The choices of a run. One more is a field here, a loop in `all` and a line in `build`.
#[derive(Debug, Clone, Copy)]
struct Combination {
    shape: &'static str,
    update: &'static str,
    stress_order: &'static str,
    particle_pressure: &'static str,
    quadrature: Quadrature,
}

/// A variant by its name in case files.
fn named<T>(variants: Vec<(&'static str, T)>, name: &str) -> T {
    variants.into_iter().find(|(known, _)| *known == name).unwrap().1
}

impl Combination {
    /// Every shape function, velocity update, stress order and quadrature that the registry knows with every other, and every way of the
    /// pressure back to the particles.
    fn all() -> Vec<Combination> {
        let mut all = Vec::new();
        for (shape, _) in registry::shapes::<1>() {
            for (update, _) in registry::velocity_updates::<1>(&Method::default()) {
                for (stress_order, _) in registry::stress_orders() {
                    for quadrature in [Quadrature::Cell, Quadrature::MaterialPoints] {
                        all.push(Combination { shape, update, stress_order, particle_pressure: "cell", quadrature });
                    }
                }
            }
        }
        let papers = all[0];
        for (particle_pressure, _) in registry::particle_pressures::<1>() {
            all.push(Combination { particle_pressure, ..papers });
        }
        all
    }

    /// A layer of 3 m of the paper's soil, three cells wide, as the widest stencils ask for, with 50 kPa put on within 0.05 s.
    fn build<const D: usize>(self) -> Solver<D> {
        let width = if D == 1 { 1 } else { WIDTH };
        let shape: Box<dyn Transfer<D>> = named(registry::shapes(), self.shape);
        let update: Box<dyn VelocityUpdate<D>> = named(registry::velocity_updates(&Method::default()), self.update);
        let has_boxes = shape.reach() > 0.0;
        let layer = Body::<D>::layer(3.0, 1.0, width)
            .boxed_shape(shape)
            .boxed_velocity_update(update)
            .boxed_stress_order(named(registry::stress_orders(), self.stress_order))
            .boxed_particle_pressure(named(registry::particle_pressures(), self.particle_pressure))
            .quadrature(self.quadrature)
            .drained(top::<D>())
            .load_on_surface(top::<D>(), down(50e3), History::new(vec![[0.0, 0.0], [0.05, 1.0]]));
        if has_boxes { layer.build() } else { at_gauss_points(layer).build() }
    }
}

/// Cells along the layer.
const WIDTH: usize = 3;

/// Puts the particles of a layer side by side at the Gauss points of half cells, where sums over them are integrals.
///
/// `Cell` takes integrals for K_v and all else is a sum over the particles. Boxes that tile the layer give the same, points in the
/// middle of equal boxes do not give it for splines, and the layer would not stay even.
fn at_gauss_points<const D: usize>(layer: Body<D>) -> Body<D> {
    let per_cell = std::array::from_fn(|axis| if axis == D - 1 { 2 } else { 4 });
    layer.particles_per_cell(per_cell).moved(|center| {
        Vector::from_fn(|axis, _| {
            let middle = (center[axis] * 2.0).floor() * 0.5 + 0.25;
            let offset = 0.25 / 3.0_f64.sqrt() * (center[axis] - middle).signum();
            if axis == D - 1 { center[axis] } else { middle + offset }
        })
    })
}

/// Pressures of the cells (Pa) and velocities of the particles along the last axis (m/s), each beside its height (m).
type Profile = Vec<(f64, f64)>;

fn profiles<const D: usize>(combination: Combination) -> [Profile; 2] {
    let mut solver = combination.build::<D>();
    run(&mut solver, 0.005, 15).unwrap();
    let particles = solver.particles();
    let centers = solver.active().cells().iter().map(|&cell| solver.grid().cell_center(cell as usize)[D - 1]);
    let velocities = particles.position.iter().zip(&particles.velocity).map(|(x, v)| (x[D - 1], v[D - 1]));
    [centers.zip(cell_pressures(&solver)).collect(), velocities.collect()]
}

/// Every value must be that of the nearest height in 1-D.
fn assert_same(what: &str, profile: &Profile, expected: &Profile) {
    let scale = expected.iter().fold(0.0_f64, |scale, (_, value)| scale.max(value.abs()));
    for &(height, value) in profile {
        let distance = |(other, _): &&(f64, f64)| (other - height).abs();
        let nearest = expected.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        // Sums in another order: round-off, 15 times over.
        assert_close(&format!("height, {what}"), height, nearest.0, 1e-9);
        assert_close(&format!("{what} at {height} m"), value, nearest.1, 1e-9 * scale);
    }
}

#[test]
fn a_layer_is_the_same_in_1d_2d_and_3d_with_every_combination() {
    let all = Combination::all();
    assert!(all.len() >= 5 * 7 * 3 * 2 + 3, "{} combinations", all.len());
    for combination in all {
        let expected = profiles::<1>(combination);
        // There is something to compare: the water carries the load, the soil moves.
        let [pressures, velocities] = &expected;
        let moves = velocities.iter().any(|(_, velocity)| velocity.abs() > 1e-4);
        assert!(pressures[0].1 > 40e3 && moves, "{combination:?}: {expected:?}");
        for (dimension, found) in [(2, profiles::<2>(combination)), (3, profiles::<3>(combination))] {
            assert_same(&format!("pressure, {dimension}-D, {combination:?}"), &found[0], &expected[0]);
            assert_same(&format!("velocity, {dimension}-D, {combination:?}"), &found[1], &expected[1]);
        }
    }
}

/// Why splines want the sums over the material points: with `cell` and points in the middle of their boxes the layer is uneven, as
/// the sums are off from the integrals, a quarter as much with twice the points along an axis.
#[test]
fn splines_with_whole_cells_are_uneven_by_the_error_of_the_sums() {
    let unevenness = |per_cell: usize, quadrature| {
        let mut solver = Body::<2>::layer(3.0, 1.0, WIDTH)
            .particles_per_cell([per_cell, 2])
            .boxed_shape(named(registry::shapes(), "bspline2"))
            .quadrature(quadrature)
            .drained(top::<2>())
            .load_on_surface(top::<2>(), down(50e3), History::new(vec![[0.0, 0.0], [2.5, 1.0]]))
            .build();
        run(&mut solver, 0.005, 250).unwrap();
        let pressures = cell_pressures(&solver);
        let top = &pressures[pressures.len() - WIDTH..];
        (top[1] - top[0]) / top[1]
    };
    let [two, four, eight] = [2, 4, 8].map(|per_cell| unevenness(per_cell, Quadrature::Cell));
    assert!(two > 5e-3, "{two}");
    // The midpoint rule is of second order; the terms of fourth order are seen with two points.
    assert_close("two points to four", two / four, 4.0, 0.5);
    assert_close("four points to eight", four / eight, 4.0, 0.1);
    assert_close("material points", unevenness(2, Quadrature::MaterialPoints), 0.0, 1e-12);
}
