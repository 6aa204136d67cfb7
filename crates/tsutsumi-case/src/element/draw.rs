//! The figures of an element test.

use std::path::Path;

use super::quantity::shown;
use super::record::Record;
use super::resistance::ResistancePoint;
use super::schema::{DrainageKind, ElementTestFile, LiquefactionCriterion, Resistance, Stage, StageKind};
use crate::figures::{AxisScale, Curve, CurveStyle, LineChart, SecondAxis};
use crate::{FigureError, ResultsError};

/// One picture: a quantity against another, perhaps a second one below over the same axis.
#[derive(Debug, Clone, PartialEq)]
struct Picture {
    name: String,
    x: String,
    y: String,
    below: Option<(&'static str, bool)>,
    x_scale: AxisScale,
    from_zero: bool,
    y_down: bool,
    /// The stages that are drawn, from 1.
    stages: Vec<usize>,
}

impl Picture {
    /// A path of stress: how far it is from the state without stress is to be seen.
    fn of_stress(name: &str, x: &str, y: &str, stages: Vec<usize>) -> Self {
        Picture { from_zero: true, ..Self::new(name, x, y, stages) }
    }

    fn new(name: &str, x: &str, y: &str, stages: Vec<usize>) -> Self {
        Picture {
            name: name.to_owned(),
            x: x.to_owned(),
            y: y.to_owned(),
            below: None,
            x_scale: AxisScale::Linear,
            from_zero: false,
            y_down: false,
            stages,
        }
    }
}

/// Draws what a test shows, into a folder; the names of the figures.
pub(super) fn draw(file: &ElementTestFile, record: &Record, folder: &Path) -> Result<Vec<String>, ResultsError> {
    let pictures = pictures(file, record);
    for picture in &pictures {
        chart(picture, record).save(&folder.join(&picture.name))?;
    }
    Ok(pictures.into_iter().map(|picture| picture.name).collect())
}

/// The pictures that the stages suggest, and those that the file asks for.
fn pictures(file: &ElementTestFile, record: &Record) -> Vec<Picture> {
    let stages = |is_wanted: &dyn Fn(&Stage) -> bool| {
        let numbered = file.stages.iter().enumerate();
        numbered.filter(|(_, stage)| is_wanted(stage)).map(|(index, _)| index + 1).collect::<Vec<usize>>()
    };
    let all = stages(&|_| true);
    let of = |kind: StageKind| stages(&|stage| stage.kind == kind);
    let (triaxial, shear) = (of(StageKind::Triaxial), of(StageKind::SimpleShear));
    let mut pictures = compression(file, record, &of);
    if !triaxial.is_empty() {
        pictures.push(Picture::of_stress("stress-path", "mean_stress", "stress_difference", all.clone()));
        let changes_volume = stages(&|stage| {
            stage.kind == StageKind::Triaxial
                && stage.amplitude.is_none()
                && stage.drainage != Some(DrainageKind::Undrained)
        });
        let below = (!changes_volume.is_empty()).then_some(("volumetric_strain", true));
        let picture = Picture::new("stress-strain", "axial_strain", "stress_difference", triaxial);
        pictures.push(Picture { below, ..picture });
    }
    if !shear.is_empty() {
        pictures.push(Picture::of_stress("shear-stress-path", "axial_stress", "shear_stress", all.clone()));
        pictures.push(Picture::new("shear-stress-strain", "shear_strain", "shear_stress", shear));
    }
    for (kind, strain, name) in
        [(StageKind::Triaxial, "axial_strain", "cycles"), (StageKind::SimpleShear, "shear_strain", "shear-cycles")]
    {
        let cyclic = stages(&|stage| stage.kind == kind && stage.amplitude.is_some());
        let is_undrained = |number: &usize| file.stages[number - 1].drainage == Some(DrainageKind::Undrained);
        match (cyclic.last().copied(), cyclic.last().is_some_and(is_undrained)) {
            (None, _) => {}
            (Some(last), false) => pictures.push(Picture::new(name, "cycle", strain, vec![last])),
            (Some(last), true) => {
                let picture = Picture::new(name, "cycle", "pore_pressure_ratio", vec![last]);
                pictures.push(Picture { below: Some((strain, false)), ..picture });
            }
        }
    }
    if !of(StageKind::Path).is_empty() {
        pictures.push(Picture::of_stress("path-stresses", "mean_stress", "deviatoric_stress", all.clone()));
        pictures.push(Picture::new("path-strains", "deviatoric_strain", "deviatoric_stress", all.clone()));
    }
    pictures.extend(file.figures.iter().map(|figure| Picture {
        x_scale: if figure.x_log { AxisScale::Logarithmic } else { AxisScale::Linear },
        y_down: figure.y_down,
        ..Picture::new(&figure.name, &figure.x, &figure.y, figure.stages.clone().unwrap_or_else(|| all.clone()))
    }));
    pictures
}

/// Compression curves over the logarithm of the stress: void ratio, or volumetric strain downwards.
fn compression(file: &ElementTestFile, record: &Record, of: &dyn Fn(StageKind) -> Vec<usize>) -> Vec<Picture> {
    let (y, y_down) =
        if file.initial.void_ratio.is_some() { ("void_ratio", false) } else { ("volumetric_strain", true) };
    let kinds =
        [(StageKind::Isotropic, "compression", "mean_stress"), (StageKind::Oedometer, "oedometer", "axial_stress")];
    let with_stages =
        kinds.into_iter().map(|(kind, name, x)| (of(kind), name, x)).filter(|(stages, ..)| !stages.is_empty());
    with_stages
        .map(|(stages, name, x)| {
            let picture = Picture { y_down, ..Picture::new(name, x, y, stages) };
            // A logarithm needs a stress of one sign, with some ratio to show.
            let (x, _) = points(&picture, x, record);
            let (least, most) =
                x.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), x| (least.min(*x), most.max(*x)));
            let x_scale = if least > 0.0 && most > 2.0 * least { AxisScale::Logarithmic } else { AxisScale::Linear };
            Picture { x_scale, ..picture }
        })
        .collect()
}

