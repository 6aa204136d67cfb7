use serde::{Deserialize, Serialize};

use super::root_pressure::RootPressure;
use super::substepping::{NoRates, PlasticRates, StressPoint, SubStepping};
use super::{ClosedPathWork, ConstitutiveLaw, LawError};
use crate::tensor::{Matrix3, Sym3};

/// SANISAND 2004: sand of any density by bounding surfaces, from monotonic loading to liquefaction.
///
/// # Equation
///
/// Compression is positive here; p = ⅓ tr σ', s = σ' − p I, r = s/p, and n = (r − α)/|r − α|.
///
/// ```text
/// G = G₀ p_at (2.97 − e)²/(1 + e) √(p/p_at)      K = 2(1 + ν)/3(1 − 2ν) G
/// f = |r − α| − √⅔ m                             ψ = e − e₀ + λ_c (p/p_at)^ξ
/// cos 3θ = √6 tr n³                              g = 2c/[(1 + c) − (1 − c) cos 3θ]
/// α^b = √⅔ [g M exp(−n_b ψ) − m] n               α^d = √⅔ [g M exp(n_d ψ) − m] n
/// dα = L ⅔ h (α^b − α)                           h = G₀ h₀ (1 − c_h e) √(p_at/p) / (α − α_in) : n
/// D = A₀ (1 + ⟨z : n⟩) (α^d − α) : n             dz = −c_z ⟨−L D⟩ (z_max n + z)
/// dε^p = L [B n − C (n² − ⅓ I) + ⅓ D I]          B = 1 + 3(1 − c)/2c g cos 3θ,   C = 3√(3/2) (1 − c)/c g
/// ```
///
/// with L from the consistency of f, and α_in := α where (α − α_in) : n becomes negative. G follows the void ratio of the moment. Where α is
/// beyond the bounding surface h is limited so that softening takes at most half of the elastic resistance to plastic flow: without that a
/// reversal there has no answer.
///
/// At low pressures two guards of OpenSees are used: p + p_r stands in place of p everywhere but in the moduli, and D is divided by
/// 1 + exp(7.6349 − 7.2713 (p + p_r)/p_r) below p + p_r = 5 p_r. With p_r = 0 the equations are those of the paper. p never falls below
/// p_at/10000: what opens keeps that.
///
/// The strain is integrated in sub-steps of the modified Euler method with controlled error.
///
/// # Validity
///
/// Drained and undrained sand, monotonic and cyclic, one set of parameters for all densities and pressures. Loading at constant stress
/// ratio (isotropic compression) stays elastic. After liquefaction the cyclic strain grows little: the loops lock at about one per cent.
///
/// # Reference
///
/// Y. F. Dafalias and M. T. Manzari (2004), J. Eng. Mech. 130(6), 622–634. The paper was not at hand: the equations were read in OpenSees
/// (`ManzariDafalias.cpp`), whose answers this law meets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sanisand {
    /// Void ratio e at the start (–), positive and below 2.97.
    pub void_ratio: f64,
    /// Atmospheric pressure p_at that the other parameters refer to (Pa), positive.
    pub atmospheric_pressure: f64,
    /// Number of the shear modulus G₀ (–), positive.
    pub shear_modulus_number: f64,
    /// Poisson's ratio ν (–), above −1 and below 0.5.
    pub poisson: f64,
    /// Critical stress ratio M = q/p in triaxial compression (–), positive.
    pub critical_stress_ratio: f64,
    /// Critical stress ratio in extension over that in compression, c (–), above 0 and at most 1.
    pub extension_ratio: f64,
    /// Void ratio e₀ of the critical state line at p = 0 (–), positive.
    pub critical_void_ratio: f64,
    /// Slope λ_c of the critical state line (–), not negative.
    pub critical_slope: f64,
    /// Exponent ξ of the critical state line (–), positive.
    pub critical_exponent: f64,
    /// Opening m of the yield surface as a stress ratio (–), positive.
    pub yield_opening: f64,
    /// Number of the plastic modulus h₀ (–), positive.
    pub hardening_number: f64,
    /// Influence c_h of the void ratio on the plastic modulus (–), not negative.
    pub hardening_void_ratio: f64,
    /// Exponent n_b of the bounding surface (–), not negative.
    pub bounding_exponent: f64,
    /// Number of the dilatancy A₀ (–), not negative.
    pub dilatancy_number: f64,
    /// Exponent n_d of the dilatancy surface (–), not negative.
    pub dilatancy_exponent: f64,
    /// Limit z_max of the fabric tensor (–), not negative.
    pub fabric_limit: f64,
    /// Rate c_z of the fabric tensor (–), not negative.
    pub fabric_rate: f64,
    /// Residual pressure p_r (Pa), not negative: keeps the equations away from the apex. 1000 Pa if left out.
    #[serde(default = "residual_pressure")]
    pub residual_pressure: f64,
    /// Largest error of a sub-step relative to the stress (–), positive. 1e-4 if left out.
    #[serde(default = "sub_step_tolerance")]
    pub sub_step_tolerance: f64,
    /// Smallest sub-step as a fraction of the strain increment (–), positive. 1e-6 if left out.
    #[serde(default = "smallest_sub_step")]
    pub smallest_sub_step: f64,
}

