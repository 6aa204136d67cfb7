//! The figures of a study, each with its numbers in a file beside it.

use std::fs;
use std::path::Path;

use super::compare::{Convergence, convergences, slope};
use super::numbers::{columns_csv, curves_csv};
use super::plan::{PlannedRun, Study};
use super::quantity::{Measure, Quantity};
use super::reference::ReferenceKind;
use super::schema::{ErrorMeasure, Figure, FigureKind};
use super::series::{History, Series};
use super::summary::{FigureReport, StudyError, StudySummary, write};
use super::table::{into_bytes, precise};
use crate::build::build_grid;
use crate::figures::{AxisScale, Curve, CurveStyle, LineChart, ParticleChart, SecondAxis};
use crate::folder::{FIGURES, PARTICLES};
use crate::pictures::{Snapshot, particle_chart};
use crate::run::significant;
use crate::vtk_reader::{read_arrays, read_collection};
use crate::{Case, ResultsError};

/// Times at which an exact solution is drawn where no variant gives them.
const SOLUTION_POINTS: usize = 201;

/// A figure that could not be drawn, in words, or whose files could not be written.
enum Trouble {
    Problem(String),
    Write(StudyError),
}

impl<E: Into<StudyError>> From<E> for Trouble {
    fn from(error: E) -> Self {
        Trouble::Write(error.into())
    }
}

/// Draws all figures of a study from what its runs have left.
pub(super) fn draw(
    study: &Study,
    summary: &StudySummary,
    histories: &[Option<History>],
) -> Result<Vec<FigureReport>, StudyError> {
    let artist = Artist { study, summary, histories };
    let folder = summary.folder.join(FIGURES);
    let mut reports = Vec::new();
    for figure in &study.file.figures {
        let path = folder.join(&figure.name);
        let drawn = match figure.kind {
            FigureKind::Lines => artist.lines(figure, &path),
            FigureKind::Particles => artist.particles(figure, &path),
            FigureKind::Convergence => artist.convergence(figure, &path),
        };
        let (problem, note) = match drawn {
            Ok(note) => (None, note),
            Err(Trouble::Problem(problem)) => {
                remove_stale(&folder, &figure.name);
                (Some(problem), None)
            }
            Err(Trouble::Write(error)) => return Err(error),
        };
        reports.push(FigureReport { name: figure.name.clone(), problem, note });
    }
    Ok(reports)
}

/// Takes away what an earlier study drew under a name, so that nobody takes it for the new figure.
fn remove_stale(folder: &Path, name: &str) {
    for ending in ["svg", "png", "csv"] {
        // There may be none.
        let _ = fs::remove_file(folder.join(format!("{name}.{ending}")));
    }
}

/// The path of a figure's numbers.
fn numbers_of(path: &Path) -> std::path::PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".csv");
    name.into()
}

/// A curve of a figure: in the units of the figure, with its name in the file of numbers.
struct DrawnCurve {
    curve: Curve,
    column: String,
}

struct Artist<'a> {
    study: &'a Study,
    summary: &'a StudySummary,
    histories: &'a [Option<History>],
}

