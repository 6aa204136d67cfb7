use serde::{Deserialize, Serialize};

use super::root_pressure::RootPressure;
use super::substepping::{NoRates, PlasticRates, StressPoint, SubStepping};
use super::{ClosedPathWork, ConstitutiveLaw, LawError};
use crate::tensor::{Matrix3, Matrix6, Sym3};

/// PM4Sand version 3.1: liquefaction of sand in plane strain, calibrated by relative density and cyclic strength.
///
/// # Equation
///
/// Compression is positive here; p = ½ (σ'_xx + σ'_yy), s = σ' − p I and r = s/p in the plane, n = (r − α)/|r − α|, M = 2 |r_max|.
///
/// ```text
/// ξ_R = R/[Q − ln(100 p/p_A)] − D_R             M_cv = 2 sin φ_cv
/// M^b = M_cv exp(−n_b ξ_R)                      M^d = M_cv exp(n_d ξ_R)          (n_b/4 and 4 n_d where ξ_R > 0)
/// f = |r − α| − √½ m                            α^b = √½ (M^b − m) n             α^d = √½ (M^d − m) n
/// G = G₀ √(p_A p) [1 − ½ min(1, (M/M^b)⁴)] (1 + z_cum/z_max)/(1 + C_GD z_cum/z_max)
/// K = 2(1 + ν)/3(1 − 2ν) G                      dσ = 2G de + K dε_v I − L (2G n + K D I)
/// dα = ⅔ L h (α^b − α)                          dz = −c_z/(1 + ⟨z_cum/2z_max − 1⟩) L (z_max n + z)  where D < 0 and (α^d − α) : n < 0
/// ```
///
/// h and D follow the manual's expressions of the back-stress ratios at the last reversals (apparent, true and previous), of the fabric z,
/// its sum z_cum and its peak, of p at the largest fabric; they are written out in the book. p never falls below a fifth of
/// p_min = max(p₀, p_A)/200. M > M^b is pulled back to M^b.
///
/// The strain is integrated in sub-steps of the modified Euler method with controlled error.
///
/// # Validity
///
/// Plane strain in x and y: a strain or shear stress out of that plane is an error. The stress across the plane has no part in the law; it is
/// kept in proportion to p. The apparent reversal point is found component by component, as the manual has it, in axes that turn with the
/// material from the grid's at the start; the law is meant for shaking of level or sloping ground, where y is up. Elastic stiffness after
/// shaking (the manual's F_sed) is left out.
///
/// # Reference
///
/// R. W. Boulanger and K. Ziotopoulou, PM4Sand (version 3.1), University of California, Davis (2017). The manual was not at hand: the
/// equations were read in OpenSees (`PM4Sand.cpp`), whose answers this law meets. OpenSees lets the fabric grow with L wherever D is
/// negative; whether the manual means L ⟨−D⟩ was not checked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Pm4Sand {
    /// Relative density D_R at the start (–), above 0 and at most 1.
    pub relative_density: f64,
    /// Number of the shear modulus G₀ (–), positive: 167 √((N₁)₆₀ + 2.5) if nothing better is known.
    pub shear_modulus_number: f64,
    /// Number of the contraction h_po (–), positive: fitted to the cyclic strength.
    pub contraction_number: f64,
    /// Atmospheric pressure p_A (Pa), positive. 101300 Pa if left out.
    #[serde(default = "atmospheric_pressure")]
    pub atmospheric_pressure: f64,
    /// Number of the plastic modulus h₀ (–), positive. The larger of 0.3 and (0.25 + D_R)/2 if left out.
    #[serde(default)]
    pub hardening_number: Option<f64>,
    /// Largest void ratio e_max (–). 0.8 if left out.
    #[serde(default = "largest_void_ratio")]
    pub largest_void_ratio: f64,
    /// Smallest void ratio e_min (–), positive and below e_max. 0.5 if left out.
    #[serde(default = "smallest_void_ratio")]
    pub smallest_void_ratio: f64,
    /// Exponent n_b of the bounding ratio (–), positive. 0.5 if left out.
    #[serde(default = "bounding_exponent")]
    pub bounding_exponent: f64,
    /// Exponent n_d of the dilatancy ratio (–), positive. 0.1 if left out.
    #[serde(default = "dilatancy_exponent")]
    pub dilatancy_exponent: f64,
    /// Number of the dilatancy A_do (–), positive. After Bolton from the initial state if left out.
    #[serde(default)]
    pub dilatancy_number: Option<f64>,
    /// Limit z_max of the fabric tensor (–), positive. The smaller of 0.7 exp(−6.1 ξ_R0) and 20 if left out.
    #[serde(default)]
    pub fabric_limit: Option<f64>,
    /// Rate c_z of the fabric tensor (–), positive. 250 if left out.
    #[serde(default = "fabric_rate")]
    pub fabric_rate: f64,
    /// Strain accumulation rate C_ε (–), positive. 0.5 up to D_R = 0.55, 0.2 from 0.75 on, linear in between, if left out.
    #[serde(default)]
    pub strain_rate_number: Option<f64>,
    /// Critical friction angle φ_cv (degrees), above 0 and below 90. 33 if left out.
    #[serde(default = "critical_friction_angle_deg")]
    pub critical_friction_angle_deg: f64,
    /// Poisson's ratio ν (–), from 0 to below 0.5. 0.3 if left out.
    #[serde(default = "poisson")]
    pub poisson: f64,
    /// Degradation C_GD of the shear modulus by fabric (–), at least 1. 2 if left out.
    #[serde(default = "modulus_degradation")]
    pub modulus_degradation: f64,
    /// Factor C_DR of the rotated dilatancy (–), positive. 5 + 25 (D_R − 0.35), at most 10, if left out.
    #[serde(default)]
    pub rotated_dilatancy_number: Option<f64>,
    /// Factor C_kαf of a static shear stress (–), positive. 5 + 220 (D_R − 0.26)³ between 4 and 35 if left out.
    #[serde(default)]
    pub static_shear_number: Option<f64>,
    /// Bolton's Q of the critical state line (–). 10 if left out.
    #[serde(default = "critical_line_q")]
    pub critical_line_q: f64,
    /// Bolton's R of the critical state line (–), positive. 1.5 if left out.
    #[serde(default = "critical_line_r")]
    pub critical_line_r: f64,
    /// Opening m of the yield surface as a stress ratio (–), positive. 0.01 if left out.
    #[serde(default = "yield_opening")]
    pub yield_opening: f64,
    /// Largest error of a sub-step relative to the stress (–), positive. 1e-4 if left out.
    #[serde(default = "sub_step_tolerance")]
    pub sub_step_tolerance: f64,
    /// Smallest sub-step as a fraction of the strain increment (–), positive. 1e-6 if left out.
    #[serde(default = "smallest_sub_step")]
    pub smallest_sub_step: f64,
}

