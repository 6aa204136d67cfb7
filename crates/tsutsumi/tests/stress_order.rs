//! Stress first, last and modified last: one step, three orders of its parts.
//!
//! ```text
//!     amplitude │╲╱╲╱╲╱╲╱╲   first, modified last
//!               │╲╱╲╱╲╱──    last: what particles and nodes disagree in is lost
//!               └──────────── t
//! ```

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::f64::consts::PI;

use tsutsumi::boundary::History;
use tsutsumi::law::{LinearElastic, NeoHookean};
use tsutsumi::shape::{CpGimp, QuadraticBSpline};
use tsutsumi::solver::{Solver, StressFirst, StressLast, StressModifiedLast};
use tsutsumi::tensor::Vector;
use tsutsumi::velocity::{Apic, Mpm2};
use tsutsumi_reference::elastic_column::{BarEnds, VibratingBar};
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::compare::{assert_close, observed_order};
use tsutsumi_testkit::noise::Noise;
use tsutsumi_testkit::reading::{cell_pressures, largest_speed, outermost, run, surface, top};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Order {
    First,
    Last,
    ModifiedLast,
}

impl Order {
    const ALL: [Order; 3] = [Order::First, Order::Last, Order::ModifiedLast];

    fn of<const D: usize, L: tsutsumi::law::ConstitutiveLaw>(self, body: Body<D, L>) -> Solver<D> {
        match self {
            Order::First => body.stress_order(StressFirst).build(),
            Order::Last => body.stress_order(StressLast).build(),
            Order::ModifiedLast => body.stress_order(StressModifiedLast).build(),
        }
    }
}

/// A dry bar of 10 m in 5 coarse cells, one end held, in its first mode.
const BAR: VibratingBar =
    VibratingBar { length: 10.0, modulus: 1e6, density: 1000.0, velocity: 0.05, mode: 1, ends: BarEnds::FixedFree };
const SPACING: f64 = 2.0;
const STEP: f64 = 0.04;

/// The largest kinetic energy of the last period over that of the first.
fn energy_left(order: Order, periods: usize) -> f64 {
    let law = LinearElastic { young: BAR.modulus, poisson: 0.0 };
    let body = Body::<1>::column(BAR.length, SPACING)
        .dry()
        .law(law)
        .density(BAR.density)
        .velocity(|x| Vector::repeat(BAR.velocity(x[0], 0.0)));
    let mut solver = order.of(body);
    let period = (1.0 / BAR.frequency() / STEP).round() as usize;
    let mut peak = || {
        let energies = (0..period).map(|_| {
            solver.step(STEP).unwrap();
            solver.particles().kinetic_energy()
        });
        energies.fold(0.0, f64::max)
    };
    let first = peak();
    (1..periods).map(|_| peak()).last().unwrap() / first
}

/// Particles at the quarter points see λ = 1 − ⅜ (1 − cos κh) of a wave on the nodes. The strains of "last" come from nodal velocities
/// that lead those of the particles by (1 − λ) Δt a: a step leaves 1 − (1 − λ) (ω Δt)² of the energy. The other two take them from the
/// particles' velocities: symplectic, nothing is lost.
#[test]
fn only_stress_last_damps_what_particles_and_nodes_disagree_in() {
    let periods = 20;
    let wave_number = 0.5 * PI / BAR.length;
    let disagreement = 0.375 * (1.0 - (wave_number * SPACING).cos());
    let turn = 2.0 * PI * BAR.frequency() * STEP;
    let steps = (periods - 1) as f64 / BAR.frequency() / STEP;
    let lost = 1.0 - disagreement * turn * turn;
    // A peak between two of 32 samples: up to 1 % of the energy; λ of the two cells at the ends, half as much again.
    assert_close("last", energy_left(Order::Last, periods), lost.powf(steps), 0.02);
    assert!(lost.powf(steps) < 0.7);
    assert_close("first", energy_left(Order::First, periods), 1.0, 0.01);
    assert_close("modified last", energy_left(Order::ModifiedLast, periods), 1.0, 0.01);
}

/// The paper's column: settlement and pressure at the base after 200 s of a ramp of 100 s.
fn column(order: Order, dt: f64) -> [f64; 2] {
    let ramp = History::new(vec![[0.0, 0.0], [100.0, 1.0]]);
    let body = Body::<1>::column(10.0, 1.0).drained(top::<1>()).load_on_surface(top::<1>(), down(50e3), ramp);
    let mut solver = order.of(body);
    let carriers = outermost(solver.particles(), top::<1>());
    run(&mut solver, dt, (200.0 / dt).round() as usize).unwrap();
    [10.0 - surface(solver.particles(), &carriers, top::<1>()), cell_pressures(&solver)[0]]
}