/// A column and the horizontal one over the stages of a picture, in shown units; a stage begins where the one before it has ended.
fn points(picture: &Picture, y: &str, record: &Record) -> (Vec<f64>, Vec<f64>) {
    let column = |name: &str| record.column(name).unwrap_or_default();
    let (x, y, stage) = ((column(&picture.x), shown(&picture.x)), (column(y), shown(y)), column("stage"));
    let rows = stage.iter().zip(x.0.iter().zip(&y.0)).filter(|(stage, _)| picture.stages.contains(&(**stage as usize)));
    rows.map(|(_, (a, b))| (a * x.1.factor, b * y.1.factor)).unzip()
}

fn curve(picture: &Picture, y: &str, record: &Record) -> Curve {
    let (x, y) = points(picture, y, record);
    Curve { x, y, style: CurveStyle::Line, place: Some(0), ..Default::default() }
}

fn chart(picture: &Picture, record: &Record) -> LineChart {
    LineChart {
        x_label: shown(&picture.x).title,
        y_label: shown(&picture.y).title,
        x_scale: picture.x_scale,
        from_zero: picture.from_zero,
        y_down: picture.y_down,
        curves: vec![curve(picture, &picture.y, record)],
        below: picture.below.map(|(y, down)| SecondAxis {
            label: shown(y).title,
            scale: AxisScale::Linear,
            down,
            curves: vec![curve(picture, y, record)],
        }),
        ..Default::default()
    }
}

/// The liquefaction resistance curves: stress ratio against cycles, one curve for each criterion.
pub(super) fn draw_resistance(
    file: &ElementTestFile,
    resistance: &Resistance,
    points: &[ResistancePoint],
    path: &Path,
) -> Result<(), FigureError> {
    let strain = match file.stages.last().map(|stage| stage.kind) {
        Some(StageKind::SimpleShear) => "γ",
        _ => "ε_a",
    };
    let per_curve = resistance.stress_ratios.len();
    let curves = resistance.criteria.iter().zip(points.chunks(per_curve.max(1))).map(|(criterion, points)| {
        let mut reached: Vec<_> = points.iter().filter(|point| point.reached).collect();
        reached.sort_by(|one, other| one.stress_ratio.total_cmp(&other.stress_ratio));
        let (x, y) = reached.into_iter().map(|point| (point.cycles, point.stress_ratio)).unzip();
        Curve { label: label(criterion, strain), x, y, style: CurveStyle::LineMarkers, place: None }
    });
    let chart = LineChart {
        x_label: "cycles to liquefaction".to_owned(),
        y_label: "cyclic stress ratio (–)".to_owned(),
        x_scale: AxisScale::Logarithmic,
        curves: curves.collect(),
        ..Default::default()
    };
    chart.save(path)
}

/// A criterion in a legend.
fn label(criterion: &LiquefactionCriterion, strain: &str) -> String {
    let percent = |value: f64| format!("{} %", (value * 1e4).round() / 100.0);
    match *criterion {
        LiquefactionCriterion { pore_pressure_ratio: Some(ratio), .. } => format!("pore pressure ratio {ratio}"),
        LiquefactionCriterion { double_strain: Some(value), .. } => {
            format!("double amplitude of {strain} {}", percent(value))
        }
        LiquefactionCriterion { single_strain: Some(value), .. } => {
            format!("single amplitude of {strain} {}", percent(value))
        }
        LiquefactionCriterion { .. } => String::new(),
    }
}
