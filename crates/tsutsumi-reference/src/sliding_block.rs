//! A rigid block on a slope with dry friction, and the safety of an infinite slope.

use schemars::JsonSchema;
use serde::Deserialize;

/// A rigid block on a plane slope with dry (Coulomb) friction.
///
/// # Equation
///
/// ```text
/// sliding down:  a = g (sin β − tan φ cos β)        sliding up:  a = g (sin β + tan φ cos β)
/// ```
///
/// Positive down the slope. A block that comes to rest stays there if tan β ≤ tan φ.
///
/// # Reference
///
/// Newton's and Coulomb's laws.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlidingBlock {
    /// Inclination of the slope β (degrees).
    pub slope_deg: f64,
    /// Angle of friction φ between block and slope (degrees).
    pub friction_angle_deg: f64,
    /// Gravity g (m/s²).
    pub gravity: f64,
    /// Velocity at time zero (m/s, positive down the slope).
    #[serde(default)]
    pub velocity: f64,
}

impl SlidingBlock {
    /// Whether a block at rest starts to slide.
    pub fn slides_from_rest(&self) -> bool {
        self.slope_deg > self.friction_angle_deg
    }

    /// The acceleration (m/s², positive down the slope) while the block moves as at time zero, or of a block let go;
    /// zero if it stays.
    pub fn acceleration(&self) -> f64 {
        if self.velocity == 0.0 {
            self.acceleration_from_rest()
        } else {
            self.acceleration_moving(self.velocity.signum())
        }
    }

    /// The time (s) at which a block that moves at time zero comes to a stand, where it stays or turns; none if it
    /// never does.
    pub fn stopping_time(&self) -> Option<f64> {
        let time = -self.velocity / self.acceleration();
        (time.is_finite() && time > 0.0).then_some(time)
    }

    /// The velocity (m/s, positive down the slope) at a time (s).
    pub fn velocity(&self, time: f64) -> f64 {
        match self.stopping_time() {
            Some(stop) if time > stop => self.acceleration_from_rest() * (time - stop),
            _ => self.velocity + self.acceleration() * time,
        }
    }

    /// The displacement (m, positive down the slope) since time zero, at a time (s).
    pub fn displacement(&self, time: f64) -> f64 {
        match self.stopping_time() {
            Some(stop) if time > stop => {
                0.5 * self.velocity * stop + 0.5 * self.acceleration_from_rest() * (time - stop).powi(2)
            }
            _ => self.velocity * time + 0.5 * self.acceleration() * time * time,
        }
    }

    fn acceleration_from_rest(&self) -> f64 {
        if self.slides_from_rest() { self.acceleration_moving(1.0) } else { 0.0 }
    }

    /// The acceleration of a block that moves down (1) or up (−1).
    fn acceleration_moving(&self, direction: f64) -> f64 {
        let (sine, cosine) = self.slope_deg.to_radians().sin_cos();
        self.gravity * (sine - direction * self.friction_angle_deg.to_radians().tan() * cosine)
    }
}

/// A slope without end whose ground slides on a plane parallel to its surface, with seepage parallel to it.
///
/// # Equation
///
/// ```text
/// FS = [c' + (γ z − γ_w h_w) cos²β tan φ'] / (γ z sin β cos β)
/// ```
///
/// `z` is the vertical depth of the plane, `h_w` the vertical height of the water above it; the flow is parallel to the
/// surface, so that p_w = γ_w h_w cos²β. With h_w = z: c'/(γ z sin β cos β) + (γ − γ_w)/γ · tan φ'/tan β.
///
/// # Reference
///
/// Limit equilibrium of a slice; Skempton & DeLory (1957) in every textbook (cited from memory, not re-read).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InfiniteSlope {
    /// Inclination of surface and sliding plane β (degrees).
    pub slope_deg: f64,
    /// Effective cohesion c' (Pa).
    pub cohesion: f64,
    /// Effective angle of friction φ' (degrees).
    pub friction_angle_deg: f64,
    /// Unit weight γ of the ground above the plane, with its water (N/m³).
    pub unit_weight: f64,
    /// Unit weight of water γ_w (N/m³).
    pub fluid_unit_weight: f64,
    /// Depth z of the plane, measured vertically (m).
    pub depth: f64,
    /// Height h_w of the water above the plane, measured vertically (m); from zero to the depth.
    #[serde(default)]
    pub water_height: f64,
}

impl InfiniteSlope {
    /// The pore pressure p_w (Pa) on the plane.
    pub fn pressure(&self) -> f64 {
        self.fluid_unit_weight * self.water_height * self.slope_deg.to_radians().cos().powi(2)
    }

