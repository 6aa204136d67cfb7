//! Laws of sand against independent programs, closed forms and their own contract.

use tsutsumi::law::{ConstitutiveLaw, LawError, Sanisand};
use tsutsumi::tensor::Sym3;
use tsutsumi_testkit::law::{LawPath, check_law};
use tsutsumi_testkit::noise::Noise;

/// Toyoura sand after Dafalias and Manzari (2004), as OpenSees' users have it.
const TOYOURA: Sanisand = Sanisand {
    void_ratio: 0.8,
    atmospheric_pressure: 100e3,
    shear_modulus_number: 125.0,
    poisson: 0.05,
    critical_stress_ratio: 1.25,
    extension_ratio: 0.712,
    critical_void_ratio: 0.934,
    critical_slope: 0.019,
    critical_exponent: 0.7,
    yield_opening: 0.01,
    hardening_number: 7.05,
    hardening_void_ratio: 0.968,
    bounding_exponent: 1.1,
    dilatancy_number: 0.704,
    dilatancy_exponent: 3.5,
    fabric_limit: 4.0,
    fabric_rate: 600.0,
    residual_pressure: 1000.0,
    sub_step_tolerance: 1e-4,
    smallest_sub_step: 1e-6,
};

/// The equations without the guards of low pressure.
fn as_published(void_ratio: f64) -> Sanisand {
    Sanisand { void_ratio, residual_pressure: 0.0, ..TOYOURA }
}

/// p' and q of triaxial compression along z (Pa).
fn invariants(stress: Sym3) -> (f64, f64) {
    (stress.trace() / -3.0, stress.xx - stress.zz)
}

/// A point of a law on its way.
struct Point<'a, L: ConstitutiveLaw> {
    law: &'a L,
    stress: Sym3,
    state: L::State,
}

impl<'a, L: ConstitutiveLaw> Point<'a, L> {
    fn new(law: &'a L, stress: Sym3) -> Self {
        Point { law, stress, state: law.initial_state(stress) }
    }

    fn strain(&mut self, strain: Sym3) {
        (self.stress, self.state) = self.law.update(self.stress, self.state, strain).unwrap();
    }

    fn output(&self, name: &str) -> f64 {
        let names = self.law.outputs();
        let mut values = vec![f64::NAN; names.len()];
        self.law.write_outputs(self.stress, &self.state, &mut values);
        values[names.iter().position(|known| *known == name).unwrap()]
    }
}

/// Isotropic compression (Pa).
fn isotropic(pressure: f64) -> Sym3 {
    Sym3::IDENTITY * -pressure
}

/// Triaxial compression without drainage; p' and q (kPa) after 1, 5 and 25 % of axial strain.
fn undrained_compression<L: ConstitutiveLaw>(law: &L, pressure: f64) -> [(f64, f64); 3] {
    let mut point = Point::new(law, isotropic(pressure));
    [100, 400, 2000].map(|increments| {
        (0..increments).for_each(|_| point.strain(Sym3::diagonal(0.5e-4, 0.5e-4, -1e-4)));
        let (mean, deviator) = invariants(point.stress);
        (1e-3 * mean, 1e-3 * deviator)
    })
}

/// Triaxial compression with constant lateral stress: a secant iteration on the lateral strain in every increment.
/// Returns q (kPa) and the void ratio after 5 and 25 % of axial strain.
fn drained_compression(law: &Sanisand, pressure: f64) -> [(f64, f64); 2] {
    let mut point = Point::new(law, isotropic(pressure));
    let axial = -1e-4;
    let mut lateral = 0.0;
    [500, 2000].map(|increments| {
        for _ in 0..increments {
            let excess = |lateral: f64| {
                let strain = Sym3::diagonal(lateral, lateral, axial);
                law.update(point.stress, point.state, strain).unwrap().0.xx + pressure
            };
            let mut last = (lateral + 1e-7, excess(lateral + 1e-7));
            for _ in 0..20 {
                let now = excess(lateral);
                if now.abs() < 1e-6 * pressure {
                    break;
                }
                (lateral, last) = (lateral - now * (lateral - last.0) / (now - last.1), (lateral, now));
            }
            point.strain(Sym3::diagonal(lateral, lateral, axial));
        }
        // The iteration did meet the lateral stress.
        assert!((point.stress.xx + pressure).abs() < 1e-5 * pressure);
        (1e-3 * invariants(point.stress).1, point.output("void_ratio"))
    })
}

