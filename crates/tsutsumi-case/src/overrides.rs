//! One value set from the command line: `--set time.step=auto`.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, TableLike, Value};

use crate::deserializer::Part;
use crate::error::{Location, Problem, ProblemKind, quoted};
use crate::key_path::{KeyPath, Segment, split};
use crate::syntax::explain_syntax;
use crate::tree::{self, SyntaxFault, Tree};

/// What stands before an override where it is shown.
const OPTION: &str = "--set ";

/// An override that has been read: which key, which value, and how it was written.
#[derive(Debug, Clone)]
pub(crate) struct Override {
    /// `--set key=value`.
    text: Arc<str>,
    path: KeyPath,
    /// Where the key stands in the text.
    key_span: Range<usize>,
    /// Where the value begins in the text.
    value_start: usize,
    tree: Tree,
    value: Value,
}

/// Why an override cannot be applied; the span counts in `key=value`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OverrideFault {
    message: String,
    help: String,
    span: Range<usize>,
}

impl Override {
    /// Takes `key=value` apart.
    pub(crate) fn read(assignment: &str) -> Result<Self, OverrideFault> {
        let all = 0..assignment.len();
        let Some(equals) = equals_sign(assignment) else {
            return Err(fault(
                format!("the override `{}` has no `=`", quoted(assignment)),
                "write key=value, such as time.step=auto",
                all,
            ));
        };
        let key_span = trimmed(assignment, 0..equals);
        let value_span = trimmed(assignment, equals + 1..assignment.len());
        let path = read_key(assignment, key_span.clone())?;
        let (tree, value) = read_value(assignment, value_span.clone())?;
        Ok(Self {
            text: format!("{OPTION}{assignment}").into(),
            path,
            key_span: shifted(key_span, OPTION.len()),
            value_start: value_span.start + OPTION.len(),
            tree,
            value,
        })
    }

    /// The problem that a fault of an override is.
    pub(crate) fn problem(case: &Path, assignment: &str, fault: OverrideFault) -> Problem {
        let location = Location {
            path: case.to_owned(),
            text: format!("{OPTION}{assignment}").into(),
            span: Some(shifted(fault.span, OPTION.len())),
            is_override: true,
        };
        let help = Some(fault.help).filter(|help| !help.is_empty());
        let key = KeyPath::from(assignment.split('=').next().unwrap_or_default().trim());
        Problem { kind: ProblemKind::Override, key, message: fault.message, help, notes: Vec::new(), location }
    }

    /// The key that is set.
    pub(crate) fn path(&self) -> &KeyPath {
        &self.path
    }

    /// `--set key=value`.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// `key=value`.
    pub(crate) fn assignment(&self) -> &str {
        self.text.strip_prefix(OPTION).unwrap_or(&self.text)
    }

    /// The place of a key at or below the one that is set.
    pub(crate) fn location(&self, case: &Path, key: &KeyPath, part: Part) -> Location {
        let inner = key.segments().get(self.path.segments().len()..).unwrap_or_default();
        let found = self.tree.find(inner);
        let span = match (part, found.key_span) {
            (Part::Key, None) if inner.is_empty() => self.key_span.clone(),
            (Part::Key, Some(span)) => shifted(span, self.value_start),
            _ => shifted(found.tree.span.clone(), self.value_start),
        };
        Location { path: case.to_owned(), text: self.text.clone(), span: Some(span), is_override: true }
    }
}

fn fault(message: impl Into<String>, help: impl Into<String>, span: Range<usize>) -> OverrideFault {
    OverrideFault { message: message.into(), help: help.into(), span }
}

fn shifted(span: Range<usize>, by: usize) -> Range<usize> {
    span.start + by..span.end + by
}

fn trimmed(text: &str, span: Range<usize>) -> Range<usize> {
    let part = text.get(span.clone()).unwrap_or_default();
    let start = span.start + (part.len() - part.trim_start().len());
    start..start + part.trim().len()
}

/// The first `=` that is not within a quoted key.
fn equals_sign(assignment: &str) -> Option<usize> {
    let mut quote = None;
    for (at, character) in assignment.char_indices() {
        match (quote, character) {
            (None, '=') => return Some(at),
            (None, '"' | '\'') => quote = Some(character),
            (Some(open), _) if open == character => quote = None,
            _ => {}
        }
    }
    None
}

