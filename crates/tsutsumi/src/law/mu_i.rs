use serde::{Deserialize, Serialize};

use super::{ClosedPathWork, ConstitutiveLaw, LawError, LinearElastic};
use crate::tensor::Sym3;

/// Granular flow by the μ(I) rheology: friction that grows with the rate of shear. Dry grains, without cohesion.
///
/// # Equation
///
/// ```text
/// τ = μ(I) p        μ = μ_s + (μ_2 − μ_s) / (I₀/I + 1)        I = γ̇ d √(ρ_s/p)
/// ```
///
/// with τ = √(½ s:s), γ̇ = √(2 ė:ė) of the plastic strain and p the mean pressure. Below μ_s p the grains are elastic; flow does not change
/// their volume. Where the grains are less dense than at rest without pressure they are apart, and free of stress:
///
/// ```text
/// p = −K ln J   for J < 1,   else 0        J = V / V at p = 0
/// ```
///
/// The return in a step Δt is implicit and closed, τ' and s' being the elastic trial:
///
/// ```text
/// (τ − μ_s p) α = (μ_2 p − τ) (τ' − τ)        α = I₀ G Δt √(p/ρ_s) / d        s = s' τ/τ'
/// ```
///
/// In steady shear it gives μ(I) whatever the step. A step of any length without a duration (rates of zero) flows at μ_s:
/// Drucker–Prager friction without dilatancy.
///
/// The equations of μ(I) flow are ill-posed at small and at large I (Barker et al. 2015): fields at these rates depend on the grid.
///
/// # Reference
///
/// P. Jop, Y. Forterre and O. Pouliquen (2006), Nature 441, 727–730, recalled; separation after S. Dunatunga and K. Kamrin (2015), J. Fluid
/// Mech. 779, 483–513, of which the abstract was read; the return is derived.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MuI {
    /// Young's modulus E of the packing (Pa), positive; a numerical choice, large against the pressures.
    pub young: f64,
    /// Poisson's ratio ν (–), above −1 and below 0.5.
    pub poisson: f64,
    /// Coefficient of friction at rest μ_s (–), positive.
    pub friction_static: f64,
    /// Coefficient of friction of the fastest flow μ_2 (–), at least μ_s.
    pub friction_limit: f64,
    /// Inertial number I₀ (–) at which friction is half way between, positive.
    pub inertial_number: f64,
    /// Diameter of the grains d (m), positive.
    pub grain_diameter: f64,
    /// Density of the grains themselves ρ_s (kg/m³), positive.
    pub grain_density: f64,
}

/// The history of [`MuI`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MuIState {
    /// ln J (–), of the volume over that without pressure: positive where the grains are apart.
    pub log_volume_ratio: f64,
    /// Plastic shear strain so far ∫ γ̇ dt (–).
    pub plastic_shear: f64,
}

impl MuI {
    fn elasticity(&self) -> LinearElastic {
        LinearElastic { young: self.young, poisson: self.poisson }
    }

    /// The bulk modulus K (Pa).
    fn bulk_modulus(&self) -> f64 {
        self.young / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// The coefficient of friction μ(I) (–) at an inertial number (–).
    pub fn friction(&self, inertial_number: f64) -> f64 {
        let share = inertial_number / (self.inertial_number + inertial_number);
        self.friction_static + (self.friction_limit - self.friction_static) * share
    }

    /// The shear stress τ (Pa) after a step that would elastically lead to `trial` > μ_s p: the smaller root of the quadratic, free of
    /// cancellation and good for α = ∞.
    fn flow(&self, trial: f64, pressure: f64, duration: f64) -> f64 {
        let (least, most) = (self.friction_static * pressure, self.friction_limit * pressure);
        let stiffness = self.inertial_number * self.elasticity().shear_modulus() * duration;
        // 1/α (1/Pa)
        let inverse = self.grain_diameter / stiffness * (self.grain_density / pressure).sqrt();
        let linear = 1.0 + inverse * (most + trial);
        let constant = least + inverse * most * trial;
        let root = (linear * linear - 4.0 * inverse * constant).max(0.0).sqrt();
        2.0 * constant / (linear + root)
    }
}

impl ConstitutiveLaw for MuI {
    type State = MuIState;

    fn update(&self, stress: Sym3, state: MuIState, strain: Sym3) -> Result<(Sym3, MuIState), LawError> {
        self.update_within(stress, state, strain, f64::INFINITY)
    }

    fn update_within(
        &self,
        stress: Sym3,
        mut state: MuIState,
        strain: Sym3,
        duration: f64,
    ) -> Result<(Sym3, MuIState), LawError> {
        state.log_volume_ratio += strain.trace();
        if state.log_volume_ratio >= 0.0 {
            return Ok((Sym3::ZERO, state));
        }
        let pressure = -self.bulk_modulus() * state.log_volume_ratio;
        let shear_modulus = self.elasticity().shear_modulus();
        let mut deviator = stress.deviator() + strain.deviator() * (2.0 * shear_modulus);
        let trial = (0.5 * deviator.double_dot(deviator)).sqrt();
        if trial > self.friction_static * pressure {
            let shear = self.flow(trial, pressure, duration);
            deviator = deviator * (shear / trial);
            state.plastic_shear += (trial - shear) / shear_modulus;
        }
        Ok((deviator - Sym3::IDENTITY * pressure, state))
    }

    fn p_wave_modulus(&self, _stress: Sym3, _state: &MuIState) -> f64 {
        self.elasticity().oedometric_modulus()
    }

    fn s_wave_modulus(&self, _stress: Sym3, _state: &MuIState) -> f64 {
        self.elasticity().shear_modulus()
    }

    /// Nothing: grains slide without opening, and a fall of the pressure between two slides wins work.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Any
    }

    fn validate(&self) -> Result<(), LawError> {
        self.elasticity().validate()?;
        for (name, value) in [
            ("friction_static", self.friction_static),
            ("inertial_number", self.inertial_number),
            ("grain_diameter", self.grain_diameter),
            ("grain_density", self.grain_density),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(LawError::Parameter { name, value, expected: "positive" });
            }
        }
        if !(self.friction_limit >= self.friction_static && self.friction_limit.is_finite()) {
            let (value, expected) = (self.friction_limit, "at least the friction at rest");
            return Err(LawError::Parameter { name: "friction_limit", value, expected });
        }
        Ok(())
    }

    /// As dense as the pressure makes it; grains cannot bear tension.
    fn initial_state(&self, stress: Sym3) -> MuIState {
        MuIState { log_volume_ratio: stress.trace() / 3.0 / self.bulk_modulus(), plastic_shear: 0.0 }
    }

    fn outputs(&self) -> &'static [&'static str] {
        &["plastic_shear", "log_volume_ratio"]
    }

    fn write_outputs(&self, _stress: Sym3, state: &MuIState, values: &mut [f64]) {
        values.copy_from_slice(&[state.plastic_shear, state.log_volume_ratio]);
    }
}
