use serde::{Deserialize, Serialize};

use super::substepping::{NoRates, PlasticRates, StressPoint, SubStepping};
use super::{ClosedPathWork, ConstitutiveLaw, LawError};
use crate::tensor::{Matrix3, Sym3};

/// Cyclic elasto-plastic sand after Oka et al. (1999), the law behind LIQCA: reconstructed from memory, not read in a source.
///
/// Non-linear kinematic hardening of the stress ratio, dilatancy that depends on an overconsolidation boundary surface, and stiffness that
/// is lost from cycle to cycle. It shows pore pressure build-up, cyclic mobility with growing strain, and a liquefaction resistance curve.
///
/// **Nobody should cite results of this law as those of Oka et al. (1999) or of LIQCA** before its equations have been held against the
/// paper. What is least certain: M̃* below the boundary surface, D* and its value on the surface, which line (phase transformation or
/// failure) starts the loss of stiffness, what counts as a reversal and what the counters hold, and the second yield function for changes
/// of the mean stress, which is left out. Each stands in a function of its own. With `hardening_decay` = 0 and the usual size of the other
/// parameters the law stops short of liquefaction; the book's page derives why.
///
/// # Equation
///
/// Compression positive here: p' the mean effective stress, s the deviator, η* = s/p', m the direction of η* − χ*.
///
/// ```text
/// f   = |η* − χ*| − k = 0                                  de^P = dγ m
/// dχ* = B* (M*_f m − χ*) dγ                                dε_v^P = D* (M̃* − η*:m) dγ
/// K   = (1+e₀) p'/κ                                        G = G₀ √(p'/p'₀) / (1 + γ^E_max/γ^E_r)
/// B*  = (B*_max − B*₁) exp(−C_f γ_last) + B*₁              B*_max = B*₀ / (1 + γ^P_max/γ^P_r)
/// f_b = |η* − η*₀| + M*_m ln(p'/p'_b)                      p'_b = OCR* p'₀ exp((1+e₀) ε_v^P/(λ−κ))
/// M̃*  = |η*| / ln(p'_c/p')  if f_b < 0, else M*_m          p'_c = p'_b exp(|η*₀|/M*_m)
/// D*  = D*₀ (M̃*/M*_m)ⁿ     if f_b < 0, else D*₀
/// ```
///
/// The losses by γ_max begin once |η*| has reached M*_m. γ_last is the plastic shear strain between the two reversals before the present
/// one, γ_max the largest so far. Ratios are norms: M* = √(2/3) M of the p'–q plane.
///
/// # Reference
///
/// F. Oka, A. Yashima, A. Tateishi, Y. Taguchi and S. Yamashita (1999), Géotechnique 49(5), 661–680. All equations are recalled; the
/// consistency condition is derived.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OkaCyclic {
    /// Void ratio at the start e₀ (–), positive.
    pub void_ratio: f64,
    /// Compression index λ (–, natural logarithm), above the swelling index.
    pub compression_index: f64,
    /// Swelling index κ (–, natural logarithm), positive.
    pub swelling_index: f64,
    /// Shear modulus over mean effective stress at the start, G₀/p'₀ (–), positive.
    pub shear_modulus_ratio: f64,
    /// Stress ratio of phase transformation M*_m (–), positive; √(2/3) of that in the p'–q plane.
    pub phase_transformation_ratio: f64,
    /// Stress ratio at failure M*_f (–), above the one of phase transformation.
    pub failure_ratio: f64,
    /// Hardening parameter at the start B*₀ (–), positive.
    pub hardening: f64,
    /// Lower bound of the hardening parameter B*₁ (–), from 0 to B*₀.
    pub hardening_least: f64,
    /// How fast plastic shear strain of the last half cycle takes hardening away, C_f (–); 0 or more.
    #[serde(default)]
    pub hardening_decay: f64,
    /// Plastic reference strain γ^P_r (–), positive.
    pub plastic_reference_strain: f64,
    /// Elastic reference strain γ^E_r (–), positive.
    pub elastic_reference_strain: f64,
    /// Dilatancy coefficient D*₀ (–), 0 or more.
    pub dilatancy: f64,
    /// Dilatancy exponent n (–), 0 or more.
    pub dilatancy_exponent: f64,
    /// Size of the boundary surface at the start over the mean effective stress, OCR* (–), 1 or more.
    pub overconsolidation_ratio: f64,
    /// Radius of the elastic region in stress ratios k (–), positive and small; a numerical choice.
    #[serde(default = "default_elastic_radius")]
    pub elastic_radius: f64,
    /// The mean effective stress never falls below this (Pa), positive; the stress ratio is kept. A numerical choice.
    #[serde(default = "default_least_pressure")]
    pub least_pressure: f64,
}