fn atmospheric_pressure() -> f64 {
    101.3e3
}

fn largest_void_ratio() -> f64 {
    0.8
}

fn smallest_void_ratio() -> f64 {
    0.5
}

fn bounding_exponent() -> f64 {
    0.5
}

fn dilatancy_exponent() -> f64 {
    0.1
}

fn fabric_rate() -> f64 {
    250.0
}

fn critical_friction_angle_deg() -> f64 {
    33.0
}

fn poisson() -> f64 {
    0.3
}

fn modulus_degradation() -> f64 {
    2.0
}

fn critical_line_q() -> f64 {
    10.0
}

fn critical_line_r() -> f64 {
    1.5
}

fn yield_opening() -> f64 {
    0.01
}

fn sub_step_tolerance() -> f64 {
    1e-4
}

fn smallest_sub_step() -> f64 {
    1e-6
}

/// A symmetric tensor without a trace in the plane.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PlaneDeviator {
    /// ½ (a_xx − a_yy).
    pub difference: f64,
    /// a_xy.
    pub shear: f64,
}

impl PlaneDeviator {
    #[inline(always)]
    fn dot(self, other: Self) -> f64 {
        2.0 * (self.difference * other.difference + self.shear * other.shear)
    }

    #[inline(always)]
    fn plus(self, other: Self, factor: f64) -> Self {
        let difference = self.difference + factor * other.difference;
        PlaneDeviator { difference, shear: self.shear + factor * other.shear }
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        PlaneDeviator { difference: self.difference * factor, shear: self.shear * factor }
    }

    /// √½ times the norm: the largest shear.
    #[inline(always)]
    fn radius(self) -> f64 {
        (self.difference * self.difference + self.shear * self.shear).sqrt()
    }

    /// In axes that the unit vector (cos 2θ, sin 2θ) turns by θ.
    #[inline(always)]
    fn seen_from(self, axis: PlaneDeviator) -> Self {
        PlaneDeviator {
            difference: self.difference * axis.difference + self.shear * axis.shear,
            shear: self.shear * axis.difference - self.difference * axis.shear,
        }
    }

    /// The inverse of [`PlaneDeviator::seen_from`].
    #[inline(always)]
    fn turned_by(self, axis: PlaneDeviator) -> Self {
        self.seen_from(PlaneDeviator { shear: -axis.shear, ..axis })
    }

    /// Each component by a function of it and of the other tensors' ones.
    #[inline(always)]
    fn by_component<const N: usize>(tensors: [Self; N], function: impl Fn([f64; N]) -> f64) -> Self {
        let difference = function(tensors.map(|tensor| tensor.difference));
        PlaneDeviator { difference, shear: function(tensors.map(|tensor| tensor.shear)) }
    }
}

/// The history of [`Pm4Sand`]: tensors are positive in compression and stand in axes that turn with the material.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pm4SandState {
    /// (cos 2θ, sin 2θ) of the angle θ that the material has turned by.
    pub axis: PlaneDeviator,
    /// Back-stress ratio α (–), the axis of the yield surface.
    pub back_stress_ratio: PlaneDeviator,
    /// α at the last reversal (–).
    pub true_reversal: PlaneDeviator,
    /// The apparent α_in, which small cycles do not move (–).
    pub apparent_reversal: PlaneDeviator,
    /// The apparent α_in before the last reversal (–).
    pub previous_reversal: PlaneDeviator,
    /// The largest negative and the smallest positive components of α at reversals (–).
    pub reversal_range: [PlaneDeviator; 2],
    /// Fabric-dilatancy tensor z (–).
    pub fabric: PlaneDeviator,
    /// z at the last reversal (–).
    pub fabric_at_reversal: PlaneDeviator,
    /// Σ |Δz|/√2 (–).
    pub fabric_sum: f64,
    /// The largest |z|/√2 so far (–).
    pub fabric_peak: f64,
    /// z_max of this point (–).
    pub fabric_limit: f64,
    /// A_do of this point (–).
    pub dilatancy_number: f64,
    /// Pressure p_zp at the reversal with the largest |z| p (Pa).
    pub pressure_at_largest_fabric: f64,
    /// The largest |z| p at a reversal (Pa); negative before the first one.
    pub largest_fabric: f64,
    /// p_min of this point (Pa).
    pub smallest_pressure: f64,
    /// Void ratio e (–).
    pub void_ratio: f64,
}

