//! A rigid plate: nodes that move as one, coupled with the pore pressure.
//!
//! ```text
//!         ↓ ↓ ↓          load on a part of the plate
//!      ▬▬▬▬▬▬▬▬▬▬▬▬▬     plate: one acceleration, one velocity along the last axis
//!      │           │
//!      │  layer    │     on rollers, drained at the top or not at all
//!      └───────────┘
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::cell::RefCell;

use tsutsumi::boundary::History;
use tsutsumi::pressure::Quadrature;
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline};
use tsutsumi::solver::Solver;
use tsutsumi::tensor::Vector;
use tsutsumi::transfer::Transfer;
use tsutsumi_testkit::body::{Body, PAPER_CONDUCTIVITY, POROSITY, WATER, down};
use tsutsumi_testkit::compare::{assert_all_close, assert_close};
use tsutsumi_testkit::noise::Noise;
use tsutsumi_testkit::reading::{cell_pressures, run, top};

/// A layer of 1 m cells in random stress and motion under a plate, not drained.
fn noisy_layer<const D: usize>(height: f64, width: usize) -> Body<D> {
    let noise = |seed| RefCell::new(Noise::new(seed));
    let (velocities, stresses, pressures) = (noise(1), noise(2), noise(3));
    Body::<D>::layer(height, 1.0, width)
        .plate(top::<D>())
        .velocity(move |_| velocities.borrow_mut().vector::<D>() * 1e-3)
        .stress(move |_| stresses.borrow_mut().tensor() * 1e5)
        .pressure(move |_| pressures.borrow_mut().number() * 1e5)
}

/// The nodes of the plate.
fn plate<const D: usize>(solver: &Solver<D>) -> &[u32] {
    solver.nodes().ties[0].nodes()
}

/// What one step leaves satisfies both equations, written down anew from the grid: momentum of every free node and of the
/// plate as a whole, and the volume balance of every cell (all of them filled and alike):
///
/// ```text
/// Σ m a = Σ (F + K_v p)        C (p − p_t) + L p + K_vᵀ (v + c a) = 0
/// ```
fn momentum_and_continuity_hold<const D: usize>(height: f64, width: usize, dt: f64, iterates: bool) {
    let mut solver = noisy_layer::<D>(height, width).build();
    let cells_before = cell_pressures(&solver);
    let (grid, particles) = (solver.grid().clone(), solver.particles().clone());
    let stencil_len = Transfer::<D>::stencil_len(&Linear);
    let active = solver.active().clone();
    let mut divergence = vec![Vector::<D>::zeros(); active.cells().len() * stencil_len];
    Linear.divergence_of_particles(&grid, &active, &particles, &mut divergence);
    assert_eq!(solver.step(dt).unwrap().pressure.iterations > 0, iterates, "the solver chosen");
    let (nodes, pressure) = (solver.nodes(), cell_pressures(&solver));

    let mut force = nodes.force.clone();
    let c = dt - PAPER_CONDUCTIVITY * WATER.density / WATER.unit_weight;
    let mut balance = vec![0.0; pressure.len()];
    let conductance = PAPER_CONDUCTIVITY / WATER.unit_weight;
    for (slot, &cell) in active.cells().iter().enumerate() {
        let mut of_cell = divergence[slot * stencil_len..][..stencil_len].iter();
        Linear.visit_stencil(&grid, cell as usize, &mut |node| {
            let k = of_cell.next().unwrap();
            force[node] += k * pressure[slot];
            balance[slot] += k.dot(&(nodes.velocity_old[node] + nodes.acceleration[node] * c));
        });
        balance[slot] += POROSITY / (WATER.bulk_modulus * dt) * (pressure[slot] - cells_before[slot]);
        for side in tsutsumi::grid::Side::all::<D>() {
            if let Some(other) = grid.neighbor(cell as usize, side).and_then(|other| active.slot(other)) {
                balance[slot] += conductance * (pressure[slot] - pressure[other]);
            }
        }
    }
    let largest = force.iter().map(|f| f.amax()).fold(0.0, f64::max);
    let on_plate = |node: &u32| plate(&solver).contains(node);
    let total: f64 = plate(&solver).iter().map(|&node| force[node as usize][D - 1]).sum();
    let mass: f64 = plate(&solver).iter().map(|&node| nodes.mass[node as usize]).sum();
    let acceleration = nodes.acceleration[plate(&solver)[0] as usize][D - 1];
    let tolerance = if iterates { 1e-9 } else { 1e-12 };
    assert_close(
        "momentum of the plate",
        mass * acceleration,
        total,
        tolerance * largest * plate(&solver).len() as f64,
    );
    for node in active.nodes().iter().filter(|node| !on_plate(node)).map(|&node| node as usize) {
        let moved = nodes.acceleration[node][D - 1] * nodes.mass[node];
        let is_base = grid.node_position(node)[D - 1] == 0.0;
        let expected = if is_base { 0.0 } else { force[node][D - 1] };
        assert_close("momentum of a node", moved, expected, tolerance * largest);
    }
    // A cell's volume rate is of the size of 1e-3 m/s, and the right side holds all of them. The iteration stops at an error of 1e-7 of the
    // change, both by energy: eᵀA e ≤ 1e-14 bᵀA⁻¹b, so |A e| ≤ 1e-7 √κ |b|, with κ = 4 c K^f Δt/(n ρ h²) ≈ 60. In b the stresses of 1e5 Pa
    // count most, c σ/(ρ h) = 0.13 m/s in each of 44² cells.
    let water = if iterates { 1e-7 * 60.0_f64.sqrt() * 0.13 * 44.0 } else { 1e2 * tolerance * 1e-3 };
    assert_all_close("water", &balance, &vec![0.0; balance.len()], water);
}

