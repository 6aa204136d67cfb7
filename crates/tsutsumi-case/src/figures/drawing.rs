//! A page of filled and stroked paths, written as SVG text or painted as PNG pixels.
//!
//! Text is a filled path too (see [`super::text`]). So both files show the same picture on every machine, whatever fonts
//! are installed there, and the two writers stay short.

use super::style::{self, Color};
use std::fmt::Write;
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke as SkiaStroke, StrokeDash, Transform};

/// One piece of a path; points are (x, y) on the page (pt), y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Segment {
    /// Starts a new piece.
    Move([f64; 2]),
    /// Straight line to the point.
    Line([f64; 2]),
    /// Quadratic curve: control point, end point.
    Quadratic([f64; 2], [f64; 2]),
    /// Cubic curve: two control points, end point.
    Cubic([f64; 2], [f64; 2], [f64; 2]),
    /// Straight line back to the start of the piece.
    Close,
}

impl Segment {
    /// Where the segment ends; not a number after a close, whose end is not known here.
    fn end(self) -> [f64; 2] {
        match self {
            Self::Move(end) | Self::Line(end) | Self::Quadratic(_, end) | Self::Cubic(_, _, end) => end,
            Self::Close => [f64::NAN; 2],
        }
    }
}

/// How the outline of a path is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    /// Colour of the line.
    pub(super) color: Color,
    /// Width (pt).
    pub(super) width: f64,
    /// Drawn and blank lengths in turn (pt), an even number of them; empty for a solid line.
    pub(super) dash: &'static [f64],
}

impl Stroke {
    /// A solid line.
    pub(super) fn solid(color: Color, width: f64) -> Self {
        Self { color, width, dash: &[] }
    }
}

/// A path with its paint.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Shape {
    /// The path.
    pub(super) path: Vec<Segment>,
    /// Colour of the inside, if it is painted.
    pub(super) fill: Option<Color>,
    /// Outline, if it is drawn.
    pub(super) stroke: Option<Stroke>,
    /// What the shape is: a class name in the SVG, for tests and for editing by hand.
    pub(super) class: &'static str,
    /// The words that the shape draws, for screen readers and for searching the SVG.
    pub(super) words: Option<String>,
}

/// A page.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawing {
    /// Page width (pt).
    pub(super) width: f64,
    /// Page height (pt).
    pub(super) height: f64,
    /// Shapes, painted in this order.
    shapes: Vec<Shape>,
}

impl Drawing {
    /// A white page.
    pub(super) fn new(width: f64, height: f64) -> Self {
        let (width, height) = (width.ceil(), height.ceil());
        let mut page = Self { width, height, shapes: Vec::new() };
        page.fill("page", rectangle([0.0, 0.0], [width, height]), style::PAPER);
        page
    }

    /// Adds a shape on top of the others; an empty path is left out.
    pub(super) fn add(&mut self, shape: Shape) {
        if !shape.path.is_empty() {
            self.shapes.push(shape);
        }
    }

    /// Adds a filled path.
    pub(super) fn fill(&mut self, class: &'static str, path: Vec<Segment>, color: Color) {
        self.add(Shape { path, fill: Some(color), class, ..Shape::default() });
    }

    /// Adds a stroked path.
    pub(super) fn stroke(&mut self, class: &'static str, path: Vec<Segment>, stroke: Stroke) {
        self.add(Shape { path, stroke: Some(stroke), class, ..Shape::default() });
    }

