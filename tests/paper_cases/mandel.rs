//! Mandel's problem, `paper-cases/mandel`.
//!
//! ```text
//!      ↓ ↓ ↓ ↓ ↓ ↓
//!     ▬▬▬▬▬▬▬▬▬▬▬▬▬   rigid plate
//!   ○│             │ drained
//!   ○│  "centre"   │           the rollers are planes of symmetry
//!     ‾○‾‾‾‾‾‾‾‾‾○‾
//! ```
//!
//! Exact values: the series of Cheng and Detournay (1988) with water of 2.2 GPa, checked by Laplace inversion of the
//! transformed solution; for 1 kPa put on with the smooth step of 1 s of the case, at the centre of the cell at the corner.

use tsutsumi_testkit::compare::{assert_close, observed_order};

use crate::curves::Curves;

/// Pressure at the centre right after loading (Pa).
const UNDRAINED: f64 = 499.37;
/// Its largest value at the centre of the first of 10 and of 20 cells (Pa).
const PEAKS: [f64; 2] = [552.045, 552.484];
/// Time (s), pressure at the centre of the first of 20 cells (Pa).
const SERIES: [[f64; 2]; 4] = [[2.5, 532.735], [5.5, 550.635], [10.5, 540.880], [19.5, 471.923]];

fn run(cells: usize, quadrature: &str) -> Curves {
    run_with(cells, &[&format!("method.pressure_quadrature={quadrature}")])
}

fn run_with(cells: usize, more: &[&str]) -> Curves {
    let h = 1.0 / cells as f64;
    let overrides = [
        format!("grid.spacing=[{h}, {h}]"),
        format!("grid.cells=[{}, {}]", cells + 2, cells / 10 + 2),
        format!("probes.0.pressure_at=[{}, {}]", h / 2.0, h / 2.0),
    ];
    Curves::of("mandel/case.toml", &[&overrides.each_ref().map(String::as_str), more].concat())
}

/// How much of the exact rise above the undrained pressure is missing (–).
fn rise_missing(curves: &Curves, peak: f64) -> f64 {
    1.0 - (curves.largest("centre.pressure") - UNDRAINED) / (peak - UNDRAINED)
}

/// The pressure at the centre rises above its first value while the sides drain, which needs the coupling with the skeleton:
/// by 53 Pa. At 10, 20 and 40 cells 2.4 %, 0.5 % and 0.07 % of that are missing: the second order of the grid.
#[test]
fn the_pressure_at_the_centre_rises_as_the_series_says() {
    let coarse = run(10, "material-points");
    assert!(coarse.largest("centre.pressure") > 1.08 * UNDRAINED, "the rise of Mandel and Cryer");
    let fine = run(20, "material-points");
    let missing = [rise_missing(&coarse, PEAKS[0]), rise_missing(&fine, PEAKS[1])];
    assert!(missing[0].abs() < 0.03 && missing[1].abs() < 0.006, "{missing:?}");
    let order = observed_order(&[(0.1, missing[0]), (0.05, missing[1])]);
    assert!(order > 1.8, "order {order} of {missing:?}");
    for [time, exact] in SERIES {
        // A tenth of a per cent of the grid: the first cell drains through a layer of 2 to 5 cells at first.
        assert_close("centre", fine.at("centre.pressure", time), exact, 1e-3 * exact);
    }
}

/// The sides stay within a cell: the paper's whole cells do as well.
#[test]
fn whole_cells_give_the_same() {
    let missing = rise_missing(&run(20, "cell"), PEAKS[1]);
    assert!(missing.abs() < 0.006, "{missing}");
}

/// The finite element reference on the same case: within 5e-3 of the largest pressure with 20 elements and steps of a
/// twentieth of the time in which the load grows.
#[test]
fn finite_elements_follow_the_series() {
    let curves = run_with(20, &["method.solver=fem", "time.step=0.05"]);
    for [time, exact] in SERIES {
        assert_close("centre", curves.at("centre.pressure", time), exact, 5e-3 * PEAKS[1]);
    }
    let missing = rise_missing(&curves, PEAKS[1]);
    assert!(missing.abs() < 0.01, "{missing}");
}
