use serde::{Deserialize, Serialize};

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

/// A material point on its way through an increment, compression positive.
#[derive(Clone, Copy)]
struct Point {
    /// Mean effective stress p' (Pa).
    pressure: f64,
    /// Deviator s (Pa).
    deviator: Sym3,
    state: OkaCyclicState,
}

/// A strain increment, compression positive.
#[derive(Clone, Copy)]
struct Strain {
    volumetric: f64,
    deviator: Sym3,
}

impl Strain {
    fn scaled(self, factor: f64) -> Self {
        Strain { volumetric: self.volumetric * factor, deviator: self.deviator * factor }
    }
}

/// The change of a point by plastic loading.
#[derive(Clone, Copy)]
struct Change {
    pressure: f64,
    deviator: Sym3,
    back_ratio: Sym3,
    plastic_volumetric_strain: f64,
    plastic_shear: f64,
    elastic_shear: f64,
}

impl Point {
    fn ratio(&self) -> Sym3 {
        self.deviator * (1.0 / self.pressure)
    }

    /// s − p' χ* (Pa).
    fn relative(&self) -> Sym3 {
        self.deviator - self.state.back_ratio * self.pressure
    }

    /// The direction m; that of the strain at the very centre of the elastic region.
    fn direction(&self, strain: &Strain) -> Sym3 {
        let relative = self.relative();
        match relative.norm() > 0.0 {
            true => relative * (1.0 / relative.norm()),
            false => strain.deviator * (1.0 / strain.deviator.norm().max(f64::MIN_POSITIVE)),
        }
    }

    fn after(&self, change: &Change) -> Point {
        let mut state = self.state;
        state.back_ratio += change.back_ratio;
        state.plastic_volumetric_strain += change.plastic_volumetric_strain;
        state.plastic_shear += change.plastic_shear;
        state.elastic_shear += change.elastic_shear;
        Point { pressure: self.pressure + change.pressure, deviator: self.deviator + change.deviator, state }
    }

    /// The mean effective stress no lower than this (Pa), with the same stress ratio.
    fn no_lower(mut self, least: f64) -> Point {
        if self.pressure < least {
            self.deviator = self.deviator * (least / self.pressure);
            self.pressure = least;
        }
        self
    }
}

impl Change {
    fn mean(self, other: Change) -> Change {
        Change {
            pressure: 0.5 * (self.pressure + other.pressure),
            deviator: (self.deviator + other.deviator) * 0.5,
            back_ratio: (self.back_ratio + other.back_ratio) * 0.5,
            plastic_volumetric_strain: 0.5 * (self.plastic_volumetric_strain + other.plastic_volumetric_strain),
            plastic_shear: 0.5 * (self.plastic_shear + other.plastic_shear),
            elastic_shear: 0.5 * (self.elastic_shear + other.elastic_shear),
        }
    }

    /// How far apart two changes are, over the mean effective stress (–).
    fn distance(&self, other: &Change, pressure: f64) -> f64 {
        let stress = (self.deviator - other.deviator).norm() + (self.pressure - other.pressure).abs();
        stress / pressure + (self.back_ratio - other.back_ratio).norm()
    }
}

/// Half the largest difference of two Euler steps, in stress ratios, that a sub-step may have.
const TOLERANCE: f64 = 1e-5;
/// No sub-step is a smaller part of the increment.
const LEAST_PART: f64 = 1e-9;
/// Sub-steps of an increment before the law gives up.
const MOST_SUBSTEPS: usize = 100_000;
/// How near to the yield surface a point lies on it, in stress ratios.
const ON_THE_SURFACE: f64 = 1e-12;

impl OkaCyclic {
    /// K / p' (–).
    fn bulk_rate(&self) -> f64 {
        (1.0 + self.void_ratio) / self.swelling_index
    }

    /// |s − p' χ*| − k p' (Pa), negative in the elastic region.
    fn yield_function(&self, point: &Point) -> f64 {
        point.relative().norm() - self.elastic_radius * point.pressure
    }

