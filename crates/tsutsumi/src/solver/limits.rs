use std::fmt;

use super::Parts;

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
/// consolidation  Δt ≤ (1 + √(1 + 4 τ c_v κ²)) / (c_v κ²),  κ = 2/h       in every dimension
/// hourglass      Δt ≤ h / √((E_oed + (D−1) G) / ρ)                      in 2-D and 3-D
/// compression    Δt ≤ h / √((E_oed + (D−1) G) / ρ)                      without water
/// shear          Δt ≤ h / √(G / ρ)                                      for information: never the smallest
/// ```
///
/// A body whose surface cuts through cells has lighter nodes than these limits assume; keep a safety factor.
///
/// # Reference
///
/// Derivation in the book, "How long may a step be?"; checked there by experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepLimits {
    /// Consolidation; infinite without water.
    pub consolidation: f64,
    /// Hourglass modes with water, all modes without; infinite in saturated 1-D.
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

/// The smallest limits over the materials, for the smallest spacing of the grid.
pub(super) fn step_limits<const D: usize>(parts: &Parts<D>) -> StepLimits {
    let spacing = parts.grid.spacing().min();
    let particles = &parts.particles;
    let mut limits = StepLimits {
        consolidation: f64::INFINITY,
        skeleton: f64::INFINITY,
        shear: f64::INFINITY,
        governing: Governing::Compression,
    };
    for group in &parts.groups {
        let range = group.particles();
        let (p_wave, s_wave) = group.wave_moduli(&particles.stress[range.clone()]);
        // The lightest and the least permeable particle: both make the step shorter.
        let lowest = |value: &dyn Fn(usize) -> f64| range.clone().map(value).fold(f64::INFINITY, f64::min);
        let density = lowest(&|p| particles.mass[p] / particles.volume[p]);
        let wet = |p: usize| {
            let (density, conductivity) = (particles.mass[p] / particles.volume[p], particles.conductivity[p]);
            parts.pressure.consolidation_limit(spacing, p_wave, density, conductivity).unwrap_or(f64::INFINITY)
        };
        let consolidation = lowest(&wet);
        let transverse = (D - 1) as f64;
        let saturated_column = D == 1 && consolidation.is_finite();
        if !saturated_column {
            limits.skeleton = limits.skeleton.min(spacing / ((p_wave + transverse * s_wave) / density).sqrt());
        }
        if D > 1 {
            limits.shear = limits.shear.min(spacing / (s_wave / density).sqrt());
        }
        limits.consolidation = limits.consolidation.min(consolidation);
    }
    limits.governing = match (limits.consolidation.is_finite(), limits.consolidation <= limits.skeleton) {
        (false, _) => Governing::Compression,
        (true, true) => Governing::Consolidation,
        (true, false) => Governing::Hourglass,
    };
    limits
}
