//! A calibration from its file to its folder.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::misfit::{CurveReport, Followed, interpolated};
use super::plan::{Calibration, MeasuredCurve};
use super::search::{Found, search};
use crate::element::shown;
use crate::figures::{Curve, CurveStyle, LineChart};
use crate::folder::{FIGURES, claim_listed, claim_numbered, write_error};
use crate::results::{Host, replace_with_json};
use crate::{CaseError, Outcome, Registry, ResultsError};

/// What a calibration writes at the top of its folder.
const COPY: &str = "calibration.toml";
const PARAMETERS: &str = "parameters.toml";
const MANIFEST: &str = "calibration.json";

/// How a calibration is to be made.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CalibrationOptions {
    /// The results folder. Without it a new one is made under `results/`, named after the file.
    pub out: Option<PathBuf>,
    /// Replaces the calibration that the folder holds.
    pub force: bool,
}

/// Why a calibration could not be made, or its results not be written.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file, or an element test, is wrong.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The folder holds something else.
    #[error("`{}` is not empty and holds no calibration: choose another folder with --out", path.display())]
    NotACalibration {
        /// The folder.
        path: PathBuf,
    },
    /// A file or folder could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
}

/// A parameter that was sought.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedParameter {
    /// Its name.
    pub name: String,
    /// Where the search began.
    pub start: f64,
    /// What it has found.
    pub value: f64,
    /// Where it was sought.
    pub bounds: [f64; 2],
    /// Whether it ended at a bound: the range may be too narrow, or the data say nothing about it.
    pub at_bound: bool,
}

/// What is left of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationSummary {
    /// The results folder.
    pub folder: PathBuf,
    /// How it ended: failed if an element test cannot go on with what was found.
    pub outcome: Outcome,
    /// The parameters.
    pub parameters: Vec<FittedParameter>,
    /// How far the element tests are from the data.
    pub curves: Vec<CurveReport>,
    /// The misfit at the start and at the end (–).
    pub misfit: [f64; 2],
    /// Sets of element tests that were run.
    pub evaluations: usize,
}

/// `calibration.json`: what was sought, and what was found.
#[derive(Debug, Serialize)]
struct Manifest<'a> {
    program: &'static str,
    version: &'static str,
    title: &'a str,
    calibration: PathBuf,
    host: Host,
    started_unix_s: u64,
    outcome: &'a Outcome,
    parameters: &'a [FittedParameter],
    curves: &'a [CurveReport],
    misfit: [f64; 2],
    evaluations: usize,
    /// The files of the calibration, from its folder: what a later one may replace.
    files: Vec<String>,
}

/// The part of a manifest that tells which files are the calibration's.
#[derive(Debug, Deserialize)]
struct Held {
    #[serde(rename = "calibration")]
    _calibration: PathBuf,
    files: Vec<String>,
}

/// Fits the parameters of a calibration and writes its folder. `stop` is asked before every set of element tests whether to end here,
/// with the best so far.
///
/// # Errors
/// Element tests that cannot begin, or results that cannot be written.
pub fn calibrate(
    calibration: &Calibration,
    registry: &Registry,
    options: &CalibrationOptions,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<CalibrationSummary, CalibrationError> {
    let folder = claim(calibration, options)?;
    let started_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let start = calibration.start();
    let before = calibration.follow(&start, registry);
    let found = search(calibration, registry, stop);
    let after = calibration.follow(&found.values, registry);
    let summary = CalibrationSummary {
        folder,
        outcome: outcome(&found, &after),
        parameters: fitted(calibration, &start, &found.values),
        curves: after.iter().map(|one| one.report.clone()).collect(),
        misfit: [calibration.misfit(&before), found.misfit],
        evaluations: found.evaluations,
    };
    write(calibration, registry, &summary, [&before, &after], started_unix_s)?;
    Ok(summary)
}

fn outcome(found: &Found, after: &[Followed]) -> Outcome {
    if found.interrupted {
        return Outcome::Interrupted;
    }
    let problem = after.iter().find_map(|one| Some(format!("{}: {}", one.report.name, one.report.problem.as_ref()?)));
    problem.map_or(Outcome::Finished, Outcome::Failed)
}

fn fitted(calibration: &Calibration, start: &[f64], values: &[f64]) -> Vec<FittedParameter> {
    let parameters = calibration.file.parameters.iter().zip(&calibration.ranges);
    let fitted = parameters.zip(start.iter().zip(values)).map(|((parameter, range), (start, value))| FittedParameter {
        name: parameter.name.clone(),
        start: *start,
        value: *value,
        bounds: parameter.bounds,
        at_bound: range.is_at_bound(*value),
    });
    fitted.collect()
}

impl CalibrationSummary {
    /// The parameters and the misfits for a terminal, ending with a newline.
    pub fn table(&self) -> String {
        let mut text = format!("{:<24}{:>14}{:>14}  range\n", "parameter", "start", "fitted");
        for parameter in &self.parameters {
            let FittedParameter { name, start, value, bounds: [low, high], at_bound } = parameter;
            let note = if *at_bound { ", at a bound" } else { "" };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:<24}{start:>14.6e}{value:>14.6e}  {low:e} to {high:e}{note}");
        }
        let _ = writeln!(text, "\n{:<24}{:>14}{:>14}  points", "measurement", "rms error", "of largest");
        for curve in &self.curves {
            let CurveReport { name, points, missing, rms, relative_rms, .. } = curve;
            let note = if *missing > 0 { format!(", {missing} of them not reached") } else { String::new() };
            let _ = writeln!(text, "{name:<24}{rms:>14.4e}{:>12.3} %  {points}{note}", 100.0 * relative_rms);
        }
        text
    }
}

