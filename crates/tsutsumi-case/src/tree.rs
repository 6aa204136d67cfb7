//! The tree of a TOML text, each key and value with its place in the text.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::key_path::{KeyPath, Segment};

/// A value and its place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tree {
    pub span: Range<usize>,
    pub value: Value,
}

/// A value of TOML, with all strings owned.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    String(String),
    /// `None` beyond 64 bits.
    Integer(Option<i64>),
    /// `None` beyond the range of `f64`.
    Float(Option<f64>),
    Boolean(bool),
    Date,
    Array(Vec<Tree>),
    Table(BTreeMap<String, Entry>),
}

/// A value of a table and the place of its key.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub key_span: Range<usize>,
    pub tree: Tree,
}

/// Why a text is not TOML.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SyntaxFault {
    pub message: String,
    pub span: Option<Range<usize>>,
}

/// The value at a path, or the nearest one around it.
pub(crate) struct Found<'a> {
    pub tree: &'a Tree,
    pub key_span: Option<Range<usize>>,
    /// Whether the path was followed to its end.
    pub is_exact: bool,
}

impl Tree {
    /// Reads a whole TOML text.
    pub(crate) fn read_document(text: &str) -> Result<Self, SyntaxFault> {
        let table = DeTable::parse(text).map_err(SyntaxFault::from)?;
        Ok(Self { span: table.span(), value: Value::from(DeValue::Table(table.into_inner())) })
    }

    /// Reads a single TOML value.
    pub(crate) fn read_value(text: &str) -> Result<Self, SyntaxFault> {
        DeValue::parse(text).map(Self::from).map_err(SyntaxFault::from)
    }

    /// Follows a path as far as it leads.
    pub(crate) fn find(&self, segments: &[Segment]) -> Found<'_> {
        let mut found = Found { tree: self, key_span: None, is_exact: true };
        for segment in segments {
            match found.tree.child(segment) {
                Some((tree, key_span)) => found = Found { tree, key_span, is_exact: true },
                None => {
                    return Found { is_exact: false, ..found };
                }
            }
        }
        found
    }

    /// The value at a path, if there is one.
    pub(crate) fn get(&self, path: &KeyPath) -> Option<&Self> {
        let found = self.find(path.segments());
        found.is_exact.then_some(found.tree)
    }

    /// A number is an index into an array and a key in a table, whichever way it was meant.
    fn child(&self, segment: &Segment) -> Option<(&Self, Option<Range<usize>>)> {
        match (&self.value, segment) {
            (Value::Table(table), Segment::Key(name)) => table.get(name).map(Entry::parts),
            (Value::Table(table), Segment::Index(index)) => table.get(&index.to_string()).map(Entry::parts),
            (Value::Array(array), Segment::Index(index)) => array.get(*index).map(|tree| (tree, None)),
            (Value::Array(array), Segment::Key(name)) => {
                array.get(name.parse::<usize>().ok()?).map(|tree| (tree, None))
            }
            _ => None,
        }
    }
}

impl Entry {
    fn parts(&self) -> (&Tree, Option<Range<usize>>) {
        (&self.tree, Some(self.key_span.clone()))
    }
}

impl From<toml::de::Error> for SyntaxFault {
    fn from(error: toml::de::Error) -> Self {
        Self { message: error.message().to_owned(), span: error.span() }
    }
}

impl From<Spanned<DeValue<'_>>> for Tree {
    fn from(value: Spanned<DeValue<'_>>) -> Self {
        Self { span: value.span(), value: Value::from(value.into_inner()) }
    }
}

impl From<DeValue<'_>> for Value {
    fn from(value: DeValue<'_>) -> Self {
        match value {
            DeValue::String(text) => Self::String(text.into_owned()),
            DeValue::Integer(integer) => Self::Integer(i64::from_str_radix(integer.as_str(), integer.radix()).ok()),
            DeValue::Float(float) => Self::Float(finite_or_literal(float.as_str())),
            DeValue::Boolean(value) => Self::Boolean(value),
            DeValue::Datetime(_) => Self::Date,
            DeValue::Array(array) => Self::Array(array.into_iter().map(Tree::from).collect()),
            DeValue::Table(table) => {
                let entries = table.into_iter().map(|(key, tree)| {
                    let entry = Entry { key_span: key.span(), tree: Tree::from(tree) };
                    (key.into_inner().into_owned(), entry)
                });
                Self::Table(entries.collect())
            }
        }
    }
}

/// `inf` and `nan` are numbers of TOML; a number that overflows to infinity is not.
fn finite_or_literal(text: &str) -> Option<f64> {
    let is_literal = text.contains("inf") || text.contains("nan");
    text.parse().ok().filter(|number: &f64| number.is_finite() || is_literal)
}
