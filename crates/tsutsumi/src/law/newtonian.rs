use serde::{Deserialize, Serialize};

use super::liquid_pressure::LiquidPressure;
use super::{ClosedPathWork, ConstitutiveLaw, Increment, LawError};
use crate::tensor::{Sym3, volume_ratio};

/// A Newtonian fluid that is hard to compress: water, oil. It stands where other laws give the effective stress, so its body has no pores:
/// leave out `[fluid]`.
///
/// # Equation
///
/// ```text
/// σ = −p I + 2 η dev(Δε)/Δt        p = K (J^−ζ − 1)/ζ,  −K ln J for ζ = 0        J = V / V at p = 0
/// ```
///
/// The volume is that of the material point, J ← det(I + ∇u) J. Where it is larger than without pressure the fluid is apart and p = 0,
/// unless it bears tension. Viscosity is explicit: steps have to stay below about ρ h²/(4 η), h the size of a cell, a limit that
/// `step = "auto"` does not know. Without a duration there is no viscous stress.
///
/// # Reference
///
/// G. K. Batchelor, An introduction to fluid dynamics, sec. 3.3; Tait's equation as in J. J. Monaghan (1994), J. Comput. Phys. 110,
/// 399–406 (both cited from memory).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Newtonian {
    /// Bulk modulus K without pressure (Pa), positive. Water has 2.2e9; a smaller one, with √(K/ρ) ten times the fastest flow, allows
    /// longer steps and leaves changes of density below about 1 %.
    pub bulk_modulus: f64,
    /// Dynamic viscosity η (Pa s), 0 or more. Water has 1e-3.
    pub viscosity: f64,
    /// Exponent ζ of Tait's equation (–), 0 or more; 0 is a pressure linear in ln J, 7 is usual for water.
    #[serde(default)]
    pub tait_exponent: f64,
    /// Whether the fluid bears tension; if not it comes apart.
    #[serde(default)]
    pub bears_tension: bool,
}

/// The history of a liquid without shear stiffness.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct NewtonianState {
    /// ln J (–), of the volume over that without pressure.
    pub log_volume_ratio: f64,
}

impl Newtonian {
    fn compression(&self) -> LiquidPressure {
        let Newtonian { bulk_modulus, tait_exponent, bears_tension, .. } = *self;
        LiquidPressure { bulk_modulus, tait_exponent, bears_tension }
    }
}

impl ConstitutiveLaw for Newtonian {
    type State = NewtonianState;
    // Only so that J is the volume of the material point; no stress is carried over from step to step.
    const FINITE_STRAIN: bool = true;

    fn update(&self, stress: Sym3, state: NewtonianState, strain: Sym3) -> Result<(Sym3, NewtonianState), LawError> {
        self.update_within(stress, state, strain, f64::INFINITY)
    }

    fn update_within(
        &self,
        stress: Sym3,
        state: NewtonianState,
        strain: Sym3,
        duration: f64,
    ) -> Result<(Sym3, NewtonianState), LawError> {
        self.deform(stress, state, &Increment { strain, duration, ..Increment::default() })
    }

    fn deform(
        &self,
        _stress: Sym3,
        state: NewtonianState,
        motion: &Increment,
    ) -> Result<(Sym3, NewtonianState), LawError> {
        let log_volume_ratio = state.log_volume_ratio + volume_ratio::<3>(&motion.displacement_gradient()).ln();
        let viscous = motion.strain.deviator() * (2.0 * self.viscosity / motion.duration);
        let pressure = self.compression().at(log_volume_ratio);
        Ok((viscous - Sym3::IDENTITY * pressure, NewtonianState { log_volume_ratio }))
    }

    fn p_wave_modulus(&self, _stress: Sym3, state: &NewtonianState) -> f64 {
        self.compression().modulus(state.log_volume_ratio)
    }

    fn s_wave_modulus(&self, _stress: Sym3, _state: &NewtonianState) -> f64 {
        0.0
    }

    /// Without a duration there is the pressure alone, a function of the volume.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Zero
    }

    fn validate(&self) -> Result<(), LawError> {
        self.compression().validate()?;
        match self.viscosity >= 0.0 && self.viscosity.is_finite() {
            true => Ok(()),
            false => {
                Err(LawError::Parameter { name: "viscosity", value: self.viscosity, expected: "0 or more (Pa s)" })
            }
        }
    }

    /// As dense as the pressure makes it; shear stresses last no longer than the motion.
    fn initial_state(&self, stress: Sym3) -> NewtonianState {
        NewtonianState { log_volume_ratio: self.compression().log_volume_ratio(stress.pressure()) }
    }

    fn outputs(&self) -> &'static [&'static str] {
        &["log_volume_ratio"]
    }

    fn write_outputs(&self, _stress: Sym3, state: &NewtonianState, values: &mut [f64]) {
        values[0] = state.log_volume_ratio;
    }
}
