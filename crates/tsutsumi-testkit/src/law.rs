//! What every constitutive law must satisfy: [`check_law`].
//!
//! ```
//! use tsutsumi_testkit::body::PAPER_SOIL;
//! use tsutsumi_testkit::law::check_law;
//!
//! check_law(&PAPER_SOIL).unwrap();
//! ```
//!
//! | module | what is asked |
//! |---|---|
//! | `objectivity` | nothing strained, nothing changed; a rigid rotation turns the stress |
//! | `stiffness` | moduli that bound the stiffness, a tangent that is it |
//! | `history` | what is written and read back goes on as if it had not been; outputs are written |
//! | `step_size` | smaller steps lead to one answer |
//! | `closed_path` | closed paths of strain take the work that the law promises |
//! | `allocation` | a step asks for no memory (feature `count-allocations`, on by default) |

mod allocation;
mod closed_path;
mod history;
mod objectivity;
mod step_size;
mod stiffness;
mod violation;

pub use violation::LawViolation;

use tsutsumi::law::ConstitutiveLaw;
use tsutsumi::tensor::{Matrix3, Sym3};

use self::history::outputs_are_written;
use self::stiffness::tangent_is_the_derivative;
use crate::noise::Noise;

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
    /// How well a law that integrates with an error control, or decides by a sign whether the load has turned, is meant to be integrated:
    /// what increments in 16 and in 32 parts may differ by anywhere on the path, relative to the stress (–). Larger differences have to fall
    /// with the size of the parts. 1e-4 by default.
    pub accuracy: f64,
}

impl Default for LawPath {
    fn default() -> Self {
        let stress = Sym3::diagonal(-100e3, -100e3, -100e3);
        LawPath { stress, strain: 1e-4, increments: 40, duration: f64::INFINITY, plane: false, accuracy: 1e-4 }
    }
}

/// A material point on its way.
#[derive(Clone, Copy)]
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
        let mut point = self.start(law);
        // The point that is turned half way and goes on in turned directions.
        let turn = self.turn();
        let mut turned = None;
        for (increment, &strain) in self.strain_increments().iter().enumerate() {
            if self.duration.is_infinite() {
                self.nothing_strained_nothing_changed(law, increment, &point)?;
                self.moduli_bound_the_stiffness(law, increment, &point)?;
                tangent_is_the_derivative(law, increment, &point, strain, self.components())?;
                self.closed_paths_keep_the_promise(law, increment, &point)?;
            }
            self.history_survives_writing(law, increment, &point, strain)?;
            self.a_step_does_not_allocate(law, increment, &point, strain)?;
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
        self.smaller_steps_agree(law)
    }

    /// Where the path begins.
    fn start<L: ConstitutiveLaw>(&self, law: &L) -> Point<L::State> {
        Point { stress: self.stress, state: law.initial_state(self.stress), duration: self.duration }
    }

    /// What a stress is measured by (Pa): itself, or the stress of an increment.
    fn scale<L: ConstitutiveLaw>(&self, law: &L, point: &Point<L::State>) -> f64 {
        point.stress.norm().max(law.p_wave_modulus(point.stress, &point.state) * self.strain)
    }

    /// The increments, one after the other.
    fn strain_increments(&self) -> Vec<Sym3> {
        let mut noise = Noise::new(1);
        (0..self.increments).map(|increment| self.strain_increment(increment, &mut noise)).collect()
    }

    fn strain_increment(&self, increment: usize, noise: &mut Noise) -> Sym3 {
        let random = self.random_strain(noise);
        match (increment < self.increments / 4, self.plane) {
            (true, false) => Sym3::diagonal(0.0, 0.0, -self.strain),
            (true, true) => Sym3::diagonal(0.0, -self.strain, 0.0),
            (false, _) => random,
        }
    }

    /// A strain of the path's size, rather in compression than in extension.
    fn random_strain(&self, noise: &mut Noise) -> Sym3 {
        let mut random = noise.tensor() - Sym3::IDENTITY * 0.5;
        if self.plane {
            random = Sym3 { zz: 0.0, yz: 0.0, zx: 0.0, ..random };
        }
        random * (self.strain / random.norm())
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
}

#[cfg(test)]
mod tests;