/// What follows from the parameters alone, found once for an increment.
struct Rates<'a> {
    law: &'a Pm4Sand,
    /// M_cv (–).
    critical_ratio: f64,
    /// h₀ (–).
    hardening: f64,
    /// K/G (–).
    bulk_ratio: f64,
}

/// A stress in the plane relative to the yield surface.
struct Bearing {
    /// p (Pa).
    pressure: f64,
    /// r (–).
    ratio: PlaneDeviator,
    /// |r − α| (–).
    distance: f64,
    /// n (–).
    normal: PlaneDeviator,
}

/// Bounding and dilatancy ratios and the state that they follow from.
struct Surfaces {
    /// M^b (–).
    bounding: f64,
    /// M^d (–).
    dilatancy: f64,
    /// ξ_R (–).
    state_index: f64,
}

/// ½ (σ_xx + σ_yy) of a stress or strain, positive in compression, and its deviator.
#[inline(always)]
fn in_plane(tensor: Sym3) -> (f64, PlaneDeviator) {
    let deviator = PlaneDeviator { difference: -0.5 * (tensor.xx - tensor.yy), shear: -tensor.xy };
    (-0.5 * (tensor.xx + tensor.yy), deviator)
}

/// The inverse of [`in_plane`].
#[inline(always)]
fn from_plane(mean: f64, deviator: PlaneDeviator) -> Sym3 {
    let (xx, yy) = (-(mean + deviator.difference), -(mean - deviator.difference));
    Sym3 { xx, yy, xy: -deviator.shear, ..Sym3::ZERO }
}

/// ⟨x⟩.
#[inline(always)]
fn positive_part(x: f64) -> f64 {
    x.max(0.0)
}

const ROOT_HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// C_Kp of the manual.
const KP_FACTOR: f64 = 2.0;
/// Keeps 1 − C_zpk2 and |(α^b − α) : n| from zero, as in OpenSees.
const TINY: f64 = 1e-10;
/// How far from the yield surface a stress ratio counts as on it: far above rounding, far below the opening.
const YIELD_TOLERANCE: f64 = 1e-12;

impl Pm4Sand {
    fn rates(&self) -> Rates<'_> {
        Rates {
            law: self,
            critical_ratio: 2.0 * self.critical_friction_angle_deg.to_radians().sin(),
            hardening: self.hardening_number.unwrap_or((0.5 * (0.25 + self.relative_density)).max(0.3)),
            bulk_ratio: 2.0 * (1.0 + self.poisson) / (3.0 * (1.0 - 2.0 * self.poisson)),
        }
    }

    fn strain_rate(&self) -> f64 {
        self.strain_rate_number.unwrap_or(0.5 - 1.5 * (self.relative_density.clamp(0.55, 0.75) - 0.55))
    }

    fn rotated_dilatancy(&self) -> f64 {
        self.rotated_dilatancy_number.unwrap_or((5.0 + 25.0 * (self.relative_density - 0.35)).min(10.0))
    }

    fn static_shear(&self) -> f64 {
        let above = self.relative_density - 0.26;
        self.static_shear_number.unwrap_or((5.0 + 220.0 * above * above * above).clamp(4.0, 35.0))
    }
}