    /// Elastic strain: exact for K in proportion to p' and G to √p'.
    ///
    /// ```text
    /// p' = p'₀ exp(K/p' ε_v)        s = s₀ + 2 G₀ e (exp(y) − 1)/y        y = ½ K/p' ε_v
    /// ```
    fn elastic(&self, point: &Point, strain: &Strain) -> Point {
        let half = 0.5 * self.bulk_rate() * strain.volumetric;
        let growth = half.exp();
        let mean = if half.abs() > 1e-5 { half.exp_m1() / half } else { 1.0 + 0.5 * half };
        let twice_shear = 2.0 * self.shear_modulus_per_root(&point.state) * point.pressure.sqrt();
        let mut state = point.state;
        state.elastic_shear += strain.deviator.norm();
        Point {
            pressure: point.pressure * growth * growth,
            deviator: point.deviator + strain.deviator * (twice_shear * mean),
            state,
        }
    }

    /// The part of an elastic strain after which the point, inside or on its way in, comes to the yield surface from inside; at its end
    /// it is outside.
    fn elastic_part(&self, point: &Point, strain: &Strain) -> f64 {
        // Newton's method from the outer end: the yield function is convex along the path but for the curvature of p'. Where that leads
        // astray, bisection.
        let (mut inner, mut part) = (0.0, 1.0);
        let mut outer = 1.0;
        for _ in 0..MOST_SUBSTEPS {
            let here = self.elastic(point, &strain.scaled(part));
            let value = self.yield_function(&here);
            if value.abs() <= ON_THE_SURFACE * here.pressure || outer - inner <= f64::EPSILON {
                break;
            }
            match value > 0.0 {
                true => outer = part,
                false => inner = part,
            }
            let pressure_rate = self.bulk_rate() * here.pressure * strain.volumetric;
            let twice_shear = 2.0 * self.shear_modulus_per_root(&here.state) * here.pressure.sqrt();
            let relative_rate = strain.deviator * twice_shear - here.state.back_ratio * pressure_rate;
            let slope = here.direction(strain).double_dot(relative_rate) - self.elastic_radius * pressure_rate;
            let newton = part - value / slope;
            part = if newton > inner && newton < outer { newton } else { 0.5 * (inner + outer) };
        }
        part
    }

    /// How fast the elastic part of a strain leads out of the yield surface (Pa): 2G m:de − K (η*:m) dε_v.
    fn drive(&self, point: &Point, strain: &Strain) -> f64 {
        let direction = point.direction(strain);
        let twice_shear = 2.0 * self.shear_modulus_per_root(&point.state) * point.pressure.sqrt();
        let bulk = self.bulk_rate() * point.pressure;
        twice_shear * direction.double_dot(strain.deviator)
            - bulk * point.ratio().double_dot(direction) * strain.volumetric
    }

    /// The change of a point on the yield surface, to first order; without plastic strain if the strain leads inside.
    ///
    /// Consistency of f, derived:
    ///
    /// ```text
    /// dγ = (2G m:de − K (η*:m) dε_v) / H      H = 2G − K (η*:m) D* (M̃* − η*:m) + p' B* (M*_f − m:χ*)
    /// ds = 2G (de − dγ m)                     dp' = K (dε_v − D* (M̃* − η*:m) dγ)
    /// ```
    fn plastic(&self, point: &Point, strain: &Strain) -> Result<Change, LawError> {
        let Point { pressure, state, .. } = point;
        let twice_shear = 2.0 * self.shear_modulus_per_root(state) * pressure.sqrt();
        let bulk = self.bulk_rate() * pressure;
        let (direction, ratio) = (point.direction(strain), point.ratio());
        let along = ratio.double_dot(direction);
        let potential_ratio = self.potential_ratio(*pressure, ratio, state);
        let contraction = self.dilatancy_factor(potential_ratio) * (potential_ratio - along);
        let hardening = self.hardening_factor(state);
        let room = self.failure_ratio - direction.double_dot(state.back_ratio);
        let modulus = twice_shear - bulk * along * contraction + pressure * hardening * room;
        if modulus <= 0.0 || modulus.is_nan() {
            return Err(LawError::SnapBack { modulus });
        }
        let shear = self.drive(point, strain).max(0.0) / modulus;
        let elastic = strain.deviator - direction * shear;
        Ok(Change {
            pressure: bulk * (strain.volumetric - contraction * shear),
            deviator: elastic * twice_shear,
            back_ratio: (direction * self.failure_ratio - state.back_ratio) * (hardening * shear),
            plastic_volumetric_strain: contraction * shear,
            plastic_shear: shear,
            elastic_shear: elastic.norm(),
        })
    }

