//! What every constitutive law must satisfy: [`check_law`].
//!
//! ```
//! use tsutsumi_testkit::body::PAPER_SOIL;
//! use tsutsumi_testkit::law::check_law;
//!
//! check_law(&PAPER_SOIL).unwrap();
//! ```

use tsutsumi::law::{ConstitutiveLaw, Increment, LawError};
use tsutsumi::tensor::{Matrix3, Matrix6, Sym3, Vector, rotation};

use crate::noise::Noise;

/// How a law breaks its contract.
#[derive(Debug, thiserror::Error)]
pub enum LawViolation {
    /// The law refuses its own parameters.
    #[error("the parameters are not valid: {0}")]
    Parameters(#[source] LawError),
    /// The law gives no answer.
    #[error("increment {increment}: the law failed: {source}")]
    Failed {
        /// The number of the increment on the path.
        increment: usize,
        /// The law's reason.
        source: LawError,
    },
    /// A stress, a tangent, a modulus or an output is infinite or not a number.
    #[error("increment {increment}: {what} is not finite")]
    NotFinite {
        /// The number of the increment on the path.
        increment: usize,
        /// What is not finite.
        what: &'static str,
    },
    /// The stress changes though nothing is strained.
    #[error("increment {increment}: a strain increment of zero changes the stress by {change:e} Pa")]
    Creeps {
        /// The number of the increment on the path.
        increment: usize,
        /// The norm of the change (Pa).
        change: f64,
    },
    /// Stress, history and strain turned together give another result than the turned one.
    #[error(
        "increment {increment}: turned stress, history and strain give a stress that is {off:e} Pa off the turned one; \
         does `rotate_state` turn every tensor of the history?"
    )]
    NotObjective {
        /// The number of the increment on the path.
        increment: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// A rigid rotation does more to the stress than turn it.
    #[error("increment {increment}: after a rigid rotation by {degrees}° the stress is {off:e} Pa off the turned one")]
    Turned {
        /// The number of the increment on the path.
        increment: usize,
        /// The angle so far.
        degrees: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// The tangent is not the derivative of the stress.
    #[error("increment {increment}: column {column} of the tangent is {off:e} Pa off the difference quotient")]
    Tangent {
        /// The number of the increment on the path.
        increment: usize,
        /// The Kelvin component of the strain, 0 = xx … 5 = zx.
        column: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// The law is stiffer in uniaxial compression than it says, so that steps would be too long.
    #[error(
        "increment {increment}: the stiffness in compression is {stiffness:e} Pa, but p_wave_modulus is {bound:e} Pa"
    )]
    CompressionModulus {
        /// The number of the increment on the path.
        increment: usize,
        /// dσ/dε along one axis (Pa).
        stiffness: f64,
        /// What the law says (Pa).
        bound: f64,
    },
    /// The law is stiffer in shear than it says.
    #[error("increment {increment}: the stiffness in shear is {stiffness:e} Pa, but s_wave_modulus is {bound:e} Pa")]
    ShearModulus {
        /// The number of the increment on the path.
        increment: usize,
        /// dτ/dγ = dσ_xy/(2 dε_xy) (Pa).
        stiffness: f64,
        /// What the law says (Pa).
        bound: f64,
    },
    /// The history cannot be written, or cannot be read back.
    #[error("increment {increment}: the history cannot be written and read: {source}")]
    Serialization {
        /// The number of the increment on the path.
        increment: usize,
        /// What serde says.
        source: serde_json::Error,
    },
    /// The history that was written and read back is another.
    #[error("increment {increment}: after writing and reading the history the next stress is {off:e} Pa off")]
    HistoryLost {
        /// The number of the increment on the path.
        increment: usize,
        /// The norm of the difference (Pa).
        off: f64,
    },
    /// An output was not written.
    #[error("increment {increment}: the output `{name}` is not written")]
    Output {
        /// The number of the increment on the path.
        increment: usize,
        /// The name of the output.
        name: &'static str,
    },
}

/// Checks a law along [`LawPath::default`]: from 100 kPa of isotropic compression.
///
/// # Errors
/// The first violation.
pub fn check_law<L: ConstitutiveLaw>(law: &L) -> Result<(), LawViolation> {
    LawPath::default().check(law)
}

/// A path of strain increments along which a law is checked: compression and shear in changing directions, one quarter of
/// it pure uniaxial compression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawPath {
    /// The effective stress at the start (Pa).
    pub stress: Sym3,
    /// The size of a strain increment (–).
    pub strain: f64,
    /// The number of increments.
    pub increments: usize,
    /// How long an increment takes (s). Infinite, the default, is for every law. In a finite time laws that depend on the rate may relax
    /// and be stiffer than an elastic solid: then only what holds for them too is checked, which is turned results, finite numbers, the
    /// history written and read, and the outputs.
    pub duration: f64,
    /// True for laws of plane strain: strains and rotations stay in x and y.
    pub plane: bool,
}

