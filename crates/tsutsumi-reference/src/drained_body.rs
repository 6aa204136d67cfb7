//! What Mandel's slab, de Leeuw's cylinder and Cryer's sphere have in common.
//!
//! In all three the displacement follows from the pressure p(r,t) by integration, and the strain of volume is
//!
//! ```text
//! ε_v = p/M + C ⟨p⟩ − q/S        C = 1/S − 1/M        ⟨ε_v⟩ = (⟨p⟩ − q)/S
//! ```
//!
//! where q is the mean of the total normal stresses (positive in compression) over the directions in which the body can
//! strain, S the stiffness against a strain of volume in these directions (λ+G in plane strain, K in three), and
//! M = λ+2G. What is left of the balances of momentum and water is diffusion that is fed by the mean pressure of the
//! body. With ρ = r/a and T = c t/a²:
//!
//! ```text
//! ∂p/∂T + 1/(h−1) d⟨p⟩/dT = ∇²p + p₀ h/(h−1) df/dT        p(1,T) = 0        ⟨p⟩ = d ∫₀¹ ρ^(d−1) p dρ
//! h = 1 + (1/M + n/K^f)/C        p₀ = q/(S (1/S + n/K^f))
//! ```
//!
//! where d = 1, 2, 3 is the number of directions in which water flows, f(T) the history of the load (0 to 1), and p₀ the
//! pressure that the whole load leaves undrained. For a load put on at once,
//!
//! ```text
//! p̂(ρ,s) = p₀ h/(s (h − m(√s))) [1 − φ(√s ρ)/φ(√s)]        m(x) = ⟨φ(x ρ)⟩/φ(x) = d φ'(x)/(x φ(x))
//! φ = cosh x (d = 1), I₀(x) (d = 2), sinh x / x (d = 3)
//! ```
//!
//! The poles s = −α² are the roots of m(iα) = h. With φ'' + (d−1) φ'/x = φ, dm/ds = (1 − m − s m²/d²) d/(2s), and
//!
//! ```text
//! p(ρ,T) = Σ_α −(2 p₀ h/d)/(1 − h + α² h²/d²) [1 − φ(iαρ)/φ(iα)] e^(−α² T)
//! ```
//!
//! The series serves late times, inversion of the transform early ones, where the series would need many terms.

use std::f64::consts::PI;

use crate::ground::Ground;
use crate::laplace::{Complex64, talbot};

/// The body, by the number of directions in which water flows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    Slab,
    Cylinder,
    Sphere,
}

/// Where the pressure is taken, as a fraction ρ of the half-width or radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Part {
    /// At ρ.
    At(f64),
    /// The mean over all that is nearer to the centre than ρ.
    Within(f64),
}

/// A body that is drained on its surface, under a load that grows linearly in `ramp` seconds and then stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DrainedBody {
    pub(crate) shape: Shape,
    /// The pressure p₀ that the whole load leaves undrained (Pa).
    pub(crate) undrained: f64,
    /// The ratio h = 1 + (1/M + n/K^f)/C (–).
    pub(crate) ratio: f64,
    /// The time a²/c (s).
    pub(crate) time_scale: f64,
    /// The time over which the load grows (s).
    pub(crate) ramp: f64,
}

/// One term of the series: amplitude (Pa) and decay α² over the time a²/c.
struct Mode {
    amplitude: f64,
    rate: f64,
}

impl DrainedBody {
    /// T before which the body is undrained but for 1e-15, and powers of 1/T would overflow.
    const EARLY: f64 = 1e-30;
    /// T from which the series is used: some fourteen terms then reach e^(−40).
    const LATE: f64 = 0.02;
    /// T after which nothing is left of any mode: the slowest, the sphere's for ν = −0.9, has α² = 0.27 and leaves
    /// e^(−54).
    const OVER: f64 = 200.0;