    /// The page as a self-contained SVG document.
    pub(super) fn to_svg(&self) -> String {
        let (width, height) = (number(self.width), number(self.height));
        let mut svg = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
             width=\"{width}pt\" height=\"{height}pt\" viewBox=\"0 0 {width} {height}\">\n"
        );
        for shape in &self.shapes {
            svg.push_str(&svg_element(shape));
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// The page as a PNG file without transparency, with its resolution noted in it.
    pub(super) fn to_png(&self) -> Result<Vec<u8>, Box<dyn std::error::Error + Send + Sync>> {
        let scale = style::PIXELS_PER_POINT;
        let (width, height) = ((self.width * scale) as u32, (self.height * scale) as u32);
        let mut pixels = Pixmap::new(width, height).ok_or("the page is too large")?;
        for shape in &self.shapes {
            paint(&mut pixels, shape, Transform::from_scale(scale as f32, scale as f32));
        }
        // The page is painted white first, so every pixel is opaque and needs no transparency channel.
        let opaque: Vec<u8> = pixels.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        encode_png(width, height, &opaque)
    }
}

/// One `<path>` element and its line end.
fn svg_element(shape: &Shape) -> String {
    let mut element = String::from("<path");
    if !shape.class.is_empty() {
        let _ = write!(element, " class=\"{}\"", shape.class);
    }
    if let Some(words) = &shape.words {
        let _ = write!(element, " role=\"img\" aria-label=\"{}\"", escaped(words));
    }
    let fill = shape.fill.map_or_else(|| String::from("none"), Color::hexadecimal);
    let _ = write!(element, " fill=\"{fill}\"");
    if let Some(stroke) = &shape.stroke {
        element.push_str(&svg_stroke(stroke));
    }
    let _ = writeln!(element, " d=\"{}\"/>", svg_path(&shape.path));
    element
}

/// The attributes of an outline.
fn svg_stroke(stroke: &Stroke) -> String {
    let mut attributes = format!(
        " stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
        stroke.color.hexadecimal(),
        number(stroke.width)
    );
    if !stroke.dash.is_empty() {
        let lengths: Vec<String> = stroke.dash.iter().map(|length| number(*length)).collect();
        let _ = write!(attributes, " stroke-dasharray=\"{}\"", lengths.join(" "));
    }
    attributes
}

/// The `d` attribute of a path. Lines along an axis get the short forms, which halves the size of a field of rectangles.
fn svg_path(path: &[Segment]) -> String {
    let mut text = String::new();
    let mut last = [f64::NAN; 2];
    for segment in path {
        let _ = match *segment {
            Segment::Move(end) => write!(text, "M{}", point(end)),
            Segment::Line([x, y]) if y == last[1] => write!(text, "H{}", number(x)),
            Segment::Line([x, y]) if x == last[0] => write!(text, "V{}", number(y)),
            Segment::Line(end) => write!(text, "L{}", point(end)),
            Segment::Quadratic(control, end) => write!(text, "Q{} {}", point(control), point(end)),
            Segment::Cubic(first, second, end) => write!(text, "C{} {} {}", point(first), point(second), point(end)),
            Segment::Close => write!(text, "Z"),
        };
        last = segment.end();
    }
    text
}

/// The two coordinates of a point.
fn point([x, y]: [f64; 2]) -> String {
    format!("{} {}", number(x), number(y))
}

/// A length with at most two decimals (0.01 pt is a third of a hundredth of a millimetre).
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { String::from("0") } else { short.to_owned() }
}

/// The words with XML's special characters escaped, and without characters that XML forbids.
fn escaped(words: &str) -> String {
    let mut text = String::new();
    for character in words.chars() {
        match character {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => {}
            other if other.is_control() => text.push(' '),
            other => text.push(other),
        }
    }
    text
}

/// Paints one shape. A path without extent has nothing to paint, and is left out.
fn paint(pixels: &mut Pixmap, shape: &Shape, transform: Transform) {
    let Some(path) = skia_path(&shape.path) else { return };
    if let Some(color) = shape.fill {
        pixels.fill_path(&path, &skia_paint(color), FillRule::Winding, transform, None);
    }
    if let Some(stroke) = &shape.stroke {
        pixels.stroke_path(&path, &skia_paint(stroke.color), &skia_stroke(stroke), transform, None);
    }
}

