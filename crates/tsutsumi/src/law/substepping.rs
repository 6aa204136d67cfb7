//! Explicit integration of elasto-plastic rate equations with sub-steps whose error is controlled.
//!
//! One implementation for all laws that are given as rates: the law implements [`PlasticRates`], and [`SubStepping::integrate`] finds where
//! the stress meets the yield surface and follows the plastic rates from there.
//!
//! # Equation
//!
//! ```text
//! y₁ = y + Δy(y),   y₂ = y + ½ [Δy(y) + Δy(y₁)]        error = ½ |Δσ(y₁) − Δσ(y)| / scale
//! next size = size · 0.9 √(tolerance / error), between a tenth and four times the last
//! ```
//!
//! # Reference
//!
//! S. W. Sloan, A. J. Abbo and D. Sheng (2001), Eng. Comput. 18, 121–194 (the scheme; cited from memory). Crossings are found by the
//! Illinois variant of the false position with bisection as its guard.

use std::fmt;

use super::LawError;
use crate::tensor::Sym3;

/// Stress and history of a material point, or changes of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressPoint<S> {
    /// The effective stress (Pa, positive in tension).
    pub stress: Sym3,
    /// The history.
    pub state: S,
}

/// Why the rates of a law have no answer at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoRates {
    /// The stress is beyond the apex of the surfaces.
    BeyondApex,
    /// Plastic strain lowers the stress faster than the elastic strain it replaces.
    SnapBack {
        /// The modulus (Pa) by which plastic loading divides; not positive.
        modulus: f64,
    },
}

/// The rate equations of an elasto-plastic law.
pub trait PlasticRates {
    /// The history, and at the same time a change of it.
    type State: Copy + fmt::Debug;

    /// The yield function (–): negative inside, zero on the yield surface, positive outside, made dimensionless by a size of the stress.
    fn yield_function(&self, at: &StressPoint<Self::State>) -> f64;

    /// The point after an elastic strain increment (–).
    fn elastic(&self, at: &StressPoint<Self::State>, strain: Sym3) -> StressPoint<Self::State>;

    /// How fast an elastic strain increment (–) leads out of the yield surface from a point on it, in any measure; negative where the point
    /// unloads.
    ///
    /// Asked before the first sub-step and after each: what unloads within an increment is elastic until it meets the surface again.
    fn drive(&self, at: &StressPoint<Self::State>, strain: Sym3) -> f64;

    /// The changes over a strain increment (–) at the rates that hold at a point; without plastic strain where it unloads.
    ///
    /// # Errors
    /// [`NoRates`] where the rates have no answer.
    fn change(&self, at: &StressPoint<Self::State>, strain: Sym3) -> Result<StressPoint<Self::State>, NoRates>;

    /// A history and a change of it, times a factor.
    fn add(&self, state: &Self::State, change: &Self::State, factor: f64) -> Self::State;

    /// The largest sub-step, as a fraction of a strain increment, in which disturbances do not grow.
    ///
    /// The error does not show this limit on a path of constant direction. With a yield surface of radius R (Pa) the stress turns into the
    /// direction of straining at the rate 2G |ė|/R, and the modified Euler method is stable up to a turn of 2.
    fn stable_sub_step(&self, _at: &StressPoint<Self::State>, _strain: Sym3) -> f64 {
        1.0
    }

    /// How far two changes of a point are apart, relative to its stress at the end (Pa); twice the error of a sub-step (–).
    ///
    /// Where settling draws the stress to the history, as to the axis of a narrow cone, the history belongs in it.
    fn distance(&self, stress: Sym3, first: &StressPoint<Self::State>, second: &StressPoint<Self::State>) -> f64;

    /// The point after the drift from the yield surface is taken back. Called where the stress meets the yield surface and after every
    /// sub-step, so that reversals can be noted here, too.
    fn settle(&self, at: StressPoint<Self::State>) -> StressPoint<Self::State>;
}

/// Where sub-stepping gave up: everything that is needed to do it again.
#[derive(Debug, Clone, PartialEq)]
pub struct SubStepFailure {
    /// The effective stress at the start of the increment (Pa).
    pub stress: Sym3,
    /// The history at the start of the increment, as Rust writes it.
    pub history: String,
    /// The strain increment (–).
    pub strain: Sym3,
    /// The fraction of the increment that was done.
    pub done: f64,
    /// The error of the smallest sub-step relative to the stress; infinite if it has no answer at all.
    pub error: f64,
}