    /// Counts a reversal, if this is one, and remembers the direction.
    fn begin_loading(&self, point: &mut Point, strain: &Strain) {
        let direction = point.direction(strain);
        if Self::is_reversal(direction, &point.state) {
            point.state = Self::after_reversal(point.state);
        }
        point.state.direction = direction;
    }

    /// Back to the yield surface, above the least pressure, and through phase transformation if it is reached.
    fn settle(&self, point: Point, strain: &Strain) -> Point {
        let mut point = point;
        // Rounding leaves traces behind, and division by the small radius makes them grow.
        point.state.back_ratio = point.state.back_ratio.deviator();
        point.deviator = point.deviator.deviator();
        let direction = point.direction(strain);
        point.deviator = (point.state.back_ratio + direction * self.elastic_radius) * point.pressure;
        point.state.direction = direction;
        point.state.transformed |= point.ratio().norm() >= self.transformation_ratio();
        point.no_lower(self.least_pressure)
    }

    /// Follows a strain increment: elastic parts exactly, plastic ones by Euler steps of two orders whose difference sets their length.
    ///
    /// S. W. Sloan (1987), Int. J. Numer. Meth. Engng 24, 893–911.
    fn follow(&self, start: Point, strain: &Strain) -> Result<Point, LawError> {
        let mut point = start;
        let (mut done, mut part) = (0.0, 1.0);
        // Set where the elastic path has come to the surface from inside: there it leads out, if only just (neutral loading).
        let mut comes_out = false;
        for _ in 0..MOST_SUBSTEPS {
            let left = 1.0 - done;
            if left <= LEAST_PART {
                return Ok(point);
            }
            let inside = self.yield_function(&point) < -ON_THE_SURFACE * point.pressure;
            if !comes_out && (inside || self.drive(&point, strain) <= 0.0) {
                let rest = strain.scaled(left);
                let end = self.elastic(&point, &rest);
                if self.yield_function(&end) <= 0.0 {
                    return Ok(end.no_lower(self.least_pressure));
                }
                let elastic_part = self.elastic_part(&point, &rest);
                point = self.elastic(&point, &rest.scaled(elastic_part)).no_lower(self.least_pressure);
                done += left * elastic_part;
                self.begin_loading(&mut point, strain);
                comes_out = true;
                continue;
            }
            part = f64::min(part, left);
            let step = strain.scaled(part);
            let first = self.plastic(&point, &step)?;
            let second = self.plastic(&point.after(&first).no_lower(self.least_pressure), &step)?;
            let error = 0.5 * first.distance(&second, point.pressure);
            let factor = 0.9 * (TOLERANCE / error.max(f64::MIN_POSITIVE)).sqrt();
            if error > TOLERANCE && part > LEAST_PART {
                part = LEAST_PART.max(part * factor.max(0.1));
                continue;
            }
            point = self.settle(point.after(&first.mean(second)), strain);
            comes_out = false;
            done += part;
            part *= factor.min(2.0);
        }
        Err(LawError::NotConverged { iterations: MOST_SUBSTEPS, residual: 1.0 - done })
    }
}

impl ConstitutiveLaw for OkaCyclic {
    type State = OkaCyclicState;

    fn update(&self, stress: Sym3, state: Self::State, strain: Sym3) -> Result<(Sym3, Self::State), LawError> {
        if !strain.is_finite() {
            return Err(LawError::NotFinite { strain });
        }
        let point = Point { pressure: stress.pressure().max(self.least_pressure), deviator: -stress.deviator(), state };
        let strain = Strain { volumetric: -strain.trace(), deviator: -strain.deviator() };
        let end = self.follow(point, &strain)?;
        Ok((-end.deviator - Sym3::IDENTITY * end.pressure, end.state))
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
