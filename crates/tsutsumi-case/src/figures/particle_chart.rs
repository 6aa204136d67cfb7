//! Particles over the background grid, coloured by a value.

use super::axis::{Axis, range_of, widened};
use super::color_map::{LEVELS, level, level_color};
use super::drawing::{Drawing, Segment, Stroke, circle, line, polygon, rectangle};
use super::frame::{Frame, TickSide, labels_fit, lines_fit};
use super::style::{
    self, COLOR_BAR_GAP, COLOR_BAR_WIDTH, COLUMN_WIDTH, FRAME_WIDTH, GAP, GRID_WIDTH, INK, LABEL_SIZE, PARTICLE_AREA,
    RIM, TICK_LENGTH, TICK_SIZE,
};
use super::text::{Align, Direction, Typeface};
use super::{AxisScale, Figure, FigureError, check_length, draw_title, title_height};
use std::collections::BTreeMap;
use std::path::Path;

/// Smallest side of the framed area (pt); the axis of a thinner body is lengthened to reach it.
const SMALLEST_SIDE: f64 = 12.0;
/// Height of the framed area (pt) below which the colour bar lies under it instead of beside it.
const SMALLEST_BAR: f64 = 70.0;
/// Grid lines nearer to each other than this (pt) would make a grey area, and are left out.
const SMALLEST_CELL: f64 = 1.5;

/// Height of one note below the chart (pt).
const NOTE_HEIGHT: f64 = TICK_SIZE * style::LINE_SPACING;

/// Particles as coloured rectangles of their current size over the background grid, with a colour bar.
///
/// One metre is as long upwards as across. The axes span the grid, and what lies outside of it. Particles whose value is not
/// finite are grey; the picture says how many particles are grey or, for want of a finite position, missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticleChart {
    /// Line above the chart; journals put it in the caption instead.
    pub title: Option<String>,
    /// Title of the horizontal axis with its unit in round brackets, for example `x (m)`.
    pub x_label: String,
    /// Title of the vertical axis with its unit in round brackets, for example `z (m)`.
    pub y_label: String,
    /// Title of the colour bar with its unit in round brackets, for example `pore pressure (kPa)`.
    pub value_label: String,
    /// Centres of the particles, across and upwards (same unit, usually m).
    pub position: Vec<[f64; 2]>,
    /// Half the width and height of every particle (unit of `position`); empty to draw dots of one size.
    pub half_size: Vec<[f64; 2]>,
    /// Value of every particle, in the unit named in `value_label`.
    pub value: Vec<f64>,
    /// Lowest and highest value of the colour bar; that of the values if none. Give it to compare pictures. A pointed end
    /// of the bar tells that values lie beyond it.
    pub value_range: Option<[f64; 2]>,
    /// Coordinates of the vertical grid lines (unit of `position`).
    pub grid_x: Vec<f64>,
    /// Coordinates of the horizontal grid lines (unit of `position`).
    pub grid_y: Vec<f64>,
    /// Straight lines drawn dashed over the particles, each from point to point (unit of `position`), for example the
    /// undeformed outline.
    pub outline: Vec<[[f64; 2]; 2]>,
}

impl ParticleChart {
    /// Writes the chart to two files, with `.svg` and `.png` put behind the path. Existing files are replaced.
    ///
    /// # Errors
    ///
    /// [`FigureError::Length`] if `value`, or `half_size` where it is given, does not have an entry for each particle,
    /// [`FigureError::Write`] if a file could not be written, [`FigureError::Draw`] if the picture could not be encoded.
    pub fn save(&self, path_without_extension: &Path) -> Result<(), FigureError> {
        super::save(self, path_without_extension)
    }

    /// Half the size of a particle, zero where it is unknown.
    fn half_size(&self, particle: usize) -> [f64; 2] {
        self.half_size
            .get(particle)
            .map_or([0.0; 2], |size| size.map(|side| if can_draw(side) { side.abs() } else { 0.0 }))
    }

    /// Particles that have a place: index and centre.
    fn placed(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        self.position.iter().copied().enumerate().filter(|(_, centre)| centre.iter().all(|value| can_draw(*value)))
    }

    /// Outline segments that have a place.
    fn placed_outline(&self) -> impl Iterator<Item = &[[f64; 2]; 2]> {
        self.outline.iter().filter(|ends| ends.iter().flatten().all(|value| can_draw(*value)))
    }

