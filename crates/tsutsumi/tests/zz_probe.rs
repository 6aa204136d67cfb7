//! Probe.
use tsutsumi::pressure::Quadrature;
use tsutsumi::solver::Solver;
use tsutsumi::tensor::Sym3;
use tsutsumi::velocity::Mpm2;
use tsutsumi_testkit::body::{Body, PAPER_DENSITY, WATER};
use tsutsumi_testkit::compare::assert_close;
use tsutsumi_testkit::reading::{cell_pressures, largest_speed, outermost, run, surface, top};
const GRAVITY: f64 = 9.8;

/// A column at rest: buoyant weight on the skeleton, K_0 = ν/(1 − ν), hydrostatic pressure.
fn ground_at_rest<const D: usize>(height: f64) -> Body<D> {
    let buoyant = (PAPER_DENSITY - WATER.density) * GRAVITY;
    let at_rest = 0.45 / 0.55;
    Body::<D>::column(height, 1.0)
        .particles_per_cell([4; D])
        .gravity(GRAVITY)
        .drained(top::<D>())
        .pressure(move |x| WATER.density * GRAVITY * (height - x[D - 1]))
        .stress(move |x| {
            let vertical = -buoyant * (height - x[D - 1]);
            let diagonal: [f64; 3] =
                std::array::from_fn(|axis| if axis == D - 1 { vertical } else { at_rest * vertical });
            Sym3::diagonal(diagonal[0], diagonal[1], diagonal[2])
        })
}

/// The hydrostatic pressures below a water table (m), at the centres of the filled parts of the cells.
fn hydrostatic(table: f64) -> Vec<f64> {
    let cells = (table - 1e-9).ceil() as usize;
    let pressure = |cell: usize| {
        let (lower, upper) = (cell as f64, table.min(cell as f64 + 1.0));
        WATER.density * GRAVITY * (table - 0.5 * (lower + upper))
    };
    (0..cells).map(pressure).collect()
}

#[test] fn p() { use Quadrature::*;
 for q in [MaterialPoints, Cell] { for dt in [4.9,4.0,1.0,0.1] { let mut s=ground_at_rest::<1>(10.0).quadrature(q).build();
  for n in 0..2000 { s.step(dt).unwrap(); if [0,1,2,5,10,50,199,500,1999].contains(&n) { let e=cell_pressures(&s)[0]-93100.0; eprintln!("P {q:?} {dt} n {n} dp0 {e:e} v {:e}", largest_speed(s.particles())); } } } } }