    /// A body of half-width or radius `size` (m) under the mean load q (Pa), which grows linearly in `ramp` seconds.
    pub(crate) fn new(shape: Shape, ground: &Ground, size: f64, load: f64, ramp: f64) -> Self {
        // S and M − S; C = (M − S)/(M S) does not cancel where S is nearly M.
        let (stiffness, rest) = match shape {
            Shape::Slab | Shape::Cylinder => (ground.lame_modulus() + ground.shear_modulus(), ground.shear_modulus()),
            Shape::Sphere => (ground.bulk_modulus(), 4.0 / 3.0 * ground.shear_modulus()),
        };
        let coupling = rest / (ground.oedometric_modulus() * stiffness);
        DrainedBody {
            shape,
            undrained: load / stiffness / (ground.storage() + coupling),
            ratio: 1.0 + ground.storage() / coupling,
            time_scale: size * size / ground.consolidation_coefficient(),
            ramp,
        }
    }

    /// The pressure (Pa) at a time (s).
    ///
    /// At time zero it is the undrained one where the load is put on at once.
    pub(crate) fn pressure(&self, part: Part, time: f64) -> f64 {
        let (now, ramp) = (time / self.time_scale, self.ramp / self.time_scale);
        let since = now - ramp;
        if now < Self::EARLY {
            self.start(part) * self.load_factor(time)
        } else if since >= Self::LATE {
            self.series(part, since, ramp)
        } else if ramp <= 0.1 * now {
            // The factor grows like e^(|s| t_r) on the left, which the weights e^(st) bear while t_r ≪ t.
            talbot(|s| self.transform(part, s) * mean_decay(s * ramp), now)
        } else {
            (self.integral(part, now) - self.integral(part, since)) / ramp
        }
    }

    /// The share of the load that acts at a time (s).
    pub(crate) fn load_factor(&self, time: f64) -> f64 {
        if time < 0.0 {
            0.0
        } else if time >= self.ramp {
            1.0
        } else {
            time / self.ramp
        }
    }

    fn start(&self, part: Part) -> f64 {
        if matches!(part, Part::At(fraction) if fraction >= 1.0) { 0.0 } else { self.undrained }
    }

    /// The transform of the response to a load put on at once.
    fn transform(&self, part: Part, s: Complex64) -> Complex64 {
        let x = s.sqrt();
        self.undrained * self.ratio / (s * (self.ratio - self.shape.mean(x)))
            * (1.0 - self.shape.part(part, x) / self.shape.value(x))
    }

    /// ∫₀^T of the response to a load put on at once.
    fn integral(&self, part: Part, time: f64) -> f64 {
        if time > 0.0 { talbot(|s| self.transform(part, s) / s, time.min(Self::OVER)) } else { 0.0 }
    }

    /// The response some time after the end of the ramp.
    fn series(&self, part: Part, since: f64, ramp: f64) -> f64 {
        let mut sum = 0.0;
        for index in 0.. {
            let Mode { amplitude, rate } = self.mode(part, index);
            if rate * since > 40.0 {
                break;
            }
            sum += amplitude * (-rate * since).exp() * mean_decay(Complex64::from(rate * ramp)).re;
        }
        sum
    }

    fn mode(&self, part: Part, index: usize) -> Mode {
        let (h, d) = (self.ratio, self.shape.dimension());
        let alpha = self.shape.root(h, index);
        let rate = alpha * alpha;
        let amplitude = -2.0 * self.undrained * h / (d * (1.0 - h + rate * (h / d).powi(2)));
        // At a root φ is its mean over h: exact also where h is large and φ nearly zero.
        let x = Complex64::I * alpha;
        let share = (self.shape.part(part, x) / self.shape.average(x)).re * h;
        Mode { amplitude: amplitude * (1.0 - share), rate }
    }
}

impl Shape {
    fn dimension(self) -> f64 {
        match self {
            Shape::Slab => 1.0,
            Shape::Cylinder => 2.0,
            Shape::Sphere => 3.0,
        }
    }