/// What happened in cyclic shear: the end of every half cycle and the first time that r_u reached 0.95.
struct Cycles {
    /// γ (–) and r_u = 1 − σ'_v/σ'_v0 at the reversals, the first after a quarter of a cycle.
    reversals: Vec<(f64, f64)>,
    /// Cycles to r_u = 0.95, by the shear strain passed between two reversals.
    to_liquefaction: f64,
}

/// Shear strain along xy at constant volume, reversed when |τ| reaches a limit (Pa); γ is followed in increments of 1e-5.
///
/// The last increment before a reversal is halved until τ is met to 0.01 %.
fn cyclic_shear<L: ConstitutiveLaw>(law: &L, start: Sym3, limit: f64, reversals: usize) -> Cycles {
    let mut point = Point::new(law, start);
    let mut cycles = Cycles { reversals: Vec::new(), to_liquefaction: f64::NAN };
    let (mut direction, mut strain, mut increment) = (1.0, 0.0, 1e-5);
    // The strain at the last reversal, and that at which r_u = 0.95 was met.
    let (mut from, mut met) = (0.0, None);
    while cycles.reversals.len() < reversals {
        let shear = Sym3 { xy: 0.5 * direction * increment, ..Sym3::ZERO };
        let (stress, state) = law.update(point.stress, point.state, shear).unwrap();
        if direction * stress.xy > limit * 1.0001 {
            increment *= 0.5;
            continue;
        }
        (point.stress, point.state) = (stress, state);
        strain += direction * increment;
        let ratio = 1.0 - stress.yy / start.yy;
        if ratio >= 0.95 && met.is_none() {
            met = Some(strain);
        }
        if direction * stress.xy >= limit {
            let half_cycles = cycles.reversals.len() as f64 - 0.5;
            if let (Some(met), true) = (met, cycles.to_liquefaction.is_nan()) {
                cycles.to_liquefaction = 0.5 * (half_cycles + f64::abs((met - from) / (strain - from)));
            }
            cycles.reversals.push((strain, ratio));
            (direction, from, increment) = (-direction, strain, 1e-5);
        }
    }
    cycles
}

/// Constitutive equations integrated by another program, with p_at = 101 kPa; p' and q (kPa) at 1, 5 and 25 % of axial strain.
#[test]
fn sanisand_undrained_compression_meets_an_independent_integration() {
    let known = [
        (0.735, 100e3, [(173.0, 231.2), (1210.0, 1721.4), (2900.1, 3624.9)]),
        (0.735, 1000e3, [(926.2, 878.8), (1720.2, 2270.9), (2897.8, 3622.4)]),
        (0.735, 3000e3, [(2500.4, 1802.8), (2293.2, 2789.3), (2895.9, 3620.3)]),
        (0.833, 100e3, [(99.0, 117.9), (409.2, 544.9), (1092.6, 1367.4)]),
        (0.833, 3000e3, [(2210.6, 1338.4), (1116.2, 1275.6), (1096.2, 1370.7)]),
    ];
    for (void_ratio, pressure, rows) in known {
        let law = Sanisand { atmospheric_pressure: 101e3, ..as_published(void_ratio) };
        for ((mean, deviator), (known_mean, known_deviator)) in
            undrained_compression(&law, pressure).into_iter().zip(rows)
        {
            let off = f64::max((mean / known_mean - 1.0).abs(), (deviator / known_deviator - 1.0).abs());
            // Four digits were kept.
            assert!(off < 0.0006, "{void_ratio} {pressure}: {mean} {deviator}");
        }
    }
}

