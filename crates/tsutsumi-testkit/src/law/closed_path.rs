//! The work of closed paths of strain, against what the law promises of it.

use tsutsumi::law::{ClosedPathWork, ConstitutiveLaw, Increment, LawError};
use tsutsumi::tensor::{Matrix3, Sym3};

use super::{LawPath, LawViolation, Point};
use crate::noise::Noise;

/// Increments of a side of a path in its finer run; the coarser one has half of them.
const PARTS: usize = 32;
/// Rounding, relative to the work of a side: 128 increments of stresses that are right to 1e-15 leave 1e-13; laws with a history of volume and a
/// stiffness far above their stress (water) lose three more digits.
const ROUNDING: f64 = 1e-10;

/// A closed path of strain: corners to go round, from and back to no strain.
struct ClosedPath {
    name: &'static str,
    corners: Vec<Sym3>,
}

/// A material point on a closed path, with the deformation gradient since the corner it began in (that of small strains is I + ε), and the
/// work so far (J/m³).
struct Traveller<S> {
    point: Point<S>,
    strain: Sym3,
    work: f64,
}

impl<S: Copy> Traveller<S> {
    /// The point after a step to another strain.
    fn to<L: ConstitutiveLaw<State = S>>(&self, law: &L, strain: Sym3) -> Result<Self, LawError> {
        let Point { stress, state, duration } = self.point;
        let change = strain - self.strain;
        let ((stress_new, state), power) = match L::FINITE_STRAIN {
            false => {
                let answer = law.update_within(stress, state, change, duration)?;
                (answer, (stress + answer.0).double_dot(change))
            }
            true => {
                let [from, to] = [self.strain, strain].map(deformation);
                // The step's own gradient F F_old⁻¹ − I, of a stretch that is near I.
                let inverse = from.try_inverse().unwrap_or_else(Matrix3::identity);
                let motion = Increment::of(&(change.to_matrix() * inverse)).within(duration);
                let answer = law.deform(stress, state, &motion)?;
                let nominal = nominal_stress(stress, &from) + nominal_stress(answer.0, &to);
                (answer, (nominal.transpose() * change.to_matrix()).trace())
            }
        };
        let point = Point { stress: stress_new, state, duration };
        Ok(Traveller { point, strain, work: self.work + 0.5 * power })
    }
}

fn deformation(strain: Sym3) -> Matrix3 {
    Matrix3::identity() + strain.to_matrix()
}

/// The stress P = J σ' F⁻ᵀ, whose work on the change of F is that per volume at the start.
fn nominal_stress(stress: Sym3, deformation: &Matrix3) -> Matrix3 {
    let inverse = deformation.try_inverse().unwrap_or_else(Matrix3::identity);
    stress.to_matrix() * inverse.transpose() * deformation.determinant()
}

impl LawPath {
    /// Out and back along a line, and round a square, from a point of the path.
    pub(super) fn closed_paths_keep_the_promise<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
    ) -> Result<(), LawViolation> {
        let promised = law.closed_path_work();
        if promised == ClosedPathWork::Any {
            return Ok(());
        }
        for path in self.closed_paths(increment) {
            // Off the law's path there may be no answer, as in tension.
            let [Ok(coarse), Ok(work)] = [PARTS / 2, PARTS].map(|parts| path.work(law, point, parts)) else { continue };
            // The trapezoidal rule, and laws that integrate rates, are off by no more than the second halving would show.
            let tolerated = ROUNDING * self.scale(law, point) * self.strain + 2.0 * (work - coarse).abs();
            let is_kept = match promised {
                ClosedPathWork::Zero => work.abs() <= tolerated,
                ClosedPathWork::NotNegative | ClosedPathWork::Any => work >= -tolerated,
            };
            if !is_kept {
                return Err(LawViolation::ClosedPath { increment, path: path.name, work, promised });
            }
        }
        Ok(())
    }

    /// In other directions at every increment: out and back, and squares to both sides and in both senses.
    fn closed_paths(&self, increment: usize) -> Vec<ClosedPath> {
        let mut noise = Noise::new(100 + increment as u64);
        let [one, other] = [(); 2].map(|()| self.random_strain(&mut noise));
        let line = ClosedPath { name: "out and back", corners: vec![one, Sym3::ZERO] };
        let squares = [(one, other), (other, one), (-one, other), (other, -one)].map(|(first, second)| ClosedPath {
            name: "a square",
            corners: vec![first, first + second, second, Sym3::ZERO],
        });
        std::iter::once(line).chain(squares).collect()
    }
}

impl ClosedPath {
    /// The work ∮ σ' : dε (J/m³) in so many increments a side, by the trapezoidal rule.
    fn work<L: ConstitutiveLaw>(&self, law: &L, point: &Point<L::State>, parts: usize) -> Result<f64, LawError> {
        let mut traveller = Traveller { point: *point, strain: Sym3::ZERO, work: 0.0 };
        for &corner in &self.corners {
            let from = traveller.strain;
            for part in 1..=parts {
                let share = part as f64 / parts as f64;
                traveller = traveller.to(law, from * (1.0 - share) + corner * share)?;
            }
        }
        Ok(traveller.work)
    }
}