impl Default for LawPath {
    fn default() -> Self {
        let stress = Sym3::diagonal(-100e3, -100e3, -100e3);
        LawPath { stress, strain: 1e-4, increments: 40, duration: f64::INFINITY, plane: false }
    }
}

/// The steps of a rigid rotation through 360°.
const STEPS_OF_A_TURN: usize = 1000;

/// A material point on its way.
struct Point<S> {
    stress: Sym3,
    state: S,
    duration: f64,
}

impl<S: Copy> Point<S> {
    fn update<L: ConstitutiveLaw<State = S>>(
        &self,
        law: &L,
        increment: usize,
        strain: Sym3,
    ) -> Result<Self, LawViolation> {
        let (stress, state) = law
            .update_within(self.stress, self.state, strain, self.duration)
            .map_err(|source| LawViolation::Failed { increment, source })?;
        match stress.is_finite() {
            true => Ok(Point { stress, state, ..*self }),
            false => Err(LawViolation::NotFinite { increment, what: "the stress" }),
        }
    }
}

impl LawPath {
    /// Checks a law along this path.
    ///
    /// # Errors
    /// The first violation.
    pub fn check<L: ConstitutiveLaw>(&self, law: &L) -> Result<(), LawViolation> {
        law.validate().map_err(LawViolation::Parameters)?;
        let mut noise = Noise::new(1);
        let state = law.initial_state(self.stress);
        let mut point = Point { stress: self.stress, state, duration: self.duration };
        // The point that is turned half way and goes on in turned directions.
        let turn = self.turn();
        let mut turned = None;
        for increment in 0..self.increments {
            let strain = self.strain_increment(increment, &mut noise);
            if self.duration.is_infinite() {
                self.nothing_strained_nothing_changed(law, increment, &point)?;
                self.moduli_bound_the_stiffness(law, increment, &point)?;
                tangent_is_the_derivative(law, increment, &point, strain, self.components())?;
            }
            self.history_survives_writing(law, increment, &point, strain)?;
            outputs_are_written(law, increment, &point)?;
            if increment == self.increments / 2 {
                if self.duration.is_infinite() {
                    self.a_rigid_rotation_turns_the_stress(law, increment, &point)?;
                }
                let state = law.rotate_state(point.state, &turn);
                turned = Some(Point { stress: point.stress.rotated(&turn), state, ..point });
            }
            point = point.update(law, increment, strain)?;
            if let Some(other) = &mut turned {
                *other = other.update(law, increment, strain.rotated(&turn))?;
                let off = (other.stress - point.stress.rotated(&turn)).norm();
                // Round-off, which a law may magnify, but not a thousand times over.
                if off > 1e-9 * self.scale(law, &point) {
                    return Err(LawViolation::NotObjective { increment, off });
                }
            }
        }
        Ok(())
    }

    /// What a stress is measured by (Pa): itself, or the stress of an increment.
    fn scale<L: ConstitutiveLaw>(&self, law: &L, point: &Point<L::State>) -> f64 {
        point.stress.norm().max(law.p_wave_modulus(point.stress, &point.state) * self.strain)
    }

    fn strain_increment(&self, increment: usize, noise: &mut Noise) -> Sym3 {
        let mut random = noise.tensor() - Sym3::IDENTITY * 0.5;
        if self.plane {
            random = Sym3 { zz: 0.0, yz: 0.0, zx: 0.0, ..random };
        }
        match (increment < self.increments / 4, self.plane) {
            (true, false) => Sym3::diagonal(0.0, 0.0, -self.strain),
            (true, true) => Sym3::diagonal(0.0, -self.strain, 0.0),
            (false, _) => random * (self.strain / random.norm()),
        }
    }

