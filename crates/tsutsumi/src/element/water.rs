use super::{Condition, Specimen};

/// The excess pore pressure of an undrained test: the total stress that the test applies, less the effective stress of the law.
///
/// # Equation
///
/// ```text
/// Δu = Δ(−σ) − Δ(−σ')      r_u = u / (−σ'₀)
/// ```
///
/// for the direction whose total stress is held: the radial one in triaxial tests, the vertical one in simple shear, so that Δ(−σ) = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExcessPressure {
    /// The effective stress of the direction whose total stress is held, positive in compression.
    pub direction: Condition,
    /// Its value when the drain was closed (Pa).
    pub start: f64,
}

impl ExcessPressure {
    /// The drain of a specimen is closed now.
    pub fn begin(direction: Condition, specimen: &Specimen) -> Self {
        ExcessPressure { direction, start: direction.of(specimen) }
    }

    /// The excess pore pressure u (Pa, positive in compression).
    pub fn pressure(&self, specimen: &Specimen) -> f64 {
        self.start - self.direction.of(specimen)
    }

    /// The pore pressure ratio r_u (–): 1 where no effective stress is left. Not a number without one at the start.
    pub fn ratio(&self, specimen: &Specimen) -> f64 {
        match self.start > 0.0 {
            true => self.pressure(specimen) / self.start,
            false => f64::NAN,
        }
    }
}
