//! What goes wrong is said: a typed error with the place, the time and the number, and never a panic.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test reports by panicking")]

use tsutsumi::boundary::History;
use tsutsumi::law::{ConstitutiveLaw, LawError, LinearElastic};
use tsutsumi::pressure::{PressureError, Quadrature};
use tsutsumi::solver::{Solver, StepError};
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi_testkit::body::{Body, PAPER_SOIL, down};
use tsutsumi_testkit::compare::assert_close;
use tsutsumi_testkit::reading::top;

/// Steps until the first error, at most `most` times.
fn first_error<const D: usize>(solver: &mut Solver<D>, dt: f64, most: usize) -> StepError {
    (0..most).find_map(|_| solver.step(dt).err()).expect("an error within so many steps")
}

/// A body of one cell that flies at 10.3 m/s along x and at 5 m/s along the other axes, from 1…2 m in a grid of 4 m. It is so
/// soft that the light nodes at its corners have nothing to magnify.
fn flying<const D: usize>() -> Body<D> {
    Body::<D>::free(Vector::repeat(1.0), Vector::repeat(2.0), 1.0, [4; D])
        .law(LinearElastic { young: 1.0, poisson: 0.0 })
        .dry()
        .velocity(|_| Vector::from_fn(|axis, _| if axis == 0 { 10.3 } else { 5.0 }))
}

fn a_particle_that_leaves_the_grid_is_named<const D: usize>() {
    let mut solver = flying::<D>().build();
    let dt = 1e-3;
    let error = first_error(&mut solver, dt, 1000);
    let StepError::Outside { time, outside } = error else { panic!("{error:?}") };
    // The foremost particles start at 1.75 m and pass 4 m at 0.2184 s, in step 219. The first of them, x fastest, is the
    // second of all.
    assert_close("time", time, 0.219, 1e-12);
    assert_eq!(outside.particle, 1);
    assert_close("x", outside.position[0], 1.75 + 10.3 * 0.219, 1e-6);
    assert_eq!((outside.from, outside.to), (vec![0.0; D], vec![4.0; D]));
    // The particles are those at the start of the refused step, and it can be refused again.
    let before = (solver.particles().clone(), solver.time(), solver.steps());
    assert!(matches!(solver.step(dt), Err(StepError::Outside { .. })));
    let after = solver.particles();
    assert_eq!((&before.0.position, &before.0.velocity), (&after.position, &after.velocity));
    assert_eq!((&before.0.stress, &before.0.volume), (&after.stress, &after.volume));
    assert_eq!((before.1, before.2), (solver.time(), solver.steps()));
}

#[test]
fn a_particle_that_leaves_the_grid_is_named_in_1d_2d_and_3d() {
    a_particle_that_leaves_the_grid_is_named::<1>();
    a_particle_that_leaves_the_grid_is_named::<2>();
    a_particle_that_leaves_the_grid_is_named::<3>();
}

#[test]
fn a_body_that_does_not_fit_is_refused_at_once() {
    let body = Body::<2>::free(Vector::zeros(), Vector::<2>::new(2.0, 5.0), 1.0, [2, 4]);
    assert!(matches!(body.try_build(), Err(StepError::Outside { time: 0.0, .. })));
}

/// Coarse sand and a small step make γΔt − k/g negative, a nearly empty top row makes the nodes light.
#[test]
fn an_indefinite_pressure_system_names_a_cell() {
    let sand = |quadrature| {
        Body::<2>::layer(7.3, 1.0, 8)
            .particles_per_cell([2, 10])
            .conductivity(|_| 1e-1)
            .drained(top::<2>())
            .load_on_surface(top::<2>(), down(1e3), History::new(vec![]))
            .quadrature(quadrature)
            .build()
    };
    let mut whole_cells = sand(Quadrature::Cell);
    let before = whole_cells.particles().clone();
    let error = whole_cells.step(1e-4).unwrap_err();
    let StepError::Pressure(PressureError::NotPositiveDefinite { time, cell, pivot, short_step: true }) = error else {
        panic!("{error:?}")
    };
    assert_eq!(time, 1e-4);
    assert!(cell.len() == 2 && cell[0] < 8 && cell[1] < 8, "{cell:?}");
    assert!(pivot < 0.0, "{pivot}");
    let after = whole_cells.particles();
    assert_eq!((&before.position, &before.pressure), (&after.position, &after.pressure));

    // Weighted with the filling the system stays positive definite.
    let mut material_points = sand(Quadrature::MaterialPoints);
    for _ in 0..10 {
        material_points.step(1e-4).unwrap();
    }
    // Without the inertia of the water, whole cells do too.
    let mut without = Body::<2>::layer(7.3, 1.0, 8)
        .particles_per_cell([2, 10])
        .conductivity(|_| 1e-1)
        .drained(top::<2>())
        .quadrature(Quadrature::Cell)
        .without_fluid_inertia()
        .build();
    without.step(1e-4).unwrap();
}

