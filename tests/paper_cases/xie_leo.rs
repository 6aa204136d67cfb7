//! Consolidation by a third of the height, `paper-cases/xie-leo`: Xie and Leo (2004).
//!
//! ```text
//!      100 kPa at once
//!    ↓ ↓ ↓ ↓ ↓ ↓  drained       H = 10 m, σ' = E ln J with E = 250 kPa, k = k₀ J²
//!   |           |
//!   |           |               in the end J = e^(−0.4): 3.30 m
//!   ‾‾‾‾‾○‾‾‾‾‾‾
//! ```

use tsutsumi_testkit::compare::{assert_close, observed_order};

use crate::curves::Curves;

/// Time (s), settlement (m) and pressure at the base (Pa) at 10, 50 and 90 % of consolidation: the closed form, with time
/// divided by 1e5 as the conductivity is 1e5 times as large.
const CLOSED_FORM: [[f64; 3]; 3] = [
    [314.230943, 0.3297175612, 100.0e3],
    [7872.44369, 1.6487325156, 81.006186e3],
    [33964.9631, 2.9679634124, 18.558290e3],
];

fn run(cells: usize) -> Curves {
    let spacing = format!("grid.spacing=[{:?}]", 10.0 / cells as f64);
    let cells = format!("grid.cells=[{}]", cells + 1);
    Curves::of("xie-leo/case.toml", &[&spacing, &cells, "output.every=314.230943", "time.end=34000.0"])
}

/// A reading at a time between two rows, along √t, in which consolidation begins as a straight line.
fn reading(curves: &Curves, name: &str, time: f64) -> f64 {
    let (times, values) = (curves.column("time"), curves.column(name));
    let after = times.partition_point(|t| *t < time * (1.0 - 1e-9)).max(1);
    let part = (time.sqrt() - times[after - 1].sqrt()) / (times[after].sqrt() - times[after - 1].sqrt());
    values[after - 1] + part * (values[after] - values[after - 1])
}

/// At 10 % of consolidation the drained layer is 1 m thick, one or two cells; the errors fall with the spacing.
#[test]
fn a_layer_loses_a_third_of_its_height() {
    let [coarse, fine] = [10, 20].map(run);
    let error = |curves: &Curves, row: usize| {
        let [time, settlement, _] = CLOSED_FORM[row];
        (reading(curves, "settlement.surface", time) / settlement - 1.0).abs()
    };
    for (row, (of_coarse, of_fine)) in [(0.03, 0.02), (0.015, 0.006), (0.005, 0.003)].into_iter().enumerate() {
        let errors = [error(&coarse, row), error(&fine, row)];
        assert!(errors[0] < of_coarse && errors[1] < of_fine, "row {row}: {errors:?}");
    }
    let order = observed_order(&[(1.0, error(&coarse, 1)), (0.5, error(&fine, 1))]);
    assert!(order > 1.0, "order {order} at 50 %");
    for [time, _, pressure] in CLOSED_FORM {
        // 0.3 % of the load, at most, where it falls.
        assert_close("base", reading(&fine, "base.pressure", time), pressure, 4e-3 * 100e3);
    }
}
