//! The framed area of a chart with its ticks, tick numbers and axis titles.

use super::axis::Axis;
use super::drawing::{Drawing, Segment, Stroke, line, rectangle};
use super::style::{self, FRAME_WIDTH, GAP, INK, LABEL_SIZE, MINOR_TICK_LENGTH, TICK_LENGTH, TICK_SIZE};
use super::text::{Align, Direction, Typeface};

/// Which way ticks point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TickSide {
    /// Into the area, and at all four sides: for curves.
    Inside,
    /// Away from the area: for areas filled with colour.
    Outside,
}

impl TickSide {
    /// How far ticks stick out of the area (pt).
    pub(super) fn outer_length(self) -> f64 {
        match self {
            Self::Inside => 0.0,
            Self::Outside => TICK_LENGTH,
        }
    }
}

/// A framed area on the page.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Upper left corner on the page (pt).
    pub(super) corner: [f64; 2],
    /// Width and height (pt).
    pub(super) size: [f64; 2],
    /// Horizontal axis.
    pub(super) x: Axis,
    /// Vertical axis.
    pub(super) y: Axis,
    /// Whether the vertical axis grows downwards.
    pub(super) y_down: bool,
    /// Which way ticks point.
    pub(super) ticks: TickSide,
    /// Whether another frame below carries the numbers and the title of the horizontal axis.
    pub(super) bare_below: bool,
    /// Room for the numbers and the title of the vertical axis (pt).
    pub(super) beside: f64,
    /// A second vertical axis at the right, and whether it grows downwards.
    pub(super) right: Option<(Axis, bool)>,
}

