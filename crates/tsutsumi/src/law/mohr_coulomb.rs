use std::f64::consts::FRAC_PI_3;

use serde::{Deserialize, Serialize};

use super::frictional::{FrictionalState, Softening, Strength, softened_strain, validate_flow};
use super::principal::Principal;
use super::{ClosedPathWork, ConstitutiveLaw, LawError, LinearElastic};
use crate::tensor::Sym3;

/// Mohr–Coulomb plasticity: friction and cohesion on planes, with dilatancy, tensile cut-off and softening.
///
/// # Equation
///
/// With principal stresses σ₁ ≥ σ₂ ≥ σ₃, tension positive:
///
/// ```text
/// f = (σ₁ − σ₃) + (σ₁ + σ₃) sin φ − 2 c cos φ ≤ 0      g = (σ₁ − σ₃) + (σ₁ + σ₃) sin ψ      σ₁ ≤ min(σ_t, c cot φ)
/// ```
///
/// Planes, edges and corners are met exactly: the stress goes back along the sum of the flow directions of the planes that are active, whose
/// multipliers are not negative; none is rounded. The cut-off flows along σ₁. At the apex of a law without cut-off the volume opens as much as
/// it must. Friction angle and cohesion fall linearly with the plastic deviatoric strain, the sum of √(2/3 Δe^p : Δe^p), and are those at the end of the
/// step; the dilatancy angle is never above the friction angle.
///
/// # Validity
///
/// Sand, silt, drained clay; with φ = 0, Tresca's undrained clay (c = c_u). No hardening before the peak, constant elastic moduli. A softening band is
/// as wide as a cell: results depend on the grid. An initial stress outside the surface comes back to it in the first step. Opening along the cut-off softens
/// by the deviatoric part of its strain only.
///
/// # Reference
///
/// Return map after Morikawa and Asai, app. A, and E. A. de Souza Neto, D. Perić and D. R. J. Owen, Computational Methods for Plasticity, sec. 8.2 (the
/// second from memory); derived again, and tested against a closest-point projection that knows nothing of edges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MohrCoulomb {
    /// Young's modulus E (Pa), positive.
    pub young: f64,
    /// Poisson's ratio ν (–), above −1 and below 0.5.
    pub poisson: f64,
    /// The friction angle φ (°), from 0 to below 90.
    pub friction_angle_deg: f64,
    /// The cohesion c (Pa), zero or positive.
    pub cohesion: f64,
    /// The dilatancy angle ψ (°), from 0 to φ; default 0.
    #[serde(default)]
    pub dilatancy_angle_deg: f64,
    /// The largest principal stress σ_t (Pa), zero or positive; without it, that of the apex.
    pub tensile_strength: Option<f64>,
    /// The friction angle after softening (°), from 0 to φ; without it, φ.
    pub friction_angle_residual_deg: Option<f64>,
    /// The cohesion after softening (Pa), from 0 to c; without it, c.
    pub cohesion_residual: Option<f64>,
    /// The plastic deviatoric strain over which the strength falls (–), positive if it does.
    #[serde(default)]
    pub softening_strain: f64,
}

/// A plane of the surface in principal stresses: normal · σ ≤ strength; plastic strain along the flow.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: [f64; 3],
    flow: [f64; 3],
    strength: f64,
}

/// The surface for one strength.
struct Surface {
    sin_friction: f64,
    sin_dilatancy: f64,
    /// 2 c cos φ (Pa).
    strength: f64,
    /// The largest principal stress (Pa): the cut-off, or the apex where that is lower; infinite where there is neither.
    tension: f64,
    /// Whether there is a cut-off below the apex.
    cut_off: bool,
    elastic: LinearElastic,
}

