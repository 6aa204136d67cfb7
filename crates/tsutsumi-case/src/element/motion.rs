//! From a stage of a file to a loading of the library.

use tsutsumi::element::{Condition, CycleLimits, Cycles, Drainage, ExcessPressure, Loading, Specimen};
use tsutsumi::law::Increment;
use tsutsumi::tensor::{Sym3, Vector};

use super::schema::{
    Amplitude, Coefficients, DrainageKind, Driver, LiquefactionCriterion, PathCondition, Stage, StageKind, Target,
    Until,
};

/// Increments of a monotonic stage, if it gives none.
const INCREMENTS: usize = 200;
/// The strain increment of a cyclic stage that turns at a stress (–), if it gives none.
const STRAIN_INCREMENT: f64 = 1e-5;
/// Increments per amplitude of other cyclic stages, if they give none.
const INCREMENTS_PER_AMPLITUDE: f64 = 100.0;
/// The strain in one direction after which an amplitude of stress counts as out of reach (–).
const GIVE_UP_STRAIN: f64 = 0.5;

/// How a stage moves the specimen.
pub(super) enum Motion {
    /// The loading parameter goes to a value in equal increments, each within a duration (s).
    Monotonic { loading: Box<Loading>, to: f64, increments: usize, duration: f64 },
    /// Back and forth.
    Cyclic(Box<Cycles>),
    /// As it is.
    Once(Box<Increment>),
}

impl Motion {
    /// The motion of a stage that begins with a specimen as it is. The stage must have been checked.
    ///
    /// # Errors
    /// A stress ratio where there is no stress, in words.
    pub(super) fn of(stage: &Stage, specimen: &Specimen, water: Option<ExcessPressure>) -> Result<Self, String> {
        if let Some(strain) = stage.strain {
            return Ok(Motion::Once(Box::new(increment(stage, strain))));
        }
        let increments = stage.increments.unwrap_or(INCREMENTS);
        let duration = stage.duration.map_or(f64::INFINITY, |duration| duration / increments as f64);
        Ok(match (&stage.conditions, stage.amplitude, stage.until) {
            (Some(conditions), ..) => {
                Motion::Monotonic { loading: Box::new(path(conditions, specimen)), to: 1.0, increments, duration }
            }
            (None, Some(amplitude), Some(until)) => {
                let cycles = cycles(stage, amplitude, until, specimen, water);
                if cycles.amplitude <= 0.0 {
                    return Err("a stress ratio needs an effective stress at the start of the stage".to_owned());
                }
                Motion::Cyclic(Box::new(cycles))
            }
            _ => {
                let (driven, value) = stage.to.as_ref().and_then(driven).unwrap_or((Condition::AXIAL_STRAIN, 0.0));
                let is_stress = driven.stress != Sym3::ZERO;
                let to = if is_stress { value - driven.of(specimen) } else { value };
                Motion::Monotonic { loading: Box::new(loading(stage, driven)), to, increments, duration }
            }
        })
    }
}

fn increment(stage: &Stage, [xx, yy, zz, xy, yz, zx]: [f64; 6]) -> Increment {
    Increment {
        strain: Sym3 { xx, yy, zz, xy, yz, zx },
        spin: stage.spin.map_or_else(Vector::zeros, Vector::from),
        duration: stage.duration.unwrap_or(f64::INFINITY),
    }
}

fn loading(stage: &Stage, driven: Condition) -> Loading {
    let drainage = match stage.drainage {
        None | Some(DrainageKind::Drained) => Drainage::Drained,
        Some(DrainageKind::Undrained) => Drainage::Undrained,
        Some(DrainageKind::ConstantMeanStress) => Drainage::ConstantMeanStress,
    };
    match stage.kind {
        StageKind::Isotropic => Loading::isotropic(driven),
        StageKind::Oedometer | StageKind::Path | StageKind::Increment => Loading::uniaxial_strain(driven),
        StageKind::Triaxial => Loading::triaxial(drainage, driven),
        StageKind::SimpleShear => Loading::simple_shear(drainage, driven),
    }
}

/// The stress whose total stays in undrained shear of this kind.
pub(super) fn held_total(kind: StageKind) -> Condition {
    match kind {
        StageKind::SimpleShear => Condition::AXIAL_STRESS,
        _ => Condition::RADIAL_STRESS,
    }
}