    /// Range of one axis (0 across, 1 upwards): the grid and all that is drawn.
    fn extent(&self, axis: usize) -> [f64; 2] {
        let grid = if axis == 0 { &self.grid_x } else { &self.grid_y };
        let particles = self.placed().flat_map(|(particle, centre)| {
            let half = self.half_size(particle)[axis];
            [centre[axis] - half, centre[axis] + half]
        });
        let outline = self.placed_outline().flatten().map(|end| end[axis]);
        let all = grid.iter().copied().chain(particles).chain(outline);
        widened(range_of(all, AxisScale::Linear).unwrap_or([0.0, 1.0]))
    }

    /// Range of the colour bar.
    fn color_range(&self) -> [f64; 2] {
        let given = self.value_range.filter(|range| range.iter().all(|value| can_draw(*value)) && range[0] < range[1]);
        let of_values = || range_of(self.value.iter().copied(), AxisScale::Linear).unwrap_or([0.0, 1.0]);
        widened(given.unwrap_or_else(of_values))
    }

    /// The frame at the corner of the page: equal scale on both axes.
    fn frame(&self, typeface: &Typeface) -> Frame {
        let mut extent = [self.extent(0), self.extent(1)];
        let length = |range: [f64; 2]| range[1] - range[0];
        // Points per metre, the same for both axes.
        let scale = (PARTICLE_AREA[0] / length(extent[0])).min(PARTICLE_AREA[1] / length(extent[1]));
        for range in &mut extent {
            let missing = (SMALLEST_SIDE / scale - length(*range)).max(0.0);
            *range = [range[0] - 0.5 * missing, range[1] + 0.5 * missing];
        }
        let size = extent.map(|range| scale * length(range));
        let across = |intervals| Axis::tight(extent[0], intervals);
        let upwards = |intervals| Axis::tight(extent[1], intervals);
        let x = Axis::finest(5, across, |axis| labels_fit(typeface, axis, size[0]));
        let y = Axis::finest(6, upwards, |axis| lines_fit(axis, size[1]));
        let ticks = TickSide::Outside;
        let beside = Frame::room_beside(typeface, &y, ticks);
        Frame { corner: [0.0; 2], size, x, y, y_down: false, ticks, bare_below: false, beside, right: None }
    }

    /// Draws the grid lines.
    fn draw_grid(&self, page: &mut Drawing, frame: &Frame) {
        let [left, top] = frame.corner;
        let [right, bottom] = frame.far_corner();
        let places = |lines: &[f64], axis: usize| {
            let placed = lines.iter().filter(|value| can_draw(**value));
            let mut places: Vec<f64> = placed.map(|value| frame.place([*value; 2])[axis]).collect();
            places.sort_by(f64::total_cmp);
            let dense = places.windows(2).any(|pair| pair[1] - pair[0] < SMALLEST_CELL);
            if dense { Vec::new() } else { places }
        };
        let mut path = Vec::new();
        path.extend(places(&self.grid_x, 0).into_iter().flat_map(|x| line([x, top], [x, bottom])));
        path.extend(places(&self.grid_y, 1).into_iter().flat_map(|y| line([left, y], [right, y])));
        page.stroke("grid", path, Stroke::solid(style::GRID, GRID_WIDTH));
    }

    /// Draws the particles, all of one colour as one path.
    fn draw_particles(&self, page: &mut Drawing, frame: &Frame, range: [f64; 2]) {
        let shrink = self.shrink(frame);
        if shrink > 0.0 {
            // Grid lines would show in those gaps that happen to lie on them.
            let ground = self.placed().flat_map(|(particle, centre)| self.particle_path(frame, particle, centre, 0.0));
            page.fill("ground", ground.collect(), style::PAPER);
        }
        let mut paths: BTreeMap<Option<usize>, Vec<Segment>> = BTreeMap::new();
        for (particle, centre) in self.placed() {
            let color = Some(self.value[particle]).filter(|value| can_draw(*value)).map(|value| level(value, range));
            paths.entry(color).or_default().extend(self.particle_path(frame, particle, centre, shrink));
        }
        for (color, path) in paths {
            page.fill("particles", path, color.map_or(style::MUTED, level_color));
        }
    }