fn default_elastic_radius() -> f64 {
    0.005
}

fn default_least_pressure() -> f64 {
    500.0
}

/// The history of [`OkaCyclic`]. Strains are positive in compression, as in the law's equations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct OkaCyclicState {
    /// Mean effective stress at the start p'₀ (Pa).
    pub initial_pressure: f64,
    /// Stress ratio at the start η*₀ (–), after anisotropic consolidation.
    pub initial_ratio: Sym3,
    /// Centre of the elastic region χ* (–).
    pub back_ratio: Sym3,
    /// Direction m of the last plastic strain (–); zero before the first.
    pub direction: Sym3,
    /// Plastic volumetric strain ε_v^P (–).
    pub plastic_volumetric_strain: f64,
    /// Plastic shear strain since the last reversal (–).
    pub plastic_shear: f64,
    /// Plastic shear strain between the two reversals before, γ_last (–).
    pub last_plastic_shear: f64,
    /// The largest plastic shear strain between reversals, γ^P_max (–).
    pub largest_plastic_shear: f64,
    /// Elastic shear strain since the last reversal (–).
    pub elastic_shear: f64,
    /// The largest elastic shear strain between reversals, γ^E_max (–).
    pub largest_elastic_shear: f64,
    /// True once the stress ratio has reached phase transformation.
    pub transformed: bool,
}

// The ingredients that are least certain, one function each: whoever has the paper corrects them here.
impl OkaCyclic {
    /// The size of the boundary surface p'_b (Pa).
    fn boundary_pressure(&self, state: &OkaCyclicState) -> f64 {
        let rate = (1.0 + self.void_ratio) / (self.compression_index - self.swelling_index);
        self.overconsolidation_ratio * state.initial_pressure * (rate * state.plastic_volumetric_strain).exp()
    }

    /// M̃* of the plastic potential (–).
    fn potential_ratio(&self, pressure: f64, ratio: Sym3, state: &OkaCyclicState) -> f64 {
        let below = (self.boundary_pressure(state) / pressure).ln();
        if (ratio - state.initial_ratio).norm() >= self.phase_transformation_ratio * below {
            return self.phase_transformation_ratio;
        }
        // ln(p'_c/p') is positive here: below > 0.
        ratio.norm() / (below + state.initial_ratio.norm() / self.phase_transformation_ratio)
    }

    /// D* of the flow rule (–). On the boundary surface M̃* = M*_m and D* = D*₀.
    fn dilatancy_factor(&self, potential_ratio: f64) -> f64 {
        self.dilatancy * (potential_ratio / self.phase_transformation_ratio).powf(self.dilatancy_exponent)
    }

    /// B* of the hardening rule (–).
    fn hardening_factor(&self, state: &OkaCyclicState) -> f64 {
        let most = match state.transformed {
            true => self.hardening / (1.0 + state.largest_plastic_shear / self.plastic_reference_strain),
            false => self.hardening,
        };
        (most - self.hardening_least) * (-self.hardening_decay * state.last_plastic_shear).exp() + self.hardening_least
    }

    /// G / √p' (√Pa).
    fn shear_modulus_per_root(&self, state: &OkaCyclicState) -> f64 {
        let whole = self.shear_modulus_ratio * state.initial_pressure.sqrt();
        match state.transformed {
            true => whole / (1.0 + state.largest_elastic_shear / self.elastic_reference_strain),
            false => whole,
        }
    }

    /// The stress ratio (norm) from which on stiffness is lost: phase transformation.
    fn transformation_ratio(&self) -> f64 {
        self.phase_transformation_ratio
    }

    /// True if plastic strain in this direction turns back on the last.
    fn is_reversal(direction: Sym3, state: &OkaCyclicState) -> bool {
        direction.double_dot(state.direction) < 0.0
    }

    /// The history after a reversal.
    fn after_reversal(state: OkaCyclicState) -> OkaCyclicState {
        OkaCyclicState {
            last_plastic_shear: state.plastic_shear,
            largest_plastic_shear: state.largest_plastic_shear.max(state.plastic_shear),
            largest_elastic_shear: state.largest_elastic_shear.max(state.elastic_shear),
            plastic_shear: 0.0,
            elastic_shear: 0.0,
            ..state
        }
    }
}

