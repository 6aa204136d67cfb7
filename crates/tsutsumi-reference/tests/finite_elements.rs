//! The finite element reference against an independent program and exact solutions.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use tsutsumi::boundary::{AppliedTo, AxisSet, Boundary, History, Load};
use tsutsumi::grid::{Grid, Side};
use tsutsumi::law::{ConstitutiveLaw, Group, LawError, LinearElastic};
use tsutsumi::particles::{Particle, Particles};
use tsutsumi::pressure::Fluid;
use tsutsumi::tensor::{Sym3, Vector};
use tsutsumi_reference::consolidation::{Layer, Ramp};
use tsutsumi_reference::finite_elements::{FiniteElements, GaussPoint, Newmark, Parts, gauss_points};

const SOIL: LinearElastic = LinearElastic { young: 4.35e6, poisson: 0.45 };
const WATER: Fluid = Fluid { density: 1000.0, bulk_modulus: 2.2e9, unit_weight: 9800.0 };
const HEIGHT: f64 = 10.0;

/// The paper's column on a mesh one element wide, drained and loaded by 50 kPa at the top.
struct Column {
    elements: usize,
    newmark: Newmark,
    history: Vec<[f64; 2]>,
    gravity: f64,
}

const COLUMN: Column =
    Column { elements: 20, newmark: Newmark { beta: 0.5, gamma: 1.0 }, history: Vec::new(), gravity: 0.0 };

fn ramp() -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [1000.0, 1.0]]
}

impl Column {
    fn model<const D: usize>(&self) -> FiniteElements<D> {
        self.model_of(SOIL)
    }

    fn model_of<const D: usize, L: ConstitutiveLaw>(&self, law: L) -> FiniteElements<D> {
        let spacing = Vector::<D>::from_fn(|axis, _| if axis + 1 == D { HEIGHT / self.elements as f64 } else { 1.0 });
        let mut cells = [1; D];
        cells[D - 1] = self.elements;
        let grid = Grid::new(Vector::zeros(), spacing, cells).unwrap();
        let top = Side { axis: D - 1, upper: true };
        let mut points = Particles::default();
        let mut forces = Vec::new();
        let axes: Vec<Vec<GaussPoint>> =
            (0..D).map(|axis| gauss_points(0.0, spacing[axis] * cells[axis] as f64, cells[axis])).collect();
        for number in 0..axes.iter().map(Vec::len).product() {
            let mut rest: usize = number;
            let at: Vec<GaussPoint> = axes
                .iter()
                .map(|axis| {
                    let point = axis[rest % axis.len()];
                    rest /= axis.len();
                    point
                })
                .collect();
            points.push(Particle {
                position: Vector::from_fn(|axis, _| at[axis].place),
                half_size: Vector::from_fn(|axis, _| at[axis].half_length),
                velocity: Vector::zeros(),
                density: 1500.0,
                stress: Sym3::ZERO,
                pressure: 0.0,
                porosity: 0.4,
                conductivity: 5.52e-5,
            });
            let p = points.len() - 1;
            points.set_volume(p, at.iter().map(|point| point.weight).product());
            if at[D - 1].place + at[D - 1].half_length > HEIGHT - 1e-9 {
                points.drained[p].insert(top);
                let mut force = Vector::zeros();
                force[D - 1] = -50e3 * at[..D - 1].iter().map(|point| point.weight).product::<f64>();
                forces.push((p, force));
            }
        }
        let mut boundary = Boundary::free(&grid);
        for axis in 0..D {
            let mut axes = AxisSet::default();
            axes.insert(axis);
            for upper in [false, true] {
                if axis + 1 < D || !upper {
                    boundary.fix_side(&grid, Side { axis, upper }, axes);
                }
            }
        }
        if !self.history.is_empty() {
            let history = History::new(self.history.clone());
            boundary.push_load(Load { forces, history, applied_to: AppliedTo::Surface(top) });
        }
        let groups: Vec<Box<dyn tsutsumi::law::MaterialGroup>> =
            vec![Box::new(Group::new("soil", law, 0..points.len(), &points.stress))];
        let mut gravity = Vector::zeros();
        gravity[D - 1] = -self.gravity;
        let fluid = Some(WATER);
        FiniteElements::new(Parts {
            grid,
            points,
            groups,
            boundary,
            gravity,
            fluid,
            // OpenSees leaves the inertia of the fluid out.
            fluid_inertia: false,
            newmark: self.newmark,
        })
        .unwrap()
    }
}

/// A model with the places of its points at the start.
struct Watched<const D: usize> {
    model: FiniteElements<D>,
    top: usize,
    height: f64,
    half_height: f64,
}

impl<const D: usize> Watched<D> {
    fn new(column: &Column) -> Self {
        Self::of(column.model())
    }

    fn of(model: FiniteElements<D>) -> Self {
        let top = model.points().len() - 1;
        let (height, half_height) = (model.points().position[top][D - 1], model.points().half_size[top][D - 1]);
        Watched { model, top, height, half_height }
    }