    /// The factor of safety (–): shear strength over shear stress on the plane.
    pub fn factor_of_safety(&self) -> f64 {
        let (sine, cosine) = self.slope_deg.to_radians().sin_cos();
        let weight = self.unit_weight * self.depth;
        let normal = weight * cosine * cosine - self.pressure();
        (self.cohesion + normal * self.friction_angle_deg.to_radians().tan()) / (weight * sine * cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(friction_angle_deg: f64, velocity: f64) -> SlidingBlock {
        SlidingBlock { slope_deg: 30.0, friction_angle_deg, gravity: 10.0, velocity }
    }

    /// sin 30° = ½, tan 30° = 1/√3: without friction 5 m/s², at the angle of friction no motion at all.
    #[test]
    fn from_rest() {
        assert!((block(0.0, 0.0).acceleration() - 5.0).abs() < 1e-14);
        assert!((block(0.0, 0.0).displacement(2.0) - 10.0).abs() < 1e-13);
        let held = block(35.0, 0.0);
        assert!(!held.slides_from_rest());
        assert_eq!((held.acceleration(), held.velocity(3.0), held.displacement(3.0)), (0.0, 0.0, 0.0));
        assert_eq!(held.stopping_time(), None);
    }

    /// Gravity's work minus friction's is the kinetic energy, m = 1 kg: friction takes tan φ g cos β per metre of path.
    #[test]
    fn the_energy_balance_closes() {
        for (angle, velocity) in [(20.0, 0.0), (20.0, 3.0), (40.0, 3.0), (20.0, -3.0), (40.0, -3.0)] {
            let block = block(angle, velocity);
            for time in [0.1, 0.5, 2.0, 10.0] {
                let lowest = block.stopping_time().map_or(0.0, |stop| block.displacement(stop.min(time)).min(0.0));
                let end = block.displacement(time);
                let path = end - 2.0 * lowest;
                let friction = angle.to_radians().tan() * 10.0 * 0.75_f64.sqrt() * path;
                let kinetic = 0.5 * block.velocity(time).powi(2);
                let balance = 0.5 * velocity * velocity + 5.0 * end - friction - kinetic;
                assert!(balance.abs() < 1e-10 * (1.0 + kinetic), "{balance} for {angle}°, {velocity} m/s at {time} s");
            }
        }
    }

    /// Explicit Euler steps of the same laws, in which friction acts against the velocity and holds a block at rest;
    /// first order, so that steps of 1e-4 s leave 1e-3 m.
    #[test]
    fn stopping_and_turning_agree_with_small_steps() {
        for (angle, start) in [(40.0, 3.0), (40.0, -3.0), (20.0, -3.0)] {
            let block = block(angle, start);
            let (dt, friction) = (1e-4, f64::to_radians(angle).tan() * 10.0 * 0.75_f64.sqrt());
            let (mut velocity, mut position) = (start, 0.0);
            for _ in 0..30_000 {
                let pushed: f64 = velocity + 5.0 * dt;
                velocity = if pushed.abs() <= friction * dt { 0.0 } else { pushed - pushed.signum() * friction * dt };
                position += velocity * dt;
            }
            assert!((block.displacement(3.0) - position).abs() < 2e-3, "{position} for {angle}°");
        }
    }

    /// Forces on a slice of unit width across the page and 1 m along the slope, resolved by components: weight, water
    /// thrust on the base, and the seepage force of the equivalent buoyant description, which must give the same
    /// safety.
    #[test]
    fn seepage_forces_give_the_same_safety() {
        let slope = InfiniteSlope {
            slope_deg: 20.0,
            cohesion: 5e3,
            friction_angle_deg: 30.0,
            unit_weight: 20e3,
            fluid_unit_weight: 9.81e3,
            depth: 3.0,
            water_height: 3.0,
        };
        let (sine, cosine) = 20.0_f64.to_radians().sin_cos();
        let volume = 3.0 * cosine;
        let buoyant = (20e3 - 9.81e3) * volume;
        let seepage = 9.81e3 * sine * volume;
        let resistance = 5e3 + buoyant * cosine * 30.0_f64.to_radians().tan();
        let expected = resistance / (buoyant * sine + seepage);
        assert!((slope.factor_of_safety() - expected).abs() < 1e-13);
    }

    /// Dry and without cohesion a slope stands up to its angle of friction, at any depth.
    #[test]
    fn a_dry_slope_of_sand_stands_up_to_its_angle_of_friction() {
        let slope = InfiniteSlope {
            slope_deg: 33.0,
            cohesion: 0.0,
            friction_angle_deg: 33.0,
            unit_weight: 16e3,
            fluid_unit_weight: 9.81e3,
            depth: 7.0,
            water_height: 0.0,
        };
        assert!((slope.factor_of_safety() - 1.0).abs() < 1e-14);
    }
}
