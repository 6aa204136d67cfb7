//! Nearly incompressible ground under a load that varies like a cosine: pressed down on the left, up on the right.
//!
//! ```text
//!     ↓ ↓ . . ↑ ↑   q cos(π x/W)
//!    ┌───────────┐
//!   ○│           │○ H
//!    └───○───○───┘
//!          W
//! ```

use std::f64::consts::PI;

use tsutsumi::damping::Damping;
use tsutsumi::law::LinearElastic;
use tsutsumi_testkit::body::{Body, PAPER_DENSITY, down};
use tsutsumi_testkit::reading::{outermost, run, top};

const WIDTH: f64 = 4.0;
const HEIGHT: f64 = 2.0;
const SHEAR_MODULUS: f64 = 1.0e6;
/// Strains of 1e-4.
const LOAD: f64 = 200.0;

/// The amplitude of the surface's fall (m) over a smooth rigid base, plane strain:
///
/// ```text
/// w = q (1 − ν)/(G k) sinh²α / (sinh α cosh α + α)        α = k H,  k = π/W
/// ```
///
/// From Airy's stress function; the known kernel of a smooth elastic layer on a smooth rigid base.
fn exact(poisson: f64) -> f64 {
    let number = PI / WIDTH;
    let depth = number * HEIGHT;
    let layer = depth.sinh().powi(2) / (depth.sinh() * depth.cosh() + depth);
    LOAD * (1.0 - poisson) / (SHEAR_MODULUS * number) * layer
}

/// The amplitude on a grid with `width` cells along the layer, in parts of the exact one.
fn amplitude(poisson: f64, width: usize, averaged: bool) -> f64 {
    let number = PI / WIDTH;
    let law = LinearElastic { young: 2.0 * SHEAR_MODULUS * (1.0 + poisson), poisson };
    // Twice the frequency of shear waves of this length: near critical for what moves here.
    let mass = 2.0 * number * (SHEAR_MODULUS / PAPER_DENSITY).sqrt();
    let body = Body::<2>::layer(HEIGHT, WIDTH / width as f64, width)
        .dry()
        .law(law)
        .damping(Damping { mass, ..Damping::default() })
        .load_varying(top::<2>(), move |x| down(LOAD * (number * x[0]).cos()));
    let mut solver = if averaged { body.cell_averaged() } else { body }.build();
    let carriers = outermost(solver.particles(), top::<2>());
    let start = solver.particles().position.clone();
    let dt = 0.9 * solver.step_limits().longest();
    // exp(−12) is left of the motion.
    let steps = (24.0 / mass / dt) as usize;
    assert!(run(&mut solver, dt, steps).is_ok());
    let particles = solver.particles();
    let fall =
        |&p: &usize| (HEIGHT - particles.position[p][1] - particles.half_size[p][1]) * (number * start[p][0]).cos();
    2.0 * carriers.iter().map(fall).sum::<f64>() / carriers.len() as f64 / exact(poisson)
}

#[test]
fn averaged_volume_changes_free_nearly_incompressible_ground() {
    // Linear shape functions follow a cosine to (h k)²/12 = 1.3 % with 8 cells and 0.3 % with 16.
    let [coarse, fine] = [8, 16].map(|width| 1.0 - amplitude(0.499, width, true));
    assert!(coarse.abs() < 0.013 && fine.abs() < 0.0033, "{coarse} {fine}");
    // With every particle's own volume change the same cells lock: E_oed/G = 500.
    let [coarse, fine] = [8, 16].map(|width| 1.0 - amplitude(0.499, width, false));
    assert!(coarse > 0.5 && fine > 0.2, "{coarse} {fine}");
}

/// Where nothing locks the two ways agree with the exact solution, and better with each other.
#[test]
fn compressible_ground_hardly_cares() {
    let [own, averaged] = [false, true].map(|averaged| amplitude(0.3, 16, averaged));
    assert!((1.0 - own).abs() < 0.0033 && (1.0 - averaged).abs() < 0.0033, "{own} {averaged}");
    assert!((own - averaged).abs() < 0.01, "{own} {averaged}");
}