/// A stress relative to the yield surface.
struct Bearing {
    /// Mean effective stress p' (Pa), no lower than the least.
    pressure: f64,
    /// Stress ratio η* (–).
    ratio: Sym3,
    /// |η* − χ*| (–).
    distance: f64,
    /// The direction m (–).
    direction: Sym3,
}

/// How the law's sub-steps are controlled: errors of stress over p' and of χ* together.
const SUB_STEPPING: SubStepping = SubStepping { tolerance: 1e-5, smallest: 1e-9, yield_tolerance: 1e-12 };

impl OkaCyclic {
    /// K / p' (–).
    fn bulk_rate(&self) -> f64 {
        (1.0 + self.void_ratio) / self.swelling_index
    }

    /// 2 G (Pa).
    fn twice_shear_modulus(&self, pressure: f64, state: &OkaCyclicState) -> f64 {
        2.0 * self.shear_modulus_per_root(state) * pressure.sqrt()
    }

    /// Where a stress stands to the yield surface, or `None` beyond its apex.
    #[inline(always)]
    fn bearing(&self, at: &StressPoint<OkaCyclicState>) -> Option<Bearing> {
        let pressure = at.stress.pressure();
        if pressure <= 0.0 {
            return None;
        }
        let ratio = at.stress.deviator() * (-1.0 / pressure);
        let relative = ratio - at.state.back_ratio;
        let distance = relative.norm();
        // At the very centre every direction is as good.
        let direction = relative * (1.0 / distance.max(f64::MIN_POSITIVE));
        Some(Bearing { pressure: pressure.max(self.least_pressure), ratio, distance, direction })
    }

    /// How fast an elastic strain leads out of the yield surface (Pa): 2G m:de − K (η*:m) dε_v.
    #[inline(always)]
    fn drive_from(&self, bearing: &Bearing, state: &OkaCyclicState, strain: Sym3) -> f64 {
        let Bearing { pressure, ratio, direction, .. } = bearing;
        let bulk = self.bulk_rate() * pressure;
        let twice_shear = self.twice_shear_modulus(*pressure, state);
        bulk * ratio.double_dot(*direction) * strain.trace() - twice_shear * direction.double_dot(strain.deviator())
    }

    /// The stress with the mean effective stress no lower than the least, at the same stress ratio.
    fn kept_closed(&self, stress: Sym3) -> Sym3 {
        let pressure = stress.pressure();
        match (pressure >= self.least_pressure, pressure > 0.0) {
            (true, _) => stress,
            (false, true) => stress * (self.least_pressure / pressure),
            (false, false) => Sym3::IDENTITY * -self.least_pressure,
        }
    }
}

impl PlasticRates for OkaCyclic {
    type State = OkaCyclicState;

    #[inline(always)]
    fn yield_function(&self, at: &StressPoint<OkaCyclicState>) -> f64 {
        self.bearing(at).map_or(f64::INFINITY, |bearing| bearing.distance - self.elastic_radius)
    }

    /// Exact for K in proportion to p' and G to √p'.
    ///
    /// ```text
    /// p' = p'₀ exp(K/p' ε_v)        s = s₀ + 2 G₀ e (exp(y) − 1)/y        y = ½ K/p' ε_v
    /// ```
    #[inline(always)]
    fn elastic(&self, at: &StressPoint<OkaCyclicState>, strain: Sym3) -> StressPoint<OkaCyclicState> {
        let pressure = at.stress.pressure();
        let half = -0.5 * self.bulk_rate() * strain.trace();
        let growth = half.exp();
        let mean = if half.abs() > 1e-5 { half.exp_m1() / half } else { 1.0 + 0.5 * half };
        let deviator = strain.deviator();
        let twice_shear = self.twice_shear_modulus(pressure, &at.state);
        let stress =
            at.stress.deviator() + deviator * (twice_shear * mean) - Sym3::IDENTITY * (pressure * growth * growth);
        let elastic_shear = at.state.elastic_shear + deviator.norm();
        StressPoint { stress, state: OkaCyclicState { elastic_shear, ..at.state } }
    }

    #[inline(always)]
    fn drive(&self, at: &StressPoint<OkaCyclicState>, strain: Sym3) -> f64 {
        self.bearing(at).map_or(0.0, |bearing| self.drive_from(&bearing, &at.state, strain))
    }