    /// What is taken off every side of a particle (pt). Large particles get a gap between them, so that each is seen; small
    /// ones overlap a little, as white hairlines would show between them otherwise.
    fn shrink(&self, frame: &Frame) -> f64 {
        let sides = self.half_size.iter().flatten().filter(|side| can_draw(**side));
        let (sum, count) = sides.fold((0.0, 0.0), |(sum, count), side| (sum + side.abs(), count + 1.0));
        let mean = sum / f64::max(count, 1.0) * points_per_unit(frame);
        if mean > 1.6 { 0.15 } else { -0.1 }
    }

    /// Outline of one particle on the page.
    fn particle_path(&self, frame: &Frame, particle: usize, centre: [f64; 2], shrink: f64) -> Vec<Segment> {
        let place = frame.place(centre);
        if self.half_size.is_empty() {
            return circle(place, self.dot_radius(frame));
        }
        let half = self.half_size(particle).map(|side| (side * points_per_unit(frame) - shrink).max(0.25));
        rectangle([place[0] - half[0], place[1] - half[1]], [place[0] + half[0], place[1] + half[1]])
    }

    /// Radius of dots (pt): they would fill three quarters of the framed area.
    fn dot_radius(&self, frame: &Frame) -> f64 {
        let area = frame.size[0] * frame.size[1] / self.position.len().max(1) as f64;
        (0.4 * area.sqrt()).clamp(0.4, 2.5)
    }

    /// Draws the outline.
    fn draw_outline(&self, page: &mut Drawing, frame: &Frame) {
        let path = self.placed_outline().flat_map(|ends| line(frame.place(ends[0]), frame.place(ends[1]))).collect();
        page.stroke("outline", path, Stroke { color: INK, width: 0.8, dash: &[3.0, 2.0] });
    }

    /// What the picture cannot show, in words.
    fn notes(&self) -> Vec<String> {
        let missing = self.position.len() - self.placed().count();
        let grey = self.placed().filter(|(particle, _)| !can_draw(self.value[*particle])).count();
        let mut notes = Vec::new();
        if self.position.is_empty() {
            notes.push(String::from("no particles"));
        }
        if grey > 0 {
            notes.push(format!("grey: {grey} without value"));
        }
        if missing > 0 {
            notes.push(format!("not drawn: {missing} without position"));
        }
        notes
    }

    /// Whether values lie below and above the range of the colour bar.
    fn beyond(&self, range: [f64; 2]) -> [bool; 2] {
        let any = |test: &dyn Fn(f64) -> bool| self.value.iter().any(|value| can_draw(*value) && test(*value));
        [any(&|value| value < range[0]), any(&|value| value > range[1])]
    }
}

impl Figure for ParticleChart {
    fn check(&self, path: &Path) -> Result<(), FigureError> {
        let count = self.position.len();
        check_length(path, "value", count, self.value.len())?;
        if self.half_size.is_empty() { Ok(()) } else { check_length(path, "half_size", count, self.half_size.len()) }
    }

    fn layout(&self, typeface: &Typeface) -> Drawing {
        let mut frame = self.frame(typeface);
        let range = self.color_range();
        let bar = ColorBar::new(typeface, range, self.beyond(range), &self.value_label, &frame);
        let titles = [frame.x.title(&self.x_label), frame.y.title(&self.y_label)];
        let margins = Margins::around(typeface, &frame, &bar, &titles);
        let notes = self.notes();
        let limit = COLUMN_WIDTH - 2.0 * RIM;
        let title = typeface.wrapped(self.title.as_deref().unwrap_or_default(), style::TITLE_SIZE, limit);
        let widest = |rows: &[String], size| rows.iter().map(|row| typeface.width(row, size)).fold(0.0, f64::max);
        let content = margins.left + frame.size[0] + margins.right;
        let width = content.max(widest(&title, style::TITLE_SIZE).max(widest(&notes, TICK_SIZE)) + 2.0 * RIM);
        frame.corner = [margins.left + 0.5 * (width - content), RIM + title_height(&title) + margins.above];
        let foot = frame.far_corner()[1] + margins.below;
        let mut page = Drawing::new(width, foot + notes.len() as f64 * NOTE_HEIGHT + RIM);
        draw_title(&mut page, typeface, &title, [0.5 * width, RIM]);
        self.draw_grid(&mut page, &frame);
        self.draw_particles(&mut page, &frame, range);
        self.draw_outline(&mut page, &frame);
        frame.draw(&mut page, typeface);
        frame.draw_titles(&mut page, typeface, [&titles[0], &titles[1]], [f64::INFINITY; 2]);
        bar.draw(&mut page, typeface, &frame);
        draw_notes(&mut page, typeface, &notes, foot);
        page
    }
}