impl Rates<'_> {
    #[inline(always)]
    fn bearing(&self, stress: Sym3, back_stress_ratio: PlaneDeviator) -> Option<Bearing> {
        let (pressure, deviator) = in_plane(stress);
        if pressure <= 0.0 {
            return None;
        }
        let ratio = deviator.times(1.0 / pressure);
        let off_axis = ratio.plus(back_stress_ratio, -1.0);
        let distance = off_axis.dot(off_axis).sqrt();
        // On the axis every direction is as good.
        let normal = off_axis.times(1.0 / distance.max(f64::MIN_POSITIVE));
        Some(Bearing { pressure, ratio, distance, normal })
    }

    fn yield_radius(&self) -> f64 {
        ROOT_HALF * self.law.yield_opening
    }

    #[inline(always)]
    fn surfaces(&self, pressure: f64, relative_density: f64) -> Surfaces {
        let law = self.law;
        let crushing = law.critical_line_q - (100.0 * pressure / law.atmospheric_pressure).ln();
        let state_index = law.critical_line_r / crushing - relative_density;
        let (for_bounding, for_dilatancy) = match state_index > 0.0 {
            true => (0.25, 4.0),
            false => (1.0, 1.0),
        };
        Surfaces {
            bounding: self.critical_ratio * (-for_bounding * law.bounding_exponent * state_index).exp(),
            dilatancy: self.critical_ratio * (for_dilatancy * law.dilatancy_exponent * state_index).exp(),
            state_index,
        }
    }

    fn surfaces_at(&self, pressure: f64, state: &Pm4SandState) -> Surfaces {
        let range = self.law.largest_void_ratio - self.law.smallest_void_ratio;
        let relative_density = (self.law.largest_void_ratio - state.void_ratio) / range;
        self.surfaces(pressure.max(state.smallest_pressure), relative_density)
    }

    /// G/√p (√Pa) at a stress ratio M and a bounding ratio M^b.
    #[inline(always)]
    fn shear_stiffness(&self, ratio: f64, bounding: f64, state: &Pm4SandState) -> f64 {
        let relative = ratio / bounding;
        let squared = relative * relative;
        let fabric = state.fabric_sum / state.fabric_limit;
        self.law.shear_modulus_number
            * self.law.atmospheric_pressure.sqrt()
            * (1.0 - 0.5 * (squared * squared).min(1.0))
            * ((1.0 + fabric) / (1.0 + self.law.modulus_degradation * fabric))
    }

    /// How fast an elastic strain increment leads out of the yield surface, over the shear modulus (–): 2 n:de − K/G dε_v n:r.
    #[inline(always)]
    fn relative_drive(&self, bearing: &Bearing, strain: Sym3) -> f64 {
        let (half_volumetric, shear_strain) = in_plane(strain);
        let Bearing { ratio, normal, .. } = bearing;
        2.0 * (normal.dot(shear_strain) - self.bulk_ratio * half_volumetric * normal.dot(*ratio))
    }

    fn least_pressure(&self, state: &Pm4SandState) -> f64 {
        0.2 * state.smallest_pressure
    }

    /// G (Pa) at a stress.
    fn shear_modulus(&self, stress: Sym3, state: &Pm4SandState) -> f64 {
        let (pressure, deviator) = in_plane(stress);
        let pressure = pressure.max(self.least_pressure(state));
        let bounding = self.surfaces_at(pressure, state).bounding;
        self.shear_stiffness(2.0 * deviator.radius() / pressure, bounding, state) * pressure.sqrt()
    }

    /// The stress with the pressure raised to the least one at the same stress ratio.
    #[inline(always)]
    fn kept_closed(&self, stress: Sym3, state: &Pm4SandState) -> Sym3 {
        let (pressure, deviator) = in_plane(stress);
        let least = self.least_pressure(state);
        match (pressure >= least, pressure > 0.0) {
            (true, _) => stress,
            (false, true) => from_plane(least, deviator.times(least / pressure)),
            (false, false) => from_plane(least, PlaneDeviator::default()),
        }
    }

    /// A reversal of the loading in the direction n.
    fn reversed(&self, pressure: f64, normal: PlaneDeviator, state: &mut Pm4SandState) {
        state.previous_reversal = state.apparent_reversal;
        state.true_reversal = state.back_stress_ratio;
        state.fabric_at_reversal = state.fabric;
        let pressure = pressure.max(state.smallest_pressure);
        let fabric = state.fabric.dot(state.fabric).sqrt() * pressure;
        let first = state.largest_fabric < 0.0;
        if first || (fabric > state.largest_fabric && pressure > state.pressure_at_largest_fabric) {
            (state.largest_fabric, state.pressure_at_largest_fabric) = (fabric, pressure);
        }
        let [largest, smallest] = state.reversal_range;
        let (back, apparent) = (state.back_stress_ratio, state.apparent_reversal);
        let lower = [smallest, back, apparent];
        let upper = [largest, back, apparent];
        state.reversal_range = [
            PlaneDeviator::by_component(
                upper,
                |[now, back, apparent]| if apparent > 0.0 { now } else { now.max(back) },
            ),
            PlaneDeviator::by_component(
                lower,
                |[now, back, apparent]| if apparent > 0.0 { now.min(back) } else { now },
            ),
        ];
        let [largest, smallest] = state.reversal_range;
        let same_side = back.shear * state.previous_reversal.shear > 0.0;
        state.apparent_reversal = match same_side {
            true => PlaneDeviator::by_component([normal, largest, smallest], |[normal, largest, smallest]| {
                if normal > 0.0 { smallest.max(0.0) } else { largest.min(0.0) }
            }),
            false => back,
        };
    }

    /// h (–) and K_p (Pa).
    #[inline(always)]
    fn hardening(&self, at: &Bearing, surfaces: &Surfaces, shear: f64, state: &Pm4SandState) -> (f64, f64) {
        let (law, n) = (self.law, at.normal);
        let pressure = at.pressure.max(state.smallest_pressure);
        let (limit, peak, sum) = (state.fabric_limit, state.fabric_peak, state.fabric_sum);
        let since = |reversal: PlaneDeviator| state.back_stress_ratio.plus(reversal, -1.0).dot(n);
        let since_apparent = positive_part(since(state.apparent_reversal));
        let since_true = positive_part(since(state.true_reversal));
        let to_bounding = ROOT_HALF * (surfaces.bounding - law.yield_opening) - state.back_stress_ratio.dot(n);
        let peak_share = (peak / (sum + 0.01 * limit)).min(1.0 - TINY);
        let lower_pressure = positive_part(state.pressure_at_largest_fabric - pressure);
        let pressure_share = lower_pressure / (lower_pressure + state.smallest_pressure);
        let static_shear = law.static_shear() / (1.0 + 6.25 * since_true * since_true);
        let static_shear = 1.0 + static_shear * pressure_share * (peak / (sum + 0.2 * limit));
        let fabric = 1.0 + KP_FACTOR * peak / limit * positive_part(to_bounding) * (1.0 - peak_share).sqrt();
        let least = self.hardening / 200.0;
        let mut h = 1.5 * shear * self.hardening * static_shear
            / (pressure * (since_apparent.exp_m1() + least) * to_bounding.abs().max(TINY).sqrt() * fabric);
        if since(state.previous_reversal) <= 0.0 {
            h *= (since_apparent + least) / (since_true + least);
        }
        (h, 2.0 / 3.0 * pressure * h * to_bounding)
    }

    /// D (–), and whether it is that of contraction.
    #[inline(always)]
    fn dilatancy(&self, at: &Bearing, surfaces: &Surfaces, state: &Pm4SandState) -> (f64, bool) {
        let n = at.normal;
        let along = state.back_stress_ratio.dot(n);
        let against = positive_part(-state.fabric.dot(n)) * ROOT_HALF / state.fabric_limit;
        let change = state.fabric_at_reversal.plus(state.fabric, -1.0).dot(n);
        let turned = 1.0 - (-2.0 * (change / state.fabric_limit).abs()).exp();
        let rotated = surfaces.dilatancy / (1.0 + 2.0 * against * (1.0 - turned));
        let to = |ratio: f64| ROOT_HALF * (ratio - self.law.yield_opening) - along;
        match to(rotated) <= 0.0 {
            true => (self.dilation(at, surfaces, state, [to(surfaces.dilatancy), to(rotated), against, turned]), false),
            false => (self.contraction(at, surfaces, state, to(surfaces.dilatancy)), true),
        }
    }

    /// D beyond the rotated dilatancy surface, with (α^d − α) : n, (α^dR − α) : n, ⟨−z : n⟩/√2 z_max and C_zin1.
    #[inline(always)]
    fn dilation(&self, at: &Bearing, surfaces: &Surfaces, state: &Pm4SandState, parts: [f64; 4]) -> f64 {
        let [to_dilatancy, to_rotated, against, turned] = parts;
        let (law, limit, least) = (self.law, state.fabric_limit, state.smallest_pressure);
        let pressure = at.pressure.max(least);
        let relative = 2.5 * pressure / state.pressure_at_largest_fabric;
        let to_fourth = relative * relative * relative * relative;
        let at_low_pressure = 1.0 / (1.0 + to_fourth * relative);
        let away_from_zero = 1.0 / (1.0 + (10.0 * least / pressure) * (10.0 * least / pressure));
        let loops = turned * (state.fabric_sum - state.fabric_peak) / (3.0 * limit);
        let worn = (1.0 + loops) / (1.0 + 3.0 * loops);
        let opposed = 1.0 - against * limit / state.fabric_peak;
        let strain_rate = law.strain_rate();
        let wear = state.fabric_sum * state.fabric_sum / limit
            * (opposed * opposed * opposed)
            * (strain_rate * strain_rate * at_low_pressure * away_from_zero * turned);
        let amount = state.dilatancy_number * worn / (wear + 1.0);
        let rotated = amount * against * to_rotated / law.rotated_dilatancy();
        let mut dilatancy = amount * to_dilatancy;
        if dilatancy > rotated {
            let margin = positive_part(surfaces.bounding - 2.0 * at.ratio.radius());
            dilatancy += (rotated - dilatancy) * margin / (margin + 0.01);
        }
        if pressure <= 2.0 * least {
            let most = -3.5 * state.dilatancy_number * positive_part(surfaces.bounding - surfaces.dilatancy);
            dilatancy = dilatancy.min(most * (2.0 * least - pressure) / least);
        }
        dilatancy
    }

    /// D below the rotated dilatancy surface, with (α^d − α) : n.
    #[inline(always)]
    fn contraction(&self, at: &Bearing, surfaces: &Surfaces, state: &Pm4SandState, to_dilatancy: f64) -> f64 {
        let (n, limit, least) = (at.normal, state.fabric_limit, state.smallest_pressure);
        let along_fabric = positive_part(state.fabric.dot(n));
        let dense = positive_part(0.5 - surfaces.state_index);
        let resistance = self.law.contraction_number * (-0.7 + 7.0 * dense * dense).exp();
        let turning = 1.0 - (state.fabric_peak / (state.fabric_sum + 0.01 * limit)).min(1.0 - TINY);
        let destroyed = (1.0 - turning * std::f64::consts::SQRT_2 * state.fabric_peak / limit)
            * (limit / (limit + turning * state.fabric_sum));
        let destroyed = destroyed.max(1.0 / (1.0 + 0.5 * limit));
        let amount = state.dilatancy_number * (1.0 + along_fabric) / (resistance * destroyed);
        let since = state.back_stress_ratio.plus(state.apparent_reversal, -1.0).dot(n)
            + std::f64::consts::SQRT_2 * along_fabric / limit;
        let ramp = ((at.pressure.max(least) - 2.0 * least) / (16.0 * least)).clamp(0.0, 1.0);
        let largest = 1.5 * state.dilatancy_number;
        (amount * since * since).min(largest) * to_dilatancy / (to_dilatancy + 0.16) * ramp
    }

    /// A point without history of loading at a pressure (Pa) and a back-stress ratio.
    fn fresh(&self, pressure: f64, ratio: PlaneDeviator) -> Pm4SandState {
        let law = self.law;
        let smallest_pressure = pressure.max(law.atmospheric_pressure) / 200.0;
        let pressure = pressure.max(smallest_pressure);
        let surfaces = self.surfaces(pressure, law.relative_density);
        let Surfaces { bounding, dilatancy, state_index } = surfaces;
        let bolton = match (state_index < 0.0, bounding > 2.0) {
            (true, false) => {
                let angle = |ratio: f64| (0.5 * ratio).asin();
                2.5 * (angle(bounding) - angle(self.critical_ratio)) / (bounding - dilatancy)
            }
            (true, true) => 1.5,
            (false, _) => 1.24,
        };
        let (largest_ratio, given_ratio) = (bounding.max(dilatancy), 2.0 * ratio.radius());
        let back_stress_ratio = match given_ratio > largest_ratio {
            true => ratio.times((largest_ratio - law.yield_opening) / given_ratio),
            false => ratio,
        };
        let fabric_limit = law.fabric_limit.unwrap_or((0.7 * (-6.1 * state_index).exp()).min(20.0));
        Pm4SandState {
            axis: PlaneDeviator { difference: 1.0, shear: 0.0 },
            back_stress_ratio,
            true_reversal: back_stress_ratio,
            reversal_range: [back_stress_ratio; 2],
            fabric_peak: 1e-5 * fabric_limit,
            fabric_limit,
            dilatancy_number: law.dilatancy_number.unwrap_or(bolton),
            pressure_at_largest_fabric: 0.01 * pressure,
            largest_fabric: -1.0,
            smallest_pressure,
            void_ratio: law.largest_void_ratio
                - law.relative_density * (law.largest_void_ratio - law.smallest_void_ratio),
            ..Pm4SandState::default()
        }
    }
}