fn residual_pressure() -> f64 {
    1000.0
}

fn sub_step_tolerance() -> f64 {
    1e-4
}

fn smallest_sub_step() -> f64 {
    1e-6
}

/// The history of [`Sanisand`]: tensors in compression-positive measure.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SanisandState {
    /// Back-stress ratio α (–), the axis of the yield surface.
    pub back_stress_ratio: Sym3,
    /// α at the last reversal of the loading, α_in (–).
    pub back_stress_ratio_at_reversal: Sym3,
    /// Fabric-dilatancy tensor z (–).
    pub fabric: Sym3,
    /// Void ratio e (–).
    pub void_ratio: f64,
    /// Plastic volumetric strain (–), positive in extension.
    pub plastic_volumetric_strain: f64,
    /// Accumulated plastic shear strain, Σ √(⅔ Δe^p : Δe^p) (–).
    pub plastic_shear_strain: f64,
}

/// √⅔ and √6.
const ROOT_2_3: f64 = 0.816_496_580_927_726;
const ROOT_6: f64 = 2.449_489_742_783_178;

impl Sanisand {
    /// The void ratio e_c (–) of the critical state line at a mean effective pressure (Pa, positive in compression).
    pub fn critical_state_line(&self, pressure: f64) -> f64 {
        let relative = pressure / self.atmospheric_pressure;
        self.critical_void_ratio - self.critical_slope * relative.powf(self.critical_exponent)
    }

    fn smallest_pressure(&self) -> f64 {
        1e-4 * self.atmospheric_pressure
    }

    /// G/√p (√Pa).
    fn shear_stiffness(&self, void_ratio: f64) -> f64 {
        let void_function = (2.97 - void_ratio) * (2.97 - void_ratio) / (1.0 + void_ratio);
        self.shear_modulus_number * void_function * self.atmospheric_pressure.sqrt()
    }

