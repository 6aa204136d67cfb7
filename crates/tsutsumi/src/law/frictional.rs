use serde::{Deserialize, Serialize};

use super::parameter::{require, require_positive};
use super::{ClosedPathWork, LawError};

/// What laws with friction and cohesion remember.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionalState {
    /// The plastic deviatoric strain √(2/3 Δe^p : Δe^p), summed over the steps (–): softening follows it.
    pub plastic_deviatoric_strain: f64,
    /// The plastic volumetric strain (–, positive in extension).
    pub plastic_volumetric_strain: f64,
    /// Whether the last step was plastic.
    pub yielding: bool,
}

impl FrictionalState {
    pub(super) const OUTPUTS: &'static [&'static str] =
        &["plastic_deviatoric_strain", "plastic_volumetric_strain", "yielding"];

    pub(super) fn write(&self, values: &mut [f64]) {
        let yielding = f64::from(self.yielding);
        values.copy_from_slice(&[self.plastic_deviatoric_strain, self.plastic_volumetric_strain, yielding]);
    }

    /// The history after a plastic step.
    pub(super) fn after(&self, plastic_deviatoric_strain: f64, volumetric_increment: f64) -> Self {
        let plastic_volumetric_strain = self.plastic_volumetric_strain + volumetric_increment;
        FrictionalState { plastic_deviatoric_strain, plastic_volumetric_strain, yielding: true }
    }
}

/// Friction (rad) and cohesion (Pa).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strength {
    pub(super) friction_angle: f64,
    pub(super) cohesion: f64,
}

/// Friction and cohesion that fall linearly with the plastic strain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Softening {
    pub(super) peak: Strength,
    pub(super) residual: Strength,
    /// The plastic deviatoric strain over which they fall (–).
    pub(super) over: f64,
}

impl Softening {
    /// From angles (°) and cohesions (Pa); what has no residual value keeps its own.
    pub(super) fn new(
        friction_angle_deg: f64,
        cohesion: f64,
        friction_angle_residual_deg: Option<f64>,
        cohesion_residual: Option<f64>,
        over: f64,
    ) -> Self {
        let strength = |degrees: f64, cohesion: f64| Strength { friction_angle: degrees.to_radians(), cohesion };
        let residual =
            strength(friction_angle_residual_deg.unwrap_or(friction_angle_deg), cohesion_residual.unwrap_or(cohesion));
        Softening { peak: strength(friction_angle_deg, cohesion), residual, over }
    }

    /// The strength after this plastic deviatoric strain.
    pub(super) fn at(&self, strain: f64) -> Strength {
        let share = if strain < self.over { 1.0 - strain / self.over } else { 0.0 };
        let between = |peak: f64, residual: f64| residual + share * (peak - residual);
        Strength {
            friction_angle: between(self.peak.friction_angle, self.residual.friction_angle),
            cohesion: between(self.peak.cohesion, self.residual.cohesion),
        }
    }

    /// Whether more plastic strain would change the strength.
    pub(super) fn goes_on_at(&self, strain: f64) -> bool {
        self.peak != self.residual && strain < self.over
    }

    /// What plasticity with this strength and dilatancy angle (°) promises about linear elasticity.
    pub(super) fn closed_path_work(&self, dilatancy_angle_deg: f64) -> ClosedPathWork {
        let is_associated = dilatancy_angle_deg.to_radians() == self.peak.friction_angle;
        match is_associated && self.peak == self.residual {
            true => ClosedPathWork::NotNegative,
            false => ClosedPathWork::Any,
        }
    }

    pub(super) fn validate(&self) -> Result<(), LawError> {
        let degrees = |strength: Strength| strength.friction_angle.to_degrees();
        let (peak, residual) = (degrees(self.peak), degrees(self.residual));
        require((0.0..90.0).contains(&peak), "friction_angle_deg", peak, "from 0 to below 90")?;
        let cohesion = self.peak.cohesion;
        require(cohesion >= 0.0 && cohesion.is_finite(), "cohesion", cohesion, "zero or positive (Pa)")?;
        if self.peak != self.residual {
            let fallen = residual >= 0.0 && residual <= peak;
            require(fallen, "friction_angle_residual_deg", residual, "from 0 to `friction_angle_deg`")?;
            let fallen = self.residual.cohesion >= 0.0 && self.residual.cohesion <= cohesion;
            require(fallen, "cohesion_residual", self.residual.cohesion, "from 0 to `cohesion`")?;
            require_positive("softening_strain", self.over, "positive where a residual strength is given")?;
        }
        let some = |strength: Strength| strength.friction_angle > 0.0 || strength.cohesion > 0.0;
        require(some(self.peak), "cohesion", cohesion, "positive where there is no friction")?;
        require(some(self.residual), "cohesion_residual", 0.0, "positive where there is no friction")
    }
}

/// Refuses dilatancy angles (°) outside the friction angle, and tensile strengths below zero.
pub(super) fn validate_flow(
    friction_angle_deg: f64,
    dilatancy_angle_deg: f64,
    tensile_strength: Option<f64>,
) -> Result<(), LawError> {
    let within = dilatancy_angle_deg >= 0.0 && dilatancy_angle_deg <= friction_angle_deg;
    require(within, "dilatancy_angle_deg", dilatancy_angle_deg, "from 0 to `friction_angle_deg`")?;
    let strength = tensile_strength.unwrap_or_default();
    require(strength >= 0.0 && strength.is_finite(), "tensile_strength", strength, "zero or positive (Pa)")
}

/// Far more than regula falsi takes: the curves are nearly straight.
const MOST_ITERATIONS: usize = 100;

/// The plastic strain ε at the end of a step in which the strength falls with it: the root of
///
/// ```text
/// ε = ε_old + Δε^p(ε)
/// ```
///
/// `increment` is Δε^p for a strength that is kept at ε, positive at ε_old. It grows where the strength falls, but shrinks near an apex that
/// moves away as the friction falls. Regula falsi (Illinois).
pub(super) fn softened_strain(strain_old: f64, over: f64, increment: impl Fn(f64) -> f64) -> Result<f64, LawError> {
    let excess = |strain: f64| strain_old + increment(strain) - strain;
    let (mut low, mut low_excess) = (strain_old, increment(strain_old));
    let mut high = strain_old + low_excess.max(increment(over));
    let mut high_excess = excess(high);
    while high_excess > 0.0 {
        high += high - strain_old;
        high_excess = excess(high);
    }
    let mut last_was_high = None;
    for _ in 0..MOST_ITERATIONS {
        if high - low <= 1e-14 * (high - strain_old) + f64::EPSILON * high {
            return Ok(high);
        }
        let middle = low + (high - low) * (low_excess / (low_excess - high_excess));
        let middle_excess = excess(middle);
        if middle_excess == 0.0 {
            return Ok(middle);
        }
        let is_high = middle_excess < 0.0;
        // The side that stays is halved, so that it comes nearer too.
        let halved = if last_was_high == Some(is_high) { 0.5 } else { 1.0 };
        if is_high {
            (high, high_excess, low_excess) = (middle, middle_excess, low_excess * halved);
        } else {
            (low, low_excess, high_excess) = (middle, middle_excess, high_excess * halved);
        }
        last_was_high = Some(is_high);
    }
    Err(LawError::NotConverged { iterations: MOST_ITERATIONS, residual: excess(low) })
}