    fn run(&mut self, time: f64, dt: f64) {
        while self.model.time() < time - 1e-9 {
            self.model.step(dt).unwrap();
        }
    }

    /// The fall of the true surface (m).
    fn settlement(&self) -> f64 {
        let points = self.model.points();
        self.height - points.position[self.top][D - 1] + self.half_height - points.half_size[self.top][D - 1]
    }

    /// The pressure (Pa) at a depth below the top (m), from the cubic through the four centres around it; the base is a
    /// line of symmetry.
    fn pressure_at_depth(&self, depth: f64) -> f64 {
        let pressure = &self.model.cells().pressure;
        let of = |element: i64| pressure[if element < 0 { -1 - element } else { element } as usize];
        let below = ((HEIGHT - depth) / self.model.grid().spacing()[D - 1]).round() as i64;
        (9.0 * (of(below - 1) + of(below)) - of(below - 2) - of(below + 1)) / 16.0
    }
}

/// OpenSees 3.7, quadUP, 100 elements, Δt 0.1 s, same column: time (s), settlement (m), pressures (kPa) at depths of 2.5,
/// 5, 7.5 and 10 m. Its accuracy is 6e-6 of the largest settlement and 2e-5 of the largest pressure.
const OPENSEES: [(f64, f64, [f64; 4]); 7] = [
    (50.0, 2.491264808e-04, [1.941048, 2.414264, 2.485819, 2.491869]),
    (100.0, 7.008875654e-04, [3.194058, 4.464079, 4.862562, 4.942490]),
    (200.0, 1.974671077e-03, [5.028082, 7.736664, 8.989194, 9.343076]),
    (500.0, 7.697965071e-03, [8.381617, 13.916463, 17.041647, 18.049196]),
    (1000.0, 2.052341682e-02, [10.688785, 18.179518, 22.611552, 24.077998]),
    (1100.0, 2.263034403e-02, [7.715405, 14.123199, 18.281754, 19.712168]),
    (2000.0, 2.932509187e-02, [0.969983, 1.792294, 2.341745, 2.534687]),
];

/// 20 elements and Δt = 10 s: within 1e-3 of the largest settlement and pressure.
#[test]
fn the_column_follows_opensees() {
    let mut column = Watched::<2>::new(&Column { history: ramp(), ..COLUMN });
    for (time, settlement, pressures) in OPENSEES {
        column.run(time, 10.0);
        assert!((column.settlement() - settlement).abs() < 1e-3 * 0.0303, "{time} s: {}", column.settlement());
        for (depth, expected) in [2.5, 5.0, 7.5, 10.0].into_iter().zip(pressures) {
            let pressure = column.pressure_at_depth(depth) / 1e3;
            assert!((pressure - expected).abs() < 1e-3 * 24.08, "{time} s, {depth} m: {pressure} kPa, not {expected}");
        }
    }
}

/// The same equations in every dimension: what remains is rounding.
#[test]
fn every_dimension_gives_the_same_column() {
    fn curve<const D: usize>() -> Vec<[f64; 2]> {
        let mut column = Watched::<D>::new(&Column { history: ramp(), elements: 10, ..COLUMN });
        let times = [100.0, 600.0, 1000.0, 1300.0];
        times
            .map(|time| {
                column.run(time, 20.0);
                [column.settlement(), column.model.cells().pressure[0]]
            })
            .to_vec()
    }
    let one = curve::<1>();
    for other in [curve::<2>(), curve::<3>()] {
        for (a, b) in one.iter().flatten().zip(other.iter().flatten()) {
            assert!((a - b).abs() <= 1e-9 * a.abs(), "{a} {b}");
        }
    }
}

/// Settlement at 500 s against the series (OpenSees' own error is far below these). Second order in the element size; in
/// the step too, for β = ½ makes displacements the trapezoidal sum of velocities.
#[test]
fn the_error_falls_at_second_order_in_space_and_time() {
    let layer = Layer {
        height: HEIGHT,
        modulus: SOIL.oedometric_modulus(),
        conductivity: 5.52e-5,
        unit_weight: 9800.0,
        fluid_compressibility: 0.4 / 2.2e9,
    };
    let exact = layer.settlement(Ramp { load: 50e3, duration: 1000.0 }, 500.0);
    let error = |elements: usize, dt: f64| {
        let mut column = Watched::<1>::new(&Column { history: ramp(), elements, ..COLUMN });
        column.run(500.0, dt);
        (column.settlement() - exact).abs()
    };
    let in_space = (error(10, 1.0) / error(20, 1.0)).log2();
    assert!((in_space - 2.0).abs() < 0.15, "order {in_space} in space");
    let reference = {
        let mut column = Watched::<1>::new(&Column { history: ramp(), elements: 10, ..COLUMN });
        column.run(500.0, 0.5);
        column.settlement()
    };
    let in_time = |dt: f64| {
        let mut column = Watched::<1>::new(&Column { history: ramp(), elements: 10, ..COLUMN });
        column.run(500.0, dt);
        (column.settlement() - reference).abs()
    };
    let order = (in_time(50.0) / in_time(25.0)).log2();
    assert!((order - 2.0).abs() < 0.2, "order {order} in time");
}