    /// K/G (–).
    fn bulk_ratio(&self) -> f64 {
        2.0 * (1.0 + self.poisson) / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// The shear modulus (Pa) at a stress.
    fn shear_modulus(&self, stress: Sym3, state: &SanisandState) -> f64 {
        self.shear_stiffness(state.void_ratio) * stress.pressure().max(self.smallest_pressure()).sqrt()
    }

    /// Radius of the yield surface in stress ratios, √⅔ m.
    fn yield_radius(&self) -> f64 {
        ROOT_2_3 * self.yield_opening
    }

    /// 1/[1 + exp(7.6349 − 7.2713 p/p_r)] at low pressures, 1 elsewhere.
    fn dilatancy_guard(&self, pressure: f64) -> f64 {
        match pressure < 5.0 * self.residual_pressure {
            true => 1.0 / (1.0 + (7.6349 - 7.2713 * pressure / self.residual_pressure).exp()),
            false => 1.0,
        }
    }

    /// Where a stress stands to the surfaces, or `None` beyond the apex.
    #[inline(always)]
    fn bearing(&self, stress: Sym3, back_stress_ratio: Sym3) -> Option<Bearing> {
        let pressure = stress.pressure() + self.residual_pressure;
        if pressure <= 0.0 {
            return None;
        }
        let ratio = stress.deviator() * (-1.0 / pressure);
        let off_axis = ratio - back_stress_ratio;
        let distance = off_axis.norm();
        // On the axis every direction is as good.
        let normal = off_axis * (1.0 / distance.max(f64::MIN_POSITIVE));
        Some(Bearing { pressure, ratio, distance, normal })
    }

    /// How fast an elastic strain increment leads out of the yield surface, over the shear modulus (–): 2 n:de − K/G dε_v n:r.
    #[inline(always)]
    fn relative_drive(&self, bearing: &Bearing, strain: Sym3) -> f64 {
        let Bearing { ratio, normal, .. } = bearing;
        self.bulk_ratio() * strain.trace() * normal.double_dot(*ratio) - 2.0 * normal.double_dot(strain.deviator())
    }

    /// The stress and history with the pressure raised to the smallest one, at the same stress ratio.
    fn kept_closed(&self, stress: Sym3) -> Sym3 {
        let (mean, smallest) = (stress.pressure(), self.smallest_pressure());
        if mean >= smallest {
            return stress;
        }
        let pressure = mean + self.residual_pressure;
        let shrunk = match pressure > 0.0 {
            true => (smallest + self.residual_pressure) / pressure,
            false => 0.0,
        };
        stress.deviator() * shrunk - Sym3::IDENTITY * smallest
    }
}

/// A stress relative to the yield surface.
struct Bearing {
    /// p + p_r (Pa).
    pressure: f64,
    /// r (–).
    ratio: Sym3,
    /// |r − α| (–).
    distance: f64,
    /// n (–).
    normal: Sym3,
}

/// a · a.
#[inline(always)]
fn squared(a: Sym3) -> Sym3 {
    Sym3 {
        xx: a.xx * a.xx + a.xy * a.xy + a.zx * a.zx,
        yy: a.xy * a.xy + a.yy * a.yy + a.yz * a.yz,
        zz: a.zx * a.zx + a.yz * a.yz + a.zz * a.zz,
        xy: a.xx * a.xy + a.xy * a.yy + a.zx * a.yz,
        yz: a.xy * a.zx + a.yy * a.yz + a.yz * a.zz,
        zx: a.xx * a.zx + a.xy * a.yz + a.zx * a.zz,
    }
}

impl PlasticRates for Sanisand {
    type State = SanisandState;

    #[inline(always)]
    fn yield_function(&self, at: &StressPoint<SanisandState>) -> f64 {
        let bearing = self.bearing(at.stress, at.state.back_stress_ratio);
        bearing.map_or(f64::INFINITY, |bearing| bearing.distance - self.yield_radius())
    }

    #[inline(always)]
    fn elastic(&self, at: &StressPoint<SanisandState>, strain: Sym3) -> StressPoint<SanisandState> {
        let volumetric = strain.trace();
        let void_ratio = at.state.void_ratio + (1.0 + at.state.void_ratio) * volumetric;
        let shear = self.shear_stiffness(0.5 * (at.state.void_ratio + void_ratio));
        let bulk = self.bulk_ratio() * shear;
        let path = RootPressure::after(at.stress.pressure(), bulk, -volumetric, self.smallest_pressure());
        let deviator = at.stress.deviator() + strain.deviator() * (2.0 * shear * path.mean_root);
        let stress = deviator - Sym3::IDENTITY * path.pressure;
        StressPoint { stress, state: SanisandState { void_ratio, ..at.state } }
    }