fn cycles(
    stage: &Stage,
    amplitude: Amplitude,
    until: Until,
    specimen: &Specimen,
    water: Option<ExcessPressure>,
) -> Cycles {
    // The stress that a stress ratio is multiplied by: 2 σ'_r in triaxial tests, σ'_v in simple shear.
    let (strain, stress, per_ratio) = match stage.kind {
        StageKind::SimpleShear => (Condition::SHEAR_STRAIN, Condition::SHEAR_STRESS, 1.0),
        _ => (Condition::AXIAL_STRAIN, Condition::STRESS_DIFFERENCE, 2.0),
    };
    let size = amplitude.stress_ratio.map(|ratio| ratio * per_ratio * held_total(stage.kind).of(specimen));
    let (watched, size) = match size.or(amplitude.stress) {
        Some(size) => (stress, size),
        None => (strain, amplitude.strain.unwrap_or_default()),
    };
    let is_by_stress = stage.driven_by == Some(Driver::Stress);
    let driven = if is_by_stress { stress } else { strain };
    let usual = if driven == watched { size / INCREMENTS_PER_AMPLITUDE } else { STRAIN_INCREMENT };
    let increment = stage.increment.unwrap_or(usual);
    Cycles {
        loading: loading(stage, driven),
        watched,
        amplitude: size,
        increment,
        duration: stage.rate.map_or(f64::INFINITY, |rate| increment / rate),
        strain,
        water,
        limits: CycleLimits {
            cycles: until.cycles,
            single_strain: until.single_strain,
            double_strain: until.double_strain,
            pore_pressure_ratio: until.pore_pressure_ratio,
            give_up_strain: GIVE_UP_STRAIN,
        },
    }
}

fn path(conditions: &[PathCondition], specimen: &Specimen) -> Loading {
    let conditions: Vec<(Condition, f64)> = conditions.iter().map(|given| prescribed(given, specimen)).collect();
    // Six, as has been checked; an absent one would leave the strain open, which the library reports.
    let at = |i: usize| conditions.get(i).copied().unwrap_or((Condition::of_stress(Sym3::ZERO), 0.0));
    Loading { conditions: std::array::from_fn(|i| at(i).0), rates: std::array::from_fn(|i| at(i).1) }
}

/// A condition, and the change of its value in the stage.
fn prescribed(given: &PathCondition, specimen: &Specimen) -> (Condition, f64) {
    let tensor =
        |c: Coefficients| Sym3 { xx: c.xx, yy: c.yy, zz: c.zz, xy: 0.5 * c.xy, yz: 0.5 * c.yz, zx: 0.5 * c.zx };
    let [stress, strain] = [given.stress, given.strain].map(|c| c.map_or(Sym3::ZERO, tensor));
    let condition = Condition { stress, strain };
    let change = given.to.map(|to| to - condition.of(specimen)).or(given.by).unwrap_or(0.0);
    (condition, change)
}

/// The quantity that a target names, and its value.
pub(super) fn driven(target: &Target) -> Option<(Condition, f64)> {
    let all = target.all();
    all.into_iter().find_map(|(_, condition, value)| Some((condition, value?)))
}

impl Target {
    /// Every quantity with its name, and its value if it is given.
    pub(super) fn all(&self) -> [(&'static str, Condition, Option<f64>); 7] {
        [
            ("mean_stress", Condition::MEAN_STRESS, self.mean_stress),
            ("axial_stress", Condition::AXIAL_STRESS, self.axial_stress),
            ("stress_difference", Condition::STRESS_DIFFERENCE, self.stress_difference),
            ("shear_stress", Condition::SHEAR_STRESS, self.shear_stress),
            ("volumetric_strain", Condition::VOLUMETRIC_STRAIN, self.volumetric_strain),
            ("axial_strain", Condition::AXIAL_STRAIN, self.axial_strain),
            ("shear_strain", Condition::SHEAR_STRAIN, self.shear_strain),
        ]
    }
}

impl Amplitude {
    /// Every measure with its name, and its value if it is given.
    pub(super) fn all(&self) -> [(&'static str, Option<f64>); 3] {
        [("stress_ratio", self.stress_ratio), ("stress", self.stress), ("strain", self.strain)]
    }
}

impl LiquefactionCriterion {
    /// Every measure with its name, and its value if it is given.
    pub(super) fn all(&self) -> [(&'static str, Option<f64>); 3] {
        [
            ("single_strain", self.single_strain),
            ("double_strain", self.double_strain),
            ("pore_pressure_ratio", self.pore_pressure_ratio),
        ]
    }
}
