//! Waves in a saturated column: one-dimensional, with inertia, under a steady harmonic or a transient surface load.
//!
//! The column of height H stands on a rigid, impermeable base; its top is loaded and drained. The depth z and the
//! displacement u are positive downwards, so that a compressed column settles with u > 0; the load is positive in
//! compression.
//!
//! # The equations
//!
//! With the filtration velocity w = n(v^f − v^s), the balance of momentum of the mixture, Darcy's law with inertia and
//! the balance of water are, in the depth,
//!
//! ```text
//! ρ ü + δ ρ_f ẇ = M u'' − p'
//! w = −(k/γ_w) [p' + θ ρ_f ü + δ (ρ_f/n) ẇ]
//! w' + u̇' + (n/K^f) ṗ = 0
//! ```
//!
//! with M = λ+2G of the skeleton, ρ the density of the mixture and, by [`Model`], (θ, δ) = (1, 0), (0, 0) or (1, 1).
//! Weights are in equilibrium and left out. For θ = 1, δ = 0 the last two lines together are this project's equation of
//! continuity, k/γ_w (−ρ_f ε̈ − p'') + ε̇ + (n/K^f) ṗ = 0 with ε = u' (tension).
//!
//! # Their solution
//!
//! After a Laplace transform (s = iω in steady vibration), w = −κ (p' + θ ρ_f s² u) with κ = 1/(γ_w/k + δ ρ_f s/n), and
//!
//! ```text
//! M u'' − R s² u − α p' = 0             R = ρ − δ κ ρ_f² s        α = 1 − δ κ ρ_f s
//! κ p'' − (n/K^f) s p − β s u' = 0      β = 1 − θ κ ρ_f s
//! ```
//!
//! Both are solved by p = cosh(λ(H−z)), u = α λ/(R s² − M λ²) sinh(λ(H−z)), which leave the base at rest and tight, if
//!
//! ```text
//! M κ λ⁴ − [M (n/K^f) s + κ R s² + α β s] λ² + R (n/K^f) s³ = 0
//! ```
//!
//! Two waves therefore run through the ground: a slow one, in which water moves through the skeleton, and a fast one,
//! in which both move together. At the top p = 0 and M u' = −q̂ give their amplitudes ±A,
//!
//! ```text
//! p = A [C₁ − C₂]        C_j = cosh(λ_j(H−z))/cosh(λ_j H)
//! A = q̂ (R s² − M λ₁²)(R s² − M λ₂²) / (M α R s² (λ₁² − λ₂²))
//! ```
//!
//! # Reference
//!
//! M.A. Biot, J. Acoust. Soc. Am. 28 (1956) 168–178; O.C. Zienkiewicz, C.T. Chang, P. Bettess, Drained, undrained,
//! consolidating and dynamic behaviour assumptions in soils, Géotechnique 30 (1980) 385–395, for the three models.

use std::f64::consts::PI;

use crate::ground::Ground;
use crate::laplace::{Complex64, FourierSeries};

/// Which accelerations the equations keep; in files `up`, `upna` and `biot`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// The u–p equations with the inertia of the fluid moving with the skeleton, ρ_f ü, in Darcy's law; the relative
    /// acceleration ẇ is left out. This is the continuity equation of this project.
    Up,
    /// The u–p equations without any inertia in Darcy's law, as in many programs.
    Upna,
    /// Biot's full equations with the relative acceleration; no added mass (tortuosity one).
    Biot,
}

/// A saturated column on a rigid, impermeable base, drained and loaded at its top.
///
/// The equations and their solution stand at the head of [this module](self).
///
/// # Validity
///
/// Small strains, uniaxial. For an incompressible fluid (`fluid_modulus = inf`) the fast wave is infinitely fast.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// The saturated ground.
    pub ground: Ground,
    /// Height H (m).
    pub height: f64,
    /// Density of the mixture ρ = (1−n) ρ_s + n ρ_f (kg/m³).
    pub density: f64,
    /// Density of the fluid ρ_f (kg/m³).
    pub fluid_density: f64,
}

/// A surface load that grows smoothly and then stays.
///
/// # Equation
///
/// ```text
/// q(t) = q [t/t_r − sin(2πt/t_r)/(2π)]  up to t_r,  then q
/// q̂(s) = q (1 − e^(−s t_r)) ω²/(t_r s² (s² + ω²))        ω = 2π/t_r
/// ```
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SmoothLoad {
    /// The final load q (Pa, positive in compression).
    pub load: f64,
    /// The time t_r over which it grows (s), above zero.
    pub duration: f64,
}

