//! Curves on the page: how they look, and in which order they lie over each other.

use super::drawing::{Drawing, Segment, Shape, Stroke, circle, polygon, polyline, rectangle};
use super::style::{self, CURVE_COLORS, CURVE_WIDTH, Color, MARKER_RADIUS};

/// How a curve is drawn. Its colour, and the form of its markers, follow from its place in the list of curves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveStyle {
    /// A line whose dashes follow from its place in the list too, so that curves differ without colour.
    #[default]
    Automatic,
    /// A solid line.
    Line,
    /// A thin solid line, drawn over the others: what they are held against.
    Thin,
    /// Hollow markers at some of its points and no line, so that a line that it follows closely is still seen.
    SparseMarkers,
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

/// What the style of a curve and its place in the list come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    color: Color,
    /// Dashes, if there is a line; empty for a solid one.
    dash: Option<&'static [f64]>,
    /// Width of the line (pt).
    width: f64,
    /// Form of the markers, if there are any.
    marker: Option<usize>,
    /// The least distance between markers (pt).
    spacing: f64,
}

impl Look {
    /// The look of the curve at a place in the list.
    pub(super) fn of(style: CurveStyle, index: usize) -> Self {
        let color = CURVE_COLORS[index % CURVE_COLORS.len()];
        let dashes: [&[f64]; 4] = [&[], style::DASHED, style::DASH_DOTTED, style::DOTTED];
        let (dash, marker) = match style {
            // Shifted by one in each round of the colours, so that no look comes twice soon.
            CurveStyle::Automatic => {
                (Some(dashes[(index % CURVE_COLORS.len() + index / CURVE_COLORS.len()) % dashes.len()]), None)
            }
            CurveStyle::Line | CurveStyle::Thin => (Some(dashes[0]), None),
            CurveStyle::Dashed => (Some(style::DASHED), None),
            CurveStyle::Dotted => (Some(style::DOTTED), None),
            CurveStyle::DashDotted => (Some(style::DASH_DOTTED), None),
            CurveStyle::Markers => (None, Some(index)),
            CurveStyle::SparseMarkers => (None, Some(index)),
            CurveStyle::LineMarkers => (Some(dashes[0]), Some(index)),
        };
        let width = if style == CurveStyle::Thin { style::THIN_CURVE_WIDTH } else { CURVE_WIDTH };
        let spacing = if style == CurveStyle::Markers { MARKER_RADIUS } else { 9.0 * MARKER_RADIUS };
        Self { color, dash, width, marker, spacing }
    }

    /// Solid lines lie lowest, then broken and thin ones, then markers alone: what leaves gaps does not hide what it covers.
    fn layer(&self) -> usize {
        match self.dash {
            Some([]) if self.width >= CURVE_WIDTH => 0,
            Some(_) => 1,
            None => 2,
        }
    }

    /// Draws the look along a path of points on the page (pt), with markers at `marked`.
    pub(super) fn draw(&self, page: &mut Drawing, points: &[[f64; 2]], marked: &[[f64; 2]]) {
        if let Some(dash) = self.dash {
            match points {
                // A line needs two points; one alone is shown as a dot.
                [point] => page.fill("curve", circle(*point, self.width), self.color),
                _ => page.stroke("curve", polyline(points), Stroke { color: self.color, width: self.width, dash }),
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
        let mut marked: Vec<[f64; 2]> = Vec::new();
        for point in points {
            if marked.last().is_none_or(|last| distance(*last, *point) >= self.spacing) {
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
    pub(super) look: Look,
}

/// Draws all curves, layer by layer.
pub(super) fn draw_traces(page: &mut Drawing, traces: &[Trace]) {
    for layer in 0..3 {
        for trace in traces.iter().filter(|trace| trace.look.layer() == layer) {
            for run in &trace.runs {
                trace.look.draw(page, &thinned(run), &trace.look.marked(run));
            }
        }
    }
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
