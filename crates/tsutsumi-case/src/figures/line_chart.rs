//! Curves over one horizontal axis.

use super::axis::{Axis, AxisScale, padded, range_of, widened};
use super::drawing::{Color, Drawing, Segment, Shape, Stroke, circle, polygon, polyline, rectangle};
use super::frame::{Frame, TickSide, labels_fit, lines_fit};
use super::legend::{Entry, Legend};
use super::style::{self, CHART_HEIGHT, COLUMN_WIDTH, CURVE_COLORS, CURVE_WIDTH, MARKER_RADIUS, RIM, TICK_SIZE};
use super::text::{Align, Direction, Typeface};
use super::{Figure, FigureError, check_length, draw_title, title_height};
use std::path::Path;

/// How a curve is drawn. Its colour, and the form of its markers, follow from its place in the list of curves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveStyle {
    /// A line whose dashes follow from its place in the list too, so that curves differ without colour.
    #[default]
    Automatic,
    /// A solid line.
    Line,
    /// A line of dashes. It is drawn over solid lines, so a solid curve that it follows closely is still seen.
    Dashed,
    /// A line of dots.
    Dotted,
    /// A line of dashes and dots in turn.
    DashDotted,
    /// A hollow marker at every point (points less than half a marker apart share one): measurements, published results.
    Markers,
    /// A solid line with hollow markers at some of its points.
    LineMarkers,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Name in the legend; a curve with an empty name is left out of the legend.
    pub label: String,
    /// Points on the horizontal axis, in the unit named in its label; one for each point of the curve.
    pub x: Vec<f64>,
    /// Points on the vertical axis, in the unit named in its label; as many as `x`.
    pub y: Vec<f64>,
    /// How the curve is drawn.
    pub style: CurveStyle,
}

/// A chart of curves over one horizontal axis, for example settlement or pore pressure over time.
///
/// An axis whose numbers are very large or small gets a power of ten in its title: `time (s)` becomes `time (×10³ s)`.
/// The legend stands where no curve passes, or above the frame if there is no such place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineChart {
    /// Line above the chart; journals put it in the caption instead.
    pub title: Option<String>,
    /// Title of the horizontal axis with its unit in round brackets, for example `time (s)`.
    pub x_label: String,
    /// Title of the vertical axis with its unit in round brackets, for example `settlement (mm)`.
    pub y_label: String,
    /// Scale of the horizontal axis.
    pub x_scale: AxisScale,
    /// Scale of the vertical axis.
    pub y_scale: AxisScale,
    /// Whether the vertical axis grows downwards, as settlement and depth are drawn.
    pub y_down: bool,
    /// Curves, in the order of the legend.
    pub curves: Vec<Curve>,
}

impl LineChart {
    /// Writes the chart to two files, with `.svg` and `.png` put behind the path. Existing files are replaced.
    ///
    /// # Errors
    ///
    /// [`FigureError::Length`] if `x` and `y` of a curve differ in length, [`FigureError::Write`] if a file could not be
    /// written, [`FigureError::Draw`] if the picture could not be encoded. Curves without any finite point are no error:
    /// the chart then says "no data".
    pub fn save(&self, path_without_extension: &Path) -> Result<(), FigureError> {
        super::save(self, path_without_extension)
    }

    /// Both axes, in loose fit around the data.
    fn axes(&self, typeface: &Typeface) -> [Axis; 2] {
        let range = |values: fn(&Curve) -> &Vec<f64>, scale| {
            let drawable = self.curves.iter().flat_map(|curve| {
                let points = curve.x.iter().zip(&curve.y).zip(values(curve));
                points.filter(|((x, y), _)| self.can_draw([**x, **y])).map(|(_, value)| *value)
            });
            range_of(drawable, scale)
        };
        let x_range = fitted(range(|curve| &curve.x, self.x_scale), self.x_scale, widened);
        let y_range = fitted(range(|curve| &curve.y, self.y_scale), self.y_scale, |range| padded(widened(range)));
        let y_axis = |intervals| Axis::loose(y_range, self.y_scale, intervals);
        let y = Axis::finest(6, y_axis, |axis| lines_fit(axis, CHART_HEIGHT));
        let width = COLUMN_WIDTH - 2.0 * RIM - Frame::room_left(typeface, &y, TickSide::Inside);
        let x_axis = |intervals| Axis::loose(x_range, self.x_scale, intervals);
        let x = Axis::finest(8, x_axis, |axis| labels_fit(typeface, axis, width));
        [x, y]
    }