/// Room around the framed area (pt).
struct Margins {
    left: f64,
    right: f64,
    above: f64,
    below: f64,
}

impl Margins {
    /// Room for numbers, titles and the colour bar. Titles may be longer than the sides that they name.
    fn around(typeface: &Typeface, frame: &Frame, bar: &ColorBar, titles: &[String; 2]) -> Self {
        let lengths = [0, 1].map(|axis| typeface.width(&titles[axis], LABEL_SIZE));
        let overhang = [0, 1].map(|axis| (0.5 * (lengths[axis] - frame.size[axis])).max(0.0));
        let beside = overhang[0].max(bar.overhang(frame));
        let along = overhang[1].max(bar.overhang_above(frame));
        Self {
            left: RIM + Frame::room_beside(typeface, &frame.y, frame.ticks).max(beside),
            right: RIM + bar.room_right().max(beside).max(TICK_SIZE),
            above: along.max(0.5 * TICK_SIZE),
            below: along.max(Frame::room_below(frame.ticks)) + bar.room_below(),
        }
    }
}

/// Writes the notes below each other, from the foot of the chart (pt) on.
fn draw_notes(page: &mut Drawing, typeface: &Typeface, notes: &[String], foot: f64) {
    for (index, note) in notes.iter().enumerate() {
        let anchor = [0.5 * page.width, foot + GAP + (index as f64 + 0.5) * NOTE_HEIGHT];
        typeface.draw(page, note, TICK_SIZE, anchor, (Align::Middle, Direction::Across));
    }
}

/// Whether a coordinate or value can be drawn.
fn can_draw(value: f64) -> bool {
    AxisScale::Linear.can_draw(value)
}

/// Points per unit of the data.
fn points_per_unit(frame: &Frame) -> f64 {
    frame.size[0] / (frame.x.high - frame.x.low)
}

/// The colour bar: beside the framed area, or below it if the area is low.
struct ColorBar {
    axis: Axis,
    title: String,
    title_width: f64,
    label_width: f64,
    length: f64,
    upright: bool,
    beyond: [bool; 2],
}

impl ColorBar {
    /// Chooses direction, length and ticks.
    fn new(typeface: &Typeface, range: [f64; 2], beyond: [bool; 2], label: &str, frame: &Frame) -> Self {
        let upright = frame.size[1] >= SMALLEST_BAR;
        let length = if upright { frame.size[1] } else { frame.size[0].max(100.0) };
        let build = |intervals| Axis::tight(range, intervals);
        let axis =
            Axis::finest(
                6,
                build,
                |axis| {
                    if upright { lines_fit(axis, length) } else { labels_fit(typeface, axis, length) }
                },
            );
        let title = axis.title(label);
        let title_width = typeface.width(&title, LABEL_SIZE);
        let widths = axis.ticks.iter().map(|tick| typeface.width(&tick.label, TICK_SIZE));
        let label_width = widths.fold(0.0, f64::max);
        Self { axis, title, title_width, label_width, length, upright, beyond }
    }

    /// Room beside the framed area (pt).
    fn room_right(&self) -> f64 {
        if !self.upright {
            return 0.5 * TICK_SIZE;
        }
        COLOR_BAR_GAP + COLOR_BAR_WIDTH + TICK_LENGTH + GAP + self.label_width + GAP + LABEL_SIZE
    }

    /// Room below the framed area and its titles (pt).
    fn room_below(&self) -> f64 {
        if self.upright { 0.0 } else { COLOR_BAR_GAP + COLOR_BAR_WIDTH + Frame::room_below(TickSide::Outside) }
    }

    /// How far a lying bar or its title stand out to either side of the framed area (pt).
    fn overhang(&self, frame: &Frame) -> f64 {
        let longest = self.title_width.max(self.length + self.label_width).max(self.length + 2.0 * COLOR_BAR_WIDTH);
        if self.upright { 0.0 } else { (0.5 * (longest - frame.size[0])).max(0.0) }
    }

