//! A ring that turns within a block at rest: a manufactured solution with large strains and a known energy.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;
use tsutsumi::boundary::BodyForce;
use tsutsumi::tensor::Vector;

use crate::gauss_legendre::integrate_panel;

/// The generalised vortex: every circle of a ring turns rigidly to and fro, the inner and the outer one not at all.
///
/// Plane strain, neo-Hookean. Inside and outside of the ring the material is at rest and free of stress.
///
/// # Equation
///
/// ```text
/// r = R      θ = Θ + α(R, t)      α = A sin(π t/T) h(s)      h = 1 − 32 s² + 256 s⁴      s = (R − R_m) / (2 (b − a))
/// J = 1      κ = R ∂α/∂R      σ_rr = 0      σ_rθ = μ κ      σ_θθ = μ κ²      W = ½ μ κ²
/// b_r = −R α̇² + μ κ² / (ρ R)      b_θ = R α̈ − μ/ρ (3 ∂α/∂R + R ∂²α/∂R²)
/// ```
///
/// `R_m` is the middle of the ring, whose sides are at |s| = ¼; h and its slope are zero there. `b` is the body force per
/// mass in the directions of the moved point, which keeps the motion going.
///
/// # Reference
///
/// Kamojjala, Brannon, Sadeghirad and Guilkey (2015), "Verification tests in solid mechanics", Engineering with Computers
/// 31, 193–213 (cited from memory; the body force is derived here and tested against the equation of motion).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vortex {
    /// The centre (m).
    pub center: [f64; 2],
    /// Inner radius a of the ring (m).
    pub inner: f64,
    /// Outer radius b of the ring (m).
    pub outer: f64,
    /// The largest angle A (rad).
    pub angle: f64,
    /// The time T of a swing to one side and back (s).
    pub duration: f64,
    /// Shear modulus μ (Pa).
    pub shear_modulus: f64,
    /// Density ρ (kg/m³).
    pub density: f64,
}

/// The angle α of a circle and its derivatives.
struct Turn {
    angle: f64,
    rate: f64,
    acceleration: f64,
    /// ∂α/∂R (1/m), and again (1/m²).
    slope: f64,
    curvature: f64,
}

impl Vortex {
    /// The displacement (m) of the material that started at a point (m), at a time (s).
    pub fn displacement(&self, start: [f64; 2], time: f64) -> [f64; 2] {
        let [x, y] = self.arm(start);
        let (sin, cos) = self.turn(x.hypot(y), time).angle.sin_cos();
        [x * (cos - 1.0) - y * sin, x * sin + y * (cos - 1.0)]
    }

    /// The velocity (m/s) of the material that started at a point (m), at a time (s).
    pub fn velocity(&self, start: [f64; 2], time: f64) -> [f64; 2] {
        let (radius, [cos, sin]) = self.polar(start, time);
        let along = radius * self.turn(radius, time).rate;
        [-along * sin, along * cos]
    }

    /// The body force (m/s²) on the material that started at a point (m), at a time (s).
    pub fn body_force(&self, start: [f64; 2], time: f64) -> [f64; 2] {
        let (radius, [cos, sin]) = self.polar(start, time);
        if !(self.inner..=self.outer).contains(&radius) {
            return [0.0; 2];
        }
        let turn = self.turn(radius, time);
        let stiffness = self.shear_modulus / self.density;
        let outwards = radius * (stiffness * turn.slope * turn.slope - turn.rate * turn.rate);
        let along = radius * turn.acceleration - stiffness * (3.0 * turn.slope + radius * turn.curvature);
        [outwards * cos - along * sin, outwards * sin + along * cos]
    }

    /// Kinetic and strain energy together (J/m) at a time (s).
    ///
    /// ```text
    /// 2π ∫_a^b ½ (ρ R² α̇² + μ κ²) R dR          a polynomial of degree 11 in R: the ten-point rule is exact
    /// ```
    pub fn energy(&self, time: f64) -> f64 {
        let density = |radius: f64| {
            let turn = self.turn(radius, time);
            PI * radius.powi(3) * (self.density * turn.rate * turn.rate + self.shear_modulus * turn.slope * turn.slope)
        };
        integrate_panel(self.inner, self.outer, &density)
    }

    /// The largest energy (J/m): when all of it is kinetic, or all of it strain.
    pub fn largest_energy(&self) -> f64 {
        self.energy(0.0).max(self.energy(0.5 * self.duration))
    }

    /// The largest displacement of all (m), up to the small part by which it lies outside of the middle of the ring.
    pub fn largest_displacement(&self) -> f64 {
        self.middle() * 2.0 * (0.5 * self.angle.min(PI)).sin()
    }

    /// The largest velocity of all (m/s), up to the same part.
    pub fn largest_velocity(&self) -> f64 {
        self.middle() * self.angle * PI / self.duration
    }

    fn middle(&self) -> f64 {
        0.5 * (self.inner + self.outer)
    }

    fn arm(&self, point: [f64; 2]) -> [f64; 2] {
        [point[0] - self.center[0], point[1] - self.center[1]]
    }

    /// The radius (m) and the direction (cosine, sine) of the moved point.
    fn polar(&self, start: [f64; 2], time: f64) -> (f64, [f64; 2]) {
        let [x, y] = self.arm(start);
        let [dx, dy] = self.displacement(start, time);
        let radius = x.hypot(y);
        // The centre has no direction, and does not move.
        let direction = if radius > 0.0 { [(x + dx) / radius, (y + dy) / radius] } else { [1.0, 0.0] };
        (radius, direction)
    }

