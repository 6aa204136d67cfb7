use serde::{Deserialize, Serialize};

use super::frictional::{FrictionalState, Softening, Strength, softened_strain, validate_flow};
use super::meridian::{Meridian, Return};
use super::{ClosedPathWork, ConstitutiveLaw, LawError, LinearElastic, tangent_by_differences};
use crate::tensor::{Matrix6, Sym3};

/// Drucker–Prager plasticity: friction and cohesion as a cone, with dilatancy, tensile cut-off and softening.
///
/// # Equation
///
/// With σ_m = ⅓ tr σ', tension positive:
///
/// ```text
/// f = √J₂ + q_φ σ_m − k_φ ≤ 0      g = √J₂ + q_ψ σ_m      σ_m ≤ min(σ_t, k_φ/q_φ)
/// compression cone   q_φ = 6 sin φ / √3 (3 − sin φ)       k_φ = 6 c cos φ / √3 (3 − sin φ)
/// extension cone     q_φ = 6 sin φ / √3 (3 + sin φ)       k_φ = 6 c cos φ / √3 (3 + sin φ)
/// plane strain       q_φ = 3 tan φ / √(9 + 12 tan² φ)     k_φ = 3 c / √(9 + 12 tan² φ)
/// ```
///
/// q_ψ is q_φ with the dilatancy angle. The cut-off flows along the mean stress. The return is exact: to the cone, the cut-off, the edge between them
/// or the apex. Friction angle and cohesion fall linearly with the plastic deviatoric strain, the sum of √(2/3 Δe^p : Δe^p), and are those at the
/// end of the step; the dilatancy angle is never above the friction angle.
///
/// # Validity
///
/// The cone is that of Mohr and Coulomb in triaxial compression, in triaxial extension, or in associated plane flow (ψ = φ), and only there: elsewhere
/// the compression cone is too strong, by (3 + sin φ)/(3 − sin φ) = 1.4 at φ = 30° in extension. A softening band is as wide as a cell: results depend on the grid.
/// An initial stress outside the surface comes back to it in the first step. Opening in tension does not soften.
///
/// # Reference
///
/// D. C. Drucker and W. Prager (1952), Q. Appl. Math. 10, 157–165; return map after E. A. de Souza Neto, D. Perić and D. R. J. Owen, Computational
/// Methods for Plasticity, ch. 8 (both cited from memory, derived again and tested as a closest-point projection). The cones were read in the source of GeoTaichi.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DruckerPrager {
    /// Young's modulus E (Pa), positive.
    pub young: f64,
    /// Poisson's ratio ν (–), above −1 and below 0.5.
    pub poisson: f64,
    /// The friction angle φ (°), from 0 to below 90.
    pub friction_angle_deg: f64,
    /// The cohesion c (Pa), zero or positive.
    pub cohesion: f64,
    /// The dilatancy angle ψ (°), from 0 to φ; default 0.
    #[serde(default)]
    pub dilatancy_angle_deg: f64,
    /// Where the cone is Mohr and Coulomb's: `"compression"` (triaxial; the default), `"extension"` or `"plane-strain"`.
    #[serde(default)]
    pub cone: Cone,
    /// The largest mean stress σ_t (Pa), zero or positive; without it, that of the apex.
    pub tensile_strength: Option<f64>,
    /// The friction angle after softening (°), from 0 to φ; without it, φ.
    pub friction_angle_residual_deg: Option<f64>,
    /// The cohesion after softening (Pa), from 0 to c; without it, c.
    pub cohesion_residual: Option<f64>,
    /// The plastic deviatoric strain over which the strength falls (–), positive if it does.
    #[serde(default)]
    pub softening_strain: f64,
}

/// Where the cone of [`DruckerPrager`] is that of Mohr and Coulomb.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Cone {
    /// In triaxial compression: the outer cone.
    #[default]
    Compression,
    /// In triaxial extension.
    Extension,
    /// In plane strain, with associated flow.
    PlaneStrain,
}

