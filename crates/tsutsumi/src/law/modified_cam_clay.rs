use serde::{Deserialize, Serialize};

use super::parameter::{require, require_positive};
use super::{ClosedPathWork, ConstitutiveLaw, LawError};
use crate::tensor::Sym3;

/// Modified Cam-Clay: the critical-state law of soft clay, with elliptic yield surface and associated flow.
///
/// # Equation
///
/// With p = −⅓ tr σ', q = √(3/2 s:s), v = 1 + e, all positive in compression:
///
/// ```text
/// f = q²/M² + p (p − p_c) ≤ 0      Δε^p = Δγ ∂f/∂σ'
/// p   = p_old   exp(  Δv^e' / κ )        Δv^e' = v̂ (Δε_v − Δε_v^p)
/// p_c = p_c,old exp(  Δv^p' / (λ−κ) )    Δv^p' = v̂ Δε_v^p
/// v   = v_old exp(−Δε_v)                 v̂ = (v_old − v) / Δε_v
/// s   = (s_old + 2 G Δe) / (1 + 6 G Δγ/M²)
/// ```
///
/// The flow rule is implicit (backward Euler). Pressure, preconsolidation pressure and void ratio are integrated exactly: whatever the
/// size of the steps, v + κ ln p + (λ−κ) ln p_c keeps its value. So the normal compression line has slope λ, swelling lines have slope κ in
/// v – ln p, and the undrained path has its closed form. One unknown is left, the stress ratio η = q/p on the yield surface, between that of the
/// trial state and that of the critical state: the iteration cannot leave it.
///
/// The bulk modulus is K = v p/κ. The shear modulus is either a constant (`shear_modulus`): then elasticity has an energy, and closed elastic
/// paths lose no work; or it follows the bulk modulus with a constant Poisson's ratio (`poisson`), as secants over the step: the usual choice, but
/// one without an energy, so that a closed elastic path may lose or win work (Zytynski et al. 1978).
///
/// The preconsolidation pressure starts at `overconsolidation_ratio` times the isotropic pressure p + q²/(M² p) of the yield surface through the
/// initial stress, or at `preconsolidation_pressure` where that is larger.
///
/// # Validity
///
/// Saturated or dry soft clay, normally to lightly overconsolidated, monotonic loading. The strength is the same in compression and extension
/// (M does not depend on the Lode angle), which is too high in extension. No tension: the stress at the start needs p > 0, and p stays positive.
///
/// # Reference
///
/// K. H. Roscoe and J. B. Burland (1968), in: Engineering Plasticity, Cambridge, 535–609; exponential elasticity and secant moduli after
/// R. I. Borja (1991), Comput. Methods Appl. Mech. Eng. 88, 225–240 (both cited from memory). The yield function and its rates were read in the source of
/// CB-Geo mpm (`modified_cam_clay.tcc`) and in Morikawa and Asai, app. B.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ModifiedCamClay {
    /// M = q/p at the critical state (–), positive; 6 sin φ/(3 − sin φ) in triaxial compression.
    pub critical_state_ratio: f64,
    /// λ, slope of the normal compression line in v – ln p (–), above κ: the compression index C_c over 2.303.
    pub lambda: f64,
    /// κ, slope of the swelling lines in v – ln p (–), positive.
    pub kappa: f64,
    /// Poisson's ratio ν (–), above −1 and below 0.5; 0.3 if neither it nor `shear_modulus` is given.
    pub poisson: Option<f64>,
    /// A constant shear modulus G (Pa), positive, in place of Poisson's ratio.
    pub shear_modulus: Option<f64>,
    /// The void ratio e at the start (–), positive.
    pub void_ratio: f64,
    /// The preconsolidation pressure p_c at the start (Pa), positive in compression, where the overconsolidation ratio does not give a larger one; default 0.
    #[serde(default)]
    pub preconsolidation_pressure: f64,
    /// The overconsolidation ratio at the start (–), in terms of isotropic pressures, at least 1; default 1.
    #[serde(default = "normally_consolidated")]
    pub overconsolidation_ratio: f64,
}

fn normally_consolidated() -> f64 {
    1.0
}

/// Poisson's ratio where a case gives no shear stiffness.
const USUAL_POISSON: f64 = 0.3;