impl PlasticRates for Rates<'_> {
    type State = Pm4SandState;

    #[inline(always)]
    fn yield_function(&self, at: &StressPoint<Pm4SandState>) -> f64 {
        let bearing = self.bearing(at.stress, at.state.back_stress_ratio);
        bearing.map_or(f64::INFINITY, |bearing| bearing.distance - self.yield_radius())
    }

    /// With the stress ratio's part of the moduli as it is at the start.
    #[inline(always)]
    fn elastic(&self, at: &StressPoint<Pm4SandState>, strain: Sym3) -> StressPoint<Pm4SandState> {
        let state = &at.state;
        let (pressure, deviator) = in_plane(at.stress);
        let bounding = self.surfaces_at(pressure, state).bounding;
        let ratio = 2.0 * deviator.radius() / pressure.max(self.least_pressure(state));
        let shear = self.shear_stiffness(ratio, bounding, state);
        let (half_volumetric, shear_strain) = in_plane(strain);
        let volumetric = 2.0 * half_volumetric;
        // In the plane a third of the volumetric strain counts as deviatoric.
        let bulk = (self.bulk_ratio + 1.0 / 3.0) * shear;
        let path = RootPressure::after(pressure, bulk, volumetric, self.least_pressure(state));
        let stress = from_plane(path.pressure, deviator.plus(shear_strain, 2.0 * shear * path.mean_root));
        let void_ratio = state.void_ratio - (1.0 + state.void_ratio) * volumetric;
        StressPoint { stress, state: Pm4SandState { void_ratio, ..*state } }
    }

    #[inline(always)]
    fn drive(&self, at: &StressPoint<Pm4SandState>, strain: Sym3) -> f64 {
        let bearing = self.bearing(at.stress, at.state.back_stress_ratio);
        bearing.map_or(0.0, |bearing| self.relative_drive(&bearing, strain))
    }

    #[inline(always)]
    fn change(&self, at: &StressPoint<Pm4SandState>, strain: Sym3) -> Result<StressPoint<Pm4SandState>, NoRates> {
        let bearing = self.bearing(at.stress, at.state.back_stress_ratio).ok_or(NoRates::BeyondApex)?;
        let (n, law) = (bearing.normal, self.law);
        // A peak of the fabric within the sub-step counts at once.
        let state = &Pm4SandState { fabric_peak: at.state.fabric_peak.max(at.state.fabric.radius()), ..at.state };
        let surfaces = self.surfaces_at(bearing.pressure, state);
        let pressure = bearing.pressure.max(self.least_pressure(state));
        let shear = self.shear_stiffness(2.0 * bearing.ratio.radius(), surfaces.bounding, state) * pressure.sqrt();
        let bulk = self.bulk_ratio * shear;
        let (h, mut plastic_modulus) = self.hardening(&bearing, &surfaces, shear, state);
        let (dilatancy, contracts) = self.dilatancy(&bearing, &surfaces, state);
        if contracts {
            plastic_modulus = plastic_modulus.max(0.0);
        }
        let (half_volumetric, shear_strain) = in_plane(strain);
        let volumetric = 2.0 * half_volumetric;
        let n_ratio = n.dot(bearing.ratio);
        let loading = shear * self.relative_drive(&bearing, strain);
        let resistance = plastic_modulus + 2.0 * shear - bulk * dilatancy * n_ratio;
        // No plastic strain on unloading, nor where the rates have no answer.
        let multiplier = match loading > 0.0 && resistance > 0.0 {
            true => loading / resistance,
            false => 0.0,
        };
        let mean = (bulk + shear / 3.0) * volumetric - multiplier * bulk * dilatancy;
        let deviator = shear_strain.plus(n, -multiplier).times(2.0 * shear);
        let along = state.back_stress_ratio.dot(n);
        let beyond = ROOT_HALF * (surfaces.dilatancy - law.yield_opening) < along;
        let fabric = match beyond && dilatancy < 0.0 {
            true => {
                let slowed = 1.0 + positive_part(0.5 * state.fabric_sum / state.fabric_limit - 1.0);
                state.fabric.plus(n, state.fabric_limit).times(-law.fabric_rate / slowed * multiplier)
            }
            false => PlaneDeviator::default(),
        };
        let bounding = n.times(ROOT_HALF * (surfaces.bounding - law.yield_opening));
        let change = Pm4SandState {
            back_stress_ratio: bounding.plus(state.back_stress_ratio, -1.0).times(2.0 / 3.0 * multiplier * h),
            fabric,
            fabric_sum: fabric.radius(),
            void_ratio: -(1.0 + state.void_ratio) * volumetric,
            ..Pm4SandState::default()
        };
        Ok(StressPoint { stress: from_plane(mean, deviator), state: change })
    }

    #[inline(always)]
    fn add(&self, state: &Pm4SandState, change: &Pm4SandState, factor: f64) -> Pm4SandState {
        Pm4SandState {
            back_stress_ratio: state.back_stress_ratio.plus(change.back_stress_ratio, factor),
            fabric: state.fabric.plus(change.fabric, factor),
            fabric_sum: state.fabric_sum + factor * change.fabric_sum,
            void_ratio: state.void_ratio + factor * change.void_ratio,
            ..*state
        }
    }

    /// Half of what is stable: the stress deviator moves by the radius of the yield surface.
    #[inline(always)]
    fn stable_sub_step(&self, at: &StressPoint<Pm4SandState>, strain: Sym3) -> f64 {
        let (_, shear_strain) = in_plane(strain);
        let pressure = in_plane(at.stress).0.max(self.least_pressure(&at.state));
        let elastic = 2.0 * self.shear_modulus(at.stress, &at.state) * shear_strain.dot(shear_strain).sqrt();
        (self.yield_radius() * pressure / elastic).min(1.0)
    }

    #[inline(always)]
    fn distance(&self, stress: Sym3, first: &StressPoint<Pm4SandState>, second: &StressPoint<Pm4SandState>) -> f64 {
        (second.stress - first.stress).norm() / stress.norm().max(self.law.atmospheric_pressure / 200.0)
    }

    /// Back to the yield surface at the same pressure and back-stress ratio, and inside the bounding ratio; a reversal is noted.
    #[inline(always)]
    fn settle(&self, at: StressPoint<Pm4SandState>) -> StressPoint<Pm4SandState> {
        let StressPoint { mut stress, mut state } = at;
        stress = self.kept_closed(stress, &state);
        state.fabric_peak = state.fabric_peak.max(state.fabric.radius());
        let Some(Bearing { pressure, mut ratio, distance, normal }) = self.bearing(stress, state.back_stress_ratio)
        else {
            return StressPoint { stress, state };
        };
        let radius = self.yield_radius();
        if distance > radius {
            ratio = state.back_stress_ratio.plus(normal, radius);
            stress = from_plane(pressure, ratio.times(pressure));
        }
        let (bounding, reached) = (self.surfaces_at(pressure, &state).bounding, 2.0 * ratio.radius());
        if reached > bounding {
            stress = from_plane(pressure, ratio.times(bounding / reached * pressure));
            state.back_stress_ratio = ratio.times((bounding - self.law.yield_opening) / reached);
        }
        if state.back_stress_ratio.plus(state.true_reversal, -1.0).dot(normal) < 0.0 {
            self.reversed(pressure, normal, &mut state);
        }
        StressPoint { stress, state }
    }
}

