//! The legend of a line chart: in a corner that no curve touches, or above the frame.

use super::drawing::{Drawing, Shape, Stroke, rectangle};
use super::frame::Frame;
use super::style::{self, FRAME_WIDTH, GAP, LINE_SPACING, MARKER_RADIUS, SAMPLE_LENGTH, TICK_SIZE};
use super::text::{Align, Direction, Typeface};
use super::trace::{Look, Trace};

/// Height of one entry (pt).
const ENTRY_HEIGHT: f64 = TICK_SIZE * LINE_SPACING;

/// One entry.
pub(super) struct Entry {
    /// Name of the curve.
    pub(super) label: String,
    /// Look of the curve.
    pub(super) look: Look,
}

/// All entries and their place.
pub(super) struct Legend {
    /// Room that the legend needs above the frame (pt); 0 if it stands inside.
    pub(super) height_above: f64,
    entries: Vec<Entry>,
    corner: [f64; 2],
    columns: usize,
    entry_width: f64,
    label_size: f64,
}

impl Legend {
    /// Finds the place of a legend: in the first of the frames, each with the curves in it, that has room.
    pub(super) fn new(typeface: &Typeface, entries: Vec<Entry>, panels: &[(&Frame, &[Trace])]) -> Self {
        let frame = panels[0].0;
        let room = frame.size[0] - SAMPLE_LENGTH - 4.0 * GAP;
        let sizes = entries.iter().map(|entry| typeface.fitting_size(&entry.label, TICK_SIZE, room));
        let label_size = sizes.fold(TICK_SIZE, f64::min);
        let widths = entries.iter().map(|entry| typeface.width(&entry.label, label_size));
        let entry_width = SAMPLE_LENGTH + GAP + widths.fold(0.0, f64::max);
        let mut legend = Self { height_above: 0.0, entries, corner: frame.corner, columns: 1, entry_width, label_size };
        match panels.iter().find_map(|(frame, traces)| legend.free_corner(frame, traces)) {
            Some(corner) => legend.corner = corner,
            None => legend.arrange_above(frame),
        }
        legend
    }

    /// Puts the legend above a frame that has been moved down to make room.
    pub(super) fn move_above(&mut self, frame: &Frame) {
        self.corner = [frame.corner[0], frame.corner[1] - self.size()[1] - GAP];
    }

    /// Draws the legend.
    pub(super) fn draw(&self, page: &mut Drawing, typeface: &Typeface) {
        if self.entries.is_empty() {
            return;
        }
        if self.height_above == 0.0 {
            self.draw_box(page);
        }
        for (index, entry) in self.entries.iter().enumerate() {
            let [column, row] = [index % self.columns, index / self.columns];
            let left = self.corner[0] + GAP + column as f64 * (self.entry_width + 3.0 * GAP);
            let middle = self.corner[1] + GAP + (row as f64 + 0.5) * ENTRY_HEIGHT;
            let sample = [[left, middle], [left + SAMPLE_LENGTH, middle]];
            entry.look.draw(page, &sample, &[[left + 0.5 * SAMPLE_LENGTH, middle]]);
            let anchor = [left + SAMPLE_LENGTH + GAP, middle];
            typeface.draw(page, &entry.label, self.label_size, anchor, (Align::Start, Direction::Across));
        }
    }

    /// Draws the background.
    fn draw_box(&self, page: &mut Drawing) {
        let [width, height] = self.size();
        let path = rectangle(self.corner, [self.corner[0] + width, self.corner[1] + height]);
        let stroke = Some(Stroke::solid(style::GRID, FRAME_WIDTH));
        page.add(Shape { path, fill: Some(style::PAPER), stroke, class: "legend", words: None });
    }

    /// Width and height (pt).
    fn size(&self) -> [f64; 2] {
        let rows = self.entries.len().div_ceil(self.columns);
        let between = 3.0 * GAP * (self.columns - 1) as f64;
        [self.columns as f64 * self.entry_width + between + 2.0 * GAP, rows as f64 * ENTRY_HEIGHT + 2.0 * GAP]
    }

    /// The first place in the frame that no curve touches: corners first, then the middles of the sides.
    fn free_corner(&self, frame: &Frame, traces: &[Trace]) -> Option<[f64; 2]> {
        let [width, height] = self.size();
        let margin = 2.0 * GAP;
        let free = [frame.size[0] - width - 2.0 * margin, frame.size[1] - height - 2.0 * margin];
        if self.entries.is_empty() || free[0] < 0.0 || free[1] < 0.0 {
            return self.entries.is_empty().then_some(frame.corner);
        }
        let places = [[1.0, 0.0], [1.0, 1.0], [0.0, 0.0], [0.0, 1.0], [1.0, 0.5], [0.0, 0.5], [0.5, 0.0], [0.5, 1.0]];
        places
            .into_iter()
            .map(|place| [0, 1].map(|axis| frame.corner[axis] + margin + place[axis] * free[axis]))
            .find(|corner| !is_touched(traces, *corner, [corner[0] + width, corner[1] + height]))
    }

    /// Arranges the entries in rows above the frame.
    fn arrange_above(&mut self, frame: &Frame) {
        let columns = (frame.size[0] / (self.entry_width + 3.0 * GAP)).floor() as usize;
        self.columns = columns.clamp(1, self.entries.len().max(1));
        self.height_above = self.size()[1] + GAP;
    }
}

/// Whether a curve comes nearer to a rectangle than a marker's width.
fn is_touched(traces: &[Trace], low: [f64; 2], high: [f64; 2]) -> bool {
    let clearance = 2.0 * MARKER_RADIUS;
    let [low, high] = [low.map(|edge| edge - clearance), high.map(|edge| edge + clearance)];
    let touches = |pair: &[[f64; 2]]| crosses(pair[0], pair[pair.len() - 1], low, high);
    traces.iter().flat_map(|trace| &trace.runs).any(|run| match run.len() {
        1 => touches(run),
        _ => run.windows(2).any(touches),
    })
}

/// Whether a straight line has a point in a rectangle: what remains of the line after cutting it at the four sides.
fn crosses(from: [f64; 2], to: [f64; 2], low: [f64; 2], high: [f64; 2]) -> bool {
    let mut inside = [0.0_f64, 1.0_f64];
    for axis in 0..2 {
        let length = to[axis] - from[axis];
        if length == 0.0 {
            if from[axis] < low[axis] || from[axis] > high[axis] {
                return false;
            }
            continue;
        }
        let [one, other] = [(low[axis] - from[axis]) / length, (high[axis] - from[axis]) / length];
        inside = [inside[0].max(one.min(other)), inside[1].min(one.max(other))];
    }
    inside[0] <= inside[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_across_a_rectangle_are_seen() {
        let crossing = |from, to| crosses(from, to, [0.0, 0.0], [2.0, 1.0]);
        assert!(crossing([-1.0, 0.5], [3.0, 0.5]));
        assert!(crossing([1.0, 0.5], [1.0, 0.5]));
        assert!(crossing([-1.0, -1.0], [3.0, 3.0]));
        assert!(!crossing([-1.0, 1.5], [3.0, 1.5]));
        assert!(!crossing([-1.0, 0.0], [1.0, 3.0]));
        assert!(!crossing([3.0, 0.5], [4.0, 0.5]));
    }
}
