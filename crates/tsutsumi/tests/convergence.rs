//! Errors fall with the square of the spacing: the ramp-loaded column against Terzaghi's series.
//!
//! ```text
//!      q(t)                      ln error
//!     ↓ ↓ ↓                        │      ╱
//!    ┌─────┐ drained               │    ╱   2
//!    │  ·  │ h = 2, 1, ½ m         │  ╱
//!    │  ·  │                       └────────── ln h
//!    └──○──┘
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::boundary::History;
use tsutsumi::pressure::Quadrature;
use tsutsumi_reference::consolidation::{Layer, Ramp};
use tsutsumi_testkit::body::{Body, PAPER_CONDUCTIVITY, PAPER_SOIL, POROSITY, WATER, down};
use tsutsumi_testkit::compare::{assert_close, observed_order, root_mean_square};
use tsutsumi_testkit::reading::{cell_pressures, outermost, run, surface, top};

const HEIGHT: f64 = 10.0;
const END: f64 = 250.0;

/// So small a load that the finite strain, 3e-6, does not show beside the errors of 1e-3 and less.
const LOAD: Ramp = Ramp { load: 50.0, duration: 200.0 };

fn layer() -> Layer {
    Layer {
        height: HEIGHT,
        modulus: PAPER_SOIL.oedometric_modulus(),
        conductivity: PAPER_CONDUCTIVITY,
        unit_weight: WATER.unit_weight,
        fluid_compressibility: POROSITY / WATER.bulk_modulus,
    }
}

/// Relative errors of the pressure profile (root mean square over the load) and of the settlement.
fn errors(spacing: f64, quadrature: Quadrature) -> (f64, f64) {
    let mut solver = Body::<1>::column(HEIGHT, spacing)
        .quadrature(quadrature)
        .drained(top::<1>())
        .load_on_surface(top::<1>(), down(LOAD.load), History::new(vec![[0.0, 0.0], [LOAD.duration, 1.0]]))
        .build();
    let carriers = outermost(solver.particles(), top::<1>());
    // The scheme is of first order in time: a step of 0.01 s leaves 1e-5.
    run(&mut solver, 0.01, (END / 0.01) as usize).unwrap();
    let differences: Vec<f64> = cell_pressures(&solver)
        .iter()
        .enumerate()
        .map(|(cell, pressure)| {
            let depth = HEIGHT - (cell as f64 + 0.5) * spacing;
            (pressure - layer().pressure(LOAD, depth, END)) / LOAD.load
        })
        .collect();
    let settlement = HEIGHT - surface(solver.particles(), &carriers, top::<1>());
    let exact = layer().settlement(LOAD, END);
    (root_mean_square(&differences), (settlement / exact - 1.0).abs())
}

#[test]
fn pressure_and_settlement_converge_with_the_square_of_the_spacing() {
    for quadrature in [Quadrature::MaterialPoints, Quadrature::Cell] {
        let runs = [2.0, 1.0, 0.5].map(|spacing| (spacing, errors(spacing, quadrature)));
        let pressure = runs.map(|(spacing, (pressure, _))| (spacing, pressure));
        let settlement = runs.map(|(spacing, (_, settlement))| (spacing, settlement));
        let order = observed_order(&pressure);
        assert!(order >= 1.8, "order {order} of the pressure from {pressure:?}");
        let order = observed_order(&settlement);
        assert!(order >= 1.8, "order {order} of the settlement from {settlement:?}");
        // Ten cells are already good to a thousandth.
        assert_close("error of the pressure at h = 1 m", pressure[1].1, 0.0, 2e-3);
    }
}