impl Artist<'_> {
    /// Quantities against time.
    fn lines(&self, figure: &Figure, path: &Path) -> Result<Option<String>, Trouble> {
        let first = figure.quantities.as_deref().unwrap_or_default();
        let has_right = !figure.right.is_empty();
        let main = self.curves(figure, first, has_right);
        let below = self.curves(figure, &figure.below, has_right);
        let right = self.curves(figure, &figure.right, has_right);
        let all: Vec<&DrawnCurve> = main.iter().chain(&right).chain(&below).collect();
        if all.is_empty() {
            return Err(Trouble::Problem("there is nothing to draw: no run of it has finished".to_owned()));
        }
        let numbers: Vec<(String, Series)> = all
            .iter()
            .map(|one| (one.column.clone(), Series { time: one.curve.x.clone(), value: one.curve.y.clone() }))
            .collect();
        let second = |quantities: &[String], curves: Vec<DrawnCurve>| {
            (!quantities.is_empty()).then(|| SecondAxis {
                label: self.axis_title(quantities, figure.second_label.as_deref()),
                down: grows_down(quantities),
                curves: curves.into_iter().map(|one| one.curve).collect(),
                ..Default::default()
            })
        };
        let chart = LineChart {
            title: figure.title.clone(),
            x_label: figure.x_label.clone().unwrap_or_else(|| "time (s)".to_owned()),
            y_label: self.axis_title(first, figure.y_label.as_deref()),
            y_down: grows_down(first),
            curves: main.into_iter().map(|one| one.curve).collect(),
            right: second(&figure.right, right),
            below: second(&figure.below, below),
            ..Default::default()
        };
        write(&numbers_of(path), curves_csv(&numbers))?;
        chart.save(path).map_err(ResultsError::from)?;
        Ok(self.missing(figure))
    }

    /// The curves of some quantities: variants first, then references.
    fn curves(&self, figure: &Figure, quantities: &[String], tell_quantity: bool) -> Vec<DrawnCurve> {
        let mut curves = Vec::new();
        let num_variants = self.study.variants().count();
        // One quantity: a variant looks the same in all figures. Several: every curve needs a look of its own.
        let is_plain = quantities.len() <= 1 && !tell_quantity;
        let look = |number: usize| is_plain.then_some(number);
        for name in quantities {
            let quantity = Quantity::read(name);
            let place = (!is_plain).then(|| self.place(name, &quantity));
            for (number, run) in self.variants_of(figure) {
                let series = self.histories[number].as_ref().and_then(|history| history.quantity(&quantity));
                let of = Whose { name: &run.name, label: &run.label, style: CurveStyle::Automatic, look: look(number) };
                curves.extend(series.map(|series| drawn(figure, series, &quantity, &of, place.as_deref())));
            }
            for (number, reference) in self.study.references.iter().enumerate() {
                if figure.references.as_ref().is_some_and(|names| !names.contains(&reference.name)) {
                    continue;
                }
                let style = match &reference.kind {
                    ReferenceKind::Table(_) => CurveStyle::Markers,
                    ReferenceKind::Solution(_) => CurveStyle::Thin,
                    ReferenceKind::Run(..) => CurveStyle::SparseMarkers,
                };
                let series = reference.draw(&quantity, &self.times(figure), self.histories);
                let look = look(num_variants + number);
                let of = Whose { name: &reference.name, label: &reference.label, style, look };
                curves.extend(series.map(|series| drawn(figure, series, &quantity, &of, place.as_deref())));
            }
        }
        curves
    }

    /// The variants of a figure with their numbers, in the order that it names them.
    fn variants_of(&self, figure: &Figure) -> Vec<(usize, &PlannedRun)> {
        match &figure.variants {
            None => self.study.variants().collect(),
            Some(names) => {
                let find = |name: &String| self.study.variants().find(|(_, run)| run.name == *name);
                names.iter().filter_map(find).collect()
            }
        }
    }

    /// The times at which exact solutions are drawn (s).
    fn times(&self, figure: &Figure) -> Vec<f64> {
        let of_variant = self.variants_of(figure).into_iter().find_map(|(number, _)| self.histories[number].as_ref());
        if let Some(history) = of_variant.or_else(|| self.histories.iter().flatten().next()) {
            return history.times().to_vec();
        }
        let end = self.study.runs.first().map_or(1.0, |run| run.case.time.end);
        (0..SOLUTION_POINTS).map(|i| end * i as f64 / (SOLUTION_POINTS - 1) as f64).collect()
    }

    /// What the legend calls a quantity.
    fn place(&self, name: &str, quantity: &Quantity) -> String {
        self.study.file.labels.get(name).cloned().unwrap_or_else(|| quantity.place())
    }

    /// The title of a vertical axis.
    fn axis_title(&self, quantities: &[String], given: Option<&str>) -> String {
        if let Some(title) = given {
            return title.to_owned();
        }
        let own = match quantities {
            [only] => self.study.file.labels.get(only).map(String::as_str),
            _ => None,
        };
        quantities.first().map_or_else(String::new, |name| Quantity::read(name).measure().title(own))
    }

    /// The runs that a figure has to do without.
    fn missing(&self, figure: &Figure) -> Option<String> {
        let variants = self.variants_of(figure).into_iter().map(|(number, _)| number);
        let is_wanted = |name: &String| figure.references.as_ref().is_none_or(|names| names.contains(name));
        let references = self.study.references.iter().filter(|reference| is_wanted(&reference.name));
        let references = references.filter_map(|reference| match reference.kind {
            ReferenceKind::Run(number, _) => Some(number),
            _ => None,
        });
        let missing = variants.chain(references).filter(|number| self.histories[*number].is_none());
        let names: Vec<String> = missing.map(|number| format!("`{}`", self.study.runs[number].name)).collect();
        (!names.is_empty()).then(|| format!("drawn without {}, which did not finish", names.join(", ")))
    }

    /// The deformed particles of a variant.
    fn particles(&self, figure: &Figure, path: &Path) -> Result<Option<String>, Trouble> {
        let name = figure.variant.as_deref().unwrap_or_default();
        let (wanted, magnification) = (figure.time.unwrap_or(0.0), figure.magnification.unwrap_or(1.0));
        let found = self.study.variants().find(|(_, run)| run.name == name);
        let Some((number, run)) = found.filter(|(number, _)| self.histories[*number].is_some()) else {
            return Err(Trouble::Problem(format!("`{name}` did not finish")));
        };
        let folder = &self.summary.runs[number].folder;
        let snapshot = read_snapshot(folder, &run.case, wanted, magnification).map_err(Trouble::Problem)?;
        let head = ["across (m)", "up (m)", "half width (m)", "half height (m)", "pore pressure (kPa)"];
        let particles = snapshot.position.iter().zip(&snapshot.half_size).zip(&snapshot.pressure);
        let rows = particles.map(|((at, half), pressure)| [at[0], at[1], half[0], half[1], *pressure]);
        write(&numbers_of(path), columns_csv(head, rows))?;
        let chart = match run.case.dimension {
            1 => chart_in::<1>(run, &snapshot)?,
            2 => chart_in::<2>(run, &snapshot)?,
            _ => chart_in::<3>(run, &snapshot)?,
        };
        let told = (magnification != 1.0).then(|| format!("displacements × {magnification}"));
        let title = figure.title.clone().or_else(|| chart.title.clone()).into_iter().chain(told);
        let chart = ParticleChart {
            title: Some(title.collect::<Vec<_>>().join(", ")),
            x_label: figure.x_label.clone().unwrap_or_else(|| chart.x_label.clone()),
            y_label: figure.y_label.clone().unwrap_or_else(|| chart.y_label.clone()),
            ..chart
        };
        chart.save(path).map_err(ResultsError::from)?;
        let is_elsewhere = (snapshot.time - wanted).abs() > 1e-6 * wanted.abs();
        Ok(is_elsewhere.then(|| {
            let nearest = significant(snapshot.time);
            format!("shows {nearest} s, the nearest to {wanted} s at which fields were written (`output.fields_every`)")
        }))
    }

    /// Errors against size.
    fn convergence(&self, figure: &Figure, path: &Path) -> Result<Option<String>, Trouble> {
        let measure = figure.error.unwrap_or_default();
        let mut curves = Vec::new();
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut write_row = |row: [String; 7]| writer.write_record(row);
        let head = ["refinement", "reference", "quantity", "variant", "size", "error", "error over largest"];
        let mut written = write_row(head.map(str::to_owned));
        let refinements = self.study.file.refinements.iter();
        let wanted = |name: &String| figure.refinements.as_ref().is_none_or(|names| names.contains(name));
        let refinements: Vec<_> = refinements.filter(|refinement| wanted(&refinement.name)).collect();
        for refinement in &refinements {
            for one in convergences(&refinement.variants, &refinement.sizes, &self.summary.rows) {
                if !is_wanted(figure, &one) {
                    continue;
                }
                let label = refinement.label.as_ref().unwrap_or(&refinement.name);
                let label = (refinements.len() > 1).then_some(label.as_str());
                for (variant, size, errors) in &one.errors {
                    let error = errors.measure(measure);
                    let words = [&refinement.name, one.reference, one.quantity, variant].map(str::to_owned);
                    let numbers = [*size, error, error / errors.largest_reference].map(precise);
                    let [a, b, c, d] = words;
                    let [e, f, g] = numbers;
                    written = written.and_then(|()| write_row([a, b, c, d, e, f, g]));
                }
                curves.push(self.convergence_curve(&one, measure, label));
            }
        }
        if curves.is_empty() {
            return Err(Trouble::Problem("there is no error to draw: no run of it has finished".to_owned()));
        }
        write(&numbers_of(path), written.and_then(|()| into_bytes(writer)))?;
        let word = if measure == ErrorMeasure::Max { "largest error" } else { "rms error" };
        let size_label = refinements.first().map_or("", |refinement| refinement.size_label.as_str());
        let chart = LineChart {
            title: figure.title.clone(),
            x_label: figure.x_label.clone().unwrap_or_else(|| size_label.to_owned()),
            y_label: figure.y_label.clone().unwrap_or_else(|| format!("{word} over largest value (–)")),
            x_scale: AxisScale::Logarithmic,
            y_scale: AxisScale::Logarithmic,
            curves,
            ..Default::default()
        };
        chart.save(path).map_err(ResultsError::from)?;
        Ok(None)
    }

    fn convergence_curve(&self, one: &Convergence, measure: ErrorMeasure, refinement: Option<&str>) -> Curve {
        let quantity = Quantity::read(one.quantity);
        let reference = self.study.references.iter().find(|reference| reference.name == one.reference);
        let reference = reference.filter(|_| self.study.references.len() > 1).map(|reference| reference.label.as_str());
        let points = one.errors.iter().map(|(_, size, errors)| {
            let error = errors.measure(measure) / errors.largest_reference;
            (*size, error)
        });
        let (x, y): (Vec<f64>, Vec<f64>) = points.unzip();
        let place = self.place(one.quantity, &quantity);
        let words: Vec<&str> = refinement.into_iter().chain([place.as_str()]).chain(reference).collect();
        let label = format!("{}: order {:.2}", words.join(", "), slope(&x, &y));
        Curve { label, x, y, style: CurveStyle::LineMarkers, place: None }
    }
}

