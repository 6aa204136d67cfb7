//! Where a value stands in a case file: `bodies[0].shape.box.max`.

use std::fmt;

/// One step of a [`KeyPath`].
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Segment {
    /// A key of a table.
    Key(String),
    /// An element of an array, or of an array of tables, counted from 0.
    Index(usize),
}

/// Where a value stands in a case file, from the top: `materials.soil.porosity`, `bodies[0].shape.box.max[1]`.
///
/// Made from text by `From<&str>`, which never fails: dots separate, `[1]` and `.1` are elements, and a key with other
/// characters than letters, digits, `-` and `_` stands in quotes (`materials."soft clay".density`).
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyPath(Vec<Segment>);

impl KeyPath {
    /// The case file itself.
    pub fn root() -> Self {
        Self::default()
    }

    /// The path one key deeper. The name is taken as it is, dots and all.
    #[must_use]
    pub fn key(mut self, name: impl Into<String>) -> Self {
        self.0.push(Segment::Key(name.into()));
        self
    }

    /// The path one array element deeper.
    #[must_use]
    pub fn index(mut self, index: usize) -> Self {
        self.0.push(Segment::Index(index));
        self
    }

    /// The steps from the top.
    pub fn segments(&self) -> &[Segment] {
        &self.0
    }

    /// Whether this is the case file itself.
    pub fn is_root(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether `parent` is this path or a table or array around it.
    pub fn starts_with(&self, parent: &KeyPath) -> bool {
        self.0.starts_with(&parent.0)
    }
}

impl FromIterator<Segment> for KeyPath {
    fn from_iter<I: IntoIterator<Item = Segment>>(segments: I) -> Self {
        Self(segments.into_iter().collect())
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (position, segment) in self.0.iter().enumerate() {
            match segment {
                Segment::Index(index) => write!(formatter, "[{index}]")?,
                Segment::Key(name) => {
                    let dot = if position > 0 { "." } else { "" };
                    match is_bare(name) {
                        true => write!(formatter, "{dot}{name}")?,
                        false => write!(formatter, "{dot}{name:?}")?,
                    }
                }
            }
        }
        Ok(())
    }
}

impl From<&str> for KeyPath {
    fn from(text: &str) -> Self {
        Self(split(text).into_iter().map(|(segment, _)| segment).collect())
    }
}

impl From<String> for KeyPath {
    fn from(text: String) -> Self {
        Self::from(text.as_str())
    }
}

impl From<&KeyPath> for KeyPath {
    fn from(path: &KeyPath) -> Self {
        path.clone()
    }
}

/// Whether TOML takes the name without quotes.
pub(crate) fn is_bare(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}

/// The segments of a path as text, each with whether it was quoted. Every text has an answer; empty names are kept, so
/// that a caller who minds (`a..b`) can see them.
pub(crate) fn split(text: &str) -> Vec<(Segment, bool)> {
    let mut segments = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let (segment, quoted, after) = first_segment(rest);
        segments.push((segment, quoted));
        rest = match after.strip_prefix('.') {
            Some("") => {
                segments.push((Segment::Key(String::new()), false));
                ""
            }
            Some(next) => next,
            None => after,
        };
    }
    segments
}

fn first_segment(text: &str) -> (Segment, bool, &str) {
    if let Some((index, after)) = bracketed_index(text) {
        return (Segment::Index(index), false, after);
    }
    for quote in ['"', '\''] {
        if let Some((name, after)) = text.strip_prefix(quote).and_then(|inner| inner.split_once(quote)) {
            return (Segment::Key(name.to_owned()), true, after);
        }
    }
    let first = text.chars().next().map_or(0, char::len_utf8);
    let end =
        if text.starts_with('.') { 0 } else { text[first..].find(['.', '[']).map_or(text.len(), |at| at + first) };
    let (name, after) = text.split_at(end);
    match name.parse() {
        Ok(index) => (Segment::Index(index), false, after),
        Err(_) => (Segment::Key(name.to_owned()), false, after),
    }
}

fn bracketed_index(text: &str) -> Option<(usize, &str)> {
    let (digits, after) = text.strip_prefix('[')?.split_once(']')?;
    Some((digits.parse().ok()?, after))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_print_as_they_are_read() {
        for text in ["", "a", "a.b_c.d-e", "bodies[0].shape.box.max[1]", "materials.\"soft clay\".density"] {
            assert_eq!(KeyPath::from(text).to_string(), text);
        }
        assert_eq!(KeyPath::from("loads.0.on"), KeyPath::from("loads[0].on"));
    }

    #[test]
    fn odd_paths_end() {
        for text in ["..", "a..b", "[", "a[", "a]", "[0", "\"", "'a", "é.ø[", ".a", "a.", "[[0]]"] {
            let _ = KeyPath::from(text).to_string();
        }
        assert_eq!(split("a..b").len(), 3);
        assert_eq!(split("a.").len(), 2);
        assert_eq!(split(".a").len(), 2);
    }
}
