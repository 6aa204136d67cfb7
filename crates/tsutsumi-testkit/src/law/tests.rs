use serde::{Deserialize, Serialize};
use tsutsumi::law::{ClosedPathWork, Hencky, LawError, NeoHookean};
use tsutsumi::tensor::Matrix6;

use super::*;
use crate::body::PAPER_SOIL;

/// An elastic law that stiffens with its strain, with one fault or none.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    None,
    Parameters,
    Fails,
    NotFinite,
    Creeps,
    TensorsStay,
    DriftsWhileTurning,
    Tangent,
    CompressionModulus,
    ShearModulus,
    NotANumberInHistory,
    HistoryNotWritten,
    OutputForgotten,
}

/// The strain so far, a tensor, which the law needs; its length, a scalar, which it puts out; and what serde leaves out.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct History {
    strain: Sym3,
    #[serde(skip)]
    not_written: f64,
    length: f64,
    drift: f64,
}

impl ConstitutiveLaw for Fault {
    type State = History;

    fn update(&self, stress: Sym3, mut state: History, strain: Sym3) -> Result<(Sym3, History), LawError> {
        let (mut new, ()) = PAPER_SOIL.update(stress, (), strain)?;
        // A kinematic part: an elastic energy of the whole strain, whose derivative is the strain.
        new += strain * 1e6 + state.strain * (1e9 * strain.double_dot(strain));
        new += Sym3::IDENTITY * state.drift;
        state.strain += strain;
        state.length += strain.norm();
        match self {
            Fault::Fails if state.length > 1e-3 => {
                return Err(LawError::NotConverged { iterations: 3, residual: 1.0 });
            }
            Fault::NotFinite if state.length > 1e-3 => new.xy = f64::NAN,
            Fault::Creeps => new.zz *= 0.999,
            Fault::NotANumberInHistory => state.length = f64::NAN,
            Fault::HistoryNotWritten => {
                new += Sym3::IDENTITY * (state.not_written * strain.trace());
                state.not_written += 1e3;
            }
            _ => {}
        }
        Ok((new, state))
    }

    fn p_wave_modulus(&self, _: Sym3, _: &History) -> f64 {
        if *self == Fault::CompressionModulus { 17e6 } else { 18e6 }
    }

    fn s_wave_modulus(&self, _: Sym3, _: &History) -> f64 {
        if *self == Fault::ShearModulus { 1.5e6 } else { 2.5e6 }
    }

    fn validate(&self) -> Result<(), LawError> {
        match self {
            Fault::Parameters => Err(LawError::Parameter { name: "young", value: -1.0, expected: "positive" }),
            _ => Ok(()),
        }
    }

    fn rotate_state(&self, state: History, rotation: &Matrix3) -> History {
        match self {
            Fault::TensorsStay => state,
            Fault::DriftsWhileTurning => History { drift: state.drift + 1.0, ..state },
            _ => History { strain: state.strain.rotated(rotation), ..state },
        }
    }

    fn tangent(&self, stress: Sym3, state: History, strain: Sym3) -> Result<Matrix6, LawError> {
        let exact = PAPER_SOIL.tangent(stress, (), strain)?
            + Matrix6::identity() * 1e6
            + state.strain.to_kelvin() * strain.to_kelvin().transpose() * 2e9;
        Ok(if *self == Fault::Tangent { exact * 1.01 } else { exact })
    }

    fn outputs(&self) -> &'static [&'static str] {
        &["length"]
    }

    fn write_outputs(&self, _: Sym3, state: &History, values: &mut [f64]) {
        if *self != Fault::OutputForgotten {
            values[0] = state.length;
        }
    }
}

