//! Curves over one horizontal axis.

use super::axis::{Axis, AxisScale, padded, range_of, widened};
use super::drawing::Drawing;
use super::frame::{Frame, TickSide, labels_fit, lines_fit};
use super::legend::{Entry, Legend};
use super::style::{self, CHART_HEIGHT, COLUMN_WIDTH, PANEL_GAP, PANEL_HEIGHT, RIM, TICK_SIZE};
use super::text::{Align, Direction, Typeface};
use super::trace::{CurveStyle, Look, Trace, draw_traces};
use super::{Figure, FigureError, check_length, draw_title, title_height};
use std::path::Path;

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
    /// The place in the list that its colour follows from; its own if none. With it, a curve looks the same in several charts.
    pub place: Option<usize>,
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
    /// Whether a linear horizontal axis reaches 0 even if no curve does, as in paths of stress.
    pub from_zero: bool,
    /// Curves, in the order of the legend.
    pub curves: Vec<Curve>,
    /// Curves with a vertical axis of their own at the right of the same area. Their looks follow on those of `curves`.
    pub right: Option<SecondAxis>,
    /// Curves in a second area below, over the same horizontal axis. A curve with the label of one above has its look, and
    /// shares its place in the legend.
    pub below: Option<SecondAxis>,
}

/// A second vertical axis with its curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SecondAxis {
    /// Title of the axis with its unit in round brackets.
    pub label: String,
    /// Scale of the axis.
    pub scale: AxisScale,
    /// Whether the axis grows downwards.
    pub down: bool,
    /// The curves.
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

    /// All curves, each with the scale of its vertical axis: those of the main area, at the right, below.
    fn all_curves(&self) -> impl Iterator<Item = (&Curve, AxisScale)> {
        let main = self.curves.iter().map(|curve| (curve, self.y_scale));
        let second = self.right.iter().chain(&self.below);
        main.chain(second.flat_map(|axis| axis.curves.iter().map(|curve| (curve, axis.scale))))
    }

    /// The horizontal axis, as long as `width` (pt), in loose fit around the data.
    fn x_axis(&self, typeface: &Typeface, width: f64) -> Axis {
        let drawable = self.all_curves().flat_map(|(curve, y_scale)| {
            let points = curve.x.iter().zip(&curve.y);
            points.filter(move |(x, y)| self.can_draw(y_scale, [**x, **y])).map(|(x, _)| *x)
        });
        let zero = (self.from_zero && self.x_scale == AxisScale::Linear).then_some(0.0);
        let range = fitted(range_of(drawable.chain(zero), self.x_scale), self.x_scale, widened);
        let x_axis = |intervals| Axis::loose(range, self.x_scale, intervals);
        Axis::finest(8, x_axis, |axis| labels_fit(typeface, axis, width))
    }

    /// A vertical axis, as high as `height` (pt), in loose fit around the data.
    fn y_axis(&self, curves: &[Curve], scale: AxisScale, height: f64) -> Axis {
        let drawable = curves.iter().flat_map(|curve| {
            let points = curve.x.iter().zip(&curve.y);
            points.filter(|(x, y)| self.can_draw(scale, [**x, **y])).map(|(_, y)| *y)
        });
        let range = fitted(range_of(drawable, scale), scale, |range| padded(widened(range)));
        Axis::finest(6, |intervals| Axis::loose(range, scale, intervals), |axis| lines_fit(axis, height))
    }

    /// Whether both axes can show a point.
    fn can_draw(&self, y_scale: AxisScale, [x, y]: [f64; 2]) -> bool {
        self.x_scale.can_draw(x) && y_scale.can_draw(y)
    }

    /// Height of a framed area (pt).
    fn height(&self) -> f64 {
        if self.below.is_some() { PANEL_HEIGHT } else { CHART_HEIGHT }
    }

    /// The framed areas, one or two, below a header of the given height (pt).
    fn frames(&self, typeface: &Typeface, header: f64) -> Vec<Frame> {
        let height = self.height();
        let main = self.y_axis(&self.curves, self.y_scale, height);
        let below = self.below.as_ref().map(|axis| (self.y_axis(&axis.curves, axis.scale, height), axis.down));
        let right = self.right.as_ref().map(|axis| (self.y_axis(&axis.curves, axis.scale, height), axis.down));
        let ticks = TickSide::Inside;
        let room = |axis: &Axis| Frame::room_beside(typeface, axis, ticks);
        let beside = below.iter().map(|(axis, _)| room(axis)).fold(room(&main), f64::max);
        let left = RIM + beside;
        let x = self.x_axis(typeface, COLUMN_WIDTH - RIM - left);
        // Half of the last number stands out to the right.
        let last = x.ticks.last().map_or(0.0, |tick| typeface.width(&tick.label, TICK_SIZE));
        let at_right = right.as_ref().map_or(0.0, |(axis, _)| room(axis));
        let margin = RIM + (0.5 * last).max(2.0).max(at_right);
        // Numbers as wide as half the page leave a small frame rather than none.
        let width = (COLUMN_WIDTH - left - margin).max(0.4 * COLUMN_WIDTH);
        let x = if at_right > 0.0 { self.x_axis(typeface, width) } else { x };
        // Half of the uppermost number stands out above.
        let top = RIM + header.max(0.5 * TICK_SIZE);
        let bare_below = below.is_some();
        let frame = |y: Axis, y_down: bool, top: f64| Frame {
            corner: [left, top],
            size: [width, height],
            x: x.clone(),
            y,
            y_down,
            ticks,
            bare_below: false,
            beside,
            right: None,
        };
        let first = Frame { bare_below, right, ..frame(main, self.y_down, top) };
        let second = below.map(|(axis, down)| frame(axis, down, top + height + PANEL_GAP));
        std::iter::once(first).chain(second).collect()
    }

    /// The looks of all curves, in the order of [`Self::all_curves`].
    fn looks(&self) -> Vec<Look> {
        let num_above = self.all_curves().count() - self.below.as_ref().map_or(0, |axis| axis.curves.len());
        let all: Vec<&Curve> = self.all_curves().map(|(curve, _)| curve).collect();
        let shared = |index: usize, label: &str| {
            let above = all[..num_above].iter().position(|curve| !label.is_empty() && curve.label == label);
            above.filter(|_| index >= num_above).unwrap_or(index)
        };
        let looks = all.iter().enumerate();
        looks
            .map(|(index, curve)| Look::of(curve.style, curve.place.unwrap_or_else(|| shared(index, &curve.label))))
            .collect()
    }

    /// The curves on the page, area by area.
    fn traces(&self, frames: &[Frame]) -> Vec<Vec<Trace>> {
        let looks = self.looks();
        let num_left = self.curves.len();
        let num_above = num_left + self.right.as_ref().map_or(0, |axis| axis.curves.len());
        let mut traces: Vec<Vec<Trace>> = frames.iter().map(|_| Vec::new()).collect();
        for (index, ((curve, y_scale), look)) in self.all_curves().zip(looks).enumerate() {
            let area = usize::from(index >= num_above);
            let frame = &frames[area];
            let place = |point| match index < num_left || index >= num_above {
                true => frame.place(point),
                false => frame.place_at_right(point),
            };
            let points = curve.x.iter().zip(&curve.y).map(|(x, y)| [*x, *y]);
            let places = points.map(|point| self.can_draw(y_scale, point).then(|| place(point)));
            traces[area].push(Trace { runs: runs(places), look });
        }
        traces
    }

    /// The curves' entries in the legend; one for curves that share look and label.
    fn entries(&self) -> Vec<Entry> {
        let mut entries: Vec<Entry> = Vec::new();
        for ((curve, _), look) in self.all_curves().zip(self.looks()) {
            let is_there = entries.iter().any(|entry| entry.label == curve.label && entry.look == look);
            if !curve.label.trim().is_empty() && !is_there {
                entries.push(Entry { label: curve.label.clone(), look });
            }
        }
        entries
    }

    /// Draws the frames with their titles, as wide as the page allows.
    fn draw_frames(&self, page: &mut Drawing, typeface: &Typeface, frames: &[Frame], header: f64) {
        let labels = [Some(&self.y_label), self.below.as_ref().map(|axis| &axis.label)];
        for (frame, label) in frames.iter().zip(labels.into_iter().flatten()) {
            frame.draw_guides(page);
            frame.draw(page, typeface);
            let middle = frame.corner[0] + 0.5 * frame.size[0];
            let beyond = if frames.len() > 1 { PANEL_GAP } else { header };
            let room = [2.0 * (page.width - RIM - middle), frame.size[1] + beyond];
            let titles = [frame.x.title(&self.x_label), frame.y.title(label)];
            frame.draw_titles(page, typeface, [&titles[0], &titles[1]], room);
            if let (Some(axis), Some((scale, _))) = (&self.right, &frame.right) {
                frame.draw_right_title(page, typeface, &scale.title(&axis.label), room[1]);
            }
        }
    }
}

