//! Quantities that are compared and drawn: columns of histories and their rates, with units and names for people.

use std::fmt;

/// A column of a history, or its change from output to output over time.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Quantity {
    /// The column of `history.csv`.
    pub column: String,
    /// Whether it is the column's change over time.
    pub is_rate: bool,
}

/// What sort of number a quantity is, and how figures show it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measure {
    /// In words: `pore pressure`.
    pub(super) word: String,
    /// Its unit in tables and files; empty if it is not known.
    pub(super) unit: String,
    /// Its unit in figures.
    pub(super) shown_unit: String,
    /// What turns a number of the table into one of a figure.
    pub(super) factor: f64,
    /// Whether figures draw it downwards.
    pub(super) grows_down: bool,
}

impl Quantity {
    /// Reads `column` or `rate(column)`.
    pub fn read(text: &str) -> Self {
        let text = text.trim();
        match text.strip_prefix("rate(").and_then(|rest| rest.strip_suffix(')')) {
            Some(column) => Quantity { column: column.trim().to_owned(), is_rate: true },
            None => Quantity { column: text.to_owned(), is_rate: false },
        }
    }

    pub(super) fn measure(&self) -> Measure {
        let (word, unit, shown_unit, factor, grows_down) = measure_of_column(&self.column);
        let mut measure = Measure {
            word: word.to_owned(),
            unit: unit.to_owned(),
            shown_unit: shown_unit.to_owned(),
            factor,
            grows_down: grows_down && !self.is_rate,
        };
        if self.is_rate {
            measure.word = if word.is_empty() { self.to_string() } else { format!("{word} rate") };
            for unit in [&mut measure.unit, &mut measure.shown_unit].into_iter().filter(|unit| !unit.is_empty()) {
                unit.push_str("/s");
            }
        } else if word.is_empty() {
            measure.word = self.column.clone();
        }
        measure
    }

    /// What the legend of a figure calls it: the probe or the kind of reading.
    pub(super) fn place(&self) -> String {
        match self.column.as_str() {
            "settlement.particles" => "top particles".to_owned(),
            "settlement.surface" => "surface".to_owned(),
            column => column.rsplit_once(".pressure").map_or(column, |(probe, _)| probe).to_owned(),
        }
    }
}

/// Word, unit, unit in figures, factor between them, and whether it is drawn downwards.
fn measure_of_column(column: &str) -> (&'static str, &'static str, &'static str, f64, bool) {
    let is_component = |of: &str| ["x", "y", "z"].iter().any(|axis| column.ends_with(&format!(".{of}.{axis}")));
    match column {
        "time" => ("time", "s", "s", 1.0, false),
        "outflow" => ("outflow", "m³", "m³", 1.0, false),
        "energy.kinetic" => ("kinetic energy", "J", "J", 1.0, false),
        "energy.strain" => ("strain energy", "J", "J", 1.0, false),
        "energy.potential" => ("potential energy", "J", "J", 1.0, false),
        "energy.total" => ("energy", "J", "J", 1.0, false),
        "noise.velocity" => ("velocity that the grid cannot see", "–", "–", 1.0, false),
        "error.displacement" => ("error of the displacement", "–", "–", 1.0, false),
        "error.velocity" => ("error of the velocity", "–", "–", 1.0, false),
        "error.energy" => ("error of the energy", "–", "–", 1.0, false),
        _ if column.starts_with("angular_momentum.") => ("angular momentum", "kg m²/s", "kg m²/s", 1.0, false),
        _ if column.starts_with("settlement.") => ("settlement", "m", "mm", 1e3, true),
        _ if column.ends_with(".pressure") => ("pore pressure", "Pa", "kPa", 1e-3, false),
        _ if is_component("displacement") => ("displacement", "m", "mm", 1e3, false),
        _ if is_component("velocity") => ("velocity", "m/s", "mm/s", 1e3, false),
        _ => ("", "", "", 1.0, false),
    }
}

impl Measure {
    /// The title of an axis: the word, or another one, with the unit in round brackets.
    pub(super) fn title(&self, word: Option<&str>) -> String {
        let word = word.unwrap_or(&self.word);
        match self.shown_unit.as_str() {
            "" => word.to_owned(),
            unit => format!("{word} ({unit})"),
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.is_rate {
            true => write!(f, "rate({})", self.column),
            false => f.write_str(&self.column),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_print_as_they_are_read() {
        for text in ["base.pressure", "rate(settlement.surface)"] {
            assert_eq!(Quantity::read(text).to_string(), text);
        }
        assert_eq!(Quantity::read(" rate( outflow ) ").column, "outflow");
    }

    #[test]
    fn units_follow_from_the_column() {
        let title = |text: &str| Quantity::read(text).measure().title(None);
        assert_eq!(title("base.pressure"), "pore pressure (kPa)");
        assert_eq!(title("top.displacement.y"), "displacement (mm)");
        assert_eq!(title("rate(settlement.surface)"), "settlement rate (mm/s)");
        assert_eq!(title("rate(contact.force)"), "rate(contact.force)");
        assert_eq!(Quantity::read("rate(outflow)").measure().unit, "m³/s");
    }
}