/// What [`ModifiedCamClay`] remembers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CamClayState {
    /// The void ratio e (–).
    pub void_ratio: f64,
    /// The preconsolidation pressure p_c (Pa, positive in compression).
    pub preconsolidation_pressure: f64,
    /// The plastic volumetric strain (–, positive in extension).
    pub plastic_volumetric_strain: f64,
    /// The plastic deviatoric strain √(2/3 Δe^p : Δe^p), summed over the steps (–).
    pub plastic_deviatoric_strain: f64,
    /// Whether the last step was plastic.
    pub yielding: bool,
}

impl ModifiedCamClay {
    /// The isotropic pressure (Pa) of the yield surface through a stress, which must have some compression.
    pub fn yield_pressure(&self, stress: Sym3) -> f64 {
        let (pressure, q) = (stress.pressure(), stress.deviatoric_stress());
        pressure + q * q / (self.critical_state_ratio * self.critical_state_ratio * pressure)
    }

    /// The shear modulus (Pa) that goes with a bulk modulus (Pa).
    fn shear_modulus(&self, bulk_modulus: f64) -> f64 {
        self.shear_modulus.unwrap_or_else(|| {
            let poisson = self.poisson.unwrap_or(USUAL_POISSON);
            bulk_modulus * 1.5 * (1.0 - 2.0 * poisson) / (1.0 + poisson)
        })
    }

    /// The tangent bulk modulus K = v p/κ (Pa).
    fn bulk_modulus(&self, stress: Sym3, state: &CamClayState) -> f64 {
        (1.0 + state.void_ratio) * stress.pressure().max(0.0) / self.kappa
    }
}

/// A strain increment on its way through the law. Pressures and volumetric strains are positive in compression.
struct Step<'a> {
    law: &'a ModifiedCamClay,
    state: CamClayState,
    pressure_old: f64,
    deviator_old: Sym3,
    deviatoric_strain: Sym3,
    compression: f64,
    /// The specific volume v̂ that turns volumetric strains into changes of v (–).
    volume: f64,
}

/// The elastic side of a step, for a given plastic compression.
struct Elastic {
    pressure: f64,
    shear_modulus: f64,
    /// dG/dΔε_v^p (Pa).
    shear_modulus_slope: f64,
    /// The deviator s_old + 2 G Δe (Pa) and its von Mises stress.
    deviator: Sym3,
    von_mises: f64,
}

/// The equation to solve at one stress ratio.
struct Residual {
    value: f64,
    slope: f64,
    plastic_compression: f64,
    elastic: Elastic,
}

/// Newton's method doubles the digits in each iteration; bisection, where it has to step in, adds one bit.
const MOST_ITERATIONS: usize = 100;

impl<'a> Step<'a> {
    fn new(law: &'a ModifiedCamClay, stress: Sym3, state: CamClayState, strain: Sym3) -> Result<Self, LawError> {
        let pressure_old = stress.pressure();
        if !(pressure_old > 0.0 && state.preconsolidation_pressure > 0.0) {
            return Err(LawError::NoCompression { pressure: pressure_old });
        }
        let compression = -strain.trace();
        let volume = (1.0 + state.void_ratio) * relative_growth(-compression, (-compression).exp_m1());
        let (deviator_old, deviatoric_strain) = (stress.deviator(), strain.deviator());
        Ok(Step { law, state, pressure_old, deviator_old, deviatoric_strain, compression, volume })
    }

    fn elastic(&self, plastic_compression: f64) -> Elastic {
        let rate = self.volume / self.law.kappa;
        let exponent = rate * (self.compression - plastic_compression);
        let growth = exponent.exp_m1();
        let secant = rate * self.pressure_old * relative_growth(exponent, growth);
        let shear_modulus = self.law.shear_modulus(secant);
        let shear_modulus_slope = match self.law.shear_modulus {
            Some(_) => 0.0,
            None => -rate * rate * self.pressure_old * relative_growth_slope(exponent, growth) * shear_modulus / secant,
        };
        let deviator = self.deviator_old + self.deviatoric_strain * (2.0 * shear_modulus);
        Elastic {
            pressure: self.pressure_old * (1.0 + growth),
            shear_modulus,
            shear_modulus_slope,
            deviator,
            von_mises: (1.5 * deviator.double_dot(deviator)).sqrt(),
        }
    }

    /// d(Δv^p')/d ln(p/p_c) on the yield surface is −1 over this (–).
    fn closing_rate(&self) -> f64 {
        self.volume * (1.0 / self.law.kappa + 1.0 / (self.law.lambda - self.law.kappa))
    }