/// The same program, q (kPa) and void ratio at 25 %.
#[test]
fn sanisand_drained_compression_meets_an_independent_integration() {
    let known = [
        (0.831, 100e3, 220.3, 0.8931),
        (0.996, 100e3, 210.5, 0.9149),
        (0.81, 500e3, 1096.7, 0.8382),
        (0.96, 500e3, 1045.3, 0.8603),
    ];
    for (void_ratio, pressure, deviator, at_end) in known {
        let law = Sanisand { atmospheric_pressure: 101e3, ..as_published(void_ratio) };
        let [_, (deviator_at_end, void_ratio_at_end)] = drained_compression(&law, pressure);
        // Four digits were kept.
        assert!((deviator_at_end / deviator - 1.0).abs() < 0.0003, "{deviator_at_end}");
        assert!((void_ratio_at_end - at_end).abs() < 0.6e-4, "{void_ratio_at_end}");
    }
    // The densest one passes a peak on its way.
    let law = Sanisand { atmospheric_pressure: 101e3, ..as_published(0.831) };
    let [(at_peak, _), _] = drained_compression(&law, 100e3);
    assert!((at_peak / 242.8 - 1.0).abs() < 0.0003, "{at_peak}");
}

/// On the critical state line: e = e_c(p) and q = M p, whatever the way there.
#[test]
fn sanisand_ends_in_the_critical_state() {
    for (void_ratio, pressure) in [(0.735, 100e3), (0.735, 3000e3), (0.833, 100e3), (0.833, 3000e3)] {
        let law = as_published(void_ratio);
        let exact = 1e-3 * law.atmospheric_pressure * ((0.934 - void_ratio) / 0.019_f64).powf(1.0 / 0.7);
        let mut point = Point::new(&law, isotropic(pressure));
        (0..10_000).for_each(|_| point.strain(Sym3::diagonal(0.5e-4, 0.5e-4, -1e-4)));
        let (mean, deviator) = invariants(point.stress);
        // The state is approached exponentially; nothing but rounding is left after 100 %.
        assert!((1e-3 * mean / exact - 1.0).abs() < 1e-6 && (deviator / mean / 1.25 - 1.0).abs() < 1e-6);
    }
}

/// OpenSees 3.7.1, `ManzariDafalias` in one `stdBrick` with all displacements given, γ in steps of 5e-6, from 100 kPa of isotropic stress;
/// `P_atm` 100 kPa, the other parameters as here, its void ratio kept at e by consolidating with a hundred thousand times the stiffness.
#[test]
fn sanisand_liquefies_as_in_opensees() {
    let dense = [
        (8.050e-4, 0.00241),
        (-1.430e-3, 0.04754),
        (1.005e-3, 0.10376),
        (-1.690e-3, 0.17052),
        (1.355e-3, 0.24759),
        (-2.190e-3, 0.33472),
        (2.145e-3, 0.43151),
        (-3.555e-3, 0.53428),
        (4.565e-3, 0.62752),
        (-7.085e-3, 0.69121),
        (7.940e-3, 0.72445),
        (-9.020e-3, 0.73853),
        (8.730e-3, 0.74366),
        (-9.300e-3, 0.74541),
        (8.820e-3, 0.74607),
        (-9.330e-3, 0.74626),
        (8.830e-3, 0.74632),
        (-9.335e-3, 0.74629),
        (8.830e-3, 0.74632),
        (-9.335e-3, 0.74633),
    ];
    let looser = [
        (9.650e-4, 0.01138),
        (-1.915e-3, 0.10176),
        (1.520e-3, 0.21629),
        (-2.925e-3, 0.36039),
        (4.085e-3, 0.54190),
        (-1.1255e-2, 0.69781),
        (1.4895e-2, 0.74350),
        (-1.520e-2, 0.75430),
        (1.551e-2, 0.75559),
        (-1.527e-2, 0.75577),
    ];
    for (void_ratio, known, to_liquefaction) in [(0.8, &dense[..], None), (0.85, &looser[..], Some(3.310))] {
        let law = Sanisand { void_ratio, ..TOYOURA };
        let cycles = cyclic_shear(&law, isotropic(100e3), 16e3, known.len());
        for ((strain, ratio), (known_strain, known_ratio)) in cycles.reversals.iter().zip(known) {
            // The other program turns at the first step beyond the limit, up to 24 Pa late, and starts from 99.997 kPa.
            assert!((ratio - known_ratio).abs() < 1e-3, "r_u {ratio} {known_ratio}");
            assert!((strain - known_strain).abs() < 5e-6 + 4e-3 * f64::abs(*known_strain), "γ {strain} {known_strain}");
        }
        if let Some(known) = to_liquefaction {
            assert!((cycles.to_liquefaction - known).abs() < 0.005, "{}", cycles.to_liquefaction);
        }
    }
}