    /// Consistency of f, derived:
    ///
    /// ```text
    /// dγ = (2G m:de − K (η*:m) dε_v) / H      H = 2G − K (η*:m) D* (M̃* − η*:m) + p' B* (M*_f − m:χ*)
    /// ds = 2G (de − dγ m)                     dp' = K (dε_v − D* (M̃* − η*:m) dγ)
    /// ```
    #[inline(always)]
    fn change(&self, at: &StressPoint<OkaCyclicState>, strain: Sym3) -> Result<StressPoint<OkaCyclicState>, NoRates> {
        let state = &at.state;
        let bearing = self.bearing(at).ok_or(NoRates::BeyondApex)?;
        let Bearing { pressure, ratio, direction, .. } = bearing;
        let (twice_shear, bulk) = (self.twice_shear_modulus(pressure, state), self.bulk_rate() * pressure);
        let along = ratio.double_dot(direction);
        let potential_ratio = self.potential_ratio(pressure, ratio, state);
        let contraction = self.dilatancy_factor(potential_ratio) * (potential_ratio - along);
        let hardening = self.hardening_factor(state);
        let room = self.failure_ratio - direction.double_dot(state.back_ratio);
        let modulus = twice_shear - bulk * along * contraction + pressure * hardening * room;
        if modulus <= 0.0 || modulus.is_nan() {
            return Err(NoRates::SnapBack { modulus });
        }
        let shear = self.drive_from(&bearing, state, strain).max(0.0) / modulus;
        // In tension-positive measure, as the strain.
        let elastic = strain.deviator() + direction * shear;
        let mean = bulk * (strain.trace() + contraction * shear);
        let change = OkaCyclicState {
            back_ratio: (direction * self.failure_ratio - state.back_ratio) * (hardening * shear),
            plastic_volumetric_strain: contraction * shear,
            plastic_shear: shear,
            elastic_shear: elastic.norm(),
            ..OkaCyclicState::default()
        };
        Ok(StressPoint { stress: elastic * twice_shear + Sym3::IDENTITY * mean, state: change })
    }

    #[inline(always)]
    fn add(&self, state: &OkaCyclicState, change: &OkaCyclicState, factor: f64) -> OkaCyclicState {
        OkaCyclicState {
            back_ratio: state.back_ratio + change.back_ratio * factor,
            plastic_volumetric_strain: state.plastic_volumetric_strain + change.plastic_volumetric_strain * factor,
            plastic_shear: state.plastic_shear + change.plastic_shear * factor,
            elastic_shear: state.elastic_shear + change.elastic_shear * factor,
            ..*state
        }
    }

    /// Three quarters of what is stable. A turn of m by a small angle is drawn back by η* and by χ*, derived:
    ///
    /// ```text
    /// dm/m = −(2G/p' + B* M*_f)/k dγ        dγ ≤ |de| 2G / (2G + p' B* (M*_f − m:χ*))
    /// ```
    #[inline(always)]
    fn stable_sub_step(&self, at: &StressPoint<OkaCyclicState>, strain: Sym3) -> f64 {
        let Some(Bearing { pressure, direction, .. }) = self.bearing(at) else { return 1.0 };
        let stiffness = self.twice_shear_modulus(pressure, &at.state) / pressure;
        let hardening = self.hardening_factor(&at.state);
        let room = self.failure_ratio - direction.double_dot(at.state.back_ratio);
        let shear = strain.deviator().norm() * stiffness / (stiffness + hardening * room);
        (1.5 * self.elastic_radius / (shear * (stiffness + hardening * self.failure_ratio))).min(1.0)
    }

    /// Stresses settle round χ*, so its error is theirs.
    #[inline(always)]
    fn distance(&self, stress: Sym3, first: &StressPoint<OkaCyclicState>, second: &StressPoint<OkaCyclicState>) -> f64 {
        let pressure = stress.pressure().max(self.least_pressure);
        (second.stress - first.stress).norm() / pressure + (second.state.back_ratio - first.state.back_ratio).norm()
    }

    /// Back to the yield surface, above the least pressure; a reversal is counted, and phase transformation noted.
    #[inline(always)]
    fn settle(&self, at: StressPoint<OkaCyclicState>) -> StressPoint<OkaCyclicState> {
        let mut state = at.state;
        // Rounding leaves traces behind, and division by the small radius makes them grow.
        state.back_ratio = state.back_ratio.deviator();
        let stress = self.kept_closed(at.stress);
        let Some(Bearing { pressure, direction, .. }) = self.bearing(&StressPoint { stress, state }) else {
            return StressPoint { stress, state };
        };
        if Self::is_reversal(direction, &state) {
            state = Self::after_reversal(state);
        }
        state.direction = direction;
        let ratio = state.back_ratio + direction * self.elastic_radius;
        state.transformed |= ratio.norm() >= self.transformation_ratio();
        StressPoint { stress: (ratio + Sym3::IDENTITY) * -pressure, state }
    }
}

