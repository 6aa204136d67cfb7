use serde::{Deserialize, Serialize};

use super::liquid_pressure::LiquidPressure;
use super::{ClosedPathWork, ConstitutiveLaw, LawError};
use crate::tensor::Sym3;

/// A Bingham fluid: an elastic solid up to a yield stress, viscous beyond. Mud, fresh concrete, debris. It stands where other laws give the
/// effective stress, so its body has no pores: leave out `[fluid]`.
///
/// # Equation
///
/// ```text
/// τ = τ_y + η γ̇   where it flows        τ = √(½ s:s)   γ̇ = √(2 ė:ė) of the plastic strain
/// p = K (J^−ζ − 1)/ζ,  −K ln J for ζ = 0        J = V / V at p = 0
/// ```
///
/// Below τ_y it is elastic, with G: mud that has come to rest stays, where a fluid of two viscosities would creep. The return in a step Δt
/// is implicit, from the elastic trial τ', s', and gives τ_y + η γ̇ in steady shear whatever the step:
///
/// ```text
/// τ = τ_y + (τ' − τ_y) / (1 + G Δt/η)        s = s' τ/τ'
/// ```
///
/// Viscosity therefore does not limit the step; √(G/ρ) does. J is the sum of the strain increments. Where it is larger than without
/// pressure, p = 0, unless the fluid bears tension; shear stress stays. Without a duration it flows at τ_y: von Mises.
///
/// # Reference
///
/// E. C. Bingham (1922), Fluidity and plasticity, recalled; overstress after P. Perzyna (1966), Adv. Appl. Mech. 9, 243–377, recalled; the
/// return is derived.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bingham {
    /// Bulk modulus K without pressure (Pa), positive; smaller than the true one for longer steps, as for the Newtonian fluid.
    pub bulk_modulus: f64,
    /// Shear modulus G below the yield stress (Pa), positive; a numerical choice, large against the yield stress.
    pub shear_modulus: f64,
    /// Yield stress τ_y in simple shear (Pa), 0 or more.
    pub yield_stress: f64,
    /// Plastic viscosity η (Pa s), 0 or more.
    pub viscosity: f64,
    /// Exponent ζ of Tait's equation (–), 0 or more; 0 is a pressure linear in ln J.
    #[serde(default)]
    pub tait_exponent: f64,
    /// Whether the fluid bears tension; if not it comes apart.
    #[serde(default)]
    pub bears_tension: bool,
}

/// The history of [`Bingham`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BinghamState {
    /// ln J (–), of the volume over that without pressure.
    pub log_volume_ratio: f64,
    /// Plastic shear strain so far ∫ γ̇ dt (–).
    pub plastic_shear: f64,
}

impl Bingham {
    fn compression(&self) -> LiquidPressure {
        let Bingham { bulk_modulus, tait_exponent, bears_tension, .. } = *self;
        LiquidPressure { bulk_modulus, tait_exponent, bears_tension }
    }
}

impl ConstitutiveLaw for Bingham {
    type State = BinghamState;

    fn update(&self, stress: Sym3, state: BinghamState, strain: Sym3) -> Result<(Sym3, BinghamState), LawError> {
        self.update_within(stress, state, strain, f64::INFINITY)
    }

    fn update_within(
        &self,
        stress: Sym3,
        mut state: BinghamState,
        strain: Sym3,
        duration: f64,
    ) -> Result<(Sym3, BinghamState), LawError> {
        state.log_volume_ratio += strain.trace();
        let mut deviator = stress.deviator() + strain.deviator() * (2.0 * self.shear_modulus);
        let trial = (0.5 * deviator.double_dot(deviator)).sqrt();
        if trial > self.yield_stress {
            // η/(η + G Δt), which is 0 for an endless step.
            let kept = match duration.is_finite() {
                true => self.viscosity / (self.viscosity + self.shear_modulus * duration),
                false => 0.0,
            };
            let shear = self.yield_stress + (trial - self.yield_stress) * kept;
            deviator = deviator * (shear / trial);
            state.plastic_shear += (trial - shear) / self.shear_modulus;
        }
        Ok((deviator - Sym3::IDENTITY * self.compression().at(state.log_volume_ratio), state))
    }

    fn p_wave_modulus(&self, _stress: Sym3, state: &BinghamState) -> f64 {
        self.compression().modulus(state.log_volume_ratio) + 4.0 / 3.0 * self.shear_modulus
    }

    fn s_wave_modulus(&self, _stress: Sym3, _state: &BinghamState) -> f64 {
        self.shear_modulus
    }

    /// The pressure is a function of the volume; shear is elastic, and plastic along the normal of a surface that stays.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::NotNegative
    }

    fn validate(&self) -> Result<(), LawError> {
        self.compression().validate()?;
        if !(self.shear_modulus > 0.0 && self.shear_modulus.is_finite()) {
            let (value, expected) = (self.shear_modulus, "positive (Pa)");
            return Err(LawError::Parameter { name: "shear_modulus", value, expected });
        }
        for (name, value) in [("yield_stress", self.yield_stress), ("viscosity", self.viscosity)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(LawError::Parameter { name, value, expected: "0 or more" });
            }
        }
        Ok(())
    }

    /// As dense as the pressure makes it.
    fn initial_state(&self, stress: Sym3) -> BinghamState {
        let log_volume_ratio = self.compression().log_volume_ratio(stress.pressure());
        BinghamState { log_volume_ratio, plastic_shear: 0.0 }
    }

    fn outputs(&self) -> &'static [&'static str] {
        &["plastic_shear", "log_volume_ratio"]
    }

    fn write_outputs(&self, _stress: Sym3, state: &BinghamState, values: &mut [f64]) {
        values.copy_from_slice(&[state.plastic_shear, state.log_volume_ratio]);
    }
}
