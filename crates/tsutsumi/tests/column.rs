//! The paper's soil in a column under a ramp load: the same in every dimension, with the numbers known for it.
//!
//! ```text
//!        q(t)                    q
//!       ↓ ↓ ↓                    │   ╭─────
//!      ┌─────┐ drained           │  ╱
//!    ○ │     │ ○                 │ ╱
//!      │     │ H                 └┴──────── t
//!      └──○──┘ impermeable         t_r
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::boundary::History;
use tsutsumi::pressure::Quadrature;
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline, ShapeFunction};
use tsutsumi::solver::Solver;
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::Mpm2;
use tsutsumi_reference::consolidation::{Layer, Ramp};
use tsutsumi_testkit::body::{Body, PAPER_CONDUCTIVITY, PAPER_SOIL, POROSITY, WATER, down};
use tsutsumi_testkit::compare::{assert_all_close, assert_close};
use tsutsumi_testkit::reading::{cell_pressures, mean_position, outermost, run, surface, top};

/// A load of 50 kPa that grows over `duration` (s).
fn ramp(duration: f64) -> History {
    History::new(vec![[0.0, 0.0], [duration, 1.0]])
}

/// What the choices of a run are.
#[derive(Clone, Copy)]
struct Choices {
    quadrature: Quadrature,
    mpm2: bool,
    on_surface: bool,
}

impl Choices {
    /// All eight combinations.
    fn all() -> impl Iterator<Item = Choices> {
        (0..8).map(|bits| Choices {
            quadrature: if bits & 1 == 0 { Quadrature::Cell } else { Quadrature::MaterialPoints },
            mpm2: bits & 2 != 0,
            on_surface: bits & 4 != 0,
        })
    }

    fn apply<const D: usize>(self, body: Body<D>, history: History) -> Solver<D> {
        let body = body.quadrature(self.quadrature).drained(top::<D>());
        let body = if self.mpm2 { body.velocity_update(Mpm2) } else { body };
        let load = down(50e3);
        match self.on_surface {
            true => body.load_on_surface(top::<D>(), load, history),
            false => body.load_on_particles(top::<D>(), load, history),
        }
        .build()
    }
}

/// Cell pressures (Pa) and settlement of the true surface (m) at 12.5 s, load put on within 2.5 s.
fn pressures_and_settlement<const D: usize>(choices: Choices) -> (Vec<f64>, f64) {
    let mut solver = choices.apply(Body::<D>::column(10.0, 1.0), ramp(2.5));
    let carriers = outermost(solver.particles(), top::<D>());
    run(&mut solver, 0.005, 2500).unwrap();
    (cell_pressures(&solver), 10.0 - surface(solver.particles(), &carriers, top::<D>()))
}

/// One test worth ten: nothing may depend on how many dimensions the same column is run in.
#[test]
fn the_column_is_the_same_in_1d_2d_and_3d() {
    for choices in Choices::all() {
        let (pressures, settlement) = pressures_and_settlement::<1>(choices);
        assert!(pressures[0] > 40e3 && settlement > 1e-3, "{pressures:?} {settlement}");
        for (other_pressures, other) in [pressures_and_settlement::<2>(choices), pressures_and_settlement::<3>(choices)]
        {
            // Sums in another order: round-off, 2500 times.
            assert_all_close("pressures", &other_pressures, &pressures, 1e-9 * pressures[0]);
            assert_close("settlement", other, settlement, 1e-9 * settlement);
        }
    }
}

/// The layer is three cells wide, which is what the stencils of smooth shape functions need. Checked at 1.25 s, in the middle of
/// loading, of a layer of 3 m.
fn layer_with_shape<const D: usize, S: Transfer<D> + 'static>(shape: S, choices: Choices) -> (Vec<f64>, f64) {
    let width = if D == 1 { 1 } else { 3 };
    let mut solver = choices.apply(Body::<D>::layer(3.0, 1.0, width).shape(shape), ramp(2.5));
    let carriers = outermost(solver.particles(), top::<D>());
    run(&mut solver, 0.005, 250).unwrap();
    // One pressure of each row of cells.
    let pressures = cell_pressures(&solver).into_iter().step_by(width.pow(D as u32 - 1)).collect();
    (pressures, 3.0 - surface(solver.particles(), &carriers, top::<D>()))
}

fn a_layer_is_the_same_in_every_dimension<S>(shape: S, quadratures: &[Quadrature])
where
    S: ShapeFunction + Copy,
{
    for choices in Choices::all().filter(|choices| quadratures.contains(&choices.quadrature)) {
        let (pressures, settlement) = layer_with_shape::<1, S>(shape, choices);
        assert!(pressures[0] > 15e3 && settlement > 1e-4, "{pressures:?} {settlement}");
        for (other_pressures, other) in
            [layer_with_shape::<2, S>(shape, choices), layer_with_shape::<3, S>(shape, choices)]
        {
            // Sums in another order: round-off, 250 times.
            assert_all_close("pressures", &other_pressures, &pressures, 1e-9 * pressures[0]);
            assert_close("settlement", other, settlement, 1e-9 * settlement);
        }
    }
}