    /// e^(−x) φ(x).
    fn value(self, x: Complex64) -> Complex64 {
        match self {
            Shape::Slab => 0.5 * (1.0 + (-2.0 * x).exp()),
            Shape::Cylinder => bessel(x, 0),
            Shape::Sphere => mean_decay(2.0 * x),
        }
    }

    /// e^(−x) ⟨φ(x ρ)⟩ = e^(−x) d φ'(x)/x.
    fn average(self, x: Complex64) -> Complex64 {
        match self {
            Shape::Slab => mean_decay(2.0 * x),
            Shape::Cylinder => bessel(x, 1),
            Shape::Sphere if x.norm() < 0.1 => {
                // Six terms of the series, where the difference below would cancel.
                let y = x * x;
                (-x).exp()
                    * (1.0 + y / 10.0 * (1.0 + y / 28.0 * (1.0 + y / 54.0 * (1.0 + y / 88.0 * (1.0 + y / 130.0)))))
            }
            Shape::Sphere => 3.0 * (0.5 * (1.0 + (-2.0 * x).exp()) - mean_decay(2.0 * x)) / (x * x),
        }
    }

    /// m(x).
    fn mean(self, x: Complex64) -> Complex64 {
        self.average(x) / self.value(x)
    }

    /// e^(−x) φ(xρ) at a part of the body, or the mean of it within.
    fn part(self, part: Part, x: Complex64) -> Complex64 {
        let (fraction, scaled) = match part {
            Part::At(fraction) => (fraction, self.value(x * fraction)),
            Part::Within(fraction) => (fraction, self.average(x * fraction)),
        };
        (x * (fraction - 1.0)).exp() * scaled
    }

    /// The root α of m(iα) = h with this index: one lies before each zero of φ(iα).
    ///
    /// Newton's method on 1/m, which falls without a pole from the zero of φ(iα) back to the root.
    fn root(self, h: f64, index: usize) -> f64 {
        let count = index as f64;
        let d = self.dimension();
        let mut alpha = match self {
            Shape::Slab => (count + 0.5) * PI,
            // McMahon's expansion; good enough to start from.
            Shape::Cylinder => (count + 0.75) * PI + 1.0 / (8.0 * (count + 0.75) * PI),
            Shape::Sphere => (count + 1.0) * PI,
        };
        // Six steps are usual; the bound only ends a walk in the last bits.
        for _ in 0..60 {
            let x = Complex64::I * alpha;
            let inverse = (self.value(x) / self.average(x)).re;
            let slope = -d / alpha * (inverse * inverse - inverse + (alpha / d).powi(2));
            let change = (inverse - 1.0 / h) / slope;
            alpha -= change;
            if change.abs() < 1e-14 * alpha {
                break;
            }
        }
        alpha
    }
}

/// (1 − e^(−x))/x.
fn mean_decay(x: Complex64) -> Complex64 {
    if x.norm() < 0.5 {
        // The terms fall below round-off: 0.5^16/17! = 4e-20.
        (1..17).rev().fold(Complex64::ONE, |sum, index| 1.0 - x / (index + 1) as f64 * sum)
    } else {
        (1.0 - (-x).exp()) / x
    }
}

/// e^(−x) I₀(x) for order zero, e^(−x) 2 I₁(x)/x for order one; Re x ≥ 0.
///
/// # Equation
///
/// ```text
/// I₀(x) = 1/π ∫₀^π e^(x cos θ) dθ        2 I₁(x)/x = 2/π ∫₀^π sin²θ e^(x cos θ) dθ
/// ```
///
/// The midpoint rule on a period converges faster than any power; from |x| = 50 Hankel's expansion is used, which
/// leaves out e^(−2 Re x): on Talbot's contour that is nothing, on the imaginary axis everything (but there |α| < 49).
/// Abramowitz and Stegun 9.6.16, 9.6.18, 9.7.1.
fn bessel(x: Complex64, order: u8) -> Complex64 {
    if x.norm() < 50.0 { bessel_integral(x, order) } else { bessel_far(x, order) }
}