impl Cone {
    /// The slope q (–) of a friction or dilatancy angle (rad).
    pub fn slope(self, angle: f64) -> f64 {
        let sin = angle.sin();
        sin * self.scale(sin)
    }

    /// The strength k (Pa) at zero mean stress, from a friction angle (rad) and a cohesion (Pa).
    pub fn strength(self, angle: f64, cohesion: f64) -> f64 {
        let (sin, cos) = angle.sin_cos();
        cohesion * cos * self.scale(sin)
    }

    /// q/sin φ = k/(c cos φ) (–).
    fn scale(self, sin: f64) -> f64 {
        match self {
            Cone::Compression => 2.0 * 3.0_f64.sqrt() / (3.0 - sin),
            Cone::Extension => 2.0 * 3.0_f64.sqrt() / (3.0 + sin),
            Cone::PlaneStrain => 3.0 / (9.0 + 3.0 * sin * sin).sqrt(),
        }
    }
}

/// The cone and the cut-off for one strength.
struct Surface {
    slope: f64,
    flow_slope: f64,
    strength: f64,
    /// The largest mean stress (Pa): the cut-off, or the apex where that is lower; infinite where there is neither.
    tension: f64,
}

impl Surface {
    fn holds(&self, mean: f64, shear: f64) -> bool {
        shear + self.slope * mean <= self.strength && mean <= self.tension
    }

    /// The return of a trial point, without hardening. Only a surface that has softened away from it may hold the point itself.
    fn project(&self, trial: &Meridian, bulk_modulus: f64, shear_modulus: f64) -> Return {
        if self.holds(trial.mean, trial.shear) {
            return Return { mean: trial.mean, shear: trial.shear, derivative: [[1.0, 0.0], [0.0, 1.0]] };
        }
        let stiffness = shear_modulus + bulk_modulus * self.slope * self.flow_slope;
        let multiplier = (trial.shear + self.slope * trial.mean - self.strength) / stiffness;
        let mean = trial.mean - bulk_modulus * self.flow_slope * multiplier;
        let shear = trial.shear - shear_modulus * multiplier;
        if multiplier > 0.0 && shear >= 0.0 && mean <= self.tension {
            let (along, across) = (bulk_modulus * self.flow_slope / stiffness, shear_modulus / stiffness);
            let derivative = [[1.0 - along * self.slope, -along], [-across * self.slope, 1.0 - across]];
            return Return { mean, shear, derivative };
        }
        let edge = self.strength - self.slope * self.tension;
        if trial.shear <= edge {
            return Return { mean: self.tension, shear: trial.shear, derivative: [[0.0, 0.0], [0.0, 1.0]] };
        }
        // At the apex the edge has no shear; round-off must not make it negative.
        Return { mean: self.tension, shear: edge.max(0.0), derivative: [[0.0; 2]; 2] }
    }
}

impl DruckerPrager {
    fn elastic(&self) -> LinearElastic {
        LinearElastic { young: self.young, poisson: self.poisson }
    }

    fn softening(&self) -> Softening {
        Softening::new(
            self.friction_angle_deg,
            self.cohesion,
            self.friction_angle_residual_deg,
            self.cohesion_residual,
            self.softening_strain,
        )
    }

    fn surface(&self, softening: &Softening, plastic_strain: f64) -> Surface {
        let Strength { friction_angle, cohesion } = softening.at(plastic_strain);
        let slope = self.cone.slope(friction_angle);
        let strength = self.cone.strength(friction_angle, cohesion);
        let dilatancy_angle = self.dilatancy_angle_deg.to_radians().min(friction_angle);
        let flow_slope = if dilatancy_angle > 0.0 { self.cone.slope(dilatancy_angle) } else { 0.0 };
        let tension = (strength / slope).min(self.tensile_strength.unwrap_or(f64::INFINITY));
        Surface { slope, flow_slope, strength, tension }
    }
}