#[test]
fn momentum_and_continuity_hold_with_both_solvers() {
    momentum_and_continuity_hold::<2>(3.0, 4, 2e-3, false);
    momentum_and_continuity_hold::<3>(2.0, 3, 2e-3, false);
    momentum_and_continuity_hold::<2>(44.0, 44, 2e-3, true);
}

/// A⁻¹ is symmetric also where the conductivity varies along the plate: the pressure in cell j from one in cell i is that in
/// cell i from the same in cell j, as all cells store the same. With Δt above, between and below the k/g around. The same K_v
/// stands in (5) and (9) with every shape function and quadrature.
fn pressures_answer_each_other_alike(shape: impl Transfer<2> + Copy + 'static, quadrature: Quadrature) {
    let conductivity = |x: Vector<2>| 1e-2 * (1.0 + 0.1 * x[0] + 0.05 * x[1]);
    for dt in [1e-2, 1.2e-3, 2e-4] {
        let response = |from: usize| {
            let mut solver = Body::<2>::layer(3.0, 1.0, 4)
                .shape(shape)
                .quadrature(quadrature)
                .plate(top::<2>())
                .drained(top::<2>())
                .conductivity(conductivity)
                .pressure(move |x| if (x[1] as usize) * 4 + x[0] as usize == from { 1e3 } else { 0.0 })
                .build();
            solver.step(dt).unwrap();
            cell_pressures(&solver)
        };
        let responses: Vec<Vec<f64>> = (0..12).map(response).collect();
        for (i, of_i) in responses.iter().enumerate() {
            for (j, of_j) in responses[..i].iter().enumerate() {
                assert_close("response", of_i[j], of_j[i], 1e-10);
            }
        }
        assert!(responses[0][3].abs() > 1e-3, "the plate couples distant cells: {}", responses[0][3]);
    }
}

#[test]
fn the_pressures_of_two_cells_answer_each_other_alike() {
    for quadrature in [Quadrature::MaterialPoints, Quadrature::Cell] {
        pressures_answer_each_other_alike(Linear, quadrature);
        pressures_answer_each_other_alike(Gimp, quadrature);
        pressures_answer_each_other_alike(CpGimp, quadrature);
        pressures_answer_each_other_alike(QuadraticBSpline, quadrature);
        pressures_answer_each_other_alike(CubicBSpline, quadrature);
    }
}

