//! A point whose law has failed in a run, as an element test that asks the law again.

use std::error::Error;

use erased_serde::Serialize;
use tsutsumi::law::Question;
use tsutsumi::solver::StepError;
use tsutsumi::tensor::Sym3;
use tsutsumi_reference::finite_elements::FiniteElementError;

use crate::element::{DEFAULT_TOLERANCE, ElementTestFile, Stage, StageKind, TestInitial, TestMaterial, TestOutput};
use crate::{Case, Model};

/// The text of the element test, if it was a law that has failed; in the error, why there can be none.
///
/// The model is as the failed step has left it: the particle's group still holds the history that the law was given.
pub(crate) fn failed_point<const D: usize>(
    error: &(dyn Error + 'static),
    case: &Case,
    model: &dyn Model<D>,
) -> Option<Result<String, String>> {
    let (particle, question) = asked(error)?;
    let place = model.particles().place_of(particle);
    let group = model.groups().iter().find(|group| group.particles().contains(&place))?;
    let material = case.materials.get(group.name())?;
    let written = written(&*group.history(place - group.particles().start)).map(|history| ElementTestFile {
        title: format!("{}: the point whose law has failed", case.title),
        material: TestMaterial { law: material.law.clone(), parameters: material.parameters.clone() },
        initial: TestInitial { components: Some(components(question.stress)), history, ..TestInitial::default() },
        stages: vec![stage(question)],
        resistance: None,
        figures: Vec::new(),
        output: TestOutput { figures: false, ..TestOutput::default() },
        tolerance: DEFAULT_TOLERANCE,
    });
    let text = written.and_then(|file| toml::to_string(&file).map_err(|error| error.to_string()));
    Some(text.map(|text| comment(&error.to_string()) + &text))
}

/// The number of the particle or Gauss point whose law has failed, and what the law was asked.
fn asked(error: &(dyn Error + 'static)) -> Option<(usize, Question)> {
    if let Some(StepError::Law { particle, question, .. }) = error.downcast_ref() {
        return Some((*particle, **question));
    }
    match error.downcast_ref()? {
        FiniteElementError::Law { point, question, .. } => Some((*point, **question)),
        _ => None,
    }
}

/// A history as TOML: floats keep all their digits. Nothing for a law without a history.
fn written(history: &dyn Serialize) -> Result<Option<toml::Value>, String> {
    match toml::Value::try_from(history) {
        Ok(value) => Ok(Some(value)),
        // What serde calls a unit is no value of TOML; JSON tells it from what cannot be written.
        Err(_) if serde_json::to_string(history).is_ok_and(|text| text == "null") => Ok(None),
        Err(error) => Err(format!("its history cannot be written as TOML: {error}")),
    }
}

fn stage(question: Question) -> Stage {
    let Question { increment, .. } = question;
    let spin = [increment.spin.x, increment.spin.y, increment.spin.z];
    Stage {
        strain: Some(components(increment.strain)),
        spin: Some(spin).filter(|spin| *spin != [0.0; 3]),
        duration: Some(increment.duration).filter(|duration| duration.is_finite()),
        ..Stage::of_kind(StageKind::Increment)
    }
}

fn components(tensor: Sym3) -> [f64; 6] {
    let Sym3 { xx, yy, zz, xy, yz, zx } = tensor;
    [xx, yy, zz, xy, yz, zx]
}

/// The error above the test, line by line.
fn comment(text: &str) -> String {
    text.lines().map(|line| format!("# {line}\n")).collect()
}

#[cfg(test)]
mod tests;