/// Whether a figure shows the errors of this reference and quantity.
fn is_wanted(figure: &Figure, one: &Convergence) -> bool {
    let among = |names: &Option<Vec<String>>, name: &str| {
        names.as_ref().is_none_or(|names| names.iter().any(|known| known == name))
    };
    among(&figure.references, one.reference) && among(&figure.quantities, one.quantity)
}

fn grows_down(quantities: &[String]) -> bool {
    !quantities.is_empty() && quantities.iter().all(|name| Quantity::read(name).measure().grows_down)
}

/// The variant or reference that a curve belongs to.
struct Whose<'a> {
    name: &'a str,
    label: &'a str,
    style: CurveStyle,
    look: Option<usize>,
}

/// A series as a curve in the units of figures.
fn drawn(figure: &Figure, series: Series, quantity: &Quantity, of: &Whose, place: Option<&str>) -> DrawnCurve {
    let Measure { factor, shown_unit, .. } = quantity.measure();
    let series = series.within(figure.window);
    let label = place.map_or_else(|| of.label.to_owned(), |place| format!("{}, {place}", of.label));
    let unit = if shown_unit.is_empty() { String::new() } else { format!(" ({shown_unit})") };
    let column = format!("{}: {quantity}{unit}", of.name);
    let y = series.value.iter().map(|value| value * factor).collect();
    DrawnCurve { curve: Curve { label, x: series.time, y, style: of.style, place: of.look }, column }
}