fn bessel_integral(x: Complex64, order: u8) -> Complex64 {
    // The error is of the order of J_2N(|x|), below 1e-17 for this N.
    let count = (20.0 + 0.7 * x.norm()).ceil();
    let term = |index: usize| {
        let (sine, cosine) = ((index as f64 + 0.5) * PI / count).sin_cos();
        let weight = if order == 0 { 1.0 } else { 2.0 * sine * sine };
        (x * (cosine - 1.0)).exp() * weight
    };
    (0..count as usize).map(term).sum::<Complex64>() / count
}

fn bessel_far(x: Complex64, order: u8) -> Complex64 {
    let four_order_squared = if order == 0 { 0.0 } else { 4.0 };
    let mut term = (2.0 * PI * x).sqrt().inv();
    let mut sum = term;
    // At |x| = 50 the eighteenth term is below 1e-17 of the first.
    for index in 1..18 {
        let odd = (2 * index - 1) as f64;
        term *= (odd * odd - four_order_squared) / (8.0 * index as f64) / x;
        sum += term;
    }
    if order == 0 { sum } else { 2.0 * sum / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closeness::assert_close;

    const SHAPES: [Shape; 3] = [Shape::Slab, Shape::Cylinder, Shape::Sphere];

    fn body(shape: Shape, ratio: f64, ramp: f64) -> DrainedBody {
        DrainedBody { shape, undrained: 1.0, ratio, time_scale: 1.0, ramp }
    }

    /// Abramowitz and Stegun, tables 9.1 and 9.8: J₀, J₁ (along the imaginary axis) to ten digits, I₀ and I₁ as e^(−x)
    /// I.
    #[test]
    fn bessel_functions_follow_the_tables() {
        let ordinary = |x: f64, order: u8| (bessel(Complex64::I * x, order) * Complex64::cis(x)).re;
        for (x, j0, j1) in [
            (1.0, 0.765_197_686_6, 0.440_050_585_7),
            (5.0, -0.177_596_771_3, -0.327_579_137_6),
            (10.0, -0.245_935_764_5, 0.043_472_746_2),
            (40.0, 0.007_366_890_6, 0.126_038_318_0),
        ] {
            assert_close(ordinary(x, 0), j0, 6e-11);
            assert_close(ordinary(x, 1) * x / 2.0, j1, 6e-11);
        }
        for (x, i0, i1) in [(1.0, 0.465_759_607_6, 0.207_910_415_3), (10.0, 0.127_833_337_2, 0.121_262_681_4)] {
            assert_close(bessel(Complex64::from(x), 0).re, i0, 6e-11);
            assert_close(bessel(Complex64::from(x), 1).re * x / 2.0, i1, 6e-11);
        }
    }

    /// Two independent formulas, at the angles that occur on Talbot's contour.
    #[test]
    fn the_integral_and_the_expansion_of_the_bessel_functions_meet() {
        for angle in [0.0, 0.4, 0.8, 1.1] {
            for order in [0, 1] {
                let x = Complex64::from_polar(60.0, angle);
                let (near, far) = (bessel_integral(x, order), bessel_far(x, order));
                // Round-off of the sum of 60 terms of size one, against |e^(−x) I₀| = 0.05.
                assert!((near - far).norm() < 1e-14, "{near} is not {far}");
            }
        }
    }

    #[test]
    fn small_arguments_join_their_formulas() {
        for angle in [0.0_f64, 1.0, 1.57] {
            let below = Complex64::from_polar(0.1 - 1e-9, angle);
            let above = Complex64::from_polar(0.1 + 1e-9, angle);
            // The functions' slopes are at most one; the cancelling difference leaves 1e-16/0.1².
            assert!((Shape::Sphere.average(below) - Shape::Sphere.average(above)).norm() < 3e-9);
            let below = Complex64::from_polar(0.5 - 1e-13, angle);
            let above = Complex64::from_polar(0.5 + 1e-13, angle);
            assert!((mean_decay(below) - mean_decay(above)).norm() < 1e-12);
        }
        assert_close(mean_decay(Complex64::from(0.25)).re, 0.884_796_867_714_38, 1e-13);
    }

    /// The published characteristic equations: tan α = hα; 2 J₁ = h α J₀; 3 (1 − α cot α) = h α².
    #[test]
    fn roots_solve_the_characteristic_equations_one_in_each_interval() {
        for h in [1.2, 1.5, 2.0, 3.5, 1e3] {
            // One more than the series takes.
            for index in 0..15 {
                let interval = index as f64 * PI;
                let slab = Shape::Slab.root(h, index);
                assert_close(slab.sin(), h * slab * slab.cos(), 1e-12 * h * slab);
                assert!(slab > interval && slab < interval + 0.5 * PI);
                let sphere = Shape::Sphere.root(h, index);
                let residual = 3.0 * (sphere.sin() - sphere * sphere.cos()) - h * sphere * sphere * sphere.sin();
                assert_close(residual, 0.0, 1e-12 * h * sphere * sphere);
                assert!(sphere > interval && sphere < interval + PI);
                let cylinder = Shape::Cylinder.root(h, index);
                let x = Complex64::I * cylinder;
                assert!((bessel(x, 1) - h * bessel(x, 0)).norm() < 1e-14 * h * (1.0 + cylinder));
                assert!(cylinder > interval && cylinder < interval + 0.766 * PI);
            }
        }
    }

    /// The residue series and the inverted transform have nothing in common but the equation above them.
    #[test]
    fn the_series_agrees_with_the_inverted_transform() {
        for shape in SHAPES {
            for h in [1.5, 2.0, 3.5, 50.0] {
                let body = body(shape, h, 0.0);
                for part in [Part::At(0.0), Part::At(0.37), Part::At(0.95), Part::At(1.0), Part::Within(0.0)]
                    .into_iter()
                    .chain([Part::Within(0.6), Part::Within(1.0)])
                {
                    for time in [0.02, 0.05, 0.2, 1.0, 3.0] {
                        let inverted = talbot(|s| body.transform(part, s), time);
                        // Talbot's stated accuracy.
                        assert_close(body.series(part, time, 0.0), inverted, 1e-13);
                    }
                }
            }
        }
    }

    /// Direct substitution: the equation that heads this module, by central differences in space and time.
    #[test]
    fn pressures_satisfy_the_diffusion_fed_by_the_mean() {
        for shape in SHAPES {
            let (h, d) = (1.7, shape.dimension());
            let body = body(shape, h, 0.05);
            for (time, radius) in [(0.01, 0.9), (0.04, 0.5), (0.06, 0.8), (0.2, 0.3)] {
                let (dt, dr) = (1e-3 * time, 1e-3);
                let rate = |part| (body.pressure(part, time + dt) - body.pressure(part, time - dt)) / (2.0 * dt);
                let at = |radius| body.pressure(Part::At(radius), time);
                let flux = |radius: f64, side: f64| {
                    (at(radius + side) - at(radius)) / side * (radius + 0.5 * side).powf(d - 1.0)
                };
                let laplacian = (flux(radius, dr) - flux(radius, -dr)) / (dr * radius.powf(d - 1.0));
                let load = if time < body.ramp { h / (h - 1.0) / body.ramp } else { 0.0 };
                let stored = rate(Part::At(radius)) + rate(Part::Within(1.0)) / (h - 1.0);
                // Differences of second order: 1e-6 times fourth derivatives, here up to 20 times the rates of some 50.
                assert_close(stored, laplacian + load, 2e-3);
            }
        }
    }

    /// Undrained, p + ⟨p⟩/(h−1) = p₀ h/(h−1) everywhere but at the surface.
    #[test]
    fn early_pressures_are_undrained_and_finite() {
        for shape in SHAPES {
            let body = body(shape, 2.0, 0.0);
            assert_eq!(body.pressure(Part::At(0.3), 0.0), 1.0);
            assert_eq!(body.pressure(Part::At(1.0), 0.0), 0.0);
            assert_eq!(body.pressure(Part::At(0.3), -1.0), 0.0);
            for time in [1e-300, 1e-20, 1e-12, 1e-9] {
                // ⟨p⟩ has lost 2 d √(T/π) to the surface, and the mean pushes the rest up by as much over h.
                let lost = 2.0 * shape.dimension() * (time / PI).sqrt();
                assert_close(body.pressure(Part::At(0.3), time), 1.0 + lost / 2.0, 1e-13 + 3.0 * time * 9.0);
                assert_close(body.pressure(Part::At(1.0), time), 0.0, 1e-13);
            }
        }
    }

    /// Ramps by three ways of evaluation, against the step response averaged over the ramp by Gauss's rule.
    #[test]
    fn a_ramp_is_the_mean_of_shifted_steps() {
        // Three points of Gauss and Legendre on (−1, 1).
        let rule = [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)];
        for shape in SHAPES {
            let step = body(shape, 1.8, 0.0);
            for (time, duration) in [(0.5_f64, 0.1), (0.5, 1e-5), (0.01, 1e-4), (0.0015, 1e-3), (0.2, 0.19), (1.2, 1.2)]
            {
                let part = Part::At(0.6);
                // Early responses depend on √T smoothly, hence the substitution T = u².
                let (first, last) = ((time - duration).max(0.0).sqrt(), time.sqrt());
                let panel = (last - first) / 50.0;
                let weighed = |index: usize| {
                    let middle = first + panel * (index as f64 + 0.5);
                    rule.map(|(node, weight)| {
                        let u = middle + 0.5 * panel * node;
                        0.5 * panel * weight * 2.0 * u * step.pressure(part, u * u)
                    })
                };
                let mean = (0..50).flat_map(weighed).sum::<f64>() / duration;
                // The rule's error is (1/50)⁶ times a sixth derivative; the short ramp cancels five digits of u.
                assert_close(body(shape, 1.8, duration).pressure(part, time), mean, 2e-9);
            }
        }
    }

    #[test]
    fn ramps_join_where_the_way_of_evaluation_changes() {
        for shape in SHAPES {
            for ramp in [1e-4, 0.02, 3.0] {
                let body = body(shape, 2.5, ramp);
                for border in [ramp + DrainedBody::LATE, 10.0 * ramp] {
                    let (before, after) = (border * (1.0 - 1e-12), border * (1.0 + 1e-12));
                    let part = Part::At(0.2);
                    // Both sides of the change differ by the way of evaluation only.
                    assert_close(body.pressure(part, before), body.pressure(part, after), 1e-11);
                }
                assert_eq!(body.pressure(Part::At(0.2), 0.0), 0.0);
                assert_eq!(body.load_factor(0.25 * ramp), 0.25);
            }
        }
    }

    /// After a long ramp the flow is steady: ∇²p = −p₀ h/(h−1) df/dT, so p = p₀ h/(h−1)/t_r (1 − ρ²)/(2d).
    #[test]
    fn long_ramps_become_steady() {
        for shape in SHAPES {
            let (h, ramp) = (1.5, 1e4);
            let body = body(shape, h, ramp);
            for time in [90.0, 300.0, 9e3] {
                let steady = h / (h - 1.0) / ramp * (1.0 - 0.25) / (2.0 * shape.dimension());
                assert_close(body.pressure(Part::At(0.5), time), steady, 1e-11 * steady);
            }
        }
    }
}