    #[inline(always)]
    fn drive(&self, at: &StressPoint<SanisandState>, strain: Sym3) -> f64 {
        let bearing = self.bearing(at.stress, at.state.back_stress_ratio);
        bearing.map_or(0.0, |bearing| self.relative_drive(&bearing, strain))
    }

    #[inline(always)]
    fn change(&self, at: &StressPoint<SanisandState>, strain: Sym3) -> Result<StressPoint<SanisandState>, NoRates> {
        let state = &at.state;
        let bearing = self.bearing(at.stress, state.back_stress_ratio).ok_or(NoRates::BeyondApex)?;
        let Bearing { pressure, ratio, normal: n, .. } = bearing;
        let n_squared = squared(n);
        let cubed_trace = n_squared.double_dot(n);
        let cos_3_theta = (ROOT_6 * cubed_trace).clamp(-1.0, 1.0);
        let c = self.extension_ratio;
        let lode = 2.0 * c / ((1.0 + c) - (1.0 - c) * cos_3_theta);
        let state_parameter = state.void_ratio - self.critical_state_line(pressure);
        let critical = lode * self.critical_stress_ratio;
        let surface = |exponent: f64| ROOT_2_3 * (critical * (exponent * state_parameter).exp() - self.yield_opening);
        let (bounding, dilatancy_surface) = (surface(-self.bounding_exponent), surface(self.dilatancy_exponent));
        let along = state.back_stress_ratio.double_dot(n);

        // With h = b₀/u, L = u L/u stays finite at a reversal, where u = (α − α_in) : n is zero.
        let since_reversal = (state.back_stress_ratio - state.back_stress_ratio_at_reversal).double_dot(n).max(0.0);
        let hardening = self.shear_modulus_number
            * self.hardening_number
            * (1.0 - self.hardening_void_ratio * state.void_ratio)
            * (self.atmospheric_pressure / pressure).sqrt();
        let dilatancy = self.dilatancy_number
            * (1.0 + state.fabric.double_dot(n).max(0.0))
            * (dilatancy_surface - along)
            * self.dilatancy_guard(pressure);
        let flow_ratio = (1.0 - c) / c * lode;
        let (flow_b, flow_c) = (1.0 + 1.5 * flow_ratio * cos_3_theta, 3.0 * 1.5_f64.sqrt() * flow_ratio);

        let shear = self.shear_modulus(at.stress, state);
        let bulk = self.bulk_ratio() * shear;
        let (volumetric, deviator) = (-strain.trace(), -strain.deviator());
        let n_ratio = n.double_dot(ratio);
        let loading = shear * self.relative_drive(&bearing, strain);
        let elastic_part = 2.0 * shear * (flow_b - flow_c * cubed_trace) - bulk * dilatancy * n_ratio;
        // K_p u: beyond the bounding surface h is limited, so that softening takes half of the elastic resistance at most.
        let plastic_part = 2.0 / 3.0 * pressure * hardening * (bounding - along);
        let arm = since_reversal.max(-2.0 * plastic_part / elastic_part);
        // L/u; there is no plastic strain on unloading.
        let multiplier = loading.max(0.0) / (plastic_part + arm * elastic_part);
        let amount = multiplier * arm;

        let plastic_deviator = (n * flow_b - (n_squared - Sym3::IDENTITY * (1.0 / 3.0)) * flow_c) * amount;
        let plastic_volumetric = amount * dilatancy;
        let mean = bulk * (volumetric - plastic_volumetric);
        let stress = (plastic_deviator - deviator) * (2.0 * shear) - Sym3::IDENTITY * mean;
        let fabric_growth = self.fabric_rate * (-plastic_volumetric).max(0.0);
        let change = SanisandState {
            back_stress_ratio: (n * bounding - state.back_stress_ratio) * (2.0 / 3.0 * hardening * multiplier),
            back_stress_ratio_at_reversal: Sym3::ZERO,
            fabric: (n * self.fabric_limit + state.fabric) * -fabric_growth,
            void_ratio: -(1.0 + state.void_ratio) * volumetric,
            plastic_volumetric_strain: -plastic_volumetric,
            plastic_shear_strain: ROOT_2_3 * plastic_deviator.norm(),
        };
        Ok(StressPoint { stress, state: change })
    }

