//! The runs that a study file asks for.

use super::schema::{Reference, Refinement, StudyFile, Sweep, Variant};
use super::setting::{Setting, refuse_unquoted};
use super::sweep::{RefinementStep, SweptVariant, expanded};
use crate::{CaseError, CaseSource, KeyPath};

/// A run as the study file asks for it.
pub(super) struct WantedRun {
    pub(super) name: String,
    pub(super) label: Option<String>,
    pub(super) is_reference: bool,
    pub(super) allow_unstable: bool,
    /// The problem that it belongs to.
    pub(super) problem: Option<String>,
    /// Its place in the refinement of a sweep.
    pub(super) step: Option<RefinementStep>,
    /// Where it stands in the study file.
    pub(super) place: KeyPath,
    /// A case file of its own.
    pub(super) case: Option<String>,
    pub(super) settings: Vec<Setting>,
}

/// All runs that a study asks for, in the order of the file: variants, sweeps, reference runs.
pub(super) fn wanted_runs(
    source: &CaseSource,
    file: &StudyFile,
    extra: &[String],
) -> Result<Vec<WantedRun>, CaseError> {
    let mut runs: Vec<WantedRun> = Vec::new();
    let own = read_settings(source, &KeyPath::from("set"), &file.set)?;
    for (index, variant) in file.variants.iter().enumerate() {
        let place = KeyPath::from("variants").index(index);
        let settings = read_settings(source, &place.clone().key("set"), &variant.set)?;
        runs.push(of_variant(variant, place, [own.clone(), settings].concat()));
    }
    for (index, sweep) in file.sweeps.iter().enumerate() {
        let place = KeyPath::from("sweeps").index(index);
        let common = [own.clone(), read_settings(source, &place.clone().key("set"), &sweep.set)?].concat();
        for variant in expanded(source, &place, sweep)? {
            runs.push(of_sweep(sweep, place.clone(), variant, &common));
        }
    }
    for (index, reference) in file.references.iter().enumerate().filter(|(_, reference)| is_run(reference)) {
        let place = KeyPath::from("references").index(index);
        let settings = match &reference.set {
            Some(set) => read_settings(source, &place.clone().key("set"), set)?,
            None => Vec::new(),
        };
        runs.push(of_reference(reference, place, [own.clone(), settings].concat()));
    }
    for run in &mut runs {
        run.settings.extend(extra.iter().map(|text| Setting { assignment: text.clone(), place: None }));
    }
    Ok(runs)
}

/// The refinements that sweeps make, in the order of their first variants.
pub(super) fn swept_refinements(runs: &[WantedRun]) -> Vec<Refinement> {
    let mut refinements: Vec<Refinement> = Vec::new();
    for run in runs {
        let Some(step) = &run.step else { continue };
        let known = refinements.iter().position(|refinement| refinement.name == step.refinement);
        let place = known.unwrap_or_else(|| {
            refinements.push(Refinement {
                name: step.refinement.clone(),
                label: None,
                variants: Vec::new(),
                sizes: Vec::new(),
                size_label: step.size_label.clone(),
            });
            refinements.len() - 1
        });
        refinements[place].variants.push(run.name.clone());
        refinements[place].sizes.push(step.size);
    }
    refinements
}

/// Whether a reference is another run.
pub(super) fn is_run(reference: &Reference) -> bool {
    reference.solution.is_none() && reference.file.is_none()
}

fn of_variant(variant: &Variant, place: KeyPath, settings: Vec<Setting>) -> WantedRun {
    WantedRun {
        name: variant.name.clone(),
        label: variant.label.clone(),
        is_reference: false,
        allow_unstable: variant.allow_unstable,
        problem: variant.problem.clone(),
        step: None,
        place,
        case: variant.case.clone(),
        settings,
    }
}

fn of_sweep(sweep: &Sweep, place: KeyPath, variant: SweptVariant, common: &[Setting]) -> WantedRun {
    WantedRun {
        name: variant.name,
        label: None,
        is_reference: false,
        allow_unstable: sweep.allow_unstable,
        problem: sweep.problem.clone(),
        step: variant.step,
        place,
        case: sweep.case.clone(),
        settings: [common, &variant.settings].concat(),
    }
}

fn of_reference(reference: &Reference, place: KeyPath, settings: Vec<Setting>) -> WantedRun {
    WantedRun {
        name: reference.name.clone(),
        label: reference.label.clone(),
        is_reference: true,
        allow_unstable: reference.allow_unstable,
        problem: None,
        step: None,
        place,
        case: reference.case.clone(),
        settings,
    }
}

/// A table of values to set.
fn read_settings(source: &CaseSource, place: &KeyPath, set: &toml::Table) -> Result<Vec<Setting>, CaseError> {
    let read = |(key, value): (&String, &toml::Value)| {
        let place = place.clone().key(key);
        refuse_unquoted(source, &place, key, value)?;
        Ok(Setting::new(key, value, place))
    };
    set.iter().map(read).collect()
}
