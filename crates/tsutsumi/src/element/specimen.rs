use nalgebra::Vector6;

use super::{Condition, ElementError, SpecimenState};
use crate::law::{ConstitutiveLaw, Group, Increment, MaterialGroup};
use crate::tensor::{Matrix6, Sym3};

/// Newton iterations before an increment is given up.
const MAX_ITERATIONS: usize = 25;
/// Halvings of a Newton step in search of a smaller residual.
const MAX_HALVINGS: usize = 10;
/// The part of the promised decrease of the residual that a step has to bring (Armijo's rule).
const DECREASE: f64 = 1e-4;
/// What is left of a condition, relative to the largest stress (or strain) of the test so far.
const TOLERANCE: f64 = 1e-9;

/// The largest strain that a residual may ask for, as a multiple of the strain that it is worth along its own condition. Beyond, the
/// material is taken to have no stiffness left in some direction: tangents by differences are noise there.
const LARGEST_GAIN: f64 = 1e6;

/// Iterations of the decomposition that finds the shortest step.
const MAX_SWEEPS: usize = 100;

/// One material point: a law with its stress, strain and history.
pub struct Specimen {
    group: Box<dyn MaterialGroup>,
    stress: Sym3,
    strain: Sym3,
    /// The time of the increments that took one (s).
    time: f64,
    tolerance: f64,
    /// The largest stress so far (Pa): residuals are held against it, so that a state without stress can be reached.
    largest_stress: f64,
}

/// A strain increment that meets the conditions; nothing has been done with it yet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution {
    /// The strain increment (–).
    pub increment: Sym3,
    /// The stress at its end (Pa).
    pub stress: Sym3,
    /// How long it takes (s); infinite where time plays no part.
    pub duration: f64,
    /// Newton iterations made.
    pub iterations: usize,
}

/// What an increment has to bring.
#[derive(Clone, Copy)]
struct Wanted<'a> {
    conditions: &'a [Condition; 6],
    values: &'a [f64; 6],
    duration: f64,
}

/// How far a strain increment is from what is wanted.
struct Attempt {
    increment: Sym3,
    stress: Sym3,
    tangent: Matrix6,
    residual: Vector6<f64>,
}

impl Specimen {
    /// A specimen of a law with this effective stress (Pa); its strain is zero.
    pub fn new<L: ConstitutiveLaw>(law: L, stress: Sym3) -> Self {
        Self::of_group(Box::new(Group::new("specimen", law, 0..1, [stress])), stress)
    }

    /// A specimen of a law that was chosen at run time: the first particle of a group that starts with this effective stress (Pa).
    pub fn of_group(group: Box<dyn MaterialGroup>, stress: Sym3) -> Self {
        let largest_stress = stress.to_kelvin().norm();
        Specimen { group, stress, strain: Sym3::ZERO, time: 0.0, tolerance: TOLERANCE, largest_stress }
    }