impl Frame {
    /// The place on the page (pt) of a point of the data.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.place_on(&self.y, self.y_down, [x, y])
    }

    /// The place on the page (pt) of a point that belongs to the axis at the right; to the left one if there is no other.
    pub(super) fn place_at_right(&self, point: [f64; 2]) -> [f64; 2] {
        match &self.right {
            Some((axis, down)) => self.place_on(axis, *down, point),
            None => self.place(point),
        }
    }

    fn place_on(&self, axis: &Axis, down: bool, [x, y]: [f64; 2]) -> [f64; 2] {
        let fraction = if down { axis.fraction(y) } else { 1.0 - axis.fraction(y) };
        [self.corner[0] + self.x.fraction(x) * self.size[0], self.corner[1] + fraction * self.size[1]]
    }

    /// Right and lower end on the page (pt).
    pub(super) fn far_corner(&self) -> [f64; 2] {
        [self.corner[0] + self.size[0], self.corner[1] + self.size[1]]
    }

    /// Room that tick numbers and title of a vertical axis need beside the area (pt).
    pub(super) fn room_beside(typeface: &Typeface, y: &Axis, ticks: TickSide) -> f64 {
        ticks.outer_length() + GAP + widest_label(typeface, y) + GAP + LABEL_SIZE
    }

    /// Room that tick numbers and title need below (pt).
    pub(super) fn room_below(ticks: TickSide) -> f64 {
        ticks.outer_length() + GAP + TICK_SIZE + GAP + LABEL_SIZE
    }

    /// Draws faint lines through the area at the numbered ticks.
    pub(super) fn draw_guides(&self, page: &mut Drawing) {
        let mut path = Vec::new();
        let [right, bottom] = self.far_corner();
        for tick in self.x.ticks.iter().map(|tick| self.place([tick.value, self.y.low])[0]) {
            path.extend(line([tick, self.corner[1]], [tick, bottom]));
        }
        for tick in self.y.ticks.iter().map(|tick| self.place([self.x.low, tick.value])[1]) {
            path.extend(line([self.corner[0], tick], [right, tick]));
        }
        page.stroke("guides", path, Stroke::solid(style::GUIDE, style::GRID_WIDTH));
    }

    /// Draws the frame, ticks and tick numbers.
    pub(super) fn draw(&self, page: &mut Drawing, typeface: &Typeface) {
        page.stroke("ticks", self.tick_marks(), Stroke::solid(INK, FRAME_WIDTH));
        page.stroke("frame", rectangle(self.corner, self.far_corner()), Stroke::solid(INK, FRAME_WIDTH));
        let gap = self.ticks.outer_length() + GAP;
        let below: &[_] = if self.bare_below { &[] } else { &self.x.ticks };
        for tick in below {
            let anchor = [self.place([tick.value, self.y.low])[0], self.far_corner()[1] + gap + 0.5 * TICK_SIZE];
            typeface.draw(page, &tick.label, TICK_SIZE, anchor, (Align::Middle, Direction::Across));
        }
        for tick in &self.y.ticks {
            let anchor = [self.corner[0] - gap, self.place([self.x.low, tick.value])[1]];
            typeface.draw(page, &tick.label, TICK_SIZE, anchor, (Align::End, Direction::Across));
        }
        for tick in self.right.iter().flat_map(|(axis, _)| &axis.ticks) {
            let anchor = [self.far_corner()[0] + gap, self.place_at_right([self.x.low, tick.value])[1]];
            typeface.draw(page, &tick.label, TICK_SIZE, anchor, (Align::Start, Direction::Across));
        }
    }

    /// Writes the axis titles, in a smaller font where they would be longer than `room` (pt along x and y).
    pub(super) fn draw_titles(&self, page: &mut Drawing, typeface: &Typeface, [x, y]: [&str; 2], room: [f64; 2]) {
        let middle = [self.corner[0] + 0.5 * self.size[0], self.corner[1] + 0.5 * self.size[1]];
        if !self.bare_below {
            let below = self.far_corner()[1] + Self::room_below(self.ticks) - 0.5 * LABEL_SIZE;
            let size = typeface.fitting_size(x, LABEL_SIZE, room[0]);
            typeface.draw(page, x, size, [middle[0], below], (Align::Middle, Direction::Across));
        }
        let beside = self.corner[0] - self.beside + 0.5 * LABEL_SIZE;
        let size = typeface.fitting_size(y, LABEL_SIZE, room[1]);
        typeface.draw(page, y, size, [beside, middle[1]], (Align::Middle, Direction::Upwards));
    }

    /// Writes the title of the axis at the right, in a smaller font where it would be longer than `room` (pt).
    pub(super) fn draw_right_title(&self, page: &mut Drawing, typeface: &Typeface, title: &str, room: f64) {
        let Some((axis, _)) = &self.right else { return };
        let beside = self.far_corner()[0] + Self::room_beside(typeface, axis, self.ticks) - 0.5 * LABEL_SIZE;
        let anchor = [beside, self.corner[1] + 0.5 * self.size[1]];
        let size = typeface.fitting_size(title, LABEL_SIZE, room);
        typeface.draw(page, title, size, anchor, (Align::Middle, Direction::Upwards));
    }

    /// All ticks as one path.
    fn tick_marks(&self) -> Vec<Segment> {
        let mut path = Vec::new();
        let numbered = |axis: &Axis| axis.ticks.iter().map(|tick| (tick.value, TICK_LENGTH)).collect::<Vec<_>>();
        let unnumbered = |axis: &Axis| axis.minor.iter().map(|value| (*value, MINOR_TICK_LENGTH)).collect::<Vec<_>>();
        for (value, length) in [numbered(&self.x), unnumbered(&self.x)].concat() {
            path.extend(self.vertical_marks(self.place([value, self.y.low])[0], length));
        }
        for (value, length) in [numbered(&self.y), unnumbered(&self.y)].concat() {
            path.extend(self.horizontal_marks(self.place([self.x.low, value])[1], length));
        }
        let right = self.far_corner()[0];
        for (value, length) in self.right.iter().flat_map(|(axis, _)| [numbered(axis), unnumbered(axis)].concat()) {
            let y = self.place_at_right([self.x.low, value])[1];
            path.extend(line([right, y], [right - length, y]));
        }
        path
    }

    /// The ticks at one place of the horizontal axis.
    fn vertical_marks(&self, x: f64, length: f64) -> Vec<Segment> {
        let [top, bottom] = [self.corner[1], self.far_corner()[1]];
        match self.ticks {
            TickSide::Outside => line([x, bottom], [x, bottom + length]),
            TickSide::Inside => [line([x, bottom], [x, bottom - length]), line([x, top], [x, top + length])].concat(),
        }
    }

    /// The ticks at one place of the vertical axis.
    fn horizontal_marks(&self, y: f64, length: f64) -> Vec<Segment> {
        let [left, right] = [self.corner[0], self.far_corner()[0]];
        match self.ticks {
            TickSide::Outside => line([left, y], [left - length, y]),
            TickSide::Inside if self.right.is_some() => line([left, y], [left + length, y]),
            TickSide::Inside => [line([left, y], [left + length, y]), line([right, y], [right - length, y])].concat(),
        }
    }
}

/// Width of the widest tick number of an axis (pt).
fn widest_label(typeface: &Typeface, axis: &Axis) -> f64 {
    axis.ticks.iter().map(|tick| typeface.width(&tick.label, TICK_SIZE)).fold(0.0, f64::max)
}

/// Whether the numbers of a horizontal axis of this length (pt) stand clear of each other.
pub(super) fn labels_fit(typeface: &Typeface, axis: &Axis, length: f64) -> bool {
    axis.ticks.windows(2).all(|pair| {
        let distance = length * (axis.fraction(pair[1].value) - axis.fraction(pair[0].value));
        let widths = pair.iter().map(|tick| typeface.width(&tick.label, TICK_SIZE)).sum::<f64>();
        distance >= 0.5 * widths + 0.9 * TICK_SIZE
    })
}

/// Whether the numbers of a vertical axis of this length (pt) stand clear of each other.
pub(super) fn lines_fit(axis: &Axis, length: f64) -> bool {
    axis.ticks
        .windows(2)
        .all(|pair| length * (axis.fraction(pair[1].value) - axis.fraction(pair[0].value)) >= 1.8 * TICK_SIZE)
}
