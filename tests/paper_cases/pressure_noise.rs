//! The checkerboard of the pressure in nearly impermeable ground, `paper-cases/pressure-noise`: the worst cases that a search has
//! found, without and with `method.pressure_stabilisation`.
//!
//! ```text
//!   →│‾‾‾╲  10 kPa all round          ↓↓ 100 kPa on half a cell
//!    │     ╲                       ┌──▬▬──────┐
//!    │ p = ? ╲                     │          │  drained, fixed base
//!     ‾○‾‾‾○‾‾                      ‾‾‾‾‾‾‾‾‾‾
//! ```

use std::path::Path;

use tsutsumi::tensor::Vector;
use tsutsumi_case::build::build;
use tsutsumi_case::{CaseSource, Registry, Step, read_case};
use tsutsumi_testkit::compare::root_mean_square;

use crate::curves::Curves;

const ON: &str = "method.pressure_stabilisation=30";

/// The cells at the end of a run: their centres (m) and pressures (Pa).
fn pressures(file: &str, overrides: &[&str]) -> Vec<(Vector<2>, f64)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../paper-cases/pressure-noise").join(file);
    let source = CaseSource::read(path).unwrap();
    let source = overrides.iter().fold(source, |source, text| source.with_override(text).unwrap());
    let case = read_case(&source).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let mut simulation = build::<2>(&source, &case, &Registry::built_in()).unwrap();
    let Step::Seconds(step) = case.time.step else { panic!("the cases have fixed steps") };
    for _ in 0..(case.time.end / step).round() as usize {
        simulation.model_mut().step(step).unwrap();
    }
    let (grid, pressure) = (simulation.model().grid(), &simulation.model().cells().pressure);
    let cells = simulation.model().active().cells().iter().map(|&cell| cell as usize);
    cells.map(|cell| (grid.cell_center(cell), pressure[cell])).collect()
}

/// The pressure of a disc of linearly elastic, undrained ground under the pressure q all round, in plane strain: the water and the
/// skeleton, λ + G = 15 MPa, share one volume change.
const DISC: f64 = 10e3 / (1.0 + 15e6 * 0.4 / 2.2e9);

/// Errors inside the disc, two cells and more from its surface, in parts of the pressure.
fn errors_inside(overrides: &[&str]) -> Vec<f64> {
    let inside = |(center, _): &(Vector<2>, f64)| center.norm() < 6.0;
    let cells = pressures("disc.toml", overrides).into_iter().filter(inside);
    let errors: Vec<f64> = cells.map(|(_, pressure)| pressure / DISC - 1.0).collect();
    assert!(errors.len() > 20);
    errors
}

fn largest(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |largest, error| error.abs().max(largest))
}

#[test]
fn a_disc_of_whole_cells_has_a_checkerboard_and_the_stabilisation_takes_it_away() {
    let (without, with) = (errors_inside(&[]), errors_inside(&[ON]));
    let [rms, rms_with] = [root_mean_square(&without), root_mean_square(&with)];
    assert!(rms > 0.035 && largest(&without) > 0.08, "the case has grown tame: {rms}, {}", largest(&without));
    assert!(rms_with < rms / 5.0, "{rms_with} of {rms}");
    assert!(largest(&with) < 0.03, "{}", largest(&with));
    // Sums over the material points fit the load: nothing to cure. Finite strain, q/M = 2e-6 and less, is all that is left, and
    // local damping stops within some 1e-6 of rest.
    let points = errors_inside(&["method.pressure_quadrature=material-points"]);
    assert!(largest(&points) < 1e-4, "{}", largest(&points));
}

/// Finite elements with a quarter of the spacing, averaged over the cells: undrained, at rest by steps of 5 s.
fn fine_elements() -> Vec<(Vector<2>, f64)> {
    let fem = [
        "method.solver=fem",
        "method.damping.local=0",
        "method.pressure_quadrature=cell",
        "grid.spacing=[0.25, 0.25]",
        "grid.cells=[40, 44]",
        "time.step=5",
        "time.end=50",
    ];
    let elements = pressures("edge.toml", &fem);
    let mut cells: Vec<(Vector<2>, f64)> = Vec::new();
    for (center, pressure) in elements {
        let cell = center.map(|x| x.floor() + 0.5);
        match cells.iter_mut().find(|(known, _)| (*known - cell).norm() < 1e-6) {
            Some((_, sum)) => *sum += pressure / 16.0,
            None => cells.push((cell, pressure / 16.0)),
        }
    }
    cells
}

#[test]
fn a_load_on_half_a_cell_agrees_with_finite_elements_away_from_it() {
    let fine = fine_elements();
    let peak = fine.iter().map(|(_, pressure)| *pressure).fold(0.0, f64::max);
    // The stress is singular at the ends of the load: cells within 2.5 m of it are left out.
    let far = |center: Vector<2>| (center - Vector::<2>::new(4.75, 10.0)).norm() > 2.5;
    let compare = |overrides: &[&str]| {
        let cells = pressures("edge.toml", overrides);
        assert_eq!(cells.len(), 100);
        let exact = |center: Vector<2>| fine.iter().find(|(known, _)| (*known - center).norm() < 1e-6).unwrap().1;
        let errors: Vec<(Vector<2>, f64)> = cells.iter().map(|&(c, p)| (c, (p - exact(c)) / peak)).collect();
        let error_at = |c: Vector<2>| errors.iter().find(|(known, _)| (*known - c).norm() < 1e-6).map(|found| found.1);
        // The part of the errors that changes sign from cell to cell: (+ − − +)/4 over every block of four far cells.
        let twist = |c: Vector<2>| {
            let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| c + Vector::<2>::new(x, y));
            if !corners.iter().all(|&corner| far(corner)) {
                return None;
            }
            let [a, b, c, d] = corners.map(error_at);
            Some((a? - b? - c? + d?) / 4.0)
        };
        let twists: Vec<f64> = errors.iter().filter_map(|&(c, _)| twist(c)).collect();
        let far_errors: Vec<f64> = errors.iter().filter(|(c, _)| far(*c)).map(|&(_, error)| error).collect();
        (root_mean_square(&twists), largest(&far_errors))
    };
    let ((noise, _), (noise_with, error_with)) = (compare(&[]), compare(&[ON]));
    assert!(noise > 2e-3, "the case has grown tame: {noise}");
    assert!(noise_with < noise / 4.0, "{noise_with} of {noise}");
    assert!(error_with < 0.03, "{error_with}");
}

/// The column's pressure knows one axis, and Mandel's too: both stay, up to rounding that the explicit skeleton carries on.
#[test]
fn where_there_is_nothing_to_cure_nothing_changes() {
    let cases = [
        ("poroelastic-column/case.toml", "time.step=5e-3", 200.0, "base"),
        ("mandel/case.toml", "time.step=5e-4", 3.0, "centre"),
    ];
    for (file, step, end, probe) in cases {
        let readings = |overrides: &[&str]| {
            let curves = Curves::until(end, end, file, overrides);
            curves.at(&format!("{probe}.pressure"), end)
        };
        let (without, with) = (readings(&[step]), readings(&[step, ON]));
        assert!((with / without - 1.0).abs() < 1e-8, "{file}: {with} in place of {without} Pa");
    }
}