    fn turn(&self, radius: f64, time: f64) -> Turn {
        if !(self.inner..=self.outer).contains(&radius) {
            return Turn { angle: 0.0, rate: 0.0, acceleration: 0.0, slope: 0.0, curvature: 0.0 };
        }
        let width = 2.0 * (self.outer - self.inner);
        let s = (radius - self.middle()) / width;
        let shape = 1.0 - 32.0 * s.powi(2) + 256.0 * s.powi(4);
        let slope = (1024.0 * s.powi(3) - 64.0 * s) / width;
        let curvature = (3072.0 * s.powi(2) - 64.0) / (width * width);
        let frequency = PI / self.duration;
        let (sin, cos) = (frequency * time).sin_cos();
        Turn {
            angle: self.angle * sin * shape,
            rate: self.angle * frequency * cos * shape,
            acceleration: -self.angle * frequency * frequency * sin * shape,
            slope: self.angle * sin * slope,
            curvature: self.angle * sin * curvature,
        }
    }
}

/// In the plane of the first two axes.
impl<const D: usize> BodyForce<D> for Vortex {
    fn force(&self, start: &Vector<D>, time: f64) -> Vector<D> {
        let component = |axis: usize| start.get(axis).copied().unwrap_or(0.0);
        let force = self.body_force([component(0), component(1)], time);
        Vector::from_fn(|axis, _| force.get(axis).copied().unwrap_or(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VORTEX: Vortex = Vortex {
        center: [0.3, -0.2],
        inner: 0.75,
        outer: 1.25,
        angle: 1.0,
        duration: 1.0,
        shear_modulus: 385.0,
        density: 1000.0,
    };

    /// The first Piola–Kirchhoff stress P = μ (F − F⁻ᵀ) + λ ln J F⁻ᵀ of the neo-Hookean law, F by central differences.
    fn piola(start: [f64; 2], time: f64) -> [[f64; 2]; 2] {
        let step = 1e-4;
        let mut f = [[1.0, 0.0], [0.0, 1.0]];
        for axis in 0..2 {
            let (mut before, mut after) = (start, start);
            before[axis] -= step;
            after[axis] += step;
            let (u0, u1) = (VORTEX.displacement(before, time), VORTEX.displacement(after, time));
            for component in 0..2 {
                f[component][axis] += (u1[component] - u0[component]) / (2.0 * step);
            }
        }
        let jacobian = f[0][0] * f[1][1] - f[0][1] * f[1][0];
        let inverse_transposed = [[f[1][1], -f[1][0]], [-f[0][1], f[0][0]]].map(|row| row.map(|x| x / jacobian));
        let lame = 577.0 * jacobian.ln();
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                VORTEX.shear_modulus * (f[i][j] - inverse_transposed[i][j]) + lame * inverse_transposed[i][j]
            })
        })
    }

    /// ρ ẍ = Div P + ρ b, all derivatives by central differences: errors of (π Δ/(b − a))² ≈ 1e-6 and of rounding,
    /// 1e-16/Δ² ≈ 1e-8 of second derivatives, beside forces of up to 30 m/s².
    #[test]
    fn the_body_force_keeps_the_motion_going() {
        for (start, time) in [([1.2, 0.1], 0.3), ([0.35, 0.75], 0.65), ([-0.6, -0.7], 0.9), ([0.35, 0.1], 0.4)] {
            let step = 1e-4;
            let force = VORTEX.body_force(start, time);
            let mut divergence = [0.0; 2];
            for axis in 0..2 {
                let (mut before, mut after) = (start, start);
                before[axis] -= step;
                after[axis] += step;
                let (p0, p1) = (piola(before, time), piola(after, time));
                for component in 0..2 {
                    divergence[component] += (p1[component][axis] - p0[component][axis]) / (2.0 * step);
                }
            }
            let (v0, v1) = (VORTEX.velocity(start, time - step), VORTEX.velocity(start, time + step));
            let (u0, u1) = (VORTEX.displacement(start, time - step), VORTEX.displacement(start, time + step));
            let velocity = VORTEX.velocity(start, time);
            for component in 0..2 {
                let acceleration = (v1[component] - v0[component]) / (2.0 * step);
                let residual = acceleration - divergence[component] / VORTEX.density - force[component];
                assert!(residual.abs() < 1e-4, "{start:?} {time}: {residual}");
                let by_differences = (u1[component] - u0[component]) / (2.0 * step);
                assert!((velocity[component] - by_differences).abs() < 1e-6);
            }
        }
    }

    /// At the start all energy is kinetic; half a swing later all is strain. Both by the midpoint rule on 4000 rings.
    #[test]
    fn the_energy_is_that_of_the_rings() {
        let rings = |density: &dyn Fn(f64) -> f64| {
            let width = 0.5 / 4000.0;
            (0..4000)
                .map(|i| 0.75 + (f64::from(i) + 0.5) * width)
                .map(|r| density(r) * 2.0 * PI * r * width)
                .sum::<f64>()
        };
        let at = |radius: f64| [0.3 + radius, -0.2];
        let kinetic = rings(&|r| {
            let [x, y] = VORTEX.velocity(at(r), 0.0);
            0.5 * VORTEX.density * (x * x + y * y)
        });
        assert!((VORTEX.energy(0.0) / kinetic - 1.0).abs() < 1e-6);
        // W = ½ μ (tr b − 2) − μ ln J with J = 1, and tr b = tr (F Fᵀ) = 2 + κ²; κ from neighbours' angles.
        let strain = rings(&|r| {
            let angle = |r: f64| {
                let [x, y] = VORTEX.displacement(at(r), 0.5);
                y.atan2(r + x)
            };
            let shear = r * (angle(r + 1e-5) - angle(r - 1e-5)) / 2e-5;
            0.5 * VORTEX.shear_modulus * shear * shear
        });
        assert!((VORTEX.energy(0.5) / strain - 1.0).abs() < 1e-4, "{} {strain}", VORTEX.energy(0.5));
    }
}