impl fmt::Display for SubStepFailure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SubStepFailure { stress, history, strain, done, error } = self;
        write!(
            formatter,
            "the smallest sub-step has an error of {error:.1e} after {:.2} % of the increment",
            100.0 * done
        )?;
        write!(formatter, "; stress {stress}; strain increment {strain}; history {history}")
    }
}

/// How finely rates are integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubStepping {
    /// The largest error of a sub-step relative to the stress (–).
    pub tolerance: f64,
    /// The smallest sub-step, as a fraction of the increment (–).
    pub smallest: f64,
    /// How far from zero the yield function may be on the yield surface (–).
    pub yield_tolerance: f64,
}

/// The first trial fraction of an increment that looks for a stress inside the yield surface.
const PROBE: f64 = 1.0 / 1024.0;
/// The least part of a sub-step that is taken to where unloading begins.
const LEAST_PART: f64 = 0.1;
/// Halving the bracket this often ends in neighbouring numbers.
const MOST_ITERATIONS: usize = 60;

/// How far a strain increment has been followed.
struct Path<S> {
    point: StressPoint<S>,
    /// The whole increment (–).
    strain: Sym3,
    /// The fraction of it that is left.
    left: f64,
    /// The fraction of it that the next sub-step tries.
    size: f64,
}

/// Why a path cannot be followed any further.
enum Stop {
    NoRates(NoRates),
    /// The error of the smallest sub-step.
    Inaccurate(f64),
}

impl SubStepping {
    /// The point after a strain increment (–): elastic up to the yield surface, along the plastic rates from there, and elastic again
    /// wherever it unloads.
    ///
    /// # Errors
    /// [`LawError::SubSteps`] if the smallest sub-step is not accurate enough or the stress is beyond the apex, [`LawError::SnapBack`].
    #[inline]
    pub fn integrate<R: PlasticRates>(
        &self,
        rates: &R,
        start: StressPoint<R::State>,
        strain: Sym3,
    ) -> Result<StressPoint<R::State>, LawError> {
        let mut path = Path { point: start, strain, left: 1.0, size: 1.0 };
        let mut unloads = None;
        while path.left > f64::EPSILON {
            let rest = strain * path.left;
            let at_start = rates.yield_function(&path.point);
            if at_start < -self.yield_tolerance || unloads.unwrap_or_else(|| rates.drive(&path.point, strain) < 0.0) {
                let trial = rates.elastic(&path.point, rest);
                let at_end = rates.yield_function(&trial);
                if at_end <= self.yield_tolerance {
                    return Ok(trial);
                }
                let fraction = self.elastic_fraction(rates, &path.point, rest, (at_start, at_end));
                path.point = if fraction > 0.0 { rates.elastic(&path.point, rest * fraction) } else { path.point };
                path.left *= 1.0 - fraction;
            }
            path.point = rates.settle(path.point);
            let stopped = self.plastic(rates, &mut path).map_err(|stop| failure(stop, &start, &path))?;
            unloads = Some(stopped);
        }
        Ok(path.point)
    }

    /// The fraction of an increment at which an elastic path, from inside or on its way in, leaves the yield surface for good. With the
    /// yield function at both ends.
    ///
    /// The yield function is taken to be convex along the elastic path: a path that leaves the surface inwards comes back once.
    fn elastic_fraction<R: PlasticRates>(
        &self,
        rates: &R,
        start: &StressPoint<R::State>,
        strain: Sym3,
        (at_start, at_end): (f64, f64),
    ) -> f64 {
        let value = |fraction| rates.yield_function(&rates.elastic(start, strain * fraction));
        let (mut fraction, mut inside) = (0.0_f64, at_start);
        while inside >= -self.yield_tolerance && fraction < 1.0 {
            fraction = (2.0 * fraction).max(PROBE);
            inside = value(fraction);
        }
        match fraction < 1.0 {
            true => root(value, (fraction, inside), (1.0, at_end), self.yield_tolerance),
            false => 0.0,
        }
    }

