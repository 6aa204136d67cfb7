//! The shared look of all figures: every size, font size and colour stands here and nowhere else.
//!
//! Lengths are in typographic points (1 pt = 1/72 inch = 0.353 mm) at the printed size.

/// Red, green, blue (0 to 255 each).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Color(pub(super) [u8; 3]);

impl Color {
    /// The colour as SVG writes it, `#rrggbb`.
    pub(super) fn hexadecimal(self) -> String {
        let [red, green, blue] = self.0;
        format!("#{red:02x}{green:02x}{blue:02x}")
    }
}

/// Width of a single journal column, 90 mm (pt).
pub(super) const COLUMN_WIDTH: f64 = 255.0;
/// Height of the framed area of a line chart (pt).
pub(super) const CHART_HEIGHT: f64 = 158.0;
/// Height of each framed area where there are two below each other (pt).
pub(super) const PANEL_HEIGHT: f64 = 104.0;
/// Gap between framed areas below each other (pt).
pub(super) const PANEL_GAP: f64 = 8.0;
/// Largest framed area of a particle chart, width and height (pt).
pub(super) const PARTICLE_AREA: [f64; 2] = [172.0, 230.0];
/// White rim around every figure (pt).
pub(super) const RIM: f64 = 4.0;

/// Font size of the title (pt).
pub(super) const TITLE_SIZE: f64 = 8.5;
/// Font size of axis titles (pt).
pub(super) const LABEL_SIZE: f64 = 8.0;
/// Font size of tick numbers and the legend (pt).
pub(super) const TICK_SIZE: f64 = 7.5;
/// Line spacing as a multiple of the font size.
pub(super) const LINE_SPACING: f64 = 1.35;

/// Width of frames and ticks (pt).
pub(super) const FRAME_WIDTH: f64 = 0.6;
/// Width of curves (pt).
pub(super) const CURVE_WIDTH: f64 = 1.1;
/// Width of thin curves (pt).
pub(super) const THIN_CURVE_WIDTH: f64 = 0.6;
/// Width of background grid lines (pt).
pub(super) const GRID_WIDTH: f64 = 0.35;
/// Length of major ticks (pt).
pub(super) const TICK_LENGTH: f64 = 3.0;
/// Length of minor ticks (pt).
pub(super) const MINOR_TICK_LENGTH: f64 = 1.6;
/// Gap between frame and tick numbers, and between tick numbers and axis titles (pt).
pub(super) const GAP: f64 = 3.5;
/// Half of the width of a marker (pt).
pub(super) const MARKER_RADIUS: f64 = 2.0;
/// Length of the curve sample in the legend (pt).
pub(super) const SAMPLE_LENGTH: f64 = 22.0;
/// Width of the colour bar (pt).
pub(super) const COLOR_BAR_WIDTH: f64 = 8.0;
/// Gap between the framed area and the colour bar (pt).
pub(super) const COLOR_BAR_GAP: f64 = 10.0;

/// Pixels of the PNG per point: 5 gives 360 dots per inch, above the 300 that journals ask for.
pub(super) const PIXELS_PER_POINT: f64 = 5.0;

/// Text, frames and ticks.
pub(super) const INK: Color = Color([0, 0, 0]);
/// Page and legend background.
pub(super) const PAPER: Color = Color([255, 255, 255]);
/// Background grid lines.
pub(super) const GRID: Color = Color([190, 190, 190]);
/// Faint lines at the tick numbers of a line chart.
pub(super) const GUIDE: Color = Color([232, 232, 232]);
/// Particles without a finite value, notes such as "no data".
pub(super) const MUTED: Color = Color([140, 140, 140]);

/// Curve colours, the set of Okabe and Ito without its yellow (too light on paper), darkest first.
///
/// # Reference
///
/// Okabe and Ito (2008), Color Universal Design: how to make figures that are friendly to colour-blind people.
pub(super) const CURVE_COLORS: [Color; 7] = [
    Color([0, 0, 0]),
    Color([213, 94, 0]),
    Color([0, 114, 178]),
    Color([0, 158, 115]),
    Color([204, 121, 167]),
    Color([230, 159, 0]),
    Color([86, 180, 233]),
];

/// Long dashes: drawn, gap (pt).
pub(super) const DASHED: &[f64] = &[5.0, 2.5];
/// Dots: drawn, gap (pt).
pub(super) const DOTTED: &[f64] = &[1.2, 1.8];
/// Dash and dot: drawn, gap, drawn, gap (pt).
pub(super) const DASH_DOTTED: &[f64] = &[6.0, 1.8, 1.2, 1.8];