/// The plastic deviatoric strain of a return (–).
fn plastic_increment(trial: &Meridian, end: &Return, shear_modulus: f64) -> f64 {
    (trial.shear - end.shear) / (3.0_f64.sqrt() * shear_modulus)
}

impl ConstitutiveLaw for DruckerPrager {
    type State = FrictionalState;

    fn update(&self, stress: Sym3, state: FrictionalState, strain: Sym3) -> Result<(Sym3, FrictionalState), LawError> {
        let elastic = self.elastic();
        let (trial_stress, ()) = elastic.update(stress, (), strain)?;
        let (trial, softening) = (Meridian::of(trial_stress), self.softening());
        let strain_old = state.plastic_deviatoric_strain;
        let surface = self.surface(&softening, strain_old);
        if surface.holds(trial.mean, trial.shear) {
            return Ok((trial_stress, FrictionalState { yielding: false, ..state }));
        }
        let (bulk_modulus, shear_modulus) = (elastic.bulk_modulus(), elastic.shear_modulus());
        let mut end = surface.project(&trial, bulk_modulus, shear_modulus);
        let mut plastic_strain = strain_old + plastic_increment(&trial, &end, shear_modulus);
        if softening.goes_on_at(strain_old) && plastic_strain > strain_old {
            let project = |strain: f64| self.surface(&softening, strain).project(&trial, bulk_modulus, shear_modulus);
            let increment = |strain: f64| plastic_increment(&trial, &project(strain), shear_modulus);
            plastic_strain = softened_strain(strain_old, softening.over, increment)?;
            end = project(plastic_strain);
        }
        let state = state.after(plastic_strain, (trial.mean - end.mean) / bulk_modulus);
        Ok((trial.stress_at(end.mean, end.shear), state))
    }

    /// Analytical, but by differences while the strength falls.
    fn tangent(&self, stress: Sym3, state: FrictionalState, strain: Sym3) -> Result<Matrix6, LawError> {
        let (elastic, softening) = (self.elastic(), self.softening());
        let (trial_stress, ()) = elastic.update(stress, (), strain)?;
        let trial = Meridian::of(trial_stress);
        let surface = self.surface(&softening, state.plastic_deviatoric_strain);
        if surface.holds(trial.mean, trial.shear) {
            return elastic.tangent(stress, (), strain);
        }
        if softening.goes_on_at(state.plastic_deviatoric_strain) {
            return tangent_by_differences(self, stress, state, strain);
        }
        let (bulk_modulus, shear_modulus) = (elastic.bulk_modulus(), elastic.shear_modulus());
        let end = surface.project(&trial, bulk_modulus, shear_modulus);
        Ok(trial.tangent(&end, bulk_modulus, shear_modulus))
    }

    fn p_wave_modulus(&self, _stress: Sym3, _state: &FrictionalState) -> f64 {
        self.elastic().oedometric_modulus()
    }

    fn s_wave_modulus(&self, _stress: Sym3, _state: &FrictionalState) -> f64 {
        self.elastic().shear_modulus()
    }

    /// Flow along the normal of a surface that stays, where ψ = φ and nothing softens. Otherwise there are paths that win work: flow that opens less than
    /// the normal does is driven by a smaller shear stress after a fall of the pressure.
    fn closed_path_work(&self) -> ClosedPathWork {
        self.softening().closed_path_work(self.dilatancy_angle_deg)
    }

    fn validate(&self) -> Result<(), LawError> {
        self.elastic().validate()?;
        self.softening().validate()?;
        validate_flow(self.friction_angle_deg, self.dilatancy_angle_deg, self.tensile_strength)
    }

    fn outputs(&self) -> &'static [&'static str] {
        FrictionalState::OUTPUTS
    }

    fn write_outputs(&self, _stress: Sym3, state: &FrictionalState, values: &mut [f64]) {
        state.write(values);
    }
}
