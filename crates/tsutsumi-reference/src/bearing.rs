//! Bearing capacity of a strip footing on weightless ground.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;

/// A strip footing, smooth or rough, on weightless rigid–plastic ground with an associated flow rule.
///
/// # Equation
///
/// ```text
/// q_u = c N_c + q N_q        N_q = e^(π tan φ) tan²(π/4 + φ/2)        N_c = (N_q − 1) cot φ
/// φ = 0:  N_c = 2 + π        N_q = 1
/// ```
///
/// # Reference
///
/// Prandtl (1920), Reissner (1924); exact, upper and lower bound meet. Recalled, not re-read.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StripFooting {
    /// Cohesion c (Pa); the undrained strength c_u with a friction angle of zero.
    pub cohesion: f64,
    /// Angle of friction φ (degrees).
    #[serde(default)]
    pub friction_angle_deg: f64,
    /// Surcharge q beside the footing (Pa).
    #[serde(default)]
    pub surcharge: f64,
}

impl StripFooting {
    /// The pressure q_u under which the ground fails (Pa, positive in compression).
    pub fn capacity(&self) -> f64 {
        self.cohesion * self.cohesion_factor() + self.surcharge * self.surcharge_factor()
    }

    /// N_c (–).
    pub fn cohesion_factor(&self) -> f64 {
        let tangent = self.friction_angle_deg.to_radians().tan();
        if tangent == 0.0 { 2.0 + PI } else { self.log_surcharge_factor().exp_m1() / tangent }
    }

    /// N_q (–).
    pub fn surcharge_factor(&self) -> f64 {
        self.log_surcharge_factor().exp()
    }

    /// ln N_q, from which N_q − 1 follows without cancellation where φ is small.
    fn log_surcharge_factor(&self) -> f64 {
        let angle = self.friction_angle_deg.to_radians();
        // ln tan(π/4 + φ/2) = artanh(sin φ).
        PI * angle.tan() + 2.0 * angle.sin().atanh()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn footing(friction_angle_deg: f64) -> StripFooting {
        StripFooting { cohesion: 1e3, friction_angle_deg, surcharge: 2e3 }
    }

    /// The table of N_c and N_q of every textbook, two decimals.
    #[test]
    fn the_table_of_bearing_capacity_factors() {
        for (angle, cohesion, surcharge) in
            [(0.0, 5.14, 1.0), (10.0, 8.34, 2.47), (20.0, 14.83, 6.40), (30.0, 30.14, 18.40), (40.0, 75.31, 64.20)]
        {
            let footing = footing(angle);
            assert!((footing.cohesion_factor() - cohesion).abs() < 6e-3, "{} at {angle}", footing.cohesion_factor());
            assert!((footing.surcharge_factor() - surcharge).abs() < 6e-3, "{} at {angle}", footing.surcharge_factor());
            let capacity = 1e3 * cohesion + 2e3 * surcharge;
            assert!((footing.capacity() - capacity).abs() < 18.0, "both factors to half of their last digit");
        }
    }

    /// Prandtl's 2 + π is the limit of small angles of friction: N_c grows by less than 14 φ (rad).
    #[test]
    fn undrained_capacity_is_the_limit_of_small_friction() {
        let (undrained, slight) = (footing(0.0).cohesion_factor(), footing(1e-6).cohesion_factor());
        assert!((slight - undrained).abs() < 14.0 * 1e-6_f64.to_radians());
        assert!((undrained - 5.141_592_653_589_793).abs() < 1e-15);
    }

    /// Upper bound: ground turns on a circle through one edge of the footing, its centre above the other; the best
    /// circle gives 5.52 c. Lower bound: two stress fields side by side, 4 c. Prandtl's 5.14 c lies between.
    #[test]
    fn prandtl_lies_between_simple_bounds() {
        // With θ half the arc's angle and the footing's width B = R sin θ: c 2θ R² = q B²/2.
        let bound = |angle: f64| 4.0 * angle / angle.sin().powi(2);
        let best = (1..=1570).map(|i| bound(i as f64 * 1e-3)).fold(f64::INFINITY, f64::min);
        let factor = footing(0.0).cohesion_factor();
        assert!(4.0 < factor && factor < best, "{best}");
    }
}