fn determinant(a: Sym3) -> f64 {
    a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.zx) + a.zx * (a.xy * a.yz - a.yy * a.zx)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Surface {
    /// The plane of the stresses number `largest` and `smallest`.
    fn shear_plane(&self, largest: usize, smallest: usize) -> Plane {
        let direction = |sin: f64| {
            let mut vector = [0.0; 3];
            (vector[largest], vector[smallest]) = (1.0 + sin, sin - 1.0);
            vector
        };
        Plane { normal: direction(self.sin_friction), flow: direction(self.sin_dilatancy), strength: self.strength }
    }

    /// The cut-off of one principal stress.
    fn tension_plane(&self, axis: usize) -> Plane {
        let mut direction = [0.0; 3];
        direction[axis] = 1.0;
        Plane { normal: direction, flow: direction, strength: self.tension }
    }

    /// The stress (Pa) that belongs to elastic principal strains.
    fn stiffness_times(&self, strain: [f64; 3]) -> [f64; 3] {
        let volumetric = self.elastic.lame() * (strain[0] + strain[1] + strain[2]);
        strain.map(|component| volumetric + 2.0 * self.elastic.shear_modulus() * component)
    }

    /// Whether a stress lies inside by more than round-off: spares elastic points the search for axes.
    ///
    /// ```text
    /// σ₁ = σ_m + 2 √(J₂/3) cos α      σ₃ = σ_m + 2 √(J₂/3) cos(α + 120°)      cos 3α = ½ J₃ (3/J₂)^(3/2)
    /// ```
    fn surely_holds(&self, stress: Sym3) -> bool {
        let (mean, deviator) = (stress.trace() / 3.0, stress.deviator());
        let radius = (2.0 / 3.0 * deviator.double_dot(deviator)).sqrt();
        let cosine = if radius > 0.0 { 4.0 * determinant(deviator) / radius.powi(3) } else { 0.0 };
        let angle = cosine.clamp(-1.0, 1.0).acos() / 3.0;
        let [largest, smallest] = [0.0, 2.0].map(|thirds| mean + radius * (angle + thirds * FRAC_PI_3).cos());
        // Where two stresses are equal, the angle has half the digits of the stress.
        self.holds([largest, mean, smallest], -1e-6 * radius)
    }

    /// Whether stresses in falling order lie inside, give or take `margin` (Pa).
    fn holds(&self, stress: [f64; 3], margin: f64) -> bool {
        let [first, _, last] = stress;
        (first - last) + (first + last) * self.sin_friction <= self.strength + 2.0 * margin
            && first <= self.tension + margin
    }

    /// The stress on all of these planes, if it is reached by multipliers that are not negative.
    fn on<const N: usize>(&self, trial: [f64; 3], planes: [Plane; N], margin: f64) -> Option<[f64; 3]> {
        let pushes = planes.map(|plane| self.stiffness_times(plane.flow));
        let matrix = nalgebra::SMatrix::<f64, N, N>::from_fn(|i, j| dot(planes[i].normal, pushes[j]));
        let excess = nalgebra::SVector::<f64, N>::from_fn(|i, _| dot(planes[i].normal, trial) - planes[i].strength);
        let multipliers = solve(matrix, excess)?;
        let mut stress = trial;
        for (push, &multiplier) in pushes.iter().zip(&multipliers) {
            for (component, change) in stress.iter_mut().zip(push) {
                *component -= multiplier * change;
            }
        }
        let ordered = stress[0] >= stress[1] - margin && stress[1] >= stress[2] - margin;
        let forward = multipliers.iter().all(|&multiplier| multiplier * self.elastic.shear_modulus() >= -margin);
        (ordered && forward && self.holds(stress, margin)).then_some(stress)
    }

    /// The return of ordered trial stresses. Only a surface that has softened away from them may hold them as they are. Else one of the planes, edges and corners takes it; the last needs no test.
    fn project(&self, trial: [f64; 3]) -> [f64; 3] {
        if self.holds(trial, 0.0) {
            return trial;
        }
        // Round-off of the stresses, so that none of two neighbours refuses a point between them.
        let margin = 1e-12 * (trial[0].abs() + trial[2].abs() + self.strength);
        let main = self.shear_plane(0, 2);
        let (right, left) = (self.shear_plane(0, 1), self.shear_plane(1, 2));
        let shear = || {
            self.on(trial, [main], margin)
                .or_else(|| self.on(trial, [main, right], margin))
                .or_else(|| self.on(trial, [main, left], margin))
        };
        if !self.cut_off {
            return shear().unwrap_or([self.tension; 3]);
        }
        let [first, second, third] = [0, 1, 2].map(|axis| self.tension_plane(axis));
        shear()
            .or_else(|| self.on(trial, [first], margin))
            .or_else(|| self.on(trial, [first, second], margin))
            .or_else(|| self.on(trial, [first, second, third], margin))
            .or_else(|| self.on(trial, [main, first], margin))
            .or_else(|| self.on(trial, [main, right, first], margin))
            .unwrap_or_else(|| {
                let smallest = ((1.0 + self.sin_friction) * self.tension - self.strength) / (1.0 - self.sin_friction);
                [self.tension, self.tension, smallest]
            })
    }
}