    /// The equation Δε_v^p = Δγ (2p − p_c) on the yield surface, where q = M p t and p_c = p (1 + t²).
    ///
    /// ```text
    /// R(t) = M²/6G (q_tr − M p t)(1 − t²) − M Δε_v^p t      Δε_v^p = (ln(p_tr/p_c,old) + ln(1 + t²)) / (v̂/κ + v̂/(λ−κ))
    /// ```
    fn residual(&self, ratio: f64, trial_pressure: f64) -> Residual {
        let m = self.law.critical_state_ratio;
        let growth = 1.0 + ratio * ratio;
        let plastic_compression =
            (trial_pressure / self.state.preconsolidation_pressure * growth).ln() / self.closing_rate();
        let plastic_slope = 2.0 * ratio / (growth * self.closing_rate());
        let elastic = self.elastic(plastic_compression);

        let (factor, excess) =
            (m * m / (6.0 * elastic.shear_modulus), elastic.von_mises - m * elastic.pressure * ratio);
        let shear_modulus_slope = elastic.shear_modulus_slope * plastic_slope;
        let pressure_slope = -self.volume / self.law.kappa * elastic.pressure * plastic_slope;
        let trial_slope = match elastic.von_mises > 0.0 {
            true => 3.0 * elastic.deviator.double_dot(self.deviatoric_strain) / elastic.von_mises * shear_modulus_slope,
            false => 0.0,
        };
        let factor_slope = -factor / elastic.shear_modulus * shear_modulus_slope;
        let excess_slope = trial_slope - m * (pressure_slope * ratio + elastic.pressure);
        let wetness = 1.0 - ratio * ratio;
        Residual {
            value: factor * excess * wetness - m * plastic_compression * ratio,
            slope: (factor_slope * excess + factor * excess_slope) * wetness
                - 2.0 * factor * excess * ratio
                - m * (plastic_slope * ratio + plastic_compression),
            plastic_compression,
            elastic,
        }
    }

    /// Newton's method from the ratio at which nothing is plastic, held between that and the critical state.
    fn plastic(&self, trial_pressure: f64) -> Result<(f64, Residual), LawError> {
        let elastic_ratio = (self.state.preconsolidation_pressure / trial_pressure - 1.0).max(0.0).sqrt();
        // R falls through zero between the elastic ratio and 1 on the wet side, and between 1 and the elastic ratio on the dry one.
        let (mut low, mut high) = (elastic_ratio.min(1.0), elastic_ratio.max(1.0));
        let mut ratio = elastic_ratio;
        let mut residual = self.residual(ratio, trial_pressure);
        for _ in 0..MOST_ITERATIONS {
            match residual.value > 0.0 {
                true => low = ratio,
                false => high = ratio,
            }
            let newton = ratio - residual.value / residual.slope;
            let within = newton >= low && newton <= high;
            let next = if within { newton } else { 0.5 * (low + high) };
            let change = (next - ratio).abs();
            ratio = next;
            residual = self.residual(ratio, trial_pressure);
            // What is left after a step of Newton's is about its square; bisection has no such promise.
            if change <= if within { 1e-10 } else { 1e-15 } * ratio {
                return Ok((ratio, residual));
            }
        }
        Err(LawError::NotConverged { iterations: MOST_ITERATIONS, residual: residual.value })
    }

    /// Stress and history of an elastic step.
    fn end_elastic(&self, elastic: &Elastic) -> (Sym3, CamClayState) {
        let state = CamClayState { void_ratio: self.void_ratio(), yielding: false, ..self.state };
        (elastic.deviator - Sym3::IDENTITY * elastic.pressure, state)
    }

    /// Stress and history on the yield surface.
    fn end_plastic(&self, ratio: f64, solution: &Residual) -> (Sym3, CamClayState) {
        let Residual { plastic_compression, elastic, .. } = solution;
        let von_mises = self.law.critical_state_ratio * elastic.pressure * ratio;
        let share = if elastic.von_mises > 0.0 { von_mises / elastic.von_mises } else { 0.0 };
        let state = CamClayState {
            void_ratio: self.void_ratio(),
            preconsolidation_pressure: elastic.pressure * (1.0 + ratio * ratio),
            plastic_volumetric_strain: self.state.plastic_volumetric_strain - plastic_compression,
            plastic_deviatoric_strain: self.state.plastic_deviatoric_strain
                + (elastic.von_mises - von_mises) / (3.0 * elastic.shear_modulus),
            yielding: true,
        };
        (elastic.deviator * share - Sym3::IDENTITY * elastic.pressure, state)
    }