    /// Whether both axes can show a point.
    fn can_draw(&self, [x, y]: [f64; 2]) -> bool {
        self.x_scale.can_draw(x) && self.y_scale.can_draw(y)
    }

    /// The frame below a header of the given height (pt).
    fn frame(&self, typeface: &Typeface, header: f64) -> Frame {
        let [x, y] = self.axes(typeface);
        let left = RIM + Frame::room_left(typeface, &y, TickSide::Inside);
        // Half of the last number stands out to the right.
        let last = x.ticks.last().map_or(0.0, |tick| typeface.width(&tick.label, TICK_SIZE));
        let right = RIM + (0.5 * last).max(2.0);
        // Numbers as wide as half the page leave a small frame rather than none.
        let width = (COLUMN_WIDTH - left - right).max(0.4 * COLUMN_WIDTH);
        // Half of the uppermost number stands out above.
        let corner = [left, RIM + header.max(0.5 * TICK_SIZE)];
        Frame { corner, size: [width, CHART_HEIGHT], x, y, y_down: self.y_down, ticks: TickSide::Inside }
    }

    /// The curves on the page.
    fn traces(&self, frame: &Frame) -> Vec<Trace> {
        self.curves
            .iter()
            .enumerate()
            .map(|(index, curve)| {
                let points = curve.x.iter().zip(&curve.y).map(|(x, y)| [*x, *y]);
                let places = points.map(|point| self.can_draw(point).then(|| frame.place(point)));
                Trace { runs: runs(places), look: Look::of(curve.style, index) }
            })
            .collect()
    }

    /// The curves' entries in the legend.
    fn entries(&self) -> Vec<Entry> {
        let named = self.curves.iter().enumerate().filter(|(_, curve)| !curve.label.trim().is_empty());
        named.map(|(index, curve)| Entry { label: curve.label.clone(), look: Look::of(curve.style, index) }).collect()
    }
}

impl Figure for LineChart {
    fn check(&self, path: &Path) -> Result<(), FigureError> {
        self.curves.iter().try_for_each(|curve| {
            check_length(path, &format!("y of curve \"{}\"", curve.label), curve.x.len(), curve.y.len())
        })
    }

    fn layout(&self, typeface: &Typeface) -> Drawing {
        let title_width = COLUMN_WIDTH - 2.0 * RIM;
        let title = typeface.wrapped(self.title.as_deref().unwrap_or_default(), style::TITLE_SIZE, title_width);
        let header = title_height(&title);
        let mut frame = self.frame(typeface, header);
        let mut traces = self.traces(&frame);
        let mut legend = Legend::new(typeface, self.entries(), &frame, &traces);
        if legend.height_above > 0.0 {
            frame = self.frame(typeface, header + legend.height_above);
            traces = self.traces(&frame);
            legend.move_above(&frame);
        }
        let [right, bottom] = frame.far_corner();
        let width = COLUMN_WIDTH.max(right + RIM);
        let mut page = Drawing::new(width, bottom + Frame::room_below(TickSide::Inside) + RIM);
        draw_title(&mut page, typeface, &title, [0.5 * width, RIM]);
        frame.draw_guides(&mut page);
        frame.draw(&mut page, typeface);
        let middle = frame.corner[0] + 0.5 * frame.size[0];
        let room = [2.0 * (width - RIM - middle), CHART_HEIGHT + header];
        let titles = [frame.x.title(&self.x_label), frame.y.title(&self.y_label)];
        frame.draw_titles(&mut page, typeface, [&titles[0], &titles[1]], room);
        draw_traces(&mut page, &traces);
        legend.draw(&mut page, typeface);
        if traces.iter().all(|trace| trace.runs.is_empty()) {
            let anchor = [middle, 0.5 * (frame.corner[1] + bottom)];
            typeface.draw(&mut page, "no data", TICK_SIZE, anchor, (Align::Middle, Direction::Across));
        }
        page
    }
}