/// Writes everything into the folder.
fn write(
    calibration: &Calibration,
    registry: &Registry,
    summary: &CalibrationSummary,
    [before, after]: [&[Followed]; 2],
    started_unix_s: u64,
) -> Result<(), CalibrationError> {
    let mut files = Vec::new();
    let mut put = |name: String, content: Vec<u8>| {
        let path = summary.folder.join(&name);
        files.push(name);
        fs::write(&path, content).map_err(write_error(&path))
    };
    put(COPY.to_owned(), calibration.source.text().as_bytes().to_vec())?;
    put(PARAMETERS.to_owned(), parameter_file(calibration, registry, summary)?.into_bytes())?;
    let figures = summary.folder.join(FIGURES);
    fs::create_dir_all(&figures).map_err(write_error(&figures))?;
    for (curve, (before, after)) in calibration.curves.iter().zip(before.iter().zip(after)) {
        let name = format!("{FIGURES}/{}", curve.measurement.name);
        put(format!("{name}.csv"), numbers(curve, before, after).map_err(|error| failed(&summary.folder, error))?)?;
        chart(curve, before, after).save(&summary.folder.join(&name)).map_err(ResultsError::from)?;
    }
    let drawn = calibration.curves.iter().map(|curve| &curve.measurement.name);
    files.extend(drawn.flat_map(|name| ["svg", "png"].map(|ending| format!("{FIGURES}/{name}.{ending}"))));
    let path = summary.folder.join(MANIFEST);
    let file = calibration.source.path();
    let manifest = Manifest {
        program: "tsutsumi",
        version: env!("CARGO_PKG_VERSION"),
        title: calibration.title(),
        calibration: fs::canonicalize(file).unwrap_or_else(|_| file.to_owned()),
        host: Host::this(),
        started_unix_s,
        outcome: &summary.outcome,
        parameters: &summary.parameters,
        curves: &summary.curves,
        misfit: summary.misfit,
        evaluations: summary.evaluations,
        files,
    };
    Ok(replace_with_json(&path, &manifest).map_err(write_error(&path))?)
}

fn failed(folder: &Path, error: csv::Error) -> ResultsError {
    write_error(folder)(io::Error::from(error))
}

/// The law with all of its parameters, as a table that element tests take as it is.
fn parameter_file(
    calibration: &Calibration,
    registry: &Registry,
    summary: &CalibrationSummary,
) -> Result<String, CaseError> {
    let values: Vec<f64> = summary.parameters.iter().map(|parameter| parameter.value).collect();
    // There is one measurement at least, as has been checked.
    let Some(curve) = calibration.curves.first() else { return Ok(String::new()) };
    let material = calibration.test(curve, &values, registry)?.file.material;
    let names: Vec<&str> = summary.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let mut text =
        format!("# Fitted: {}. {}\n\n[material]\nlaw = \"{}\"\n", names.join(", "), calibration.title(), material.law);
    text += "\n[material.parameters]\n";
    text += &material.parameters.to_string();
    Ok(text)
}

/// The measured points with the element test beside them, before and after.
fn numbers(curve: &MeasuredCurve, before: &Followed, after: &Followed) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let [x, y] = [&curve.measurement.x.quantity, &curve.measurement.y.quantity];
    writer.write_record([x, &format!("{y}: measured"), &format!("{y}: fitted"), &format!("{y}: start")])?;
    for [x, y] in &curve.points {
        let [after, before] = [after, before].map(|one| interpolated(&one.curve, *x));
        let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.16e}"));
        writer.write_record([cell(Some(*x)), cell(Some(*y)), cell(after), cell(before)])?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

fn chart(curve: &MeasuredCurve, before: &Followed, after: &Followed) -> LineChart {
    let [x, y] = [&curve.measurement.x, &curve.measurement.y].map(|column| shown(&column.quantity));
    let drawn = |label: &str, points: &[[f64; 2]], style: CurveStyle, place: usize| {
        let (x, y) = points.iter().map(|[a, b]| (a * x.factor, b * y.factor)).unzip();
        Curve { label: label.to_owned(), x, y, style, place: Some(place) }
    };
    LineChart {
        x_label: x.title.clone(),
        y_label: y.title.clone(),
        curves: vec![
            drawn("measured", &curve.points, CurveStyle::Markers, 0),
            drawn("fitted", &after.curve, CurveStyle::Line, 1),
            drawn("start", &before.curve, CurveStyle::Dotted, 2),
        ],
        ..Default::default()
    }
}

/// Makes a folder for the results: the one asked for, or a new one under `results/`. With `force`, the files of an earlier calibration in
/// it are removed; whatever else it holds stays.
fn claim(calibration: &Calibration, options: &CalibrationOptions) -> Result<PathBuf, CalibrationError> {
    let Some(folder) = options.out.clone() else { return Ok(claim_numbered(&calibration.source)?) };
    let is_ours = claim_listed(&folder, MANIFEST, options.force, |text| {
        serde_json::from_str(text).ok().map(|held: Held| held.files)
    })?;
    match is_ours {
        true => Ok(folder),
        false => Err(CalibrationError::NotACalibration { path: folder }),
    }
}