    fn void_ratio(&self) -> f64 {
        self.state.void_ratio - self.volume * self.compression
    }
}

/// (eˣ − 1)/x, with x and eˣ − 1 given.
fn relative_growth(x: f64, growth: f64) -> f64 {
    if x == 0.0 { 1.0 } else { growth / x }
}

/// The derivative of [`relative_growth`].
fn relative_growth_slope(x: f64, growth: f64) -> f64 {
    // The quotient loses digits where x is small, and the series where it is not: 1e-8 of the slope at 1e-4.
    if x.abs() < 1e-4 { 0.5 + x / 3.0 } else { (1.0 + growth - growth / x) / x }
}

impl ConstitutiveLaw for ModifiedCamClay {
    type State = CamClayState;

    fn update(&self, stress: Sym3, state: CamClayState, strain: Sym3) -> Result<(Sym3, CamClayState), LawError> {
        let step = Step::new(self, stress, state, strain)?;
        let trial = step.elastic(0.0);
        let q_over_m = trial.von_mises / self.critical_state_ratio;
        if q_over_m * q_over_m + trial.pressure * (trial.pressure - state.preconsolidation_pressure) <= 0.0 {
            return Ok(step.end_elastic(&trial));
        }
        let (ratio, solution) = step.plastic(trial.pressure)?;
        Ok(step.end_plastic(ratio, &solution))
    }

    /// Elastic: K + 4/3 G.
    fn p_wave_modulus(&self, stress: Sym3, state: &CamClayState) -> f64 {
        let bulk_modulus = self.bulk_modulus(stress, state);
        bulk_modulus + 4.0 / 3.0 * self.shear_modulus(bulk_modulus)
    }

    fn s_wave_modulus(&self, stress: Sym3, state: &CamClayState) -> f64 {
        self.shear_modulus(self.bulk_modulus(stress, state))
    }

    /// Nothing: with Poisson's ratio elasticity has no energy, and with a constant shear modulus the surface still shrinks on the dry side.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Any
    }

    fn validate(&self) -> Result<(), LawError> {
        require_positive("critical_state_ratio", self.critical_state_ratio, "positive")?;
        require_positive("kappa", self.kappa, "positive")?;
        require(self.lambda > self.kappa && self.lambda.is_finite(), "lambda", self.lambda, "above `kappa`")?;
        require_positive("void_ratio", self.void_ratio, "positive")?;
        if let Some(poisson) = self.poisson {
            require(poisson > -1.0 && poisson < 0.5, "poisson", poisson, "above -1 and below 0.5")?;
        }
        if let Some(modulus) = self.shear_modulus {
            require_positive("shear_modulus", modulus, "positive (Pa)")?;
            require(self.poisson.is_none(), "shear_modulus", modulus, "left out where `poisson` is given")?;
        }
        let (pressure, ratio) = (self.preconsolidation_pressure, self.overconsolidation_ratio);
        let not_negative = pressure >= 0.0 && pressure.is_finite();
        require(not_negative, "preconsolidation_pressure", pressure, "zero or positive (Pa)")?;
        require(ratio >= 1.0 && ratio.is_finite(), "overconsolidation_ratio", ratio, "at least 1")
    }

    fn initial_state(&self, stress: Sym3) -> CamClayState {
        // Without compression there is no surface through the stress; the first update refuses it.
        let by_ratio = self.overconsolidation_ratio * self.yield_pressure(stress);
        let preconsolidation_pressure = self.preconsolidation_pressure.max(by_ratio);
        CamClayState { void_ratio: self.void_ratio, preconsolidation_pressure, ..CamClayState::default() }
    }

    fn outputs(&self) -> &'static [&'static str] {
        &[
            "void_ratio",
            "preconsolidation_pressure",
            "plastic_volumetric_strain",
            "plastic_deviatoric_strain",
            "yielding",
        ]
    }

    fn write_outputs(&self, _stress: Sym3, state: &CamClayState, values: &mut [f64]) {
        values.copy_from_slice(&[
            state.void_ratio,
            state.preconsolidation_pressure,
            state.plastic_volumetric_strain,
            state.plastic_deviatoric_strain,
            f64::from(state.yielding),
        ]);
    }
}