    #[inline(always)]
    fn add(&self, state: &SanisandState, change: &SanisandState, factor: f64) -> SanisandState {
        SanisandState {
            back_stress_ratio: state.back_stress_ratio + change.back_stress_ratio * factor,
            back_stress_ratio_at_reversal: state.back_stress_ratio_at_reversal,
            fabric: state.fabric + change.fabric * factor,
            void_ratio: state.void_ratio + change.void_ratio * factor,
            plastic_volumetric_strain: state.plastic_volumetric_strain + change.plastic_volumetric_strain * factor,
            plastic_shear_strain: state.plastic_shear_strain + change.plastic_shear_strain * factor,
        }
    }

    /// Half of what is stable: the stress deviator moves by the radius of the yield surface.
    #[inline(always)]
    fn stable_sub_step(&self, at: &StressPoint<SanisandState>, strain: Sym3) -> f64 {
        let pressure = at.stress.pressure().max(self.smallest_pressure()) + self.residual_pressure;
        let deviator = strain.deviator();
        let elastic = 2.0 * self.shear_modulus(at.stress, &at.state) * deviator.norm();
        (self.yield_radius() * pressure / elastic).min(1.0)
    }

    #[inline(always)]
    fn distance(&self, stress: Sym3, first: &StressPoint<SanisandState>, second: &StressPoint<SanisandState>) -> f64 {
        let scale = stress.norm().max(self.residual_pressure).max(self.smallest_pressure());
        (second.stress - first.stress).norm() / scale
    }

    /// Back to the yield surface at the same pressure and back-stress ratio; a reversal is noted.
    #[inline(always)]
    fn settle(&self, at: StressPoint<SanisandState>) -> StressPoint<SanisandState> {
        let StressPoint { mut stress, mut state } = at;
        stress = self.kept_closed(stress);
        let Some(Bearing { pressure, distance, normal, .. }) = self.bearing(stress, state.back_stress_ratio) else {
            return StressPoint { stress, state };
        };
        let radius = self.yield_radius();
        if distance > radius {
            let deviator = (state.back_stress_ratio + normal * radius) * -pressure;
            stress = deviator + Sym3::IDENTITY * (stress.trace() / 3.0);
        }
        if (state.back_stress_ratio - state.back_stress_ratio_at_reversal).double_dot(normal) < 0.0 {
            state.back_stress_ratio_at_reversal = state.back_stress_ratio;
        }
        StressPoint { stress, state }
    }
}

impl ConstitutiveLaw for Sanisand {
    type State = SanisandState;

    fn update(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<(Sym3, Self::State), LawError> {
        if strain == Sym3::ZERO {
            return Ok((stress, state));
        }
        let settings = SubStepping {
            tolerance: self.sub_step_tolerance,
            smallest: self.smallest_sub_step,
            yield_tolerance: YIELD_TOLERANCE,
        };
        let start = StressPoint { stress: self.kept_closed(stress), state };
        let StressPoint { stress, state } = settings.integrate(self, start, strain)?;
        Ok((stress, state))
    }

    fn p_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64 {
        STIFFER_THAN_ELASTIC * (self.bulk_ratio() + 4.0 / 3.0) * self.shear_modulus(stress, state)
    }

    fn s_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64 {
        STIFFER_THAN_ELASTIC * self.shear_modulus(stress, state)
    }

    /// Nothing: moduli follow the pressure without an energy behind them, and flow is not along the normal.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Any
    }