impl Figure for LineChart {
    fn check(&self, path: &Path) -> Result<(), FigureError> {
        self.all_curves().try_for_each(|(curve, _)| {
            check_length(path, &format!("y of curve \"{}\"", curve.label), curve.x.len(), curve.y.len())
        })
    }

    fn layout(&self, typeface: &Typeface) -> Drawing {
        let title_width = COLUMN_WIDTH - 2.0 * RIM;
        let title = typeface.wrapped(self.title.as_deref().unwrap_or_default(), style::TITLE_SIZE, title_width);
        let header = title_height(&title);
        let mut frames = self.frames(typeface, header);
        let mut traces = self.traces(&frames);
        let panels: Vec<_> = frames.iter().zip(&traces).map(|(frame, traces)| (frame, traces.as_slice())).collect();
        let mut legend = Legend::new(typeface, self.entries(), &panels);
        if legend.height_above > 0.0 {
            frames = self.frames(typeface, header + legend.height_above);
            traces = self.traces(&frames);
            legend.move_above(&frames[0]);
        }
        let at_right = frames[0].right.as_ref().map(|(axis, _)| Frame::room_beside(typeface, axis, frames[0].ticks));
        let [right, bottom] = frames[frames.len() - 1].far_corner();
        let width = COLUMN_WIDTH.max(right + RIM + at_right.unwrap_or(0.0));
        let mut page = Drawing::new(width, bottom + Frame::room_below(TickSide::Inside) + RIM);
        draw_title(&mut page, typeface, &title, [0.5 * width, RIM]);
        self.draw_frames(&mut page, typeface, &frames, header);
        for (frame, traces) in frames.iter().zip(&traces) {
            draw_traces(&mut page, traces);
            if traces.iter().all(|trace| trace.runs.is_empty()) {
                let anchor = [0, 1].map(|axis| frame.corner[axis] + 0.5 * frame.size[axis]);
                typeface.draw(&mut page, "no data", TICK_SIZE, anchor, (Align::Middle, Direction::Across));
            }
        }
        legend.draw(&mut page, typeface);
        page
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_split_a_curve() {
        let places = [None, Some([0.0, 0.0]), Some([1.0, 1.0]), None, None, Some([3.0, 3.0])];
        assert_eq!(runs(places.into_iter()), [vec![[0.0, 0.0], [1.0, 1.0]], vec![[3.0, 3.0]]]);
    }
}
