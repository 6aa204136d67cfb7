//! The iterative solver of the pressures: as good as the direct one, in a dozen iterations, on any number of threads.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::boundary::History;
use tsutsumi::damping::Damping;
use tsutsumi::law::LinearElastic;
use tsutsumi::pressure::Quadrature;
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, QuadraticBSpline};
use tsutsumi::solver::Solver;
use tsutsumi::tensor::Vector;
use tsutsumi_testkit::body::{Body, POROSITY, WATER, down};
use tsutsumi_testkit::reading::top;

/// A layer of `width` cells, half of its top loaded at once.
fn half_loaded<const D: usize>(width: usize, height: f64) -> Body<D> {
    let half = 0.5 * width as f64;
    Body::<D>::layer(height, 1.0, width)
        .drained(top::<D>())
        .load_varying(top::<D>(), move |x| if x[0] < half || D == 1 { down(50e3) } else { Vector::zeros() })
}

/// Steps at a part of the longest; returns the most iterations of a step.
fn iterations<const D: usize>(solver: &mut Solver<D>, part: f64, steps: usize) -> usize {
    let dt = part * solver.step_limits().longest();
    (0..steps).map(|_| solver.step(dt).unwrap().pressure.iterations).max().unwrap()
}

/// Steps the same body with both solvers and compares the pressures.
fn agrees<const D: usize>(what: &str, body: impl Fn() -> Body<D>) {
    let mut direct = body().direct_solver_up_to(usize::MAX).build();
    let mut iterative = body().direct_solver_up_to(0).build();
    let dt = 0.5 * direct.step_limits().longest();
    for _ in 0..5 {
        assert_eq!(direct.step(dt).unwrap().pressure.iterations, 0);
        assert!(iterative.step(dt).unwrap().pressure.iterations > 0);
    }
    let cells = direct.active().cells().iter().map(|&cell| cell as usize);
    let largest = cells.clone().map(|cell| direct.cells().pressure[cell].abs()).fold(0.0, f64::max);
    assert!(largest > 1e3, "{what}: there are pressures");
    for cell in cells {
        let difference = (direct.cells().pressure[cell] - iterative.cells().pressure[cell]).abs();
        // 1e-7 of the change in energy, five steps. In the softest fields the same energy is a pressure larger by the root of the
        // condition number, here up to a thousand: 5 × 1e-7 × 30 = 1.5e-5 if all went there.
        assert!(difference < 1e-5 * largest, "{what}, cell {cell}: {difference} of {largest}");
    }
}

#[test]
fn both_solvers_agree() {
    agrees("1-D", || half_loaded::<1>(1, 20.0).shape(CubicBSpline).gravity(9.8));
    agrees("full cells", || half_loaded::<2>(13, 9.0));
    agrees("cut cells and gravity", || half_loaded::<2>(13, 8.3).gravity(9.8));
    agrees("the paper's quadrature", || half_loaded::<2>(13, 9.0).quadrature(Quadrature::Cell).gravity(9.8));
    agrees("a plate", || half_loaded::<2>(13, 9.0).plate(top::<2>()));
    agrees("no fluid inertia", || half_loaded::<2>(13, 9.0).without_fluid_inertia());
    agrees("stabilised", || half_loaded::<2>(13, 9.0).pressure_stabilisation(30.0));
    agrees("damped", || half_loaded::<2>(13, 9.0).damping(Damping { local: 0.5, mass: 1.0, stiffness: 0.0 }));
    agrees("layers of sand and clay", || {
        half_loaded::<2>(13, 9.0).conductivity(|x| if (x[1] as usize).is_multiple_of(3) { 1e-9 } else { 1e-3 })
    });
    agrees("long and thin", || half_loaded::<2>(150, 2.6));
    agrees("quadratic splines", || half_loaded::<2>(13, 8.5).shape(QuadraticBSpline));
    agrees("cubic splines", || half_loaded::<2>(13, 8.5).shape(CubicBSpline));
    agrees("GIMP", || half_loaded::<2>(13, 8.5).shape(Gimp));
    agrees("cpGIMP", || half_loaded::<2>(13, 8.5).shape(CpGimp));
    agrees("3-D", || half_loaded::<3>(6, 4.5).gravity(9.8));
    agrees("3-D, a plate", || half_loaded::<3>(6, 4.0).plate(top::<3>()));
    agrees("3-D, quadratic splines", || half_loaded::<3>(4, 4.0).shape(QuadraticBSpline));
    agrees("3-D, stabilised", || half_loaded::<3>(5, 4.0).pressure_stabilisation(30.0));
}

/// The water is 5 to 5000 times as stiff as the soil: the condition number at the longest step goes with it.
#[test]
fn a_dozen_iterations_are_enough_whatever_the_soil_and_the_step() {
    for young in [1e6, 3e7, 1e9] {
        for conductivity in [1e-3, 1e-5, 1e-10] {
            for (part, height) in [(0.1, 24.0), (1.0, 24.0), (1.0, 23.4), (0.5, 23.96)] {
                let soil = LinearElastic { young, poisson: 0.3 };
                let body = half_loaded::<2>(32, height).direct_solver_up_to(0).gravity(9.8);
                let mut solver = body.conductivity(move |_| conductivity).law(soil).build();
                let most = iterations(&mut solver, part, 4);
                assert!(most <= 12, "E = {young}, k = {conductivity}, {part} of the step, {height} m: {most}");
            }
        }
    }
}

/// From 2 500 to 40 000 cells, at the longest step.
#[test]
fn iterations_do_not_grow_with_the_grid() {
    let counts = [50, 100, 200].map(|width| {
        let mut solver = half_loaded::<2>(width, width as f64 - 0.3).direct_solver_up_to(0).build();
        iterations(&mut solver, 0.9, 3)
    });
    assert!(counts.iter().all(|&count| count <= 12), "{counts:?}");
    assert!(counts[2] <= counts[0] + 1, "{counts:?}");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let pressures = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = half_loaded::<2>(120, 119.4).direct_solver_up_to(0).gravity(9.8).build();
            iterations(&mut solver, 0.9, 3);
            solver.cells().pressure.iter().map(|pressure| pressure.to_bits()).collect::<Vec<_>>()
        })
    };
    assert_eq!(pressures(1), pressures(3));
}

/// An undrained box under a uniform load on all of its top: p = q K/(K + E_oed) with K = K^f/n everywhere, at rest.
#[test]
fn steps_at_rest_change_nothing() {
    let compressibility = WATER.bulk_modulus / POROSITY;
    let (young, poisson): (f64, f64) = (4.35e6, 0.0);
    let pressure = 50e3 * compressibility / (compressibility + young);
    let body = Body::<2>::layer(20.0, 1.0, 20)
        .law(LinearElastic { young, poisson })
        .direct_solver_up_to(0)
        .load_on_surface(top::<2>(), down(50e3), History::new(vec![]))
        .pressure(move |_| pressure)
        .stress(move |_| tsutsumi::tensor::Sym3::diagonal(0.0, pressure - 50e3, 0.0));
    let mut solver = body.build();
    iterations(&mut solver, 0.5, 200);
    for &cell in solver.active().cells() {
        let difference = (solver.cells().pressure[cell as usize] - pressure).abs();
        // Round-off of the forces, some epsilons of 50 kPa, times the water's stiffness over that of the soil, 1000.
        assert!(difference < 1e-9 * pressure, "{difference}");
    }
}
