//! Patch tests: what a linear field must give exactly.
//!
//! ```text
//!          ↑ ↑ ↑ ↑              q
//!        ┌─────────┐        ┌───────┐
//!      ← │         │ →      │       │
//!      ← │ σ = const│ →      │  ε =  │
//!        └─────────┘        │ const │
//!          ↓ ↓ ↓ ↓          └───○───┘
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::boundary::{Boundary, FluidLoad, History};
use tsutsumi::grid::{NodeFields, Side};
use tsutsumi::pressure::Quadrature;
use tsutsumi::shape::{CpGimp, Linear};
use tsutsumi::tensor::{Matrix, Sym3, Vector};
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::{Gathered, Mpm2};
use tsutsumi_testkit::body::{Body, PAPER_SOIL, down};
use tsutsumi_testkit::compare::assert_close;
use tsutsumi_testkit::noise::Noise;
use tsutsumi_testkit::reading::{largest_speed, outermost, run, surface, top};

/// Nodal velocities v = A x + b come to the particles as exactly v and A, wherever the particles are.
fn a_linear_velocity_field_is_gathered_exactly<const D: usize>() {
    let from = Vector::from_fn(|axis, _| 0.3 + 0.2 * axis as f64);
    let solver = Body::<D>::free(from, from + Vector::repeat(2.1), 0.7, [5; D]).particles_per_cell([3; D]).build();
    let mut noise = Noise::new(7);
    let gradient = Matrix::<D>::from_fn(|_, _| noise.number());
    let offset: Vector<D> = noise.vector();
    let field = |x: Vector<D>| gradient * x + offset;
    let mut nodes = NodeFields::new(solver.grid());
    for node in 0..solver.grid().num_nodes() {
        let x = solver.grid().node_position(node);
        nodes.velocity[node] = field(x);
        nodes.acceleration[node] = field(x) * -2.0;
    }
    let particles = solver.particles();
    let mut gathered = vec![Gathered::default(); particles.len()];
    Linear.nodes_to_particles(solver.grid(), &nodes, particles.places(), &mut gathered);
    for (at, &x) in gathered.iter().zip(&particles.position) {
        // Sums of 2^D products of numbers of the order of 4 (velocity) and 4/0.7 (gradient).
        assert_close("velocity", (at.velocity - field(x)).norm(), 0.0, 1e-14);
        assert_close("acceleration", (at.acceleration + field(x) * 2.0).norm(), 0.0, 2e-14);
        assert_close("gradient", (at.velocity_gradient - gradient).norm(), 0.0, 4e-14);
    }
}

#[test]
fn a_linear_velocity_field_is_gathered_exactly_in_1d_2d_and_3d() {
    a_linear_velocity_field_is_gathered_exactly::<1>();
    a_linear_velocity_field_is_gathered_exactly::<2>();
    a_linear_velocity_field_is_gathered_exactly::<3>();
}

/// A body with uniform stress (and pore pressure) and the tractions of that stress on its true surface stays at rest.
///
/// Exact, as the particles' boxes do not straddle grid lines: Σ_p V_p ∇N_I is then ∫ ∇N_I dV, for bilinear N_I too.
fn a_uniform_stress_is_in_equilibrium<const D: usize>(corner: f64, edge: f64, quadrature: Option<Quadrature>) {
    let stress = Sym3 { xx: -80e3, yy: -50e3, zz: -120e3, xy: 20e3, yz: -15e3, zx: 10e3 };
    let water = if quadrature.is_some() { 30e3 } else { 0.0 };
    let total = stress - Sym3::IDENTITY * water;
    let from = Vector::repeat(corner);
    let mut body = Body::<D>::free(from, from + Vector::repeat(edge), 1.0, [5; D])
        .particles_per_cell([4; D])
        .stress(move |_| stress)
        .pressure(move |_| water);
    body = match quadrature {
        Some(quadrature) => body.quadrature(quadrature),
        None => body.dry(),
    };
    for side in Side::all::<D>() {
        let normal = Vector::from_fn(|axis, _| if axis == side.axis { side.sign() } else { 0.0 });
        body = body.load_on_surface(side, total.dot(&normal), History::new(vec![]));
    }
    let mut solver = body.build();
    run(&mut solver, 0.005, 50).unwrap();
    // A node's forces cancel to 1e-16 of 120 kPa × 1 m², over a mass of 1500 kg/m³ × 1 m³ / 64 at the corners of a body
    // that fills a quarter of a cell per axis: 5e-13 m/s² during 0.25 s.
    assert_close("speed", largest_speed(solver.particles()), 0.0, 1e-12);
    for (now, &pressure) in solver.particles().stress.iter().zip(&solver.particles().pressure) {
        let change = now - stress;
        assert_close("stress", change.norm(), 0.0, 1e-5);
        assert_close("pressure", pressure, water, 1e-5);
    }
}