fn read_key(assignment: &str, span: Range<usize>) -> Result<KeyPath, OverrideFault> {
    let text = &assignment[span.clone()];
    let segments = split(text);
    let is_empty = |(segment, quoted): &(Segment, bool)| *segment == Segment::Key(String::new()) && !quoted;
    match segments.is_empty() || segments.iter().any(is_empty) {
        true if text.is_empty() => {
            Err(fault("the override has no key", "write key=value, such as time.step=auto", 0..0))
        }
        true => Err(fault(
            format!("the override's key `{}` has an empty part", quoted(text)),
            "parts of a key are separated by single dots: time.step",
            span,
        )),
        false => Ok(segments.into_iter().map(|(segment, _)| segment).collect()),
    }
}

fn read_value(assignment: &str, span: Range<usize>) -> Result<(Tree, Value), OverrideFault> {
    let text = &assignment[span.clone()];
    if text.is_empty() {
        let help = format!(
            "for an empty string, write {}=\"\" (and quote it for the shell)",
            quoted(assignment.trim_end_matches(['=', ' ']))
        );
        return Err(fault(format!("the override `{}` has no value", quoted(assignment)), help, 0..assignment.len()));
    }
    if let (Ok(tree), Ok(value)) = (Tree::read_value(text), text.parse()) {
        return Ok((tree, value));
    }
    if is_bare_word(text) {
        return Ok((Tree { span: 0..text.len(), value: tree::Value::String(text.to_owned()) }, Value::from(text)));
    }
    Err(not_toml(text, span))
}

/// A word that can stand for a string without quotes.
fn is_bare_word(text: &str) -> bool {
    let is_inner = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    text.starts_with(|c: char| c.is_alphabetic() || c == '_') && text.chars().all(is_inner)
}

fn not_toml(text: &str, span: Range<usize>) -> OverrideFault {
    let syntax = Tree::read_value(text).err();
    let syntax = syntax.unwrap_or(SyntaxFault { message: "number out of range".to_owned(), span: None });
    let begins_as_word = text.starts_with(char::is_alphabetic);
    let (message, help) = match begins_as_word && !text.contains(['"', '\'']) {
        true => (
            format!("`{}` is not a value of TOML", quoted(text)),
            Some(format!(
                "a text needs double quotes, and single ones around them for the shell: '\"{}\"'",
                quoted(text)
            )),
        ),
        false => explain_syntax(&syntax, text),
    };
    let inner = syntax.span.filter(|inner| inner.end <= text.len()).unwrap_or(0..text.len());
    let place = if begins_as_word { span } else { shifted(inner, span.start) };
    fault(format!("the override's value is not TOML: {message}"), help.unwrap_or_default(), place)
}

/// Puts an override into a text. Its path becomes definite: what is an element and what is a key.
pub(crate) fn set_value(text: &str, setting: &mut Override) -> Result<String, OverrideFault> {
    let span = setting.key_span.start - OPTION.len()..setting.key_span.end - OPTION.len();
    let stopped = |message: String, help: String| fault(message, help, span.clone());
    let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| {
        stopped(format!("cannot edit the case: {}", error.message()), String::new())
    })?;
    let mut walk = Walk { value: setting.value.clone(), path: KeyPath::root() };
    let segments = setting.path.segments().to_vec();
    walk.set_in_table(document.as_table_mut(), &segments).map_err(|(message, help)| stopped(message, help))?;
    setting.path = walk.path;
    let text = document.to_string();
    let written = Tree::read_document(&text).ok();
    match written.as_ref().and_then(|tree| tree.get(&setting.path)) {
        Some(tree) if same(&tree.value, &setting.tree.value) => Ok(text),
        _ => Err(stopped(
            "the override cannot be written into this case file".to_owned(),
            "set the value in the file".to_owned(),
        )),
    }
}

/// Whether two values are the same, wherever they stand; nan equals nan.
fn same(left: &tree::Value, right: &tree::Value) -> bool {
    use tree::Value::{Array, Float, Table};
    match (left, right) {
        (Float(left), Float(right)) => left.map(f64::to_bits) == right.map(f64::to_bits),
        (Array(left), Array(right)) => {
            left.len() == right.len() && left.iter().zip(right).all(|(left, right)| same(&left.value, &right.value))
        }
        (Table(left), Table(right)) => {
            left.keys().eq(right.keys())
                && left.values().zip(right.values()).all(|(left, right)| same(&left.tree.value, &right.tree.value))
        }
        _ => left == right,
    }
}