    /// The same with another tolerance (–): what is left of each condition, relative to the largest stress so far, or to the strain.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Specimen { tolerance, ..self }
    }

    /// The effective stress (Pa).
    pub fn stress(&self) -> Sym3 {
        self.stress
    }

    /// The strain since the start (–): the sum of the increments. With laws of finite strain that is the logarithmic strain, to the first
    /// order of the increments.
    pub fn strain(&self) -> Sym3 {
        self.strain
    }

    /// The time since the start (s): the sum of the durations that were not infinite.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Counts the strain from here on. Stress and history stay.
    pub fn zero_strain(&mut self) {
        self.strain = Sym3::ZERO;
    }

    /// The names of the law's own output quantities.
    pub fn outputs(&self) -> &'static [&'static str] {
        self.group.outputs()
    }

    /// The values of the law's own output quantities.
    pub fn output_values(&self) -> Vec<f64> {
        let mut values = vec![0.0; self.group.outputs().len()];
        self.group.write_outputs(0, self.stress, &mut values);
        values
    }

    /// The strain increment after which the conditions have the wanted values, by Newton's method with a line search. The specimen stays
    /// as it is.
    ///
    /// # Errors
    /// The law's, [`ElementError::NotConverged`] and [`ElementError::Singular`]; a smaller change of the values may still be possible.
    pub fn solve(&self, conditions: &[Condition; 6], wanted: &[f64; 6]) -> Result<Solution, ElementError> {
        self.solve_within(conditions, wanted, f64::INFINITY)
    }

    /// The same for an increment that takes so long (s).
    ///
    /// # Errors
    /// Those of [`Specimen::solve`].
    pub fn solve_within(
        &self,
        conditions: &[Condition; 6],
        values: &[f64; 6],
        duration: f64,
    ) -> Result<Solution, ElementError> {
        let wanted = Wanted { conditions, values, duration };
        let mut attempt = self.attempt(wanted, Sym3::ZERO)?;
        let mut iterations = 0;
        loop {
            let excess = self.excess(conditions, &attempt);
            if excess <= 1.0 {
                let Attempt { increment, stress, .. } = attempt;
                return Ok(Solution { increment, stress, duration, iterations });
            }
            if iterations == MAX_ITERATIONS {
                return Err(self.not_converged(iterations, excess, attempt.increment));
            }
            iterations += 1;
            attempt = self.improved(wanted, &attempt, iterations)?;
        }
    }

    /// Makes an increment the specimen's own.
    ///
    /// # Errors
    /// The law's.
    pub fn accept(&mut self, solution: &Solution) -> Result<(), ElementError> {
        let Solution { increment: strain, duration, .. } = *solution;
        self.undergo(&Increment { strain, duration, ..Increment::default() })
    }

    /// Undergoes a motion as it is, without conditions.
    ///
    /// # Errors
    /// The law's.
    pub fn undergo(&mut self, increment: &Increment) -> Result<(), ElementError> {
        let mut stress = [self.stress];
        let outcome = self.group.update_block(0, &mut stress, std::slice::from_ref(increment), &[1.0]);
        if let Some(failure) = outcome.failure {
            return Err(ElementError::Law { source: failure.source, state: SpecimenState::of(self, increment.strain) });
        }
        self.stress = stress[0];
        self.strain += increment.strain;
        self.time += if increment.duration.is_finite() { increment.duration } else { 0.0 };
        self.largest_stress = self.largest_stress.max(self.stress.to_kelvin().norm());
        Ok(())
    }

    fn attempt(&self, wanted: Wanted, increment: Sym3) -> Result<Attempt, ElementError> {
        let Wanted { conditions, values, duration } = wanted;
        let (stress, tangent) = self
            .group
            .trial(0, self.stress, increment, duration)
            .map_err(|source| ElementError::Law { source, state: SpecimenState::of(self, increment) })?;
        let strain = self.strain + increment;
        let residual = Vector6::from_fn(|i, _| conditions[i].value(stress, strain) - values[i]);
        Ok(Attempt { increment, stress, tangent, residual })
    }

    /// The largest residual over what is tolerated.
    fn excess(&self, conditions: &[Condition; 6], attempt: &Attempt) -> f64 {
        let stress = self.largest_stress.max(attempt.stress.to_kelvin().norm());
        let strain = (self.strain + attempt.increment).to_kelvin().norm().max(attempt.increment.to_kelvin().norm());
        let excess = |(condition, residual): (&Condition, &f64)| {
            let [of_stress, of_strain] = [condition.stress, condition.strain].map(|c| c.to_kelvin().norm());
            let tolerated = self.tolerance * (of_stress * stress + of_strain * strain);
            if *residual == 0.0 { 0.0 } else { residual.abs() / tolerated }
        };
        // A residual that is not a number must not pass for a small one.
        conditions
            .iter()
            .zip(attempt.residual.iter())
            .map(excess)
            .fold(0.0, |a, b| if b >= a || b.is_nan() { b } else { a })
    }

    /// The attempt after a Newton step, shortened until the residual falls.
    fn improved(&self, wanted: Wanted, attempt: &Attempt, iterations: usize) -> Result<Attempt, ElementError> {
        let conditions = wanted.conditions;
        let mut jacobian = Matrix6::zeros();
        for (i, condition) in conditions.iter().enumerate() {
            let row =
                condition.stress.to_kelvin().transpose() * attempt.tangent + condition.strain.to_kelvin().transpose();
            jacobian.set_row(i, &row);
        }
        // Rows of stress and of strain differ by the stiffness: each is weighed with what a strain does to it.
        // A row of zeros, of a material without stiffness, has no weight to give.
        let weights =
            Vector6::from_fn(|i, _| Some(jacobian.row(i).norm()).filter(|norm| *norm > 0.0).map_or(1.0, f64::recip));
        let weighed = Matrix6::from_fn(|i, j| weights[i] * jacobian[(i, j)]);
        let residual = attempt.residual.component_mul(&weights);
        let (step, is_open) = newton_step(&weighed, &residual);
        let before = residual.norm();
        let mut failure = None;
        for halving in 0..=MAX_HALVINGS {
            let share = 0.5_f64.powi(halving as i32);
            let increment = attempt.increment + Sym3::from_kelvin(&(step * share));
            match self.attempt(wanted, increment) {
                Ok(next) if next.residual.component_mul(&weights).norm() <= (1.0 - DECREASE * share) * before => {
                    return Ok(next);
                }
                Ok(_) => {}
                Err(error) => failure = Some(error),
            }
        }
        let excess = self.excess(conditions, attempt);
        let in_vain = || match is_open {
            true => ElementError::Singular { state: SpecimenState::of(self, attempt.increment) },
            false => self.not_converged(iterations, excess, attempt.increment),
        };
        Err(failure.unwrap_or_else(in_vain))
    }

    fn not_converged(&self, iterations: usize, excess: f64, increment: Sym3) -> ElementError {
        let residual = excess * self.tolerance;
        ElementError::NotConverged { iterations, residual, state: SpecimenState::of(self, increment) }
    }
}

/// The step of Newton's method, and whether the conditions leave it open. Then it is the shortest one: at an edge of a yield surface without
/// hardening the stress does not tell all of the strain, and something has to.
fn newton_step(jacobian: &Matrix6, residual: &Vector6<f64>) -> (Vector6<f64>, bool) {
    let full = jacobian.lu().solve(&-residual);
    match full.filter(|step| step.norm() <= LARGEST_GAIN * residual.norm()) {
        Some(step) => (step, false),
        None => {
            // No answer, as for a matrix with a NaN, is a step that leads nowhere: the search ends in vain.
            let parts = jacobian.try_svd(true, true, f64::EPSILON, MAX_SWEEPS);
            let shortest = parts.and_then(|parts| {
                let least = parts.singular_values.max() / LARGEST_GAIN;
                parts.solve(&-residual, least).ok()
            });
            (shortest.unwrap_or_else(Vector6::zeros), true)
        }
    }
}