/// Load put on over a second: the fluid takes its undrained share (K_f/n) / (K_f/n + E_oed) of it, away from the drained
/// top. In that time water drains from √(c_v t) = 0.3 m, far from the base; inertia, ρ H u/t² = 15 Pa, is 3e-4 of the load.
#[test]
fn a_sudden_load_is_carried_by_the_water() {
    let share = 1.0 / (1.0 + 16.5e6 * 0.4 / 2.2e9);
    let mut column = Watched::<2>::new(&Column { history: vec![[0.0, 0.0], [1.0, 1.0]], ..COLUMN });
    column.run(1.0, 0.05);
    let pressure = column.pressure_at_depth(10.0);
    assert!((pressure / 50e3 - share).abs() < 1e-3, "{}", pressure / 50e3);
}

/// Under gravity alone everything comes to rest at p_w = ρ^f g z and σ'_v = (ρ − ρ^f) g z.
#[test]
fn under_gravity_the_water_becomes_hydrostatic() {
    let mut column = Watched::<2>::new(&Column { gravity: 9.8, elements: 10, ..COLUMN });
    // H²/c_v = 1080 s.
    column.run(20_000.0, 200.0);
    let pressure = column.model.cells().pressure[0];
    assert!((pressure - 9800.0 * 9.5).abs() < 1e-4 * 9800.0 * 9.5, "{pressure}");
    let stress = column.model.points().stress.at(0).yy;
    let depth = HEIGHT - 0.5;
    // Linear elements hold the mean stress of an element.
    let mean = 0.5 * (stress + column.model.points().stress.at(2).yy);
    assert!((mean + 500.0 * 9.8 * depth).abs() < 1e-4 * 500.0 * 9.8 * depth, "{mean}");
}

/// What the ground loses in volume has left through the top or is compressed.
#[test]
fn the_water_balance_closes() {
    let mut column = Watched::<2>::new(&Column { history: ramp(), ..COLUMN });
    column.run(1500.0, 10.0);
    let points = column.model.points();
    let compressed: f64 = (0..points.len()).map(|p| 0.4 / 2.2e9 * points.pressure[p] * points.volume[p]).sum();
    let lost = column.settlement();
    // Displacements and outflow are trapezoidal sums of the same flow, compression is summed at the ends of the steps: they
    // differ by half a step of its rate at the start, 5 s × 50 Pa/s × H n/K^f = 4.5e-7 m, of 27 mm.
    assert!((lost - column.model.outflow() - compressed).abs() < 4.6e-7, "{lost} {}", column.model.outflow());
}

/// A law that fails leaves the model as it was.
#[test]
fn a_failed_step_changes_nothing() {
    let mut column = Watched::<1>::new(&Column { history: vec![[0.0, 0.0], [1.0, f64::INFINITY]], ..COLUMN });
    let before = column.model.points().clone();
    let error = column.model.step(2.0).unwrap_err();
    assert!(error.to_string().starts_with("at t = 2.000000 s"), "{error}");
    assert_eq!(column.model.time(), 0.0);
    assert_eq!(column.model.points().position, before.position);
    column.model.step(0.0).unwrap_err();
}

/// Elasticity that stiffens in compression: σ' = E_oed ε (1 − b tr ε), the total strain in its history.
struct Stiffening;

impl Stiffening {
    const FACTOR: f64 = 100.0;
}

impl ConstitutiveLaw for Stiffening {
    type State = Sym3;

    fn update(&self, _stress: Sym3, total: Sym3, strain: Sym3) -> Result<(Sym3, Sym3), LawError> {
        let total = total + strain;
        let (linear, ()) = SOIL.update(Sym3::ZERO, (), total)?;
        Ok((linear * (1.0 - Self::FACTOR * total.trace()), total))
    }

    fn p_wave_modulus(&self, _stress: Sym3, total: &Sym3) -> f64 {
        SOIL.oedometric_modulus() * (1.0 - 2.0 * Self::FACTOR * total.trace())
    }
}

/// Drained compression by q ends where E_oed ε (1 − b ε) = −q; Newton's method needs few corrections, for the tangent, by
/// differences here, is that of the law.
#[test]
fn a_law_that_is_not_linear_is_followed_by_newtons_method() {
    let column = Column { history: ramp(), elements: 10, ..COLUMN };
    let mut column = Watched::<2>::of(column.model_of(Stiffening));
    let mut most = 0;
    // 8 H²/c_v after the load has come to rest: what is left of the consolidation is below 1e-8.
    while column.model.time() < 10_000.0 {
        most = most.max(column.model.step(50.0).unwrap().pressure.iterations);
    }
    let b = Stiffening::FACTOR;
    let strain = (1.0 - (1.0 + 4.0 * b * 50e3 / SOIL.oedometric_modulus()).sqrt()) / (2.0 * b);
    // The tolerance of the iteration, 1e-9 of the forces.
    assert!((column.settlement() / HEIGHT + strain).abs() < 1e-8 * strain.abs(), "{}", column.settlement());
    assert!(most <= 5, "{most} corrections");
}
