//! Text as outlines of an embedded typeface (Noto Sans Regular, SIL Open Font License 1.1, from the crate `notosans`).

use super::drawing::{Drawing, Segment, Shape, circle};
use super::style;
use ttf_parser::{Face, FaceParsingError, OutlineBuilder};

/// Width that a ringed digit takes, the radius of its ring and the thickness of that, as parts of the font size.
const RINGED_ADVANCE: f64 = 0.98;
const RING_RADIUS: f64 = 0.43;
const RING_WIDTH: f64 = 0.055;

/// Where a text lies along its line with regard to its anchor point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Align {
    /// The text starts at the point.
    Start,
    /// The middle of the text is at the point.
    Middle,
    /// The text ends at the point.
    End,
}

/// Direction of a line of text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Direction {
    /// From left to right.
    Across,
    /// From bottom to top, as along a vertical axis.
    Upwards,
}

/// The typeface of all figures.
pub(super) struct Typeface {
    face: Face<'static>,
}

impl Typeface {
    /// Reads the embedded typeface.
    pub(super) fn embedded() -> Result<Self, FaceParsingError> {
        Ok(Self { face: Face::parse(notosans::REGULAR_TTF, 0)? })
    }

    /// Width of a line of text (pt) at a font size (pt).
    pub(super) fn width(&self, text: &str, size: f64) -> f64 {
        text.chars().map(|character| self.advance(character)).sum::<f64>() * self.scale(size)
    }

    /// The font size, or a smaller one at which the text is not wider than `available` (pt), but not below 5 pt.
    pub(super) fn fitting_size(&self, text: &str, size: f64, available: f64) -> f64 {
        let width = self.width(text, size);
        if width <= available { size } else { (size * available / width).max(5.0) }
    }

    /// Breaks a text between words into lines not wider than `available` (pt), as far as its words allow.
    pub(super) fn wrapped(&self, text: &str, size: f64, available: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line} {word}"), size) <= available => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// Draws a line of text, its vertical middle at the anchor (pt).
    pub(super) fn draw(
        &self,
        page: &mut Drawing,
        text: &str,
        size: f64,
        anchor: [f64; 2],
        placing: (Align, Direction),
    ) {
        let (align, direction) = placing;
        let start = match align {
            Align::Start => 0.0,
            Align::Middle => -0.5 * self.width(text, size),
            Align::End => -self.width(text, size),
        };
        // Half the height of a digit below the middle is the baseline: numbers and labels look centred that way.
        let baseline =
            0.5 * self.face.capital_height().map_or(0.7 * size, |height| f64::from(height) * self.scale(size));
        let mut outline = Outline { path: Vec::new(), anchor, direction, offset: [start, 0.0], scale: 0.0 };
        for character in text.chars() {
            let form = Form::of(character);
            let advance = self.advance(character) * self.scale(size);
            let start = outline.offset[0];
            outline.scale = self.scale(size) * form.scale;
            outline.offset[1] = baseline - form.rise * size;
            if form.is_ringed {
                let digit = self.plain_advance(&form) * self.scale(size);
                outline.ring(start + 0.5 * advance, size);
                outline.offset = [start + 0.5 * (advance - digit), baseline * form.scale];
            }
            if let Some(glyph) = self.glyph(form.character) {
                self.face.outline_glyph(glyph, &mut outline);
            }
            outline.offset[0] = start + advance;
        }
        let words = Some(text.to_owned());
        page.add(Shape { path: outline.path, fill: Some(style::INK), class: "text", words, ..Shape::default() });
    }

    /// Points per font unit at a font size.
    fn scale(&self, size: f64) -> f64 {
        size / f64::from(self.face.units_per_em())
    }

    /// The glyph of a character. Characters that the typeface lacks get its box, so that they are seen to be missing.
    fn glyph(&self, character: char) -> Option<ttf_parser::GlyphId> {
        if character.is_control() {
            return None;
        }
        Some(self.face.glyph_index(character).unwrap_or(ttf_parser::GlyphId(0)))
    }

    /// Advance of a character in font units.
    fn advance(&self, character: char) -> f64 {
        let form = Form::of(character);
        if form.is_ringed { RINGED_ADVANCE * f64::from(self.face.units_per_em()) } else { self.plain_advance(&form) }
    }

    /// Advance of the glyph of a form in font units.
    fn plain_advance(&self, form: &Form) -> f64 {
        let advance = self.glyph(form.character).and_then(|glyph| self.face.glyph_hor_advance(glyph));
        form.scale * advance.map_or(0.0, f64::from)
    }
}