    /// The Kelvin components that a strain may have.
    fn components(&self) -> &'static [usize] {
        match self.plane {
            true => &[0, 1, 3],
            false => &[0, 1, 2, 3, 4, 5],
        }
    }

    /// A rotation: one that leaves no axis in place, or one in the plane.
    fn turn(&self) -> Matrix3 {
        let (sin, cos) = 0.9_f64.sin_cos();
        let about_z = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
        if self.plane { about_z } else { about_z * about_x }
    }

    fn nothing_strained_nothing_changed<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
    ) -> Result<(), LawViolation> {
        let change = (point.update(law, increment, Sym3::ZERO)?.stress - point.stress).norm();
        match change <= 1e-12 * self.scale(law, point) {
            true => Ok(()),
            false => Err(LawViolation::Creeps { increment, change }),
        }
    }

    /// Once round, by the steps that a body makes: spins for laws of small increments, deformation gradients for those of finite strain.
    fn a_rigid_rotation_turns_the_stress<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
    ) -> Result<(), LawViolation> {
        let axis = match self.plane {
            true => Vector::<3>::z(),
            false => Vector::<3>::new(0.6, -0.48, 0.64),
        };
        let spin = axis * (std::f64::consts::TAU / STEPS_OF_A_TURN as f64);
        let turn = rotation(&spin);
        let motion = match L::FINITE_STRAIN {
            false => Increment { spin, ..Increment::default() },
            true => Increment::of(&(turn - Matrix3::identity())),
        };
        let (mut stress, mut state, mut turned) = (point.stress, point.state, point.stress);
        for step in 1..=STEPS_OF_A_TURN {
            (stress, state) =
                law.deform(stress, state, &motion).map_err(|source| LawViolation::Failed { increment, source })?;
            turned = turned.rotated(&turn);
            let off = (stress - turned).norm();
            // The rounding of so many products of matrices, and of F − I in laws of finite strain.
            if off.is_nan() || off > 1e-9 * self.scale(law, point) {
                return Err(LawViolation::Turned { increment, degrees: 360 * step / STEPS_OF_A_TURN, off });
            }
        }
        // The product of the steps is the identity to 8e-14 rad a step, see `rotation`.
        let off = (stress - point.stress).norm();
        match off <= 1e-9 * self.scale(law, point) {
            true => Ok(()),
            false => Err(LawViolation::Turned { increment, degrees: 360, off }),
        }
    }

    /// Along each axis and in each plane, by a small compression or shear from the present state.
    fn moduli_bound_the_stiffness<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
    ) -> Result<(), LawViolation> {
        let compression = law.p_wave_modulus(point.stress, &point.state);
        let shear = law.s_wave_modulus(point.stress, &point.state);
        if !(compression.is_finite() && shear.is_finite()) {
            return Err(LawViolation::NotFinite { increment, what: "a wave modulus" });
        }
        let size = 1e-3 * self.strain;
        for &component in self.components() {
            let strain = unit(component) * -size;
            let change = point.update(law, increment, strain)?.stress - point.stress;
            // In Kelvin components the shear stiffness is 2 G.
            let kelvin = change.to_kelvin()[component] / -size;
            // The stiffness may grow over the small increment itself.
            if component < 3 && kelvin > compression * (1.0 + 1e-3) {
                return Err(LawViolation::CompressionModulus { increment, stiffness: kelvin, bound: compression });
            }
            if component >= 3 && 0.5 * kelvin > shear * (1.0 + 1e-3) {
                return Err(LawViolation::ShearModulus { increment, stiffness: 0.5 * kelvin, bound: shear });
            }
        }
        Ok(())
    }

    /// A history that was written and read back answers the next increment as if it had not been.
    fn history_survives_writing<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
        strain: Sym3,
    ) -> Result<(), LawViolation> {
        let state = serde_json::to_string(&point.state)
            .and_then(|text| serde_json::from_str(&text))
            .map_err(|source| LawViolation::Serialization { increment, source })?;
        let restored = Point { state, ..*point };
        let off =
            (restored.update(law, increment, strain)?.stress - point.update(law, increment, strain)?.stress).norm();
        match off <= 1e-12 * self.scale(law, point) {
            true => Ok(()),
            false => Err(LawViolation::HistoryLost { increment, off }),
        }
    }
}

/// The tensor whose Kelvin components are zero but for one, which is 1.
fn unit(component: usize) -> Sym3 {
    Sym3::from_kelvin(&Matrix6::identity().column(component).into_owned())
}

/// The tangent against one-sided and central difference quotients, where the stress has a derivative.
fn tangent_is_the_derivative<L: ConstitutiveLaw>(
    law: &L,
    increment: usize,
    point: &Point<L::State>,
    strain: Sym3,
    columns: &[usize],
) -> Result<(), LawViolation> {
    let tangent =
        law.tangent(point.stress, point.state, strain).map_err(|source| LawViolation::Failed { increment, source })?;
    if !tangent.iter().all(|value| value.is_finite()) {
        return Err(LawViolation::NotFinite { increment, what: "the tangent" });
    }
    // Rounding of the stress over this step is 1e-8 of a modulus, curvature over it 1e-4 of its change in an increment.
    let step = 1e-4 * strain.norm();
    let scale = tangent.norm();
    let center = point.update(law, increment, strain)?.stress.to_kelvin();
    for &column in columns {
        let nudge = unit(column) * step;
        let forward = (point.update(law, increment, strain + nudge)?.stress.to_kelvin() - center) / step;
        let backward = (center - point.update(law, increment, strain - nudge)?.stress.to_kelvin()) / step;
        // A kink, as at first yield: there is no derivative.
        if (forward - backward).norm() > 1e-2 * scale {
            continue;
        }
        let off = ((forward + backward) * 0.5 - tangent.column(column)).norm();
        if off > 1e-4 * scale {
            return Err(LawViolation::Tangent { increment, column, off });
        }
    }
    Ok(())
}

fn outputs_are_written<L: ConstitutiveLaw>(
    law: &L,
    increment: usize,
    point: &Point<L::State>,
) -> Result<(), LawViolation> {
    let names = law.outputs();
    let mut values = vec![f64::NAN; names.len()];
    law.write_outputs(point.stress, &point.state, &mut values);
    match names.iter().zip(&values).find(|(_, value)| !value.is_finite()) {
        Some((name, _)) => Err(LawViolation::Output { increment, name }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};
    use tsutsumi::law::{Hencky, NeoHookean};

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
}
