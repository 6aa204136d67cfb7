//! Paper-quality pictures from plain data: every figure is saved as SVG and as PNG.
//!
//! The picture is laid out here, on a page measured in points, and written by two short writers: SVG text, and pixels
//! painted by `tiny-skia`. Text is drawn as outlines of an embedded typeface. So a figure needs no font, no browser and no
//! C library, looks the same everywhere, and has the same bytes each time it is made from the same data.
//!
//! Figures are as wide as one journal column (90 mm) where their shape allows. The caller scales the data to the units
//! named in the labels (kPa, mm). Values that are not finite are left out: a curve has a gap there, a particle is grey.

mod axis;
mod color_map;
mod drawing;
mod frame;
mod legend;
mod line_chart;
mod particle_chart;
mod style;
mod text;
mod trace;

pub use axis::AxisScale;
pub use line_chart::{Curve, LineChart, SecondAxis};
pub use particle_chart::ParticleChart;
pub use trace::CurveStyle;

use drawing::Drawing;
use std::error::Error;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use text::Typeface;

/// Why a figure could not be saved.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Two lists that belong together differ in length.
    #[error("figure {}: {name} has {found} entries, {expected} are needed", path.display())]
    Length {
        /// The figure, without extension.
        path: PathBuf,
        /// Which list.
        name: String,
        /// Number of entries that it should have.
        expected: usize,
        /// Number of entries that it has.
        found: usize,
    },
    /// The picture could not be drawn or encoded.
    #[error("figure {}: could not be drawn", path.display())]
    Draw {
        /// The figure, without extension.
        path: PathBuf,
        /// The cause.
        source: Box<dyn Error + Send + Sync>,
    },
    /// A file could not be written.
    #[error("figure file {} could not be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

/// A chart that can be laid out on a page.
trait Figure {
    /// Checks that the data are complete; `path` names the figure in the error.
    fn check(&self, path: &Path) -> Result<(), FigureError>;

    /// Lays out the figure.
    fn layout(&self, typeface: &Typeface) -> Drawing;
}

/// Draws a figure and writes its two files. Nothing is written before both are complete in memory.
fn save(figure: &impl Figure, path: &Path) -> Result<(), FigureError> {
    figure.check(path)?;
    let cannot_draw = |source| FigureError::Draw { path: path.to_owned(), source };
    let typeface = Typeface::embedded().map_err(|source| cannot_draw(source.into()))?;
    let page = figure.layout(&typeface);
    let svg = page.to_svg();
    let png = page.to_png().map_err(cannot_draw)?;
    replace_file(&with_ending(path, ".svg"), svg.as_bytes())?;
    replace_file(&with_ending(path, ".png"), &png)
}

/// Writes a file beside its place and then moves it there, so that a half-written file never has the name of a whole one.
fn replace_file(path: &Path, content: &[u8]) -> Result<(), FigureError> {
    let partial = with_ending(path, &format!(".{}.partial", std::process::id()));
    fs::write(&partial, content).and_then(|()| fs::rename(&partial, path)).map_err(|source| {
        // The first error is the one to report; the partial file may not even exist.
        let _ = fs::remove_file(&partial);
        FigureError::Write { path: path.to_owned(), source }
    })
}

/// The path with an ending put behind its whole name (`Path::with_extension` would cut a name such as `step-0.5`).
fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(ending);
    PathBuf::from(name)
}

/// Fails if a list does not have the expected number of entries.
fn check_length(path: &Path, name: &str, expected: usize, found: usize) -> Result<(), FigureError> {
    if expected == found {
        return Ok(());
    }
    Err(FigureError::Length { path: path.to_owned(), name: name.to_owned(), expected, found })
}

/// Writes the lines of the title below each other, centred.
fn draw_title(page: &mut Drawing, typeface: &Typeface, lines: &[String], [middle, top]: [f64; 2]) {
    for (index, line) in lines.iter().enumerate() {
        let anchor = [middle, top + (index as f64 + 0.5) * style::TITLE_SIZE * style::LINE_SPACING];
        typeface.draw(page, line, style::TITLE_SIZE, anchor, (text::Align::Middle, text::Direction::Across));
    }
}

/// Height of the title (pt), with a gap below it if there is one.
fn title_height(lines: &[String]) -> f64 {
    if lines.is_empty() { 0.0 } else { lines.len() as f64 * style::TITLE_SIZE * style::LINE_SPACING + 1.5 * style::GAP }
}

#[cfg(test)]
mod tests;