#[test]
fn a_uniform_stress_is_in_equilibrium_in_1d_2d_and_3d() {
    // Surfaces on grid lines, then inside cells.
    for (corner, edge) in [(1.0, 3.0), (0.75, 2.75)] {
        for quadrature in [None, Some(Quadrature::MaterialPoints)] {
            a_uniform_stress_is_in_equilibrium::<1>(corner, edge, quadrature);
            a_uniform_stress_is_in_equilibrium::<2>(corner, edge, quadrature);
            a_uniform_stress_is_in_equilibrium::<3>(corner, edge, quadrature);
        }
    }
    // The paper's K_v is exact on grid lines.
    a_uniform_stress_is_in_equilibrium::<1>(1.0, 3.0, Some(Quadrature::Cell));
    a_uniform_stress_is_in_equilibrium::<2>(1.0, 3.0, Some(Quadrature::Cell));
    a_uniform_stress_is_in_equilibrium::<3>(1.0, 3.0, Some(Quadrature::Cell));
}

/// The same with boxes that straddle grid lines: with the mean over the box Σ_p V_p ∇S_I is ∫ ∇N_I dV wherever they are.
fn a_uniform_stress_is_in_equilibrium_on_any_lattice<const D: usize>(wet: bool) {
    let stress = Sym3 { xx: -80e3, yy: -50e3, zz: -120e3, xy: 20e3, yz: -15e3, zx: 10e3 };
    let water = if wet { 30e3 } else { 0.0 };
    let total = stress - Sym3::IDENTITY * water;
    let from = Vector::from_fn(|axis, _| 1.1 + 0.07 * axis as f64);
    let mut body = Body::<D>::free(from, from + Vector::repeat(2.5), 1.0, [5; D])
        .shape(CpGimp)
        .stress(move |_| stress)
        .pressure(move |_| water);
    for side in Side::all::<D>() {
        let normal = Vector::from_fn(|axis, _| if axis == side.axis { side.sign() } else { 0.0 });
        body = body.load_on_surface(side, total.dot(&normal), History::new(vec![]));
    }
    let mut solver = if wet { body } else { body.dry() }.build();
    run(&mut solver, 1e-3, 50).unwrap();
    // As above, over the mass of the lightest corner, which the body fills to 0.6 or 0.03 of a cell per axis: 3e-5 of a cell in
    // 3-D, that of its node a hundredth of it.
    assert_close("speed", largest_speed(solver.particles()), 0.0, 1e-9);
}

#[test]
fn a_uniform_stress_is_in_equilibrium_on_any_lattice_in_1d_2d_and_3d() {
    for wet in [false, true] {
        a_uniform_stress_is_in_equilibrium_on_any_lattice::<1>(wet);
        a_uniform_stress_is_in_equilibrium_on_any_lattice::<2>(wet);
        a_uniform_stress_is_in_equilibrium_on_any_lattice::<3>(wet);
    }
}

