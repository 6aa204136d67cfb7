use serde::{Deserialize, Serialize};

use super::meridian::{Meridian, Return};
use super::parameter::{require, require_positive};
use super::{ClosedPathWork, ConstitutiveLaw, LawError, LinearElastic};
use crate::tensor::{Matrix6, Sym3};

/// Von Mises plasticity: metals, and clay that fails without drainage, with linear hardening or softening.
///
/// # Equation
///
/// ```text
/// f = √(3 J₂) − σ_y(ε^p) ≤ 0      Δe^p = 3/2 Δε^p s/√(3 J₂)      σ_y = max(σ_y0 + H ε^p, σ_r)
/// Δε^p = (√(3 J₂,tr) − σ_y,old) / (3G + H)
/// ```
///
/// with ε^p the sum of √(2/3 Δe^p : Δe^p). The return is radial and exact.
///
/// # Validity
///
/// The strength does not depend on the mean stress. An undrained shear strength c_u (Tresca's) is met exactly in triaxial compression and extension
/// with σ_y = 2 c_u, and in plane flow (simple shear, plane strain without a change of volume) with σ_y = √3 c_u; in between, 15 % off at most.
///
/// # Reference
///
/// Radial return: J. C. Simo and T. J. R. Hughes, Computational Inelasticity, sec. 3.3 (cited from memory); the formulas are derived.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct VonMises {
    /// Young's modulus E (Pa), positive.
    pub young: f64,
    /// Poisson's ratio ν (–), above −1 and below 0.5.
    pub poisson: f64,
    /// The yield stress σ_y0 in uniaxial loading (Pa), positive; 2 c_u for an undrained strength in triaxial tests, √3 c_u in plane strain.
    pub yield_stress: f64,
    /// The hardening modulus H = dσ_y/dε^p (Pa), negative for softening, above −3G; default 0.
    #[serde(default)]
    pub hardening: f64,
    /// The yield stress σ_r (Pa) at which softening ends, from 0 to `yield_stress`; default 0.
    #[serde(default)]
    pub yield_stress_residual: f64,
}

/// What [`VonMises`] remembers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct VonMisesState {
    /// The equivalent plastic strain ε^p (–).
    pub plastic_deviatoric_strain: f64,
    /// Whether the last step was plastic.
    pub yielding: bool,
}

impl VonMises {
    fn elastic(&self) -> LinearElastic {
        LinearElastic { young: self.young, poisson: self.poisson }
    }

    /// The yield stress (Pa) after this plastic strain.
    fn yield_stress(&self, plastic_strain: f64) -> f64 {
        (self.yield_stress + self.hardening * plastic_strain).max(self.yield_stress_residual)
    }

    /// The plastic strain increment, and the yield stress and hardening modulus at its end (Pa), from a trial stress √(3 J₂) beyond the yield stress.
    fn plastic_increment(&self, trial: f64, plastic_strain: f64) -> (f64, f64, f64) {
        let stiffness = 3.0 * self.elastic().shear_modulus();
        let increment = (trial - self.yield_stress(plastic_strain)) / (stiffness + self.hardening);
        let on_the_line = self.yield_stress + self.hardening * (plastic_strain + increment);
        match on_the_line > self.yield_stress_residual {
            true => (increment, on_the_line, self.hardening),
            false => ((trial - self.yield_stress_residual) / stiffness, self.yield_stress_residual, 0.0),
        }
    }
}

impl ConstitutiveLaw for VonMises {
    type State = VonMisesState;

    fn update(&self, stress: Sym3, state: VonMisesState, strain: Sym3) -> Result<(Sym3, VonMisesState), LawError> {
        let (trial_stress, ()) = self.elastic().update(stress, (), strain)?;
        let trial = Meridian::of(trial_stress);
        let von_mises = 3.0_f64.sqrt() * trial.shear;
        if von_mises <= self.yield_stress(state.plastic_deviatoric_strain) {
            return Ok((trial_stress, VonMisesState { yielding: false, ..state }));
        }
        let (increment, yield_stress, _) = self.plastic_increment(von_mises, state.plastic_deviatoric_strain);
        let plastic_deviatoric_strain = state.plastic_deviatoric_strain + increment;
        let end = trial.stress_at(trial.mean, yield_stress / 3.0_f64.sqrt());
        Ok((end, VonMisesState { plastic_deviatoric_strain, yielding: true }))
    }

    fn tangent(&self, stress: Sym3, state: VonMisesState, strain: Sym3) -> Result<Matrix6, LawError> {
        let elastic = self.elastic();
        let (trial_stress, ()) = elastic.update(stress, (), strain)?;
        let trial = Meridian::of(trial_stress);
        let von_mises = 3.0_f64.sqrt() * trial.shear;
        if von_mises <= self.yield_stress(state.plastic_deviatoric_strain) {
            return elastic.tangent(stress, (), strain);
        }
        let (_, yield_stress, hardening) = self.plastic_increment(von_mises, state.plastic_deviatoric_strain);
        let slope = hardening / (3.0 * elastic.shear_modulus() + hardening);
        let derivative = [[1.0, 0.0], [0.0, slope]];
        let end = Return { mean: trial.mean, shear: yield_stress / 3.0_f64.sqrt(), derivative };
        Ok(trial.tangent(&end, elastic.bulk_modulus(), elastic.shear_modulus()))
    }

    fn p_wave_modulus(&self, _stress: Sym3, _state: &VonMisesState) -> f64 {
        self.elastic().oedometric_modulus()
    }

    fn s_wave_modulus(&self, _stress: Sym3, _state: &VonMisesState) -> f64 {
        self.elastic().shear_modulus()
    }

    /// Flow along the normal about linear elasticity. While the yield stress falls, a closed path that leaves a plastic strain ε^p behind
    /// takes ½ (3G + H) (ε^p)² at least, and H > −3G.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::NotNegative
    }

    fn validate(&self) -> Result<(), LawError> {
        self.elastic().validate()?;
        require_positive("yield_stress", self.yield_stress, "positive (Pa)")?;
        let soft = self.hardening > -3.0 * self.elastic().shear_modulus() && self.hardening.is_finite();
        require(soft, "hardening", self.hardening, "above -3 G (Pa): softer, a step would have no answer")?;
        let residual = self.yield_stress_residual;
        require(
            (0.0..=self.yield_stress).contains(&residual),
            "yield_stress_residual",
            residual,
            "from 0 to `yield_stress`",
        )
    }

    fn outputs(&self) -> &'static [&'static str] {
        &["plastic_deviatoric_strain", "yielding"]
    }

    fn write_outputs(&self, _stress: Sym3, state: &VonMisesState, values: &mut [f64]) {
        values.copy_from_slice(&[state.plastic_deviatoric_strain, f64::from(state.yielding)]);
    }
}
