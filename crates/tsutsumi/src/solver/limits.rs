use std::fmt;

use super::{Parts, VolumetricStrain};
use crate::pressure::StepView;

/// Which limit of the time step governs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Governing {
    /// The drained compression wave: dry ground.
    Compression,
    /// Consolidation: the explicit skeleton against the implicit water.
    Consolidation,
    /// Modes inside a cell, which a pressure constant over the cell does not see.
    Hourglass,
}

impl fmt::Display for Governing {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Governing::Compression => "compression wave of the drained skeleton",
            Governing::Consolidation => "consolidation (explicit skeleton, implicit water)",
            Governing::Hourglass => "hourglass modes inside a cell",
        })
    }
}

/// The limits of the time step (s): the smallest governs.
///
/// # Equation
///
/// ```text
/// consolidation  Δt ≤ (1 + √(1 + 2 τ r)) / r,  r = c_v κ² = 4 c_v/h²     in every dimension
/// hourglass      Δt ≤ h / √((E_oed + (D−1) G) / ρ)                      in 2-D and 3-D
/// compression    Δt ≤ h / √(2 (E_oed + (D−1) G) / ρ)                    without water
/// shear          Δt ≤ h / √(G / ρ)                                      for information: never the smallest
/// ```
///
/// With shape functions that average over boxes, the first nodes beyond a surface are as light as the boxes that reach them: the
/// limits of hourglass and compression then have √(l h) for h, with l the shortest half edge of a box. With them and with splines
/// there are nodes beyond the surface that no pressure holds: the hourglass limit holds in 1-D too. For splines Σ_I |∇N_I|²/N_I is
/// at most 6 D/h² (quadratic) and 3.2 D/h² (cubic) wherever a particle is, but in the cells at the ends of the grid.
///
/// With the volume change averaged over cells, the hourglass limit of linear shape functions has 2 G (1 − 1/D) for E_oed,
/// unless the damping has a part by stiffness: where consolidation and shear limit the step alike, their sum does then.
///
/// A stabilised checkerboard lets the water give way in the shortest waves: the limit of compression then holds with water too, in
/// 2-D and 3-D.
///
/// Damping shortens the limits of hourglass and compression, see [`Damping`](crate::damping::Damping).
///
/// The hourglass limit is for particles anywhere in a cell as long as they fill it evenly; with 2 per axis the edge lies some
/// 1.45 (2-D) and 1.54 (3-D) times higher. The compression and consolidation limits hold whatever share of the grid's accelerations the particles see; with a full
/// share they would be up to √2 longer. Where the surface cuts through cells r grows, see
/// [`Coupled`](crate::pressure::Coupled). Corners of a free body that barely reach into a cell make its nodes so light that
/// no limit is safe; such runs show it by growing velocities.
///
/// # Reference
///
/// Derivation in the book, "How long may a step be?"; checked there by experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepLimits {
    /// Consolidation; infinite without water.
    pub consolidation: f64,
    /// Hourglass modes with water, all modes without; infinite in saturated 1-D with linear shape functions.
    pub skeleton: f64,
    /// Shear waves; infinite in 1-D.
    pub shear: f64,
    /// The limit that governs.
    pub governing: Governing,
}

/// The part of the consolidation limit that an accurate run may use.
///
/// The settlement is a step ahead of the load: the pressure of a step balances the load at its end with the effective
/// stress at its start. At the limit itself this error of first order would be half a per cent of the paper's column.
const ACCURATE_PART: f64 = 0.25;

impl StepLimits {
    /// The longest stable step (s).
    pub fn longest(&self) -> f64 {
        self.consolidation.min(self.skeleton)
    }

    /// The longest step for accurate results (s): a quarter of the consolidation limit, the whole of the others.
    pub fn accurate(&self) -> f64 {
        (ACCURATE_PART * self.consolidation).min(self.skeleton)
    }
}

/// The stiffness (Pa) of hourglass modes when the volume change is the cell's: shear alone.
///
/// ```text
/// 2 G (1 − 1/D) + (D − 1) G        the deviatoric part of ∂u_x/∂x, then ∂u_x/∂y (and ∂u_x/∂z)
/// ```
fn shear_stiffness(shear_modulus: f64, dimension: f64) -> f64 {
    shear_modulus * (2.0 * (1.0 - 1.0 / dimension) + dimension - 1.0)
}

/// The smallest limits over the materials, for the smallest spacing of the grid.
pub(super) fn step_limits<const D: usize>(parts: &Parts<D>, at: &StepView<D>) -> StepLimits {
    let spacing = parts.grid.spacing().min();
    let particles = &parts.particles;
    let has_boxes = parts.shape.reach() > 0.0;
    let reaches_beyond_cells = parts.shape.least_cells() > 1;
    let mut limits = StepLimits {
        consolidation: f64::INFINITY,
        skeleton: f64::INFINITY,
        shear: f64::INFINITY,
        governing: Governing::Compression,
    };
    for group in &parts.groups {
        let range = group.particles();
        let (p_wave, s_wave) = group.wave_moduli(&mut particles.stress.within(range.clone()));
        let density = range.clone().map(|p| particles.mass[p] / particles.volume[p]).fold(f64::INFINITY, f64::min);
        let wave_limit = |modulus: f64| spacing / (modulus / density).sqrt();
        // Boxes stretch or keep their first size, by the shape function.
        let smallest = |p: usize| particles.half_size[p].inf(&particles.half_size_at_start[p]).min();
        let shortest = range.clone().map(smallest).fold(f64::INFINITY, f64::min);
        let lightness = if has_boxes { (shortest / spacing).max(0.0).sqrt().min(1.0) } else { 1.0 };
        let stiffness = p_wave + (D - 1) as f64 * s_wave;
        match parts.pressure.consolidation_limit(at, particles, range, p_wave) {
            Some(limit) => {
                limits.consolidation = limits.consolidation.min(limit);
                if D > 1 && !parts.pressure.holds_short_waves() {
                    limits.skeleton = limits.skeleton.min(lightness * wave_limit(2.0 * stiffness));
                } else if D > 1 || reaches_beyond_cells {
                    // A viscous skeleton leaves no slack to modes that consolidate and shear at once.
                    let averaged = parts.volumetric_strain == VolumetricStrain::CellAveraged
                        && !reaches_beyond_cells
                        && parts.damping.stiffness == 0.0;
                    let inside = if averaged { shear_stiffness(s_wave, D as f64) } else { stiffness };
                    limits.skeleton = limits.skeleton.min(lightness * wave_limit(inside));
                }
            }
            None => limits.skeleton = limits.skeleton.min(lightness * wave_limit(2.0 * stiffness)),
        }
        if D > 1 {
            limits.shear = limits.shear.min(wave_limit(s_wave));
        }
    }
    limits.skeleton = parts.damping.shorten(limits.skeleton);
    limits.governing = match (limits.consolidation.is_finite(), limits.consolidation <= limits.skeleton) {
        (false, _) => Governing::Compression,
        (true, true) => Governing::Consolidation,
        (true, false) => Governing::Hourglass,
    };
    limits
}