/// The load stands on the right half of the plate, the plate sinks as one.
fn a_plate_stays_flat<const D: usize>(dry: bool) {
    let layer = Body::<D>::layer(3.0, 1.0, 4).plate(top::<D>()).drained(top::<D>());
    let layer = layer.load_on_surface(top::<D>(), down(50e3), History::new(vec![]));
    let noise = RefCell::new(Noise::new(5));
    let layer = layer.stress(move |_| noise.borrow_mut().tensor() * 1e4);
    let mut solver = if dry { layer.dry() } else { layer }.build();
    run(&mut solver, 1e-3, 50).unwrap();
    let nodes = solver.nodes();
    let first = plate(&solver)[0] as usize;
    assert_eq!(plate(&solver).len(), 5_usize.pow(D as u32 - 1));
    assert!(nodes.velocity[first][D - 1] < 0.0, "the plate sinks");
    for &node in plate(&solver) {
        assert_eq!(nodes.velocity[node as usize][D - 1], nodes.velocity[first][D - 1]);
        assert_eq!(nodes.acceleration[node as usize][D - 1], nodes.acceleration[first][D - 1]);
    }
    // Along the plate the nodes are free: the uneven stress moves them.
    assert!(plate(&solver).iter().any(|&node| nodes.velocity[node as usize][0] != 0.0));
}

#[test]
fn a_plate_stays_flat_in_2d_and_3d_wet_and_dry() {
    a_plate_stays_flat::<2>(false);
    a_plate_stays_flat::<2>(true);
    a_plate_stays_flat::<3>(false);
    a_plate_stays_flat::<3>(true);
}

/// Where the surface sinks evenly by itself, the plate changes nothing.
#[test]
fn a_plate_on_an_even_surface_changes_nothing() {
    let layer = || {
        let ramp = History::new(vec![[0.0, 0.0], [0.5, 1.0]]);
        Body::<2>::layer(4.0, 1.0, 3).drained(top::<2>()).load_on_surface(top::<2>(), down(50e3), ramp)
    };
    let (mut free, mut plated) = (layer().build(), layer().plate(top::<2>()).build());
    run(&mut free, 2e-3, 500).unwrap();
    run(&mut plated, 2e-3, 500).unwrap();
    // 500 steps of pressures of 5e4 Pa that agree to some epsilons each.
    assert_all_close("pressure", &cell_pressures(&plated), &cell_pressures(&free), 1e-12 * 50e3 * 500.0);
    for (with, without) in plated.particles().position.iter().zip(&free.particles().position) {
        assert_close("position", (with - without).norm(), 0.0, 1e-12);
    }
}

/// A free body with two plates of its own keeps its momentum.
#[test]
fn plates_keep_the_momentum_of_a_free_body() {
    let noise = |seed| RefCell::new(Noise::new(seed));
    let (velocities, stresses) = (noise(1), noise(2));
    let side = |upper| tsutsumi::grid::Side { axis: 0, upper };
    let mut solver = Body::<2>::free(Vector::repeat(1.0), Vector::repeat(3.0), 1.0, [5, 5])
        .plate(side(false))
        .plate(top::<2>())
        .velocity(move |_| velocities.borrow_mut().vector())
        .stress(move |_| stresses.borrow_mut().tensor() * 1e5)
        .build();
    let (before, mass) = (solver.particles().momentum(), solver.particles().mass.iter().sum::<f64>());
    run(&mut solver, 1e-4, 20).unwrap();
    assert_eq!(solver.nodes().ties.len(), 2);
    // Speeds of 1 m/s, and forces of 2e5 N over 2e-3 s, summed up in some thousand steps.
    let change = solver.particles().momentum() - before;
    assert_close("change of momentum", change.norm(), 0.0, 1e-14 * (mass + 2e5 * 2e-3) * 20.0);
}