/// How a character is drawn: the typeface lacks some of the raised, lowered and ringed digits, so all are made from plain ones.
struct Form {
    character: char,
    /// Size as part of the font size.
    scale: f64,
    /// Height above the baseline as part of the font size.
    rise: f64,
    /// Whether it stands in a ring: ① to ⑨.
    is_ringed: bool,
}

impl Form {
    /// The form of a character.
    fn of(character: char) -> Self {
        let place = |list: &str| list.chars().position(|other| other == character);
        let plain = |place: usize| "0123456789−+".chars().nth(place).unwrap_or(character);
        if let Some(place) = place("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺") {
            return Self { character: plain(place), scale: 0.66, rise: 0.34, is_ringed: false };
        }
        if let Some(place) = place("₀₁₂₃₄₅₆₇₈₉₋₊") {
            return Self { character: plain(place), scale: 0.66, rise: -0.13, is_ringed: false };
        }
        if let Some(place) = place("①②③④⑤⑥⑦⑧⑨") {
            return Self { character: plain(place + 1), scale: 0.72, rise: 0.0, is_ringed: true };
        }
        Self { character, scale: 1.0, rise: 0.0, is_ringed: false }
    }
}

/// Collects the outline of a line of text, turned and moved to its place.
struct Outline {
    path: Vec<Segment>,
    anchor: [f64; 2],
    direction: Direction,
    offset: [f64; 2],
    scale: f64,
}

impl Outline {
    /// A point of a glyph (font units, y upwards) on the page (pt, y downwards).
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        let along = self.offset[0] + f64::from(x) * self.scale;
        let down = self.offset[1] - f64::from(y) * self.scale;
        match self.direction {
            Direction::Across => [self.anchor[0] + along, self.anchor[1] + down],
            Direction::Upwards => [self.anchor[0] + down, self.anchor[1] - along],
        }
    }
}

impl Outline {
    /// A ring around the middle of the line, its centre so far along it (pt), for a font size (pt).
    fn ring(&mut self, along: f64, size: f64) {
        let centre = match self.direction {
            Direction::Across => [self.anchor[0] + along, self.anchor[1]],
            Direction::Upwards => [self.anchor[0], self.anchor[1] - along],
        };
        self.path.extend(circle(centre, RING_RADIUS * size));
        // The other way round, so that the inside stays empty.
        let mirrored = |[x, y]: [f64; 2]| [x, 2.0 * centre[1] - y];
        let inside = circle(centre, (RING_RADIUS - RING_WIDTH) * size).into_iter().map(|segment| match segment {
            Segment::Move(to) => Segment::Move(mirrored(to)),
            Segment::Line(to) => Segment::Line(mirrored(to)),
            Segment::Quadratic(by, to) => Segment::Quadratic(mirrored(by), mirrored(to)),
            Segment::Cubic(from, by, to) => Segment::Cubic(mirrored(from), mirrored(by), mirrored(to)),
            Segment::Close => Segment::Close,
        });
        self.path.extend(inside);
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.push(Segment::Move(self.place(x, y)));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.path.push(Segment::Line(self.place(x, y)));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.path.push(Segment::Quadratic(self.place(x1, y1), self.place(x, y)));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.path.push(Segment::Cubic(self.place(x1, y1), self.place(x2, y2), self.place(x, y)));
    }

    fn close(&mut self) {
        self.path.push(Segment::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typeface_has_the_characters_that_geomechanics_needs() {
        let typeface = Typeface::embedded().unwrap();
        let missing: String = "−×·–°′²³⁰¹⁴⁵⁶⁷⁸⁹⁻₀₁₂₃①②⑨σταβγδεζηθκλμνξπρφχψωΔΣΩ"
            .chars()
            .filter(|character| typeface.face.glyph_index(Form::of(*character).character).is_none())
            .collect();
        assert_eq!(missing, "");
    }

    #[test]
    fn width_grows_with_text_and_size() {
        let typeface = Typeface::embedded().unwrap();
        assert_eq!(typeface.width("", 8.0), 0.0);
        assert!(typeface.width("kPa", 8.0) > typeface.width("kP", 8.0));
        assert!((typeface.width("kPa", 16.0) - 2.0 * typeface.width("kPa", 8.0)).abs() < 1e-12);
    }

    #[test]
    fn wrapped_lines_fit_and_keep_every_word() {
        let typeface = Typeface::embedded().unwrap();
        let title = "consolidation of a soft column under a ramp load";
        let lines = typeface.wrapped(title, 8.0, 80.0);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| typeface.width(line, 8.0) <= 80.0));
        assert_eq!(lines.join(" "), title);
    }
}