/// What they disagree in falls with the step: they are orders of one scheme.
#[test]
fn the_orders_meet_when_the_step_is_short() {
    for order in [Order::First, Order::ModifiedLast] {
        for reading in 0..2 {
            let difference = |dt: f64| {
                let (value, last) = (column(order, dt)[reading], column(Order::Last, dt)[reading]);
                (dt, (value - last).abs() / last)
            };
            let differences = [0.4, 0.2, 0.1].map(difference);
            assert!(differences[2].1 < 1e-3, "{order:?} {differences:?}");
            let observed = observed_order(&differences);
            assert!(observed > 0.9, "{order:?}: order {observed} from {differences:?}");
        }
    }
}

/// Momentum is the nodes' affair, whatever the order: a free body under internal stress keeps it to round-off.
#[test]
fn momentum_is_conserved_in_every_order() {
    for order in Order::ALL {
        let noise = std::cell::RefCell::new(Noise::new(3));
        let body = Body::<2>::free(Vector::repeat(2.0), Vector::repeat(4.0), 1.0, [6, 6])
            .dry()
            .shape(QuadraticBSpline)
            .velocity_update(Apic)
            .velocity(move |_| noise.borrow_mut().vector());
        let mut solver = order.of(body);
        let before = solver.particles().momentum();
        let scale = solver.particles().mass.iter().sum::<f64>() * largest_speed(solver.particles());
        run(&mut solver, 1e-4, 200).unwrap();
        assert!((solver.particles().momentum() - before).norm() < 1e-12 * scale, "{order:?}");
    }
}

/// The step limits hold for every order: small noise does not grow beyond what a step near the limit makes of it.
///
/// An explicit step of ω Δt = 2 f keeps (v²/2 + ω² u²/2) (1 − f²) at least: velocities up to 1/√(1 − f²) times the first, 3.2 for f = 0.95.
///
/// Over 20,000 steps MPM① with stress first grows in the wet layer, by 0.1 % a step: the other orders do not (see the book).
#[test]
fn the_stated_limits_hold_in_every_order() {
    fn grown<const D: usize>(order: Order, body: Body<D>, steps: usize) -> f64 {
        let noise = std::cell::RefCell::new(Noise::new(5));
        let mut solver = order.of(body.velocity(move |_| noise.borrow_mut().vector() * 1e-9));
        let before = largest_speed(solver.particles());
        let dt = 0.95 * solver.step_limits().longest();
        run(&mut solver, dt, steps).map_or(f64::INFINITY, |()| largest_speed(solver.particles()) / before)
    }
    for order in Order::ALL {
        for pic in [false, true] {
            let plane = |body: Body<2>| if pic { body.velocity_update(Mpm2) } else { body };
            let wet = || Body::<2>::layer(4.0, 1.0, 3).drained(top::<2>());
            let growths = [
                grown(order, plane(wet()), 2000),
                grown(order, plane(wet().shape(CpGimp)), 2000),
                grown(order, plane(Body::layer(4.0, 1.0, 4).dry()), 2000),
                grown(order, Body::<1>::column(10.0, 1.0).dry(), 2000),
                grown(order, Body::<1>::column(10.0, 1.0).drained(top::<1>()), 2000),
            ];
            // Velocities that the grid does not see neither grow nor fade with MPM①.
            assert!(growths.iter().all(|&growth| growth < 3.2), "{order:?} MPM② {pic}: {growths:?}");
        }
    }
}

/// A law of finite strain and the volume see the same deformation gradient: J of the law is the volume ratio to round-off.
#[test]
fn the_volume_is_the_determinant_of_the_deformation_gradient() {
    for order in Order::ALL {
        let law = NeoHookean { young: 1e5, poisson: 0.2 };
        let body = Body::<2>::free(Vector::repeat(2.0), Vector::repeat(4.0), 0.5, [12, 12])
            .dry()
            .law(law)
            .density(1000.0)
            .shape(QuadraticBSpline)
            .velocity(|x| Vector::<2>::new(3.0 - x[1], x[0] - 3.0) * 2.0 + Vector::<2>::new(3.0 - x[0], 0.0));
        let mut solver = order.of(body);
        let volume = solver.particles().volume[0];
        run(&mut solver, 1e-3, 400).unwrap();
        let particles = solver.particles();
        let stretched = particles.volume.iter().map(|v| (v / volume - 1.0).abs()).fold(0.0, f64::max);
        assert!(stretched > 0.02, "{order:?}: {stretched}");
        for p in 0..particles.len() {
            // In plane strain tr σ' and J are one to one for given b: with c = b − I, J σ_zz = λ ln J gives J from σ_zz alone.
            let (ratio, stress) = (particles.volume[p] / volume, particles.stress.at(p));
            let lame = 1e5 * 0.2 / (1.2 * 0.6);
            assert_close("σ_zz", stress.zz, lame * ratio.ln() / ratio, 1e-8 * lame);
        }
    }
}