fn a_velocity_that_is_not_a_number_is_an_error<const D: usize>() {
    let sick = |x: Vector<D>| Vector::repeat(if x[D - 1] > 2.6 { f64::NAN } else { 0.0 });
    let body = || Body::<D>::layer(3.0, 1.0, 2).velocity(sick);
    let error = body().build().step(1e-3).unwrap_err();
    let StepError::Pressure(PressureError::NotFinite { cell, .. }) = error else { panic!("{error:?}") };
    // The first cell in the order of the cells that shares a node with the particles in row 2.
    assert_eq!(cell[D - 1], 1, "{cell:?}");
    // Without water the first to notice is the law.
    let error = body().dry().build().step(1e-3).unwrap_err();
    let StepError::Law { source, .. } = error else { panic!("{error:?}") };
    assert!(matches!(*source, LawError::NotFinite { .. }), "{source:?}");
}

#[test]
fn a_velocity_that_is_not_a_number_is_an_error_in_1d_2d_and_3d() {
    a_velocity_that_is_not_a_number_is_an_error::<1>();
    a_velocity_that_is_not_a_number_is_an_error::<2>();
    a_velocity_that_is_not_a_number_is_an_error::<3>();
}

/// A soft column pressed by more than it has pores: J = 1 − n = 0.6 is passed at σ = E_oed ln 0.6, half of the load.
#[test]
fn pores_that_close_are_an_error() {
    let soft = LinearElastic { young: 1e5, poisson: 0.0 };
    let ramp = History::new(vec![[0.0, 0.0], [200.0, 1.0]]);
    let mut solver = Body::<1>::column(2.0, 0.5)
        .law(soft)
        .conductivity(|_| 1e-3)
        .drained(top::<1>())
        .load_on_surface(top::<1>(), down(1e5), ramp)
        .build();
    let error = first_error(&mut solver, 2e-2, 20_000);
    let StepError::ClosedPores { particle, porosity, .. } = error else { panic!("{error:?}") };
    assert!((-1e-3..0.0).contains(&porosity), "{porosity}");
    let stress = solver.particles().stress.at(particle).xx;
    // A step of 0.02 s of the ramp is 10 Pa.
    assert!((stress - 1e5 * 0.6_f64.ln()).abs() < 1e2, "{stress}");
}

/// A linear elastic law that refuses tension beyond this stress (Pa).
struct Brittle(f64);

impl ConstitutiveLaw for Brittle {
    type State = ();

    fn update(&self, stress: Sym3, (): (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        let (stress, ()) = PAPER_SOIL.update(stress, (), strain)?;
        let residual = stress.xx.max(stress.yy).max(stress.zz);
        match residual > self.0 {
            true => Err(LawError::NotConverged { iterations: 25, residual }),
            false => Ok((stress, ())),
        }
    }

    fn p_wave_modulus(&self, stress: Sym3, (): &()) -> f64 {
        PAPER_SOIL.p_wave_modulus(stress, &())
    }
}

fn a_failing_law_names_the_particle<const D: usize>() {
    // The lower half stands still, the upper one rises: the cell between them tears.
    let rising = |x: Vector<D>| down::<D>(if x[D - 1] > 2.0 { -1.0 } else { 0.0 });
    let mut solver = Body::<D>::layer(4.0, 1.0, 1).dry().law(Brittle(50e3)).velocity(rising).build();
    let error = first_error(&mut solver, 1e-3, 100);
    let time_now = solver.time();
    let StepError::Law { material, particle, position, time, question, source } = error else { panic!("{error:?}") };
    assert_eq!(material, "soil");
    assert_eq!(time, time_now);
    assert!((1.0..3.0).contains(&position[D - 1]), "{position:?}");
    let LawError::NotConverged { iterations: 25, residual } = *source else { panic!("{source:?}") };
    assert!(residual > 50e3, "{residual}");
    // It keeps its last good stress.
    let stress = solver.particles().stress.at(particle);
    assert!(stress.xx.max(stress.yy).max(stress.zz) <= 50e3, "{stress:?}");
    // Asked again, the law fails again.
    assert_eq!((question.stress, question.increment.duration), (stress, 1e-3));
    let again = Brittle(50e3).deform(question.stress, (), &question.increment).unwrap_err();
    assert_eq!(again, LawError::NotConverged { iterations: 25, residual });
}

#[test]
fn a_failing_law_names_the_particle_in_1d_2d_and_3d() {
    a_failing_law_names_the_particle::<1>();
    a_failing_law_names_the_particle::<2>();
    a_failing_law_names_the_particle::<3>();
}