/// A fluid all round a box presses like normal tractions on its faces: the divergence theorem, particle by particle. Exact for
/// surfaces on grid lines and inside cells, as N_I is linear along each edge.
fn a_fluid_outside_presses_like_tractions_on_the_faces<const D: usize>(corner: f64, edge: f64) {
    let (q, time) = (20e3, 0.5);
    let history = || History::new(vec![[0.0, 0.0], [1.0, 1.0]]);
    let from = Vector::repeat(corner);
    let body = || Body::<D>::free(from, from + Vector::repeat(edge), 1.0, [5; D]).particles_per_cell([4; D]);
    let mut with_tractions = body();
    for side in Side::all::<D>() {
        let normal = Vector::from_fn(|axis, _| if axis == side.axis { side.sign() } else { 0.0 });
        with_tractions = with_tractions.load_on_surface(side, normal * -q, history());
    }
    let with_tractions = with_tractions.build();
    let (grid, particles) = (with_tractions.grid(), with_tractions.particles());
    let mut fluid = Boundary::free(grid);
    fluid.push_fluid_load(FluidLoad { particles: 0..particles.len(), pressure: q, history: history() });
    let forces = |boundary: &Boundary<D>| {
        let mut nodes = NodeFields::new(grid);
        boundary.add_loads(grid, with_tractions.active(), &Linear, particles, time, &mut nodes);
        nodes.force
    };
    let (expected, forces) = (forces(with_tractions.boundary()), forces(&fluid));
    assert!(expected.iter().any(|force| force.norm() > 100.0));
    for (force, expected) in forces.iter().zip(&expected) {
        // Some hundred parts of 20 kPa × 1 m² each.
        assert_close("force", (force - expected).norm(), 0.0, 1e-13 * q * 10.0);
    }
}

#[test]
fn a_fluid_outside_presses_like_tractions_on_the_faces_in_1d_2d_and_3d() {
    for (corner, edge) in [(1.0, 3.0), (0.75, 2.75)] {
        a_fluid_outside_presses_like_tractions_on_the_faces::<1>(corner, edge);
        a_fluid_outside_presses_like_tractions_on_the_faces::<2>(corner, edge);
        a_fluid_outside_presses_like_tractions_on_the_faces::<3>(corner, edge);
    }
}

/// Dry soil on rollers under a load put on smoothly: σ' = −q and ε = −q/E_oed everywhere.
fn a_loaded_column_strains_uniformly<const D: usize>(height: f64) {
    // A raised cosine over 10 s, 66 periods of the column: its start and end are so smooth that the wave they leave is
    // small, and MPM② damps it in the 5 s that follow.
    let (load, rise) = (50.0, 10.0);
    let smooth = |i: usize| {
        let share = i as f64 / 1000.0;
        [share * rise, 0.5 * (1.0 - (share * std::f64::consts::PI).cos())]
    };
    let mut solver = Body::<D>::column(height, 1.0)
        .particles_per_cell([4; D])
        .dry()
        .velocity_update(Mpm2)
        .load_on_surface(top::<D>(), down(load), History::new((0..=1000).map(smooth).collect()))
        .build();
    let carriers = outermost(solver.particles(), top::<D>());
    run(&mut solver, 0.005, 3000).unwrap();
    let strain = (height - surface(solver.particles(), &carriers, top::<D>())) / height;
    // The strain of finite displacements is ln(1 − s/H) = −s/H (1 + s/2H): 2e-6 off. Round-off of the positions: 1e-15 of
    // a settlement of 3e-5 m.
    let modulus = PAPER_SOIL.oedometric_modulus();
    assert_close("E_oed ε", modulus * strain, load, 1e-5 * load);
    let lateral = PAPER_SOIL.lame() / modulus;
    // The particles of the top cell, of length L, lose ε L, their cell sinks by ε H: σ L (1 − ε) = q (L − ε H), up to 5 ε.
    let tolerance = 2e-5 * load;
    for stress in &solver.particles().stress {
        for (axis, component) in [stress.xx, stress.yy, stress.zz].into_iter().enumerate() {
            let expected = if axis == D - 1 { -load } else { -lateral * load };
            assert_close("stress", component, expected, tolerance);
        }
        assert_close("shear", stress.xy.abs() + stress.yz.abs() + stress.zx.abs(), 0.0, 1e-6 * load);
    }
}

#[test]
fn a_loaded_column_strains_uniformly_in_1d_2d_and_3d() {
    // On a grid line and inside a cell.
    for height in [4.0, 3.75] {
        a_loaded_column_strains_uniformly::<1>(height);
        a_loaded_column_strains_uniformly::<2>(height);
        a_loaded_column_strains_uniformly::<3>(height);
    }
}