    fn validate(&self) -> Result<(), LawError> {
        let positive: [(_, f64); 10] = [
            ("void_ratio", self.void_ratio),
            ("atmospheric_pressure", self.atmospheric_pressure),
            ("shear_modulus_number", self.shear_modulus_number),
            ("critical_stress_ratio", self.critical_stress_ratio),
            ("critical_void_ratio", self.critical_void_ratio),
            ("critical_exponent", self.critical_exponent),
            ("yield_opening", self.yield_opening),
            ("hardening_number", self.hardening_number),
            ("sub_step_tolerance", self.sub_step_tolerance),
            ("smallest_sub_step", self.smallest_sub_step),
        ];
        let not_negative: [(_, f64); 8] = [
            ("critical_slope", self.critical_slope),
            ("hardening_void_ratio", self.hardening_void_ratio),
            ("bounding_exponent", self.bounding_exponent),
            ("dilatancy_number", self.dilatancy_number),
            ("dilatancy_exponent", self.dilatancy_exponent),
            ("fabric_limit", self.fabric_limit),
            ("fabric_rate", self.fabric_rate),
            ("residual_pressure", self.residual_pressure),
        ];
        let refuse = |name, value, expected| Err(LawError::Parameter { name, value, expected });
        if let Some(&(name, value)) = positive.iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
            return refuse(name, value, "positive");
        }
        if let Some(&(name, value)) = not_negative.iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            return refuse(name, value, "zero or positive");
        }
        if self.void_ratio >= 2.97 {
            return refuse("void_ratio", self.void_ratio, "below 2.97");
        }
        if self.hardening_void_ratio * self.void_ratio >= 1.0 {
            return refuse("hardening_void_ratio", self.hardening_void_ratio, "below 1/void_ratio");
        }
        if !(self.poisson > -1.0 && self.poisson < 0.5) {
            return refuse("poisson", self.poisson, "above -1 and below 0.5");
        }
        match self.extension_ratio > 0.0 && self.extension_ratio <= 1.0 {
            true => Ok(()),
            false => refuse("extension_ratio", self.extension_ratio, "above 0 and at most 1"),
        }
    }

    /// The stress stands in the middle of the yield surface, which is where the last reversal was; no fabric.
    fn initial_state(&self, stress: Sym3) -> Self::State {
        let pressure = stress.pressure() + self.residual_pressure;
        let back_stress_ratio = match pressure > self.smallest_pressure() {
            true => stress.deviator() * (-1.0 / pressure),
            false => Sym3::ZERO,
        };
        SanisandState {
            back_stress_ratio,
            back_stress_ratio_at_reversal: back_stress_ratio,
            void_ratio: self.void_ratio,
            ..SanisandState::default()
        }
    }

    fn rotate_state(&self, state: Self::State, rotation: &Matrix3) -> Self::State {
        SanisandState {
            back_stress_ratio: state.back_stress_ratio.rotated(rotation),
            back_stress_ratio_at_reversal: state.back_stress_ratio_at_reversal.rotated(rotation),
            fabric: state.fabric.rotated(rotation),
            ..state
        }
    }

    fn outputs(&self) -> &'static [&'static str] {
        &[
            "void_ratio",
            "state_parameter",
            "back_stress_ratio",
            "fabric",
            "plastic_volumetric_strain",
            "plastic_shear_strain",
        ]
    }

    fn write_outputs(&self, stress: Sym3, state: &Self::State, values: &mut [f64]) {
        let pressure = stress.pressure().max(0.0) + self.residual_pressure;
        values.copy_from_slice(&[
            state.void_ratio,
            state.void_ratio - self.critical_state_line(pressure),
            // As q/p in triaxial compression.
            1.5_f64.sqrt() * state.back_stress_ratio.norm(),
            state.fabric.norm(),
            state.plastic_volumetric_strain,
            state.plastic_shear_strain,
        ]);
    }
}

/// Plastic flow that is not along the normal of the yield surface makes some directions stiffer than elasticity. In shear at c = 0.7 they are
/// 27° apart, which is worth (1/cos 27° − 1)/2 = 6 %.
const STIFFER_THAN_ELASTIC: f64 = 1.1;

/// How far from the yield surface a stress ratio counts as on it: far above rounding, far below the opening.
const YIELD_TOLERANCE: f64 = 1e-12;