type Stopped = (String, String);

/// A walk down a document to the value that is set.
struct Walk {
    value: Value,
    /// The path walked so far.
    path: KeyPath,
}

impl Walk {
    fn set_in_table(&mut self, table: &mut dyn TableLike, segments: &[Segment]) -> Result<(), Stopped> {
        let Some((segment, rest)) = segments.split_first() else {
            return Ok(());
        };
        let name = match segment {
            Segment::Key(name) => name.clone(),
            Segment::Index(index) => index.to_string(),
        };
        self.path = std::mem::take(&mut self.path).key(&name);
        if rest.is_empty() {
            self.put(table, &name);
            return Ok(());
        }
        if table.get(&name).is_none_or(Item::is_none) {
            if let Some(Segment::Index(index)) = rest.first() {
                let message = format!("the case has no `{0}`, so there is no `{0}.{index}`", self.path);
                return Err((message, format!("set it as a whole: {}=[…]", self.path)));
            }
            table.insert(&name, Item::Value(Value::InlineTable(InlineTable::new())));
        }
        match table.get_mut(&name) {
            Some(Item::Value(value)) => self.set_in_value(value, rest),
            Some(Item::Table(table)) => self.set_in_table(table, rest),
            Some(Item::ArrayOfTables(array)) => self.set_in_array_of_tables(array, rest),
            _ => Ok(()),
        }
    }

    /// Replaces a value and keeps the comment behind it, or adds a new one.
    fn put(&self, table: &mut dyn TableLike, name: &str) {
        if let Some(Item::Value(old)) = table.get_mut(name) {
            self.replace(old);
            return;
        }
        table.remove(name);
        table.insert(name, Item::Value(self.value.clone()));
    }

    fn replace(&self, old: &mut Value) {
        let decor = old.decor().clone();
        *old = self.value.clone();
        *old.decor_mut() = decor;
    }

    fn set_in_value(&mut self, value: &mut Value, segments: &[Segment]) -> Result<(), Stopped> {
        match value {
            Value::InlineTable(table) => self.set_in_table(table, segments),
            Value::Array(array) => {
                let (index, rest) = self.element(segments, array.len())?;
                match array.get_mut(index) {
                    Some(element) if rest.is_empty() => self.replace(element),
                    Some(element) => self.set_in_value(element, rest)?,
                    None => {}
                }
                Ok(())
            }
            _ => Err((
                format!("`{}` is not a table: nothing can be set in it", self.path),
                format!("set `{}` itself", self.path),
            )),
        }
    }

    fn set_in_array_of_tables(&mut self, array: &mut ArrayOfTables, segments: &[Segment]) -> Result<(), Stopped> {
        let (index, rest) = self.element(segments, array.len())?;
        let Some(element) = array.get_mut(index) else {
            return Ok(());
        };
        if !rest.is_empty() {
            return self.set_in_table(element, rest);
        }
        let Value::InlineTable(table) = &self.value else {
            return Err((
                format!("`{}` is a table: it can only be set to another table", self.path),
                "write { key = value, … }".to_owned(),
            ));
        };
        let position = element.position();
        *element = table.clone().into_table();
        element.set_position(position);
        Ok(())
    }

    fn element<'s>(&mut self, segments: &'s [Segment], len: usize) -> Result<(usize, &'s [Segment]), Stopped> {
        let path = self.path.clone();
        let Some((segment, rest)) = segments.split_first() else {
            return Ok((0, &[]));
        };
        let Segment::Index(index) = segment else {
            return Err((
                format!("`{path}` is a list: the key has to say which element"),
                format!("count from 0: `{path}.0`"),
            ));
        };
        if *index >= len {
            let elements = if len == 1 { "element" } else { "elements" };
            let help = if len == 0 {
                "add it in the file".to_owned()
            } else {
                format!("the last one is `{path}.{}`", len - 1)
            };
            return Err((format!("`{path}` has {len} {elements}, counted from 0: there is no `{path}.{index}`"), help));
        }
        self.path = std::mem::take(&mut self.path).index(*index);
        Ok((*index, rest))
    }
}