impl ConstitutiveLaw for OkaCyclic {
    type State = OkaCyclicState;

    fn update(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<(Sym3, Self::State), LawError> {
        if !strain.is_finite() {
            return Err(LawError::NotFinite { strain });
        }
        // Below the least pressure the elastic region lies round the deviator as it is, as at the start.
        let lift = (self.least_pressure - stress.pressure()).max(0.0);
        let start = StressPoint { stress: stress - Sym3::IDENTITY * lift, state };
        let StressPoint { stress, state } = SUB_STEPPING.integrate(self, start, strain)?;
        Ok((self.kept_closed(stress), state))
    }

    fn p_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64 {
        self.bulk_rate() * stress.pressure().max(self.least_pressure) + 4.0 / 3.0 * self.s_wave_modulus(stress, state)
    }

    fn s_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64 {
        self.shear_modulus_per_root(state) * stress.pressure().max(self.least_pressure).sqrt()
    }

    /// Nothing: moduli follow the pressure without an energy behind them, and flow is not along the normal.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Any
    }

    fn validate(&self) -> Result<(), LawError> {
        let refuse = |name, value, expected| Err(LawError::Parameter { name, value, expected });
        for (name, value) in [
            ("void_ratio", self.void_ratio),
            ("swelling_index", self.swelling_index),
            ("shear_modulus_ratio", self.shear_modulus_ratio),
            ("phase_transformation_ratio", self.phase_transformation_ratio),
            ("hardening", self.hardening),
            ("plastic_reference_strain", self.plastic_reference_strain),
            ("elastic_reference_strain", self.elastic_reference_strain),
            ("elastic_radius", self.elastic_radius),
            ("least_pressure", self.least_pressure),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return refuse(name, value, "positive");
            }
        }
        for (name, value) in [
            ("hardening_decay", self.hardening_decay),
            ("dilatancy", self.dilatancy),
            ("dilatancy_exponent", self.dilatancy_exponent),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return refuse(name, value, "0 or more");
            }
        }
        if !(self.compression_index > self.swelling_index && self.compression_index.is_finite()) {
            return refuse("compression_index", self.compression_index, "above the swelling index");
        }
        if !(self.failure_ratio > self.phase_transformation_ratio && self.failure_ratio.is_finite()) {
            return refuse("failure_ratio", self.failure_ratio, "above the phase transformation ratio");
        }
        if !(self.hardening_least >= 0.0 && self.hardening_least <= self.hardening) {
            return refuse("hardening_least", self.hardening_least, "from 0 to the hardening at the start");
        }
        if !(self.overconsolidation_ratio >= 1.0 && self.overconsolidation_ratio.is_finite()) {
            return refuse("overconsolidation_ratio", self.overconsolidation_ratio, "1 or more");
        }
        Ok(())
    }

    /// The elastic region lies round the stress. A mean stress below the least pressure counts as that.
    fn initial_state(&self, stress: Sym3) -> Self::State {
        let initial_pressure = stress.pressure().max(self.least_pressure);
        let initial_ratio = -stress.deviator() * (1.0 / initial_pressure);
        let transformed = initial_ratio.norm() >= self.transformation_ratio();
        OkaCyclicState { initial_pressure, initial_ratio, back_ratio: initial_ratio, transformed, ..Default::default() }
    }

    fn rotate_state(&self, state: Self::State, rotation: &Matrix3) -> Self::State {
        OkaCyclicState {
            initial_ratio: state.initial_ratio.rotated(rotation),
            back_ratio: state.back_ratio.rotated(rotation),
            direction: state.direction.rotated(rotation),
            ..state
        }
    }

    /// The stress ratio |η*|; strains positive in extension.
    fn outputs(&self) -> &'static [&'static str] {
        &["stress_ratio", "plastic_volumetric_strain", "plastic_shear_since_reversal", "hardening", "transformed"]
    }

    fn write_outputs(&self, stress: Sym3, state: &Self::State, values: &mut [f64]) {
        let ratio = stress.deviator().norm() / stress.pressure().max(self.least_pressure);
        let volumetric = -state.plastic_volumetric_strain;
        let transformed = f64::from(u8::from(state.transformed));
        values.copy_from_slice(&[ratio, volumetric, state.plastic_shear, self.hardening_factor(state), transformed]);
    }
}