#[test]
fn sound_laws_pass() {
    check_law(&PAPER_SOIL).unwrap();
    check_law(&Fault::None).unwrap();
    check_law(&NeoHookean { young: 1e7, poisson: 0.3 }).unwrap();
    check_law(&Hencky { young: 1e7, poisson: 0.3 }).unwrap();
    let unstressed = LawPath { stress: Sym3::ZERO, ..LawPath::default() };
    unstressed.check(&PAPER_SOIL).unwrap();
    // Strains of tens of per cent.
    let far = LawPath { stress: Sym3::ZERO, strain: 0.01, ..LawPath::default() };
    far.check(&NeoHookean { young: 1e7, poisson: 0.3 }).unwrap();
    far.check(&Hencky { young: 1e7, poisson: 0.3 }).unwrap();
}

macro_rules! assert_violation {
    ($fault:ident, $violation:pat) => {
        let outcome = check_law(&Fault::$fault);
        assert!(matches!(outcome, Err($violation)), "{}: {outcome:?}", stringify!($fault));
    };
}

#[test]
fn every_fault_is_found_and_named() {
    assert_violation!(Parameters, LawViolation::Parameters(_));
    assert_violation!(Fails, LawViolation::Failed { .. });
    assert_violation!(NotFinite, LawViolation::NotFinite { .. });
    assert_violation!(Creeps, LawViolation::Creeps { increment: 0, .. });
    assert_violation!(DriftsWhileTurning, LawViolation::Turned { increment: 20, .. });
    assert_violation!(TensorsStay, LawViolation::NotObjective { .. });
    assert_violation!(Tangent, LawViolation::Tangent { increment: 0, .. });
    assert_violation!(CompressionModulus, LawViolation::CompressionModulus { increment: 0, .. });
    assert_violation!(ShearModulus, LawViolation::ShearModulus { increment: 0, .. });
    assert_violation!(NotANumberInHistory, LawViolation::Serialization { increment: 1, .. });
    assert_violation!(HistoryNotWritten, LawViolation::HistoryLost { increment: 1, .. });
    assert_violation!(OutputForgotten, LawViolation::Output { increment: 0, .. });
}

#[test]
fn increments_with_a_duration_are_turned_written_and_read() {
    let path = LawPath { duration: 1e-3, ..LawPath::default() };
    path.check(&PAPER_SOIL).unwrap();
    // Laws that depend on the rate may be stiffer than their elastic part.
    path.check(&Fault::ShearModulus).unwrap();
    assert!(matches!(path.check(&Fault::TensorsStay), Err(LawViolation::NotObjective { .. })));
    assert!(matches!(path.check(&Fault::HistoryNotWritten), Err(LawViolation::HistoryLost { .. })));
    assert!(matches!(path.check(&Fault::OutputForgotten), Err(LawViolation::Output { .. })));
}

/// Elasticity that is stiffer along x, with the tangent by differences that every law has.
struct Wooden;

impl ConstitutiveLaw for Wooden {
    type State = ();

    fn update(&self, stress: Sym3, (): (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        let (mut new, ()) = PAPER_SOIL.update(stress, (), strain)?;
        new.xx += 1e3 * strain.xx;
        Ok((new, ()))
    }

    fn p_wave_modulus(&self, _: Sym3, (): &()) -> f64 {
        17e6
    }
}

#[test]
fn a_preferred_direction_outside_the_history_is_not_objective() {
    let violation = check_law(&Wooden).unwrap_err();
    assert!(matches!(violation, LawViolation::NotObjective { increment: 20, .. }), "{violation}");
    assert!(violation.to_string().contains("rotate_state"));
}

/// An elastic law that is off by a few pascals at every call, however small the increment.
struct Nudged;

impl ConstitutiveLaw for Nudged {
    type State = ();