/// The path as the painter wants it.
fn skia_path(path: &[Segment]) -> Option<tiny_skia::Path> {
    let mut builder = PathBuilder::new();
    let narrow = |point: [f64; 2]| (point[0] as f32, point[1] as f32);
    for segment in path {
        match *segment {
            Segment::Move(end) => builder.move_to(narrow(end).0, narrow(end).1),
            Segment::Line(end) => builder.line_to(narrow(end).0, narrow(end).1),
            Segment::Quadratic(control, end) => {
                builder.quad_to(narrow(control).0, narrow(control).1, narrow(end).0, narrow(end).1);
            }
            Segment::Cubic(first, second, end) => {
                let (first, second, end) = (narrow(first), narrow(second), narrow(end));
                builder.cubic_to(first.0, first.1, second.0, second.1, end.0, end.1);
            }
            Segment::Close => builder.close(),
        }
    }
    builder.finish()
}

/// The colour as the painter wants it.
fn skia_paint(color: Color) -> Paint<'static> {
    let [red, green, blue] = color.0;
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

/// The outline as the painter wants it.
fn skia_stroke(stroke: &Stroke) -> SkiaStroke {
    let lengths = stroke.dash.iter().map(|length| *length as f32).collect();
    SkiaStroke {
        width: stroke.width as f32,
        line_cap: LineCap::Butt,
        line_join: LineJoin::Round,
        dash: StrokeDash::new(lengths, 0.0),
        ..SkiaStroke::default()
    }
}

/// Encodes red, green and blue bytes, row by row from the top.
fn encode_png(width: u32, height: u32, pixels: &[u8]) -> Result<Vec<u8>, Box<dyn std::error::Error + Send + Sync>> {
    let pixels_per_metre = (style::PIXELS_PER_POINT * 72.0 / 0.0254).round() as u32;
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: pixels_per_metre,
        yppu: pixels_per_metre,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(file)
}

/// Path of a straight line.
pub(super) fn line(from: [f64; 2], to: [f64; 2]) -> Vec<Segment> {
    vec![Segment::Move(from), Segment::Line(to)]
}

/// Path of a rectangle between two opposite corners.
pub(super) fn rectangle(from: [f64; 2], to: [f64; 2]) -> Vec<Segment> {
    polygon(&[from, [to[0], from[1]], to, [from[0], to[1]]])
}

/// Path of a closed polygon.
pub(super) fn polygon(corners: &[[f64; 2]]) -> Vec<Segment> {
    let mut path = polyline(corners);
    if !path.is_empty() {
        path.push(Segment::Close);
    }
    path
}

/// Path of straight lines from point to point.
pub(super) fn polyline(points: &[[f64; 2]]) -> Vec<Segment> {
    let mut path = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        path.push(if index == 0 { Segment::Move(*point) } else { Segment::Line(*point) });
    }
    path
}

/// Path of a circle, four cubic curves.
pub(super) fn circle([x, y]: [f64; 2], radius: f64) -> Vec<Segment> {
    // Control length at which a cubic quarter touches the circle at its middle: 4/3 tan(π/8).
    let control = radius * 0.552_284_75;
    vec![
        Segment::Move([x + radius, y]),
        Segment::Cubic([x + radius, y + control], [x + control, y + radius], [x, y + radius]),
        Segment::Cubic([x - control, y + radius], [x - radius, y + control], [x - radius, y]),
        Segment::Cubic([x - radius, y - control], [x - control, y - radius], [x, y - radius]),
        Segment::Cubic([x + control, y - radius], [x + radius, y - control], [x + radius, y]),
        Segment::Close,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_never_minus_zero() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(100.0), "100");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(-2.504), "-2.5");
    }

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(escaped("a<b & \"c\"\u{1}"), "a&lt;b &amp; &quot;c&quot; ");
    }

    #[test]
    fn png_is_white_where_nothing_is_drawn_and_coloured_where_something_is() {
        let mut page = Drawing::new(10.0, 10.0);
        page.fill("", rectangle([0.0, 0.0], [5.0, 10.0]), Color([10, 200, 30]));
        let file = page.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((frame.width, frame.height), (50, 50));
        assert_eq!(pixels[..3], [10, 200, 30]);
        assert_eq!(pixels[49 * 3..50 * 3], [255, 255, 255]);
    }
}