/// Of splines the whole-cell K_v is exact across the layer, while the masses are sums over the particles: the two agree only as
/// far as those sums do, which `tests/dimensions` measures. Linear functions and boxes make them the same.
#[test]
fn a_layer_is_the_same_in_every_dimension_with_every_shape_function() {
    use Quadrature::{Cell, MaterialPoints};
    a_layer_is_the_same_in_every_dimension(Linear, &[Cell, MaterialPoints]);
    a_layer_is_the_same_in_every_dimension(Gimp, &[Cell, MaterialPoints]);
    a_layer_is_the_same_in_every_dimension(CpGimp, &[Cell, MaterialPoints]);
    a_layer_is_the_same_in_every_dimension(QuadraticBSpline, &[MaterialPoints]);
    a_layer_is_the_same_in_every_dimension(CubicBSpline, &[MaterialPoints]);
}

/// A column of this height under the paper's load at 1000 s: base pressure (Pa), settlement of the top particles (m).
fn at_1000_s(height: f64, per_cell: usize, dt: f64, choices: Choices) -> (f64, f64) {
    let body = Body::<1>::column(height, 1.0).particles_per_cell([per_cell]);
    let mut solver = choices.apply(body, ramp(1000.0));
    let particles = outermost(solver.particles(), top::<1>());
    let before = mean_position(solver.particles(), &particles, 0);
    run(&mut solver, dt, (1000.0 / dt).round() as usize).unwrap();
    let settlement = before - mean_position(solver.particles(), &particles, 0);
    (cell_pressures(&solver)[0], settlement)
}

/// Settlements found with an independent 1-D program of the same equations: the load on the top particles makes them
/// settle less than the theory's 20.508 mm, since it acts, and is read, half a particle below the surface.
#[test]
fn loaded_particles_settle_less_by_their_depth() {
    for (per_cell, mpm2, settlement, base) in [
        (2, false, 19.185e-3, 24.056e3),
        (4, false, 19.754e-3, 24.086e3),
        (2, true, 19.1849e-3, 24.0552e3),
        (4, true, 19.7534e-3, 24.0845e3),
    ] {
        let choices = Choices { quadrature: Quadrature::Cell, mpm2, on_surface: false };
        let (pressure, settled) = at_1000_s(10.0, per_cell, 0.05, choices);
        // The program took K_f = 2 GPa and its own step.
        assert_close("settlement", settled, settlement, 0.02e-3);
        assert_close("base pressure", pressure, base, 30.0);
    }
}

/// A surface inside a cell: right with the material points, off with whole cells, which drain at the grid line.
#[test]
fn a_surface_inside_a_cell_needs_the_material_points() {
    let height = 9.5;
    let layer = Layer {
        height,
        modulus: PAPER_SOIL.oedometric_modulus(),
        conductivity: PAPER_CONDUCTIVITY,
        unit_weight: WATER.unit_weight,
        fluid_compressibility: POROSITY / WATER.bulk_modulus,
    };
    let load = Ramp { load: 50e3, duration: 1000.0 };
    let exact = layer.pressure(load, height - 0.5, 1000.0);
    let error = |quadrature| {
        let choices = Choices { quadrature, mpm2: false, on_surface: true };
        at_1000_s(height, 4, 0.5, choices).0 / exact - 1.0
    };
    // The column shortens by 0.2 %, which the series leaves out: the pressure follows H², 0.4 %.
    assert_close("relative error, material points", error(Quadrature::MaterialPoints), 0.0, 5e-3);
    // Draining half a cell too high is worth (10/9.5)² − 1 = 10.8 % once the flow is quasi-steady, less before.
    assert_close("relative error, whole cells", error(Quadrature::Cell), 0.075, 0.015);
}

/// A body so wide that its system is solved by iteration, against the column, solved directly: the same physics.
#[test]
fn the_iterative_and_the_direct_solver_agree() {
    for choices in [
        Choices { quadrature: Quadrature::Cell, mpm2: false, on_surface: false },
        Choices { quadrature: Quadrature::MaterialPoints, mpm2: true, on_surface: true },
    ] {
        let (height, width, steps) = (44, 44, 60);
        let mut wide = choices.apply(Body::<2>::layer(height as f64, 1.0, width), ramp(0.1));
        let mut column = choices.apply(Body::<2>::layer(height as f64, 1.0, 1), ramp(0.1));
        for _ in 0..steps {
            let (iterative, direct) = (wide.step(0.005).unwrap(), column.step(0.005).unwrap());
            assert!(iterative.pressure.iterations > 0, "the wide body was to be iterated on");
            assert_eq!(direct.pressure.iterations, 0, "the column was to be solved directly");
        }
        let expected = cell_pressures(&column);
        assert!(expected[0] > 10e3, "{expected:?}");
        let pressures = cell_pressures(&wide);
        for place in 0..width {
            let of_column: Vec<f64> = pressures.iter().skip(place).step_by(width).copied().collect();
            // The iteration stops at a residual of 1e-11 of the right side, every step.
            assert_all_close("pressures", &of_column, &expected, 1e-8 * 50e3);
        }
    }
}