/// The solution of a small system of equations, by the inverse in closed form.
fn solve<const N: usize>(
    matrix: nalgebra::SMatrix<f64, N, N>,
    right_side: nalgebra::SVector<f64, N>,
) -> Option<nalgebra::SVector<f64, N>> {
    Some(matrix.try_inverse()? * right_side)
}

/// An elastic trial stress outside the surface.
struct Trial {
    stress: Sym3,
    principal: Principal,
    elastic: LinearElastic,
}

impl Trial {
    /// The stress (Pa) to which a surface takes it, and the plastic strain (–).
    fn returned(&self, surface: &Surface) -> (Sym3, Sym3) {
        let stress = self.principal.with_values(surface.project(self.principal.values));
        let change = self.stress - stress;
        let volumetric = change.trace() / (9.0 * self.elastic.bulk_modulus());
        let strain = change.deviator() * (0.5 / self.elastic.shear_modulus()) + Sym3::IDENTITY * volumetric;
        (stress, strain)
    }
}

impl MohrCoulomb {
    fn elastic(&self) -> LinearElastic {
        LinearElastic { young: self.young, poisson: self.poisson }
    }

    fn softening(&self) -> Softening {
        Softening::new(
            self.friction_angle_deg,
            self.cohesion,
            self.friction_angle_residual_deg,
            self.cohesion_residual,
            self.softening_strain,
        )
    }

    fn surface(&self, softening: &Softening, plastic_strain: f64) -> Surface {
        let Strength { friction_angle, cohesion } = softening.at(plastic_strain);
        let (sin_friction, cos_friction) = friction_angle.sin_cos();
        let sin_dilatancy = self.dilatancy_angle_deg.to_radians().min(friction_angle).sin();
        let apex = cohesion * cos_friction / sin_friction;
        let tension = self.tensile_strength.unwrap_or(f64::INFINITY);
        Surface {
            sin_friction,
            sin_dilatancy,
            strength: 2.0 * cohesion * cos_friction,
            tension: tension.min(apex),
            cut_off: tension < apex,
            elastic: self.elastic(),
        }
    }
}

impl ConstitutiveLaw for MohrCoulomb {
    type State = FrictionalState;

    fn update(&self, stress: Sym3, state: FrictionalState, strain: Sym3) -> Result<(Sym3, FrictionalState), LawError> {
        let (elastic, softening) = (self.elastic(), self.softening());
        let (trial_stress, ()) = elastic.update(stress, (), strain)?;
        let strain_old = state.plastic_deviatoric_strain;
        let surface = self.surface(&softening, strain_old);
        let still_elastic = FrictionalState { yielding: false, ..state };
        if surface.surely_holds(trial_stress) {
            return Ok((trial_stress, still_elastic));
        }
        let trial = Trial { stress: trial_stress, principal: Principal::of(trial_stress), elastic };
        if surface.holds(trial.principal.values, 0.0) {
            return Ok((trial_stress, still_elastic));
        }
        let (mut end, mut plastic) = trial.returned(&surface);
        let mut plastic_strain = strain_old + plastic.deviatoric_strain();
        if softening.goes_on_at(strain_old) && plastic_strain > strain_old {
            let returned = |strain: f64| trial.returned(&self.surface(&softening, strain));
            let increment = |strain: f64| returned(strain).1.deviatoric_strain();
            plastic_strain = softened_strain(strain_old, softening.over, increment)?;
            (end, plastic) = returned(plastic_strain);
        }
        Ok((end, state.after(plastic_strain, plastic.trace())))
    }

    fn p_wave_modulus(&self, _stress: Sym3, _state: &FrictionalState) -> f64 {
        self.elastic().oedometric_modulus()
    }

    fn s_wave_modulus(&self, _stress: Sym3, _state: &FrictionalState) -> f64 {
        self.elastic().shear_modulus()
    }

    /// Flow along the normal of a surface that stays, where ψ = φ and nothing softens. Otherwise there are paths that win work: flow that opens less than
    /// the normal does is driven by a smaller shear stress after a fall of the pressure.
    fn closed_path_work(&self) -> ClosedPathWork {
        self.softening().closed_path_work(self.dilatancy_angle_deg)
    }

    fn validate(&self) -> Result<(), LawError> {
        self.elastic().validate()?;
        self.softening().validate()?;
        validate_flow(self.friction_angle_deg, self.dilatancy_angle_deg, self.tensile_strength)
    }

    fn outputs(&self) -> &'static [&'static str] {
        FrictionalState::OUTPUTS
    }

    fn write_outputs(&self, _stress: Sym3, state: &FrictionalState, values: &mut [f64]) {
        state.write(values);
    }
}
