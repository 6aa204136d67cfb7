use super::LawError;

/// The pressure of a liquid that is hard to compress, from its volume.
///
/// # Equation
///
/// ```text
/// p = K (J^−ζ − 1)/ζ      p = −K ln J for ζ = 0      J = V / V at p = 0
/// ```
///
/// Tait's form, with ζ = 7 for water; a liquid that bears no tension has p = 0 for J > 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct LiquidPressure {
    pub(super) bulk_modulus: f64,
    pub(super) tait_exponent: f64,
    pub(super) bears_tension: bool,
}

impl LiquidPressure {
    /// The pressure (Pa) at ln J (–).
    pub(super) fn at(&self, log_volume_ratio: f64) -> f64 {
        if log_volume_ratio > 0.0 && !self.bears_tension {
            return 0.0;
        }
        let power = -self.tait_exponent * log_volume_ratio;
        match power == 0.0 {
            true => -self.bulk_modulus * log_volume_ratio,
            false => self.bulk_modulus * power.exp_m1() / self.tait_exponent,
        }
    }

    /// dp/d(−ln J) (Pa), as if tension were borne.
    pub(super) fn modulus(&self, log_volume_ratio: f64) -> f64 {
        self.bulk_modulus * (-self.tait_exponent * log_volume_ratio).exp()
    }

    /// ln J (–) at a pressure (Pa).
    pub(super) fn log_volume_ratio(&self, pressure: f64) -> f64 {
        let ratio = pressure / self.bulk_modulus;
        let log_ratio = match self.tait_exponent == 0.0 {
            true => -ratio,
            false => -(self.tait_exponent * ratio).ln_1p() / self.tait_exponent,
        };
        if self.bears_tension { log_ratio } else { log_ratio.min(0.0) }
    }

    pub(super) fn validate(&self) -> Result<(), LawError> {
        if !(self.bulk_modulus > 0.0 && self.bulk_modulus.is_finite()) {
            return Err(LawError::Parameter {
                name: "bulk_modulus",
                value: self.bulk_modulus,
                expected: "positive (Pa)",
            });
        }
        if !(self.tait_exponent >= 0.0 && self.tait_exponent.is_finite()) {
            return Err(LawError::Parameter {
                name: "tait_exponent",
                value: self.tait_exponent,
                expected: "0 or more",
            });
        }
        Ok(())
    }
}