/// The in-plane part of a tensor in the axes of the material, or back with the opposite angle.
fn in_material_axes(tensor: Sym3, axis: PlaneDeviator) -> Sym3 {
    let (mean, deviator) = in_plane(tensor);
    from_plane(mean, deviator.seen_from(axis))
}

/// An error if one of the components out of the plane is not zero.
fn in_plane_only(what: &'static str, components: &[(&'static str, f64)]) -> Result<(), LawError> {
    match components.iter().find(|(_, value)| *value != 0.0) {
        Some(&(component, value)) => Err(LawError::OutOfPlane { what, component, value }),
        None => Ok(()),
    }
}

impl ConstitutiveLaw for Pm4Sand {
    type State = Pm4SandState;

    fn update(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<(Sym3, Self::State), LawError> {
        in_plane_only("strain increment", &[("zz", strain.zz), ("yz", strain.yz), ("zx", strain.zx)])?;
        in_plane_only("stress", &[("yz", stress.yz), ("zx", stress.zx)])?;
        if strain == Sym3::ZERO {
            return Ok((stress, state));
        }
        let rates = self.rates();
        let axis = state.axis;
        let material_stress = rates.kept_closed(in_material_axes(stress, axis), &state);
        let settings = SubStepping {
            tolerance: self.sub_step_tolerance,
            smallest: self.smallest_sub_step,
            yield_tolerance: YIELD_TOLERANCE,
        };
        let start = StressPoint { stress: material_stress, state };
        let end = settings.integrate(&rates, start, in_material_axes(strain, axis))?;
        let (pressure, deviator) = in_plane(end.stress);
        // Out of the plane the stress keeps its share of the pressure.
        let zz = stress.zz * (pressure / in_plane(material_stress).0);
        Ok((Sym3 { zz, ..from_plane(pressure, deviator.turned_by(axis)) }, end.state))
    }

    fn p_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64 {
        let rates = self.rates();
        (rates.bulk_ratio + 4.0 / 3.0) * rates.shear_modulus(stress, state)
    }

    fn s_wave_modulus(&self, stress: Sym3, state: &Self::State) -> f64 {
        self.rates().shear_modulus(stress, state)
    }

    /// By central differences in the plane; the columns out of the plane are zero.
    fn tangent(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<Matrix6, LawError> {
        let step = strain.to_kelvin().norm().max(1e-6) * f64::EPSILON.cbrt();
        let mut tangent = Matrix6::zeros();
        for column in [0, 1, 3] {
            let nudge = Sym3::from_kelvin(&(Matrix6::identity().column(column) * step));
            let (forward, _) = self.update(stress, state, strain + nudge)?;
            let (backward, _) = self.update(stress, state, strain - nudge)?;
            tangent.set_column(column, &((forward - backward).to_kelvin() / (2.0 * step)));
        }
        Ok(tangent)
    }

    /// Nothing: moduli follow the pressure without an energy behind them, and flow is not along the normal.
    fn closed_path_work(&self) -> ClosedPathWork {
        ClosedPathWork::Any
    }

    fn validate(&self) -> Result<(), LawError> {
        let refuse = |name, value, expected| Err(LawError::Parameter { name, value, expected });
        let given = [
            ("shear_modulus_number", Some(self.shear_modulus_number)),
            ("contraction_number", Some(self.contraction_number)),
            ("atmospheric_pressure", Some(self.atmospheric_pressure)),
            ("hardening_number", self.hardening_number),
            ("smallest_void_ratio", Some(self.smallest_void_ratio)),
            ("bounding_exponent", Some(self.bounding_exponent)),
            ("dilatancy_exponent", Some(self.dilatancy_exponent)),
            ("dilatancy_number", self.dilatancy_number),
            ("fabric_limit", self.fabric_limit),
            ("fabric_rate", Some(self.fabric_rate)),
            ("strain_rate_number", self.strain_rate_number),
            ("rotated_dilatancy_number", self.rotated_dilatancy_number),
            ("static_shear_number", self.static_shear_number),
            ("critical_line_q", Some(self.critical_line_q)),
            ("critical_line_r", Some(self.critical_line_r)),
            ("yield_opening", Some(self.yield_opening)),
            ("sub_step_tolerance", Some(self.sub_step_tolerance)),
            ("smallest_sub_step", Some(self.smallest_sub_step)),
        ];
        let given = given.iter().filter_map(|&(name, value)| value.map(|value| (name, value)));
        for (name, value) in given {
            if !(value > 0.0 && value.is_finite()) {
                return refuse(name, value, "positive");
            }
        }
        let ranges = [
            ("relative_density", self.relative_density, f64::MIN_POSITIVE..=1.0, "above 0 and at most 1"),
            ("poisson", self.poisson, 0.0..=0.4999, "from 0 to 0.4999"),
            ("modulus_degradation", self.modulus_degradation, 1.0..=f64::MAX, "at least 1"),
            ("critical_friction_angle_deg", self.critical_friction_angle_deg, 1.0..=89.0, "from 1 to 89"),
        ];
        for (name, value, range, expected) in ranges {
            if !range.contains(&value) {
                return refuse(name, value, expected);
            }
        }
        match self.largest_void_ratio > self.smallest_void_ratio {
            true => Ok(()),
            false => refuse("largest_void_ratio", self.largest_void_ratio, "above smallest_void_ratio"),
        }
    }

    /// The stress stands in the middle of the yield surface, or at the bounding or dilatancy ratio if it is beyond both; no fabric.
    fn initial_state(&self, stress: Sym3) -> Self::State {
        let (pressure, deviator) = in_plane(stress);
        let rates = self.rates();
        match pressure > self.atmospheric_pressure / 200.0 {
            true => rates.fresh(pressure, deviator.times(1.0 / pressure)),
            false => rates.fresh(pressure, PlaneDeviator::default()),
        }
    }

    /// The axes of the material turn with the part of the rotation that is in the plane.
    fn rotate_state(&self, state: Self::State, rotation: &Matrix3) -> Self::State {
        let (cos, sin) = (rotation[(0, 0)], rotation[(1, 0)]);
        let turn = PlaneDeviator { difference: cos * cos - sin * sin, shear: 2.0 * cos * sin };
        Pm4SandState { axis: state.axis.turned_by(turn), ..state }
    }

    fn outputs(&self) -> &'static [&'static str] {
        &["void_ratio", "relative_state_index", "back_stress_ratio", "fabric", "fabric_sum"]
    }

    fn write_outputs(&self, stress: Sym3, state: &Self::State, values: &mut [f64]) {
        let (pressure, _) = in_plane(stress);
        values.copy_from_slice(&[
            state.void_ratio,
            self.rates().surfaces_at(pressure, state).state_index,
            // As M.
            2.0 * state.back_stress_ratio.radius(),
            state.fabric.radius(),
            state.fabric_sum,
        ]);
    }
}