    /// Follows the plastic rates from the yield surface, for one sub-step at least, to the end of the increment or to where it unloads:
    /// that is the answer.
    #[inline(always)]
    fn plastic<R: PlasticRates>(&self, rates: &R, path: &mut Path<R::State>) -> Result<bool, Stop> {
        let mut drive = rates.drive(&path.point, path.strain);
        while path.left > f64::EPSILON {
            let (point, left) = (path.point, path.left);
            self.advance(rates, path)?;
            let drive_old = std::mem::replace(&mut drive, rates.drive(&path.point, path.strain));
            if drive >= 0.0 {
                continue;
            }
            if drive_old > 0.0 {
                // Taken again to where unloading begins, but for a part that is sure to go on: so the answer has no jumps.
                let taken = left - path.left;
                (path.point, path.left) = (point, left);
                path.size = taken * (drive_old / (drive_old - drive)).max(LEAST_PART);
                self.advance(rates, path)?;
            }
            return Ok(true);
        }
        Ok(false)
    }

    /// One plastic sub-step, as long as its error allows.
    #[inline(always)]
    fn advance<R: PlasticRates>(&self, rates: &R, path: &mut Path<R::State>) -> Result<(), Stop> {
        path.size = path.size.min(path.left).min(rates.stable_sub_step(&path.point, path.strain));
        loop {
            let part = path.strain * path.size;
            // Where the point itself has no answer, no shorter sub-step has one.
            let first = rates.change(&path.point, part).map_err(Stop::NoRates)?;
            let (error, stop) = match sub_step(rates, &path.point, &first, part) {
                Ok((next, error)) if error <= self.tolerance => {
                    path.point = rates.settle(next);
                    path.left -= path.size;
                    path.size *= (0.9 * (self.tolerance / error).sqrt()).clamp(0.1, 4.0);
                    return Ok(());
                }
                Ok((_, error)) => (error, Stop::Inaccurate(error)),
                Err(no_rates) => (f64::INFINITY, Stop::NoRates(no_rates)),
            };
            if path.size <= self.smallest {
                return Err(stop);
            }
            path.size = (path.size * (0.9 * (self.tolerance / error).sqrt()).max(0.1)).max(self.smallest);
        }
    }
}

/// One step of the modified Euler method from its first change, and its error relative to the stress.
#[inline(always)]
fn sub_step<R: PlasticRates>(
    rates: &R,
    at: &StressPoint<R::State>,
    first: &StressPoint<R::State>,
    strain: Sym3,
) -> Result<(StressPoint<R::State>, f64), NoRates> {
    let euler = StressPoint { stress: at.stress + first.stress, state: rates.add(&at.state, &first.state, 1.0) };
    let second = rates.change(&euler, strain)?;
    let stress = at.stress + (first.stress + second.stress) * 0.5;
    let state = rates.add(&rates.add(&at.state, &first.state, 0.5), &second.state, 0.5);
    let error = 0.5 * rates.distance(stress, first, &second);
    // A sub-step without a number as its error is as bad as can be.
    Ok((StressPoint { stress, state }, if error.is_nan() { f64::INFINITY } else { error }))
}

/// What is said where a path cannot be followed.
#[cold]
fn failure<S: fmt::Debug>(stop: Stop, start: &StressPoint<S>, path: &Path<S>) -> LawError {
    let error = match stop {
        Stop::NoRates(NoRates::SnapBack { modulus }) => return LawError::SnapBack { modulus },
        Stop::NoRates(NoRates::BeyondApex) => f64::INFINITY,
        Stop::Inaccurate(error) => error,
    };
    LawError::SubSteps(Box::new(SubStepFailure {
        stress: start.stress,
        history: format!("{:?}", start.state),
        strain: path.strain,
        done: 1.0 - path.left,
        error,
    }))
}