/// What the style of a curve and its place in the list come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    color: Color,
    /// Dashes, if there is a line; empty for a solid one.
    dash: Option<&'static [f64]>,
    /// Form of the markers, if there are any.
    marker: Option<usize>,
}

impl Look {
    /// The look of the curve at a place in the list.
    fn of(style: CurveStyle, index: usize) -> Self {
        let color = CURVE_COLORS[index % CURVE_COLORS.len()];
        let dashes: [&[f64]; 4] = [&[], style::DASHED, style::DASH_DOTTED, style::DOTTED];
        let (dash, marker) = match style {
            // Shifted by one in each round of the colours, so that no look comes twice soon.
            CurveStyle::Automatic => {
                (Some(dashes[(index % CURVE_COLORS.len() + index / CURVE_COLORS.len()) % dashes.len()]), None)
            }
            CurveStyle::Line => (Some(dashes[0]), None),
            CurveStyle::Dashed => (Some(style::DASHED), None),
            CurveStyle::Dotted => (Some(style::DOTTED), None),
            CurveStyle::DashDotted => (Some(style::DASH_DOTTED), None),
            CurveStyle::Markers => (None, Some(index)),
            CurveStyle::LineMarkers => (Some(dashes[0]), Some(index)),
        };
        Self { color, dash, marker }
    }

    /// Solid lines lie lowest, then broken ones, then markers alone: what leaves gaps does not hide what it covers.
    fn layer(&self) -> usize {
        match self.dash {
            Some([]) => 0,
            Some(_) => 1,
            None => 2,
        }
    }

    /// Draws the look along a path of points on the page (pt), with markers at `marked`.
    pub(super) fn draw(&self, page: &mut Drawing, points: &[[f64; 2]], marked: &[[f64; 2]]) {
        if let Some(dash) = self.dash {
            match points {
                // A line needs two points; one alone is shown as a dot.
                [point] => page.fill("curve", circle(*point, CURVE_WIDTH), self.color),
                _ => page.stroke("curve", polyline(points), Stroke { color: self.color, width: CURVE_WIDTH, dash }),
            }
        }
        if let Some(form) = self.marker {
            let path = marked.iter().flat_map(|point| marker(form, *point)).collect();
            let stroke = Some(Stroke::solid(self.color, 0.8));
            page.add(Shape { path, fill: Some(style::PAPER), stroke, class: "markers", words: None });
        }
    }

    /// The points that carry markers (pt): all that stand clear of each other, or some along a line.
    fn marked(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let spacing = if self.dash.is_some() { 9.0 * MARKER_RADIUS } else { MARKER_RADIUS };
        let mut marked: Vec<[f64; 2]> = Vec::new();
        for point in points {
            if marked.last().is_none_or(|last| distance(*last, *point) >= spacing) {
                marked.push(*point);
            }
        }
        marked
    }
}

/// A curve on the page.
#[derive(Clone, Debug)]
pub(super) struct Trace {
    /// Its unbroken parts (pt).
    pub(super) runs: Vec<Vec<[f64; 2]>>,
    look: Look,
}

/// Draws all curves, layer by layer.
fn draw_traces(page: &mut Drawing, traces: &[Trace]) {
    for layer in 0..3 {
        for trace in traces.iter().filter(|trace| trace.look.layer() == layer) {
            for run in &trace.runs {
                trace.look.draw(page, &thinned(run), &trace.look.marked(run));
            }
        }
    }
}