/// Complex amplitudes of a steady vibration, or Laplace transforms, of the pressure and the displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitude {
    /// The pore pressure (Pa).
    pub pressure: Complex64,
    /// The displacement (m, positive downwards).
    pub displacement: Complex64,
}

/// The state of a point at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// The pore pressure (Pa, positive in compression, above the hydrostatic one).
    pub pressure: f64,
    /// The displacement (m, positive downwards).
    pub displacement: f64,
}

/// The coefficients of the transformed equations.
struct Transformed {
    /// κ (m²/(Pa s)).
    mobility: Complex64,
    /// R (kg/m³).
    density: Complex64,
    /// α (–).
    push: Complex64,
    /// β (–).
    squeeze: Complex64,
}

impl SmoothLoad {
    /// The highest angular frequency kept, over 1/t_r. The spectrum falls like 4π²/(ω t_r)³ q/ω, so that what is left
    /// out is below 33·4π²/(3π) 2000^(−3) = 2e-8 of q, and only near the start and end of the growth and their echoes.
    const HIGHEST: f64 = 2000.0;

    /// The load (Pa) at a time (s).
    pub fn at(&self, time: f64) -> f64 {
        let share = (time / self.duration).clamp(0.0, 1.0);
        self.load * (share - (2.0 * PI * share).sin() / (2.0 * PI))
    }

    /// The Laplace transform of the load (Pa s) for Re s > 0 (1/s).
    pub fn transform(&self, s: Complex64) -> Complex64 {
        let square = (2.0 * PI / self.duration).powi(2);
        self.load * (1.0 - (-s * self.duration).exp()) * square / (self.duration * s * s * (s * s + square))
    }
}

impl Column {
    /// The response to the surface load q e^(iωt), as amplitudes of e^(iωt).
    ///
    /// `load` q (Pa), `angular_frequency` ω (rad/s), zero for the drained static state, `depth` z (m).
    pub fn harmonic(&self, model: Model, load: f64, angular_frequency: f64, depth: f64) -> Amplitude {
        if angular_frequency == 0.0 {
            let displacement = load * (self.height - depth) / self.ground.oedometric_modulus();
            return Amplitude { pressure: Complex64::ZERO, displacement: displacement.into() };
        }
        let unit = self.transfer(model, Complex64::I * angular_frequency, depth);
        Amplitude { pressure: unit.pressure * load, displacement: unit.displacement * load }
    }

    /// The transforms of the response over the transform of the surface load.
    ///
    /// `s` is the variable of the Laplace transform (1/s), Re s ≥ 0 and not zero, `depth` z (m). The pressure is
    /// without unit, the displacement in m/Pa.
    pub fn transfer(&self, model: Model, s: Complex64, depth: f64) -> Amplitude {
        let modulus = self.ground.oedometric_modulus();
        let Transformed { density, push, .. } = self.transformed(model, s);
        let [slow, fast] = self.wave_numbers_squared(model, s);
        let inertia = density * s * s;
        let (slow_gap, fast_gap) = (inertia - modulus * slow, inertia - modulus * fast);
        let amplitude = slow_gap * fast_gap / (modulus * push * inertia * (slow - fast));
        let (slow_wave, fast_wave) = (self.shape(slow, depth), self.shape(fast, depth));
        Amplitude {
            pressure: amplitude * (slow_wave[0] - fast_wave[0]),
            displacement: amplitude * push * (slow_wave[1] / slow_gap - fast_wave[1] / fast_gap),
        }
    }

    /// The responses at a depth (m) to a smooth load at each of the times (s).
    ///
    /// The error is below 2e-8 of the load, and of the settlement it makes; against d'Alembert's undamped waves it is
    /// 1.4e-9.
    ///
    /// # Cost
    ///
    /// Some 2600 times the last time over the duration of the growth in evaluations of [`Column::transfer`], once for
    /// all times.
    pub fn smooth(&self, model: Model, load: SmoothLoad, depth: f64, times: &[f64]) -> Vec<Motion> {
        let end = times.iter().fold(load.duration, |end, &time| end.max(time));
        let series = FourierSeries::up_to_frequency(end, SmoothLoad::HIGHEST / load.duration);
        self.transient(model, |s| load.transform(s), series, depth, times)
    }