    /// How far the title of an upright bar, or its pointed ends, stand out above and below the framed area (pt).
    fn overhang_above(&self, frame: &Frame) -> f64 {
        if !self.upright {
            return 0.0;
        }
        let points = if self.beyond == [false; 2] { 0.0 } else { COLOR_BAR_WIDTH };
        (0.5 * (self.title_width - frame.size[1])).max(points)
    }

    /// Start of the bar (its low end) on the page, and the place across it (pt).
    fn origin(&self, frame: &Frame) -> [f64; 2] {
        let [right, bottom] = frame.far_corner();
        if self.upright {
            return [right + COLOR_BAR_GAP, bottom];
        }
        let left = frame.corner[0] + 0.5 * (frame.size[0] - self.length);
        [left, bottom + Frame::room_below(frame.ticks) + COLOR_BAR_GAP]
    }

    /// The place on the page at a distance along the bar, and a distance across it towards its numbers (pt).
    fn place(&self, frame: &Frame, along: f64, across: f64) -> [f64; 2] {
        let [x, y] = self.origin(frame);
        if self.upright { [x + across, y - along] } else { [x + along, y + across] }
    }

    /// Draws the bar, its numbers and its title.
    fn draw(&self, page: &mut Drawing, typeface: &Typeface, frame: &Frame) {
        self.draw_colors(page, frame);
        self.draw_points(page, frame);
        let corners = [self.place(frame, 0.0, 0.0), self.place(frame, self.length, COLOR_BAR_WIDTH)];
        page.stroke("bar", rectangle(corners[0], corners[1]), Stroke::solid(INK, FRAME_WIDTH));
        for tick in &self.axis.ticks {
            self.draw_tick(page, typeface, frame, (self.axis.fraction(tick.value), &tick.label));
        }
        let (depth, direction) = if self.upright {
            (self.room_right() - COLOR_BAR_GAP - 0.5 * LABEL_SIZE, Direction::Upwards)
        } else {
            (COLOR_BAR_WIDTH + Frame::room_below(TickSide::Outside) - 0.5 * LABEL_SIZE, Direction::Across)
        };
        let anchor = self.place(frame, 0.5 * self.length, depth);
        typeface.draw(page, &self.title, LABEL_SIZE, anchor, (Align::Middle, direction));
    }

    /// Draws one tick and its number.
    fn draw_tick(&self, page: &mut Drawing, typeface: &Typeface, frame: &Frame, (fraction, label): (f64, &str)) {
        let along = fraction * self.length;
        let outer = COLOR_BAR_WIDTH + TICK_LENGTH;
        let ends = [self.place(frame, along, COLOR_BAR_WIDTH), self.place(frame, along, outer)];
        page.stroke("ticks", line(ends[0], ends[1]), Stroke::solid(INK, FRAME_WIDTH));
        let (align, gap) = if self.upright { (Align::Start, GAP) } else { (Align::Middle, GAP + 0.5 * TICK_SIZE) };
        let anchor = self.place(frame, along, outer + gap);
        typeface.draw(page, label, TICK_SIZE, anchor, (align, Direction::Across));
    }

    /// Draws the colours from high to low, each down to the low end, so that no seam shows between them.
    fn draw_colors(&self, page: &mut Drawing, frame: &Frame) {
        for level in (0..LEVELS).rev() {
            let end = self.length * (level + 1) as f64 / LEVELS as f64;
            let corners = [self.place(frame, 0.0, 0.0), self.place(frame, end, COLOR_BAR_WIDTH)];
            page.fill("colors", rectangle(corners[0], corners[1]), level_color(level));
        }
    }

    /// Draws the pointed ends beyond which there are values.
    fn draw_points(&self, page: &mut Drawing, frame: &Frame) {
        let ends = [(0.0, -1.0, 0), (self.length, 1.0, LEVELS - 1)];
        for (_, (along, outwards, level)) in self.beyond.into_iter().zip(ends).filter(|(beyond, _)| *beyond) {
            let tip = self.place(frame, along + outwards * 0.9 * COLOR_BAR_WIDTH, 0.5 * COLOR_BAR_WIDTH);
            let triangle = polygon(&[self.place(frame, along, 0.0), tip, self.place(frame, along, COLOR_BAR_WIDTH)]);
            page.fill("beyond", triangle.clone(), level_color(level));
            page.stroke("beyond", triangle, Stroke::solid(INK, FRAME_WIDTH));
        }
    }
}