/// The range of an axis: that of its data, with a margin if it is linear, or any if there are no data.
fn fitted(range: Option<[f64; 2]>, scale: AxisScale, margin: fn([f64; 2]) -> [f64; 2]) -> [f64; 2] {
    match (range, scale) {
        (Some(range), AxisScale::Linear) => margin(range),
        (Some(range), AxisScale::Logarithmic) => range,
        (None, AxisScale::Linear) => [0.0, 1.0],
        (None, AxisScale::Logarithmic) => [1.0, 10.0],
    }
}

/// Splits points at those that cannot be drawn.
fn runs(places: impl Iterator<Item = Option<[f64; 2]>>) -> Vec<Vec<[f64; 2]>> {
    let mut runs = Vec::new();
    let mut run = Vec::new();
    for place in places {
        match place {
            Some(point) => run.push(point),
            None => runs.push(std::mem::take(&mut run)),
        }
    }
    runs.push(run);
    runs.retain(|run| !run.is_empty());
    runs
}

/// The points without those that cannot be seen: in every strip a quarter of a point wide, the first, lowest, highest and
/// last remain, so that a curve of a million oscillating points keeps its envelope.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let strip = |point: &[f64; 2]| (4.0 * point[0]).floor();
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for group in points.chunk_by(|one, other| strip(one) == strip(other)) {
        let last = group.len() - 1;
        let by_height = |one: &usize, other: &usize| group[*one][1].total_cmp(&group[*other][1]);
        let lowest = (0..=last).min_by(by_height).unwrap_or(0);
        let highest = (0..=last).max_by(by_height).unwrap_or(last);
        let mut places = [0, lowest.min(highest), lowest.max(highest), last].to_vec();
        places.dedup();
        kept.extend(places.into_iter().map(|place| group[place]));
    }
    kept
}

/// Distance of two points.
fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// Outline of a marker around a point; the forms have about the same area.
fn marker(form: usize, [x, y]: [f64; 2]) -> Vec<Segment> {
    let radius = MARKER_RADIUS;
    match form % 5 {
        0 => circle([x, y], radius),
        1 => rectangle([x - 0.9 * radius, y - 0.9 * radius], [x + 0.9 * radius, y + 0.9 * radius]),
        2 => polygon(&[
            [x, y - 1.35 * radius],
            [x + 1.2 * radius, y + 0.7 * radius],
            [x - 1.2 * radius, y + 0.7 * radius],
        ]),
        3 => polygon(&[[x, y - 1.3 * radius], [x + 1.3 * radius, y], [x, y + 1.3 * radius], [x - 1.3 * radius, y]]),
        _ => polygon(&[
            [x, y + 1.35 * radius],
            [x + 1.2 * radius, y - 0.7 * radius],
            [x - 1.2 * radius, y - 0.7 * radius],
        ]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_split_a_curve() {
        let places = [None, Some([0.0, 0.0]), Some([1.0, 1.0]), None, None, Some([3.0, 3.0])];
        assert_eq!(runs(places.into_iter()), [vec![[0.0, 0.0], [1.0, 1.0]], vec![[3.0, 3.0]]]);
    }

    #[test]
    fn thinning_keeps_the_envelope_and_the_ends() {
        let points: Vec<[f64; 2]> = (0..100_000).map(|index| [1e-3 * f64::from(index), f64::from(index % 7)]).collect();
        let kept = thinned(&points);
        assert!(kept.len() <= 4 * 401);
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[points.len() - 1]));
        for strip in kept.chunk_by(|one, other| (4.0 * one[0]).floor() == (4.0 * other[0]).floor()) {
            assert!(strip.iter().any(|point| point[1] == 0.0) && strip.iter().any(|point| point[1] == 6.0));
        }
    }

    #[test]
    fn the_first_looks_all_differ() {
        let looks: Vec<Look> = (0..20).map(|index| Look::of(CurveStyle::Automatic, index)).collect();
        for (index, look) in looks.iter().enumerate() {
            assert!(looks[..index].iter().all(|other| other != look), "{index}");
        }
    }
}