/// Shear in all directions, in increments of 1e-6 to 1e-2, while the volume swings: the ground closes, opens, and closes again.
fn endure<L: ConstitutiveLaw>(law: &L, start: Sym3, in_plane: bool) {
    let mut noise = Noise::new(7);
    let mut point = Point::new(law, start);
    let mut volume = 0.0;
    for increment in 0..2000 {
        let mut strain = noise.tensor() * 10_f64.powi(-2 - increment % 5);
        let swing = 3e-3 * f64::sin(0.05 * f64::from(increment));
        if in_plane {
            strain = Sym3 { zz: 0.0, yz: 0.0, zx: 0.0, ..strain };
            let change = 0.5 * (swing - volume - strain.trace());
            strain += Sym3::diagonal(change, change, 0.0);
        } else {
            strain = strain.deviator() + Sym3::IDENTITY * ((swing - volume) / 3.0);
        }
        volume = swing;
        point.strain(strain);
        assert!(point.stress.is_finite() && point.stress.trace() < 0.0, "{increment}: {}", point.stress);
    }
}

#[test]
fn sanisand_keeps_the_contract() {
    check_law(&TOYOURA).unwrap();
    let near_the_apex = LawPath { stress: isotropic(3e3), strain: 1e-5, ..LawPath::default() };
    near_the_apex.check(&TOYOURA).unwrap();
    let beyond_the_bounding_surface = LawPath { stress: Sym3::diagonal(-100e3, -100e3, -10e3), ..LawPath::default() };
    beyond_the_bounding_surface.check(&TOYOURA).unwrap();
}

#[test]
fn sanisand_has_an_answer_everywhere() {
    endure(&TOYOURA, isotropic(100e3), false);
    endure(&Sanisand { void_ratio: 0.95, ..TOYOURA }, Sym3::ZERO, false);
}

/// Opened ground keeps the smallest pressure, and closes again.
#[test]
fn sanisand_opens_and_closes() {
    let mut point = Point::new(&TOYOURA, isotropic(5e3));
    (0..100).for_each(|_| point.strain(Sym3::IDENTITY * 1e-4));
    assert!((point.stress.trace() / -3.0 - 10.0).abs() < 1e-9, "{}", point.stress);
    (0..100).for_each(|_| point.strain(Sym3::IDENTITY * -1e-4));
    assert!(point.stress.trace() < -3.0 * 5e3, "{}", point.stress);
}

#[test]
fn sanisand_names_the_parameter_that_is_out_of_range() {
    let bad = [
        (Sanisand { void_ratio: 3.0, ..TOYOURA }, "void_ratio"),
        (Sanisand { poisson: 0.5, ..TOYOURA }, "poisson"),
        (Sanisand { extension_ratio: 0.0, ..TOYOURA }, "extension_ratio"),
        (Sanisand { fabric_rate: -1.0, ..TOYOURA }, "fabric_rate"),
        (Sanisand { hardening_void_ratio: 1.3, ..TOYOURA }, "hardening_void_ratio"),
        (Sanisand { yield_opening: f64::NAN, ..TOYOURA }, "yield_opening"),
    ];
    for (law, expected) in bad {
        let Err(LawError::Parameter { name, .. }) = law.validate() else { panic!("{expected} was accepted") };
        assert_eq!(name, expected);
    }
}