    fn update(&self, stress: Sym3, (): (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        let (new, ()) = PAPER_SOIL.update(stress, (), strain)?;
        Ok((new + Sym3::IDENTITY * (20.0 * (strain.norm() * 1e6).tanh()), ()))
    }

    fn p_wave_modulus(&self, stress: Sym3, (): &()) -> f64 {
        PAPER_SOIL.p_wave_modulus(stress, &())
    }
}

#[test]
fn an_error_that_steps_do_not_reduce_is_found() {
    let violation = check_law(&Nudged).unwrap_err();
    // Pushed by 20 Pa in each of three directions at each of 16 calls an increment, to the end of the path.
    let expected = 20.0 * 3.0_f64.sqrt() * 16.0 * 40.0;
    let LawViolation::StepSize { increment: 39, parts: 32, off, .. } = violation else { panic!("{violation}") };
    assert!((off / expected - 1.0).abs() < 0.02, "{off}, not {expected}");
    // Who says that so much is the law's own error gets it passed.
    LawPath { accuracy: 0.2, ..LawPath::default() }.check(&Nudged).unwrap();
}

/// Shear moves the mean stress, but the mean strain does not move the shear stress: a tangent without symmetry, and no energy.
struct Dilating(ClosedPathWork);

impl ConstitutiveLaw for Dilating {
    type State = ();

    fn update(&self, stress: Sym3, (): (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        let (new, ()) = PAPER_SOIL.update(stress, (), strain)?;
        Ok((new + Sym3::IDENTITY * (stress.deviator().double_dot(strain) * 50.0), ()))
    }

    fn p_wave_modulus(&self, _: Sym3, (): &()) -> f64 {
        20e6
    }

    fn closed_path_work(&self) -> ClosedPathWork {
        self.0
    }
}

#[test]
fn work_that_a_law_has_promised_not_to_give_back_is_found() {
    check_law(&Dilating(ClosedPathWork::Any)).unwrap();
    let violation = check_law(&Dilating(ClosedPathWork::NotNegative)).unwrap_err();
    assert!(matches!(violation, LawViolation::ClosedPath { path: "a square", work: ..0.0, .. }), "{violation}");
    let violation = check_law(&Dilating(ClosedPathWork::Zero)).unwrap_err();
    assert!(matches!(violation, LawViolation::ClosedPath { .. }), "{violation}");
}

/// Plastic, though it promises to be elastic.
struct Yielding;

impl ConstitutiveLaw for Yielding {
    type State = ();

    fn update(&self, stress: Sym3, (): (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        let (new, ()) = PAPER_SOIL.update(stress, (), strain)?;
        let shear = new.deviator().norm();
        Ok((new.deviator() * (100.0 / shear.max(100.0)) + Sym3::IDENTITY * (new.trace() / 3.0), ()))
    }

    fn p_wave_modulus(&self, stress: Sym3, (): &()) -> f64 {
        PAPER_SOIL.p_wave_modulus(stress, &())
    }

    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Zero
    }
}

#[test]
fn work_that_an_elastic_law_loses_is_found() {
    let violation = check_law(&Yielding).unwrap_err();
    assert!(matches!(violation, LawViolation::ClosedPath { work: 0.0.., .. }), "{violation}");
}

/// Elastic, with a list in every update, or in those that fail.
#[cfg(feature = "count-allocations")]
struct Listing {
    always: bool,
}

#[cfg(feature = "count-allocations")]
impl ConstitutiveLaw for Listing {
    type State = ();

    fn update(&self, stress: Sym3, (): (), strain: Sym3) -> Result<(Sym3, ()), LawError> {
        if self.always {
            std::hint::black_box(vec![strain; 2]);
        }
        match stress == Sym3::ZERO && !self.always {
            true => Err(LawError::Foreign { message: "no".repeat(2) }),
            false => PAPER_SOIL.update(stress, (), strain),
        }
    }

    fn p_wave_modulus(&self, stress: Sym3, (): &()) -> f64 {
        PAPER_SOIL.p_wave_modulus(stress, &())
    }
}

#[cfg(feature = "count-allocations")]
#[test]
fn memory_that_a_step_asks_for_is_found() {
    let violation = check_law(&Listing { always: true }).unwrap_err();
    assert!(matches!(violation, LawViolation::Allocates { increment: 0, count: 1 }), "{violation}");
    let fails = Listing { always: false };
    let point = Point { stress: Sym3::ZERO, state: (), duration: f64::INFINITY };
    LawPath::default().a_step_does_not_allocate(&fails, 0, &point, Sym3::ZERO).unwrap();
}