/// The particles of a run as a chart.
fn chart_in<const D: usize>(run: &PlannedRun, snapshot: &Snapshot) -> Result<ParticleChart, Trouble> {
    let grid = build_grid::<D>(&run.source, &run.case).map_err(|error| Trouble::Problem(error.to_string()))?;
    Ok(particle_chart(&run.case, &grid, snapshot))
}

/// The particles of a results folder at the time nearest to the one wanted (s), displacements magnified.
fn read_snapshot(folder: &Path, case: &Case, wanted: f64, magnification: f64) -> Result<Snapshot, String> {
    let entries = read_collection(&folder.join(PARTICLES))?;
    let far = |time: f64| (time - wanted).abs();
    let nearest = entries.iter().min_by(|one, other| far(one.0).total_cmp(&far(other.0)));
    let (time, file) = nearest.ok_or_else(|| "the run has written no particles".to_owned())?;
    let names = ["Points", "displacement", "half_size", "pressure"];
    let [position, displacement, half_size, pressure] = read_arrays(&folder.join(file), names)?;
    let (position, displacement, half_size) =
        (position.as_chunks::<3>().0, displacement.as_chunks::<3>().0, half_size.as_chunks::<3>().0);
    let [at_first] = read_arrays(&folder.join(&entries[0].1), ["half_size"])?;
    let half_at_first = Some(at_first.as_chunks::<3>().0).filter(|first| first.len() == half_size.len());
    let mut snapshot = Snapshot { time: *time, ..Default::default() };
    let up = case.dimension - 1;
    let particles = position.iter().zip(displacement).zip(half_size).zip(half_at_first.unwrap_or(half_size));
    for ((((at, moved), half), first), pressure) in particles.zip(pressure) {
        // A 3-D body is cut along its first layer of cells across y, a 1-D column drawn one cell height wide.
        if up == 2 && at[1] > case.grid.origin[1] + case.grid.spacing[1] {
            continue;
        }
        let shown = |axis: usize| at[axis] + (magnification - 1.0) * moved[axis];
        let size = |axis: usize| first[axis] + magnification * (half[axis] - first[axis]);
        let width = 0.5 * case.grid.spacing[0];
        snapshot.position.push([if up == 0 { width } else { shown(0) }, shown(up)]);
        snapshot.half_size.push([if up == 0 { width } else { size(0) }, size(up)]);
        snapshot.pressure.push(pressure * 1e-3);
        snapshot.largest = snapshot.largest.max(pressure);
    }
    Ok(snapshot)
}