/// A root of a function that changes its sign between two points (argument, value).
///
/// The end is the first argument whose value is within the tolerance, or, where rounding does not allow that, the best.
fn root(function: impl Fn(f64) -> f64, mut a: (f64, f64), mut b: (f64, f64), tolerance: f64) -> f64 {
    for iteration in 0..MOST_ITERATIONS {
        // Every third step halves the bracket, so that a flat function cannot hold it up.
        let next = match iteration % 3 {
            2 => 0.5 * (a.0 + b.0),
            _ => b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1),
        };
        let value = function(next);
        if value.abs() <= tolerance {
            return next;
        }
        match (value < 0.0) == (a.1 < 0.0) {
            true => (a, b.1) = ((next, value), 0.5 * b.1),
            false => (b, a.1) = ((next, value), 0.5 * a.1),
        }
    }
    0.5 * (a.0 + b.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: SubStepping = SubStepping { tolerance: 1e-6, smallest: 1e-6, yield_tolerance: 1e-9 };

    /// A stress that grows towards a limit, dσ = E (1 − σ/σ_∞) dε, from the first strain on: σ = σ_∞ (1 − exp(−E ε/σ_∞)).
    struct Saturation;

    const LIMIT: f64 = 1e5;
    const MODULUS: f64 = 1e7;

    impl PlasticRates for Saturation {
        type State = ();

        fn yield_function(&self, at: &StressPoint<()>) -> f64 {
            at.stress.xx / LIMIT
        }

        fn elastic(&self, at: &StressPoint<()>, strain: Sym3) -> StressPoint<()> {
            StressPoint { stress: at.stress + strain * MODULUS, state: () }
        }

        fn drive(&self, _: &StressPoint<()>, strain: Sym3) -> f64 {
            strain.xx
        }

        fn change(&self, at: &StressPoint<()>, strain: Sym3) -> Result<StressPoint<()>, NoRates> {
            Ok(StressPoint { stress: strain * (MODULUS * (1.0 - at.stress.xx / LIMIT)), state: () })
        }

        fn add(&self, (): &(), (): &(), _: f64) {}

        fn distance(&self, _: Sym3, first: &StressPoint<()>, second: &StressPoint<()>) -> f64 {
            (second.stress - first.stress).norm() / LIMIT
        }

        fn settle(&self, at: StressPoint<()>) -> StressPoint<()> {
            at
        }
    }

    /// The relative error at 2 % strain, where the exact stress is σ_∞ (1 − e⁻²).
    fn saturation_error(settings: SubStepping, increments: usize) -> f64 {
        let strain = Sym3::diagonal(0.02 / increments as f64, 0.0, 0.0);
        let start = StressPoint { stress: Sym3::ZERO, state: () };
        let end = (0..increments).fold(start, |at, _| settings.integrate(&Saturation, at, strain).unwrap());
        (end.stress.xx / LIMIT - (1.0 - (-2.0_f64).exp())).abs()
    }

    #[test]
    fn one_sub_step_an_increment_is_of_second_order() {
        let coarse = SubStepping { tolerance: 1.0, ..FINE };
        let errors = [64, 128, 256].map(|increments| saturation_error(coarse, increments));
        for pair in errors.windows(2) {
            // Increments of 1/32 of the relaxation strain: the next term of the error is a few hundredths of the leading one.
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.05, "{order} {errors:?}");
        }
    }

    #[test]
    fn the_error_follows_its_tolerance() {
        for tolerance in [1e-3, 1e-4, 1e-5, 1e-6] {
            let error = saturation_error(SubStepping { tolerance, ..FINE }, 1);
            // The estimate is the error of Euler's method: that of the stress that is kept is smaller, over all sub-steps about as large.
            assert!(error < tolerance && error > 1e-3 * tolerance, "{error:e} at {tolerance:e}");
        }
    }

    /// Von Mises' perfect plasticity, in shear alone: |s| ≤ R.
    struct Perfect;

    const SHEAR_MODULUS: f64 = 10e6;
    const RADIUS: f64 = 50e3;

    impl PlasticRates for Perfect {
        type State = ();

        fn yield_function(&self, at: &StressPoint<()>) -> f64 {
            at.stress.norm() / RADIUS - 1.0
        }

        fn elastic(&self, at: &StressPoint<()>, strain: Sym3) -> StressPoint<()> {
            StressPoint { stress: at.stress + strain * (2.0 * SHEAR_MODULUS), state: () }
        }

        fn drive(&self, at: &StressPoint<()>, strain: Sym3) -> f64 {
            at.stress.double_dot(strain)
        }

        fn change(&self, at: &StressPoint<()>, strain: Sym3) -> Result<StressPoint<()>, NoRates> {
            let normal = at.stress * (1.0 / at.stress.norm());
            let loading = normal.double_dot(strain).max(0.0);
            Ok(StressPoint { stress: (strain - normal * loading) * (2.0 * SHEAR_MODULUS), state: () })
        }

        fn add(&self, (): &(), (): &(), _: f64) {}

        fn distance(&self, _: Sym3, first: &StressPoint<()>, second: &StressPoint<()>) -> f64 {
            (second.stress - first.stress).norm() / RADIUS
        }

        fn settle(&self, at: StressPoint<()>) -> StressPoint<()> {
            StressPoint { stress: at.stress * (RADIUS / at.stress.norm()).min(1.0), state: () }
        }
    }

    fn shear(xy: f64, yz: f64) -> Sym3 {
        Sym3 { xy, yz, ..Sym3::ZERO }
    }

    /// On the surface, at the angle ψ to a constant strain rate: tan(ψ/2) = tan(ψ₀/2) exp(−2G |Δε|/R) (R. D. Krieg and D. B. Krieg 1977).
    #[test]
    fn perfect_plasticity_turns_into_the_direction_of_straining_as_krieg_and_krieg_say() {
        let start = StressPoint { stress: shear(RADIUS / 2.0_f64.sqrt(), 0.0), state: () };
        for length in [1e-4, 1e-3, 5e-3] {
            let strain = shear(0.0, length / 2.0_f64.sqrt());
            let end = FINE.integrate(&Perfect, start, strain).unwrap().stress;
            let exact = 2.0 * (-2.0 * SHEAR_MODULUS * length / RADIUS).exp().atan();
            // The tolerance of a sub-step, over fewer than a thousand of them whose errors fade.
            assert!((end.xy.atan2(end.yz) - exact).abs() < 1e-5, "{length}");
            assert!((end.norm() - RADIUS).abs() < 1e-9 * RADIUS);
        }
    }

    /// Shear back and forth: elastic within 2R, perfectly plastic beyond, whatever the increments.
    #[test]
    fn crossings_are_found_from_inside_from_the_surface_and_after_unloading() {
        let yield_strain = RADIUS / (2.0 * SHEAR_MODULUS) / 2.0_f64.sqrt();
        let at = |fraction: f64| StressPoint { stress: shear(fraction * RADIUS / 2.0_f64.sqrt(), 0.0), state: () };
        for (start, strain, end) in
            [(0.3, 5.0, 1.0), (1.0, 0.7, 1.0), (1.0, -0.5, 0.5), (1.0, -7.0, -1.0), (-1.0, 2.5, 1.0)]
        {
            let stress = FINE.integrate(&Perfect, at(start), shear(strain * yield_strain, 0.0)).unwrap().stress;
            let off = (stress - at(end).stress).norm() / RADIUS;
            assert!(off < 1e-9, "{start} {strain}: {off:e}");
        }
        // Unloading along a chord: the path is elastic until it meets the circle again.
        let strain = shear(-2.0, 1.0) * yield_strain;
        let at_end = Perfect.yield_function(&Perfect.elastic(&at(1.0), strain));
        let fraction = FINE.elastic_fraction(&Perfect, &at(1.0), strain, (0.0, at_end));
        // (1 − 2t)² + t² = 1.
        assert!((fraction - 0.8).abs() < 1e-8, "{fraction}");
    }

    /// A cone |s| ≤ M p in shear, K = k p, constant G, no dilatancy.
    struct Cone;

    const BULK_RATE: f64 = 200.0;
    const SLOPE: f64 = 0.5;

    impl Cone {
        fn elastic_stress(stress: Sym3, strain: Sym3) -> Sym3 {
            let pressure = stress.pressure() * (-BULK_RATE * strain.trace()).exp();
            stress.deviator() + strain.deviator() * (2.0 * SHEAR_MODULUS) - Sym3::IDENTITY * pressure
        }
    }

    impl PlasticRates for Cone {
        type State = ();

        fn yield_function(&self, at: &StressPoint<()>) -> f64 {
            at.stress.deviator().norm() / at.stress.pressure() - SLOPE
        }

        fn elastic(&self, at: &StressPoint<()>, strain: Sym3) -> StressPoint<()> {
            StressPoint { stress: Cone::elastic_stress(at.stress, strain), state: () }
        }

        fn drive(&self, at: &StressPoint<()>, strain: Sym3) -> f64 {
            let deviator = at.stress.deviator();
            2.0 * SHEAR_MODULUS * deviator.double_dot(strain) / deviator.norm()
                + SLOPE * BULK_RATE * at.stress.pressure() * strain.trace()
        }

        fn change(&self, at: &StressPoint<()>, strain: Sym3) -> Result<StressPoint<()>, NoRates> {
            let deviator = at.stress.deviator();
            let volumetric = Sym3::IDENTITY * (BULK_RATE * at.stress.pressure() * strain.trace());
            let plastic = deviator * (self.drive(at, strain).max(0.0) / deviator.norm());
            Ok(StressPoint { stress: strain.deviator() * (2.0 * SHEAR_MODULUS) + volumetric - plastic, state: () })
        }

        fn add(&self, (): &(), (): &(), _: f64) {}

        fn distance(&self, stress: Sym3, first: &StressPoint<()>, second: &StressPoint<()>) -> f64 {
            (second.stress - first.stress).norm() / stress.pressure()
        }

        fn settle(&self, at: StressPoint<()>) -> StressPoint<()> {
            let (pressure, deviator) = (at.stress.pressure(), at.stress.deviator());
            let factor = (SLOPE * pressure / deviator.norm()).min(1.0);
            StressPoint { stress: deviator * factor - Sym3::IDENTITY * pressure, state: () }
        }
    }

    /// Shear and compression together, from the cone: the stress stays on it while 2G de > M k p dε_v, then p grows too fast. From there on
    /// both parts are elastic: s = M p* + 2G (e − e*), with p* = 2G e/(M k ε_v).
    #[test]
    fn unloading_within_an_increment_is_elastic() {
        let (pressure, volumetric) = (100e3, 5e-3);
        // Unloading begins after these fractions of the increment.
        for at in [0.1_f64, 0.5, 0.73, 0.95] {
            let left = pressure * (BULK_RATE * volumetric * at).exp();
            let shear_strain = left * SLOPE * BULK_RATE * volumetric / (2.0 * SHEAR_MODULUS);
            let direction = shear(1.0 / 2.0_f64.sqrt(), 0.0);
            let start = StressPoint { stress: direction * (SLOPE * pressure) - Sym3::IDENTITY * pressure, state: () };
            let strain = direction * shear_strain - Sym3::IDENTITY * (volumetric / 3.0);
            let end = SubStepping { tolerance: 1e-4, ..FINE }.integrate(&Cone, start, strain).unwrap().stress;
            let exact = SLOPE * left + 2.0 * SHEAR_MODULUS * shear_strain * (1.0 - at);
            let off = (end.deviator().norm() / exact - 1.0).abs();
            // The drive turns linearly: a sub-step that ends where it is zero to first order is as good as its tolerance.
            assert!(off < 1e-4, "{at}: {off:e}");
            assert!((end.pressure() / (pressure * (BULK_RATE * volumetric).exp()) - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn roots_of_flat_and_steep_functions() {
        for power in [1, 3, 9] {
            let found = root(|x: f64| x.powi(power) - 0.1, (0.0, -0.1), (1.0, 0.9), 1e-12);
            // d(x^n) = n x^(n−1) dx, at least 0.77 here.
            assert!((found - 0.1_f64.powf(1.0 / f64::from(power))).abs() < 2e-12, "{power}: {found}");
        }
    }

    /// Rates that are nowhere.
    struct Nowhere;

    impl PlasticRates for Nowhere {
        type State = u8;

        fn yield_function(&self, _: &StressPoint<u8>) -> f64 {
            1.0
        }

        fn elastic(&self, at: &StressPoint<u8>, _: Sym3) -> StressPoint<u8> {
            *at
        }

        fn drive(&self, _: &StressPoint<u8>, _: Sym3) -> f64 {
            1.0
        }

        fn change(&self, _: &StressPoint<u8>, _: Sym3) -> Result<StressPoint<u8>, NoRates> {
            Err(NoRates::BeyondApex)
        }

        fn add(&self, state: &u8, _: &u8, _: f64) -> u8 {
            *state
        }

        fn distance(&self, _: Sym3, _: &StressPoint<u8>, _: &StressPoint<u8>) -> f64 {
            1.0
        }

        fn settle(&self, at: StressPoint<u8>) -> StressPoint<u8> {
            at
        }
    }

    #[test]
    fn where_there_is_no_answer_the_error_carries_the_point() {
        let start = StressPoint { stress: shear(7.0, 0.0), state: 42 };
        let error = FINE.integrate(&Nowhere, start, shear(1e-3, 0.0)).unwrap_err();
        let LawError::SubSteps(failure) = &error else { panic!("{error}") };
        assert_eq!((failure.stress, failure.strain, failure.history.as_str()), (start.stress, shear(1e-3, 0.0), "42"));
        assert_eq!((failure.done, failure.error), (0.0, f64::INFINITY));
        assert!(error.to_string().contains("xy 7.000e0"), "{error}");
    }
}