    /// The responses at a depth (m) at each of the times (s) to any load whose Laplace transform (Pa s) is known.
    ///
    /// `series` must reach the last of the times and the frequencies of the load; see [`FourierSeries`] for the error.
    /// At times before zero all is at rest.
    pub fn transient(
        &self,
        model: Model,
        load: impl Fn(Complex64) -> Complex64,
        series: FourierSeries,
        depth: f64,
        times: &[f64],
    ) -> Vec<Motion> {
        let transform = |s: Complex64| {
            let (unit, load) = (self.transfer(model, s, depth), load(s));
            [unit.pressure * load, unit.displacement * load]
        };
        let motion = |(values, &time): ([f64; 2], &f64)| {
            let [pressure, displacement] = if time > 0.0 { values } else { [0.0; 2] };
            Motion { pressure, displacement }
        };
        series.invert(transform, times).into_iter().zip(times).map(motion).collect()
    }

    fn transformed(&self, model: Model, s: Complex64) -> Transformed {
        let (in_darcy, relative) = match model {
            Model::Up => (1.0, 0.0),
            Model::Upna => (0.0, 0.0),
            Model::Biot => (1.0, 1.0),
        };
        let fluid = self.fluid_density * s;
        let mobility = (1.0 / self.ground.mobility() + relative * fluid / self.ground.porosity).inv();
        Transformed {
            mobility,
            density: self.density - relative * mobility * self.fluid_density * fluid,
            push: 1.0 - relative * mobility * fluid,
            squeeze: 1.0 - in_darcy * mobility * fluid,
        }
    }

    /// λ² of the slow and of the fast wave (1/m²): the larger one first, the other from their product.
    fn wave_numbers_squared(&self, model: Model, s: Complex64) -> [Complex64; 2] {
        let Transformed { mobility, density, push, squeeze } = self.transformed(model, s);
        let (modulus, storage) = (self.ground.oedometric_modulus(), self.ground.fluid_compressibility());
        let first = modulus * mobility;
        let middle = modulus * storage * s + mobility * density * s * s + push * squeeze * s;
        let last = density * storage * s * s * s;
        let root = (middle * middle - 4.0 * first * last).sqrt();
        let sum = if (middle.conj() * root).re >= 0.0 { middle + root } else { middle - root };
        [sum / (2.0 * first), 2.0 * last / sum]
    }

    /// cosh(λ(H−z))/cosh(λH) and λ sinh(λ(H−z))/cosh(λH), without overflow.
    fn shape(&self, square: Complex64, depth: f64) -> [Complex64; 2] {
        let number = square.sqrt();
        let echo = (-2.0 * number * (self.height - depth)).exp();
        let shared = (-number * depth).exp() / (1.0 + (-2.0 * number * self.height).exp());
        [shared * (1.0 + echo), number * shared * (1.0 - echo)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closeness::assert_close;
    use crate::consolidation::{Layer, Ramp};

    const MODELS: [Model; 3] = [Model::Up, Model::Upna, Model::Biot];

    /// The paper's material with k = 1e-2 m/s: M = 16.5 MPa.
    fn column() -> Column {
        let ground = Ground {
            young: 4350e3,
            poisson: 0.45,
            conductivity: 1e-2,
            unit_weight: 9800.0,
            porosity: 0.4,
            fluid_modulus: 2.2e9,
        };
        Column { ground, height: 10.0, density: 1500.0, fluid_density: 1000.0 }
    }

    /// Amplitudes for a load of 1 kPa by an independent program (a 4×4 complex eigenproblem, checked there by
    /// collocation): ω (rad/s), z (m), p (kPa, real and imaginary part), u (m).
    const HARMONIC: &[(Model, f64, f64, [f64; 4])] = &[
        (Model::Up, 0.01, 0.0, [2.220446049250313e-16, 0.0, 0.0006057749164985406, -1.199188836665359e-05]),
        (
            Model::Up,
            1.0,
            5.0,
            [0.7850715776737404, 0.37114501446146925, 1.0057666020483219e-05, -0.00011193561095249796],
        ),
        (
            Model::Up,
            100.0,
            2.5,
            [1.0562592464910026, -0.17958187866041672, 1.6825625607894082e-06, 2.342283376995197e-09],
        ),
        (
            Model::Up,
            250.0,
            10.0,
            [2.8601827330923033, -2.194819203019125, -5.2567378059903245e-22, 5.2567378059903245e-22],
        ),
        (
            Model::Upna,
            0.01,
            0.0,
            [-8.326672684688674e-17, 1.6653345369377348e-16, 0.0006057750387246497, -1.1991894186175156e-05],
        ),
        (
            Model::Upna,
            1.0,
            5.0,
            [0.7852525327061007, 0.37140899322226995, 9.960307190300254e-06, -0.00011201937039002885],
        ),
        (
            Model::Upna,
            100.0,
            2.5,
            [1.0341460522740147, -0.18602837240233389, 1.7379676219205513e-06, -1.5547684854986577e-07],
        ),
        (Model::Upna, 250.0, 10.0, [1.380219510885943, -1.8927812624491613, 0.0, 3.9425533544927434e-22]),
        (
            Model::Biot,
            0.01,
            0.0,
            [-5.551115123125783e-17, -1.3877787807814457e-16, 0.0006057750998367569, -1.199189711763333e-05],
        ),
        (
            Model::Biot,
            1.0,
            5.0,
            [0.7849686917373649, 0.3723384523628272, 9.909961624239523e-06, -0.00011205959592622626],
        ),
        (
            Model::Biot,
            100.0,
            2.5,
            [1.0500852171817132, -0.07236540310759493, 1.896881365154821e-06, 1.4037650160707278e-07],
        ),
        (Model::Biot, 250.0, 10.0, [3.4000100392898625, -0.6226505788689521, -2.6283689029951623e-22, 0.0]),
    ];

    #[test]
    fn steady_vibrations_follow_an_independent_program() {
        let column = column();
        for &(model, frequency, depth, [p_re, p_im, u_re, u_im]) in HARMONIC {
            let response = column.harmonic(model, 1e3, frequency, depth);
            // Both are closed forms: round-off, amplified by the cancellation of two waves at the lowest frequency.
            let pressure = Complex64::new(p_re, p_im) * 1e3;
            assert!((response.pressure - pressure).norm() < 1e-12 * 5e3, "{response:?}");
            let displacement = Complex64::new(u_re, u_im);
            assert!((response.displacement - displacement).norm() < 1e-12 * 6e-4, "{response:?}");
        }
    }

    /// Responses to 10 kPa in 0.1 s by an independent program (fast Fourier transform with an exponential window): t
    /// (s), z (m), p (kPa), u (m).
    const TRANSIENT: &[(Model, f64, f64, [f64; 2])] = &[
        (Model::Up, 0.029296875, 0.5, [0.8958617025947289, 8.99536662567676e-06]),
        (Model::Up, 0.069580078125, 10.0, [8.310055050222974, -8.931446092845096e-21]),
        (Model::Up, 0.120849609375, 2.5, [8.978103437044604, 5.6329616889230185e-05]),
        (Model::Up, 0.6005859375, 0.0, [4.400231607227949e-15, 0.0020901995620183854]),
        (Model::Up, 0.6005859375, 5.0, [7.5322127171273285, 0.0003225866442314183]),
        (Model::Up, 1.497802734375, 5.0, [4.945134742741069, 0.001130484179307677]),
        (Model::Upna, 0.029296875, 0.5, [0.9228852896609503, 7.763439937177872e-06]),
        (Model::Upna, 0.069580078125, 10.0, [8.294223152636889, -1.2552130213521643e-20]),
        (Model::Upna, 0.120849609375, 2.5, [9.000730798134901, 5.3825046624547255e-05]),
        (Model::Upna, 0.6005859375, 0.0, [-1.2253477432182773e-15, 0.0020892468623562982]),
        (Model::Upna, 0.6005859375, 5.0, [7.533304602065014, 0.00032146927425794666]),
        (Model::Upna, 1.497802734375, 5.0, [4.945738940740642, 0.0011301358054896368]),
        (Model::Biot, 0.029296875, 0.5, [1.0167456560838917, 7.688846366787801e-06]),
        (Model::Biot, 0.069580078125, 10.0, [8.452375705881472, 6.351357598303088e-22]),
        (Model::Biot, 0.120849609375, 2.5, [8.984555942371927, 5.2528428187626356e-05]),
        (Model::Biot, 0.6005859375, 0.0, [-9.312030972074676e-16, 0.002088747534701126]),
        (Model::Biot, 0.6005859375, 5.0, [7.528954428229868, 0.0003208929523399953]),
        (Model::Biot, 1.497802734375, 5.0, [4.943927794233398, 0.0011299526818173776]),
    ];

    #[test]
    fn a_smooth_step_follows_an_independent_program() {
        let (column, load) = (column(), SmoothLoad { load: 10e3, duration: 0.1 });
        for &(model, time, depth, [pressure, displacement]) in TRANSIENT {
            let motion = column.smooth(model, load, depth, &[time])[0];
            // The other program states 5e-6 of the load; both seem better.
            assert_close(motion.pressure, pressure * 1e3, 2e-8 * 10e3);
            assert_close(motion.displacement, displacement, 2e-8 * 6e-3);
        }
    }

    /// The equations projected on sin κz (pressure) and cos κz (displacement), κ = (m+½)π/H, which meet every condition
    /// at top and base: a sum over modes instead of two waves.
    fn by_modes(column: &Column, model: Model, s: Complex64, depth: f64) -> Amplitude {
        let Transformed { mobility, density, push, squeeze } = column.transformed(model, s);
        let modulus = column.ground.oedometric_modulus();
        let storage = column.ground.fluid_compressibility() * s;
        // The static displacement is known in closed form; the modes add what differs from it, which falls like κ^(−4).
        let mut sum =
            Amplitude { pressure: Complex64::ZERO, displacement: Complex64::from((column.height - depth) / modulus) };
        for mode in 0..20_000 {
            let number = (mode as f64 + 0.5) * PI / column.height;
            let pressed = squeeze * s * number / (mobility * number * number + storage);
            let stiffness = density * s * s + modulus * number * number + push * number * pressed;
            let share = 2.0 / column.height / stiffness;
            let fixed = 2.0 / (column.height * modulus * number * number);
            sum.displacement += (share - fixed) * (number * depth).cos();
            sum.pressure += pressed * share * (number * depth).sin();
        }
        sum
    }

    #[test]
    fn two_waves_are_a_sum_over_modes() {
        let column = column();
        for model in MODELS {
            for s in [Complex64::new(0.0, 3.0), Complex64::new(0.0, 170.0), Complex64::new(2.0, 30.0)] {
                for depth in [1.3, 6.0, 10.0] {
                    let (waves, modes) = (column.transfer(model, s, depth), by_modes(&column, model, s, depth));
                    // The modes left out: |ρ s²/M² + s γ_w/(k M)| 2/(H M) Σ κ^(−4) for u, 2 s γ_w/(k M H) Σ κ^(−3) sin
                    // κz for p.
                    assert!((waves.pressure - modes.pressure).norm() < 1e-8, "{waves:?} {modes:?}");
                    let tolerance = 1e-10 * column.height / column.ground.oedometric_modulus();
                    assert!((waves.displacement - modes.displacement).norm() < tolerance, "{waves:?} {modes:?}");
                }
            }
        }
    }

    /// A half-space with incompressible fluid under a load of 3 kPa put on at once (the data of de Boer, Ehlers and
    /// Liu, 1993): u (mm) from the closed solution of the telegraph equation, integrated by an independent program, for
    /// t (s) and z (m), full and u–p. The column's base is not felt before 0.11 s.
    #[test]
    fn a_sudden_load_on_a_half_space_follows_the_telegraph_equation() {
        let ground = Ground {
            young: 20.1e6,
            poisson: 0.2,
            conductivity: 0.01,
            unit_weight: 9810.0,
            porosity: 0.33,
            fluid_modulus: f64::INFINITY,
        };
        let column = Column { ground, height: 10.0, density: 1670.0, fluid_density: 1000.0 };
        let table = [
            (0.005, 0.0, 0.04236, 0.04928),
            (0.01, 0.0, 0.06653, 0.07105),
            (0.01, 0.4, 0.0243, 0.02949),
            (0.02, 1.0, 0.01482, 0.0184),
            (0.05, 0.4, 0.11128, 0.11306),
            (0.05, 1.0, 0.05902, 0.06102),
            (0.1, 0.0, 0.22711, 0.22831),
        ];
        for (time, depth, full, up) in table {
            for (model, expected) in [(Model::Biot, full), (Model::Up, up)] {
                let series = FourierSeries::up_to_frequency(time, 400.0 / time);
                let motion = column.transient(model, |s| 3e3 / s, series, depth, &[time])[0];
                // Half of the last digit.
                assert_close(motion.displacement * 1e3, expected, 5.1e-6);
            }
        }
    }

    /// Without mass the column consolidates: Terzaghi's series for a step, weighed with the rate of the load, 1 − cos,
    /// for which the trapezoidal rule is exact to round-off.
    #[test]
    fn without_mass_it_is_consolidation() {
        let column = Column { density: 1e-7, fluid_density: 1e-10, ..column() };
        let layer = Layer {
            height: 10.0,
            modulus: column.ground.oedometric_modulus(),
            conductivity: 1e-2,
            unit_weight: 9800.0,
            fluid_compressibility: column.ground.fluid_compressibility(),
        };
        let load = SmoothLoad { load: 10e3, duration: 2.0 };
        let step = Ramp { load: 10e3, duration: 0.0 };
        let shifted = |of: &dyn Fn(f64) -> f64| {
            let weight = |index: usize| (1.0 - (2.0 * PI * index as f64 / 256.0).cos()) / 256.0;
            (0..256).map(|index| weight(index) * of(5.0 - 2.0 * index as f64 / 256.0)).sum::<f64>()
        };
        for model in MODELS {
            let motion = column.smooth(model, load, 4.0, &[5.0])[0];
            // The stated accuracy of the inversion.
            assert_close(motion.pressure, shifted(&|time| layer.pressure(step, 4.0, time)), 2e-8 * 10e3);
            let top = column.smooth(model, load, 0.0, &[5.0])[0];
            assert_close(top.displacement, shifted(&|time| layer.settlement(step, time)), 2e-8 * 6e-3);
        }
    }

    /// Almost impermeable ground is one elastic body of modulus M + K^f/n: d'Alembert's waves, which double at the
    /// base.
    #[test]
    fn without_flow_it_is_one_elastic_body() {
        let ground = Ground { conductivity: 1e-14, ..column().ground };
        let column = Column { ground, ..column() };
        let (fluid, density) = (2.2e9 / 0.4, 1500.0);
        let modulus = column.ground.oedometric_modulus() + fluid;
        let speed = (modulus / density).sqrt();
        let load = SmoothLoad { load: 10e3, duration: 4e-3 };
        for model in MODELS {
            for time in [6e-3, 8e-3, 12e-3] {
                let base = column.smooth(model, load, 10.0, &[time])[0];
                // The drained film at the top, √(c_v t) = 4e-7 m thick, has no mass and passes the load on
                // undiminished.
                assert_close(base.pressure, 2.0 * fluid / modulus * load.at(time - 10.0 / speed), 5e-9 * 10e3);
                let middle = column.smooth(model, load, 5.0, &[time])[0];
                let waves = load.at(time - 5.0 / speed) + load.at(time - 15.0 / speed);
                assert_close(middle.pressure, fluid / modulus * waves, 5e-9 * 10e3);
            }
        }
    }

    #[test]
    fn it_is_at_rest_before_the_load_and_static_at_its_end() {
        let (column, load) = (column(), SmoothLoad { load: 10e3, duration: 2.0 });
        let static_state = column.harmonic(Model::Up, 10e3, 0.0, 3.0);
        for model in MODELS {
            let motions = column.smooth(model, load, 3.0, &[-1.0, 0.0, 1e-9, 60.0]);
            assert_eq!(motions[0], Motion { pressure: 0.0, displacement: 0.0 });
            assert_eq!(motions[1], motions[0]);
            assert_close(motions[2].pressure, 0.0, 2e-8 * 10e3);
            // c_v t/H² = 10 leaves e^(−25) of the pressure.
            assert_close(motions[3].pressure, 0.0, 2e-8 * 10e3);
            assert_close(motions[3].displacement, static_state.displacement.re, 2e-8 * 6e-3);
            let slow = column.harmonic(model, 10e3, 1e-9, 3.0);
            assert!((slow.displacement - static_state.displacement).norm() < 1e-8 * 6e-3);
            assert!(slow.pressure.norm() < 1e-7 * 10e3);
        }
    }

    #[test]
    fn it_is_read_by_the_names_of_its_fields() {
        let text = r#"{ "ground": { "young": 4350e3, "poisson": 0.45, "conductivity": 1e-2, "unit_weight": 9800.0,
            "porosity": 0.4, "fluid_modulus": 2.2e9 }, "height": 10.0, "density": 1500.0, "fluid_density": 1000.0 }"#;
        assert_eq!(serde_json::from_str::<Column>(text).unwrap(), column());
        let names = ["\"up\"", "\"upna\"", "\"biot\""];
        assert_eq!(names.map(|name| serde_json::from_str::<Model>(name).unwrap()), MODELS);
        assert!(serde_json::from_str::<SmoothLoad>(r#"{ "load": 1.0, "duration": 1.0, "shape": 2 }"#).is_err());
    }
}
