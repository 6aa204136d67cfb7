//! The text of a case: read, overridden, parsed, with every complaint at its place.

use std::fs::{self, File};
use std::io::{self, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;

use crate::deserializer::{Fault, FaultKind, Part, deserialize};
use crate::error::{CaseError, Location, Problem, ProblemKind, did_you_mean, quoted};
use crate::file_kind::{FileKind, SIZE_LIMIT};
use crate::key_path::KeyPath;
use crate::overrides::{Override, set_value};
use crate::schema::Case;
use crate::syntax::explain_syntax;
use crate::tree::{SyntaxFault, Tree, Value};

/// Names that a message lists before it stops.
const LISTED_NAMES: usize = 24;

/// A case or study file as text, with the overrides that were put on it.
#[derive(Debug, Clone)]
pub struct CaseSource {
    kind: FileKind,
    path: PathBuf,
    original: Sheet,
    effective: Sheet,
    overrides: Vec<Override>,
}

/// A text and its tree, or why it has none.
#[derive(Debug, Clone)]
struct Sheet {
    text: Arc<str>,
    tree: Result<Tree, SyntaxFault>,
}

impl Sheet {
    fn new(text: impl Into<Arc<str>>) -> Self {
        let text = text.into();
        let tree = Tree::read_document(&text);
        Self { text, tree }
    }
}

impl CaseSource {
    /// Reads a case file. What it says is not looked at yet.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, CaseError> {
        Self::read_kind(path.as_ref(), FileKind::Case)
    }

    /// Reads a file of some kind.
    pub(crate) fn read_kind(path: &Path, kind: FileKind) -> Result<Self, CaseError> {
        let text = read_text(path, kind)?;
        match text.trim_start_matches('\u{feff}').trim().is_empty() {
            true => Err(CaseError::Empty { path: path.to_owned(), kind }),
            false => Ok(Self::from_text_of_kind(path, text, kind)),
        }
    }

    /// A case from a text in memory; messages call it by `path`.
    pub fn from_text(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self::from_text_of_kind(path, text, FileKind::Case)
    }

    /// A file of some kind from a text in memory.
    pub(crate) fn from_text_of_kind(path: impl Into<PathBuf>, text: impl Into<String>, kind: FileKind) -> Self {
        let original = Sheet::new(text.into());
        Self { kind, path: path.into(), effective: original.clone(), original, overrides: Vec::new() }
    }

    /// A path that the file gives, taken from the folder of the file.
    pub(crate) fn beside(&self, path: &str) -> PathBuf {
        self.path.parent().map_or_else(|| PathBuf::from(path), |folder| folder.join(path))
    }

    /// The path of the case file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text as it was read.
    pub fn original_text(&self) -> &str {
        &self.original.text
    }

    /// The text with the overrides in it, comments kept: what runs, and what is saved beside the results.
    pub fn text(&self) -> &str {
        &self.effective.text
    }

    /// The overrides, `key=value`, in the order they were given.
    pub fn overrides(&self) -> impl Iterator<Item = &str> {
        self.overrides.iter().map(Override::assignment)
    }

    /// Sets one value: `key=value`, where the key is a path such as `loads.0.applied_to` and the value is TOML or a bare
    /// word. Whether the key means anything is found when the case is parsed.
    pub fn with_override(mut self, assignment: &str) -> Result<Self, CaseError> {
        self.syntax_check()?;
        let problem = |fault| CaseError::content(vec![Override::problem(&self.path, assignment, fault)]);
        let mut setting = Override::read(assignment).map_err(problem)?;
        let text = set_value(&self.effective.text, &mut setting).map_err(problem)?;
        self.effective = Sheet::new(text);
        self.overrides.push(setting);
        Ok(self)
    }

    /// The case that the text describes. Run [`Self::validate`] on it before use.
    pub fn parse(&self) -> Result<Case, CaseError> {
        self.parse_at(&KeyPath::root())
    }

    /// The value at a path, such as `materials.soil.parameters`, as a type of the caller's. A value that is absent is
    /// read as an empty table. Unknown keys are errors whether or not the type denies them.
    pub fn parse_at<T: DeserializeOwned>(&self, path: &KeyPath) -> Result<T, CaseError> {
        let root = self.syntax_check()?;
        let absent = Tree { span: 0..0, value: Value::Table(Default::default()) };
        let tree = root.get(path).unwrap_or(&absent);
        deserialize(tree, path).map_err(|faults| {
            let faults = without_consequences(faults);
            CaseError::content(faults.into_iter().map(|fault| self.problem_of(fault)).collect())
        })
    }

    /// An error about a value that does not make sense, shown where the key stands (or the nearest table around it). An
    /// empty `help` shows none.
    pub fn invalid(&self, key: impl Into<KeyPath>, message: impl Into<String>, help: impl Into<String>) -> CaseError {
        CaseError::Content(vec![self.invalid_problem(key.into(), message.into(), help.into())])
    }

    pub(crate) fn invalid_problem(&self, key: KeyPath, message: String, help: String) -> Problem {
        let help = Some(help).filter(|help| !help.is_empty());
        self.problem(ProblemKind::Invalid, key, Part::Value, message, help)
    }

    fn syntax_check(&self) -> Result<&Tree, CaseError> {
        self.effective.tree.as_ref().map_err(|fault| {
            let (message, help) = explain_syntax(fault, &self.effective.text);
            let location = self.location(self.effective.text.clone(), fault.span.clone());
            let key = KeyPath::root();
            CaseError::Content(vec![Problem { kind: ProblemKind::Syntax, key, message, help, notes: vec![], location }])
        })
    }

    fn location(&self, text: Arc<str>, span: Option<Range<usize>>) -> Location {
        Location { path: self.path.clone(), text, span, is_override: false }
    }

    fn problem(&self, kind: ProblemKind, key: KeyPath, part: Part, message: String, help: Option<String>) -> Problem {
        let (location, note) = self.locate(&key, part);
        Problem { kind, key, message, help, notes: note.into_iter().collect(), location }
    }

    /// Where a key or its value stands in the file, or the nearest table around it.
    pub(crate) fn place_of(&self, key: &KeyPath, part: Part) -> Location {
        self.locate(key, part).0
    }

    /// What the file is in messages about itself: `the case`.
    fn itself(&self) -> String {
        format!("the {}", self.kind.name())
    }

    /// Where a key stands, for people: in the override that set it, or else in the file as they wrote it.
    fn locate(&self, key: &KeyPath, part: Part) -> (Location, Option<String>) {
        if let Some(setting) = self.overrides.iter().rev().find(|setting| key.starts_with(setting.path())) {
            return (setting.location(&self.path, key, part), self.note_on_override(setting));
        }
        let Ok(tree) = &self.original.tree else {
            return (self.location(self.original.text.clone(), None), None);
        };
        let found = tree.find(key.segments());
        if !found.is_exact
            && let Some(setting) = self.overrides.iter().rev().find(|setting| setting.path().starts_with(key))
        {
            return (setting.location(&self.path, key, Part::Key), self.note_on_override(setting));
        }
        let span = match (part, found.is_exact, found.key_span) {
            (Part::Key, true, Some(span)) => span,
            _ => found.tree.span.clone(),
        };
        (self.location(self.original.text.clone(), Some(span).filter(|span| !span.is_empty())), None)
    }

    /// What the file itself says where an override has replaced it.
    fn note_on_override(&self, setting: &Override) -> Option<String> {
        let set_by = format!("set by `{}`", quoted(setting.text()));
        let Some(tree) = self.original.tree.as_ref().ok()?.get(setting.path()) else {
            return Some(set_by);
        };
        let location = self.location(self.original.text.clone(), Some(tree.span.clone()));
        let (line, _) = location.line_and_column()?;
        let value = match tree.value {
            Value::Table(_) | Value::Array(_) => "something else".to_owned(),
            _ => describe(tree, &self.original.text),
        };
        Some(format!("{set_by}; line {line} of the file says {value}"))
    }

    fn problem_of(&self, fault: Fault) -> Problem {
        let (key, part) = fault.place.unwrap_or((KeyPath::root(), Part::Value));
        match fault.kind {
            FaultKind::UnknownKey { name, known } => self.unknown_key(key, &name, &known),
            FaultKind::MissingKey { name } => self.missing_key(key, &name),
            FaultKind::WrongType { expected } => self.wrong_type(key, part, &expected),
            FaultKind::UnknownName { name, known } => self.unknown_name(key, part, &name, &known),
            FaultKind::Other { message } => {
                let message = format!("{} {message}", in_quotes(&key, &self.itself()));
                self.problem(ProblemKind::Invalid, key, part, message, None)
            }
        }
    }

    fn unknown_key(&self, key: KeyPath, name: &str, known: &[String]) -> Problem {
        let parent = parent_of(&key);
        let place = if parent.is_root() { "at the top level".to_owned() } else { format!("in `{parent}`") };
        let help = match did_you_mean(name, known.iter().map(String::as_str)) {
            Some(near) => Some(format!("did you mean `{near}`?")),
            None => self.misplaced(name, &parent),
        };
        let message = format!("unknown key `{}` {place}", quoted(name));
        let mut problem = self.problem(ProblemKind::UnknownKey, key, Part::Key, message, help);
        let note =
            if known.is_empty() { "no key is known here".to_owned() } else { format!("known keys: {}", list(known)) };
        problem.notes.insert(0, note);
        problem
    }

    /// Help for a key that is known, but elsewhere.
    fn misplaced(&self, name: &str, parent: &KeyPath) -> Option<String> {
        let homes = self.kind.keys().homes_of(name);
        match homes.as_slice() {
            [] => None,
            [top] if top.is_empty() => {
                Some(format!("`{name}` belongs to the top level: move it up, before the first line in brackets"))
            }
            homes if homes.iter().any(|home| *home == parent.to_string()) => None,
            homes => Some(format!("`{name}` belongs to {}", list(homes))),
        }
    }

    fn missing_key(&self, table: KeyPath, name: &str) -> Problem {
        let place = if table.is_root() { String::new() } else { format!(" in `{table}`") };
        let help = match self.kind.keys().description_of(&table, name) {
            Some(description) => format!("add `{name}`: {}", in_passing(&description)),
            None => format!("add `{name} = …`"),
        };
        self.problem(ProblemKind::MissingKey, table, Part::Value, format!("missing key `{name}`{place}"), Some(help))
    }

    fn wrong_type(&self, key: KeyPath, part: Part, expected: &str) -> Problem {
        let found = self.found_instead(&key, expected);
        let message = format!("{} must be {expected}, not {found}", in_quotes(&key, &self.itself()));
        let help = self.type_help(&key, expected);
        self.problem(ProblemKind::WrongType, key, part, message, help)
    }

    /// What stands where something else was expected.
    fn found_instead(&self, key: &KeyPath, expected: &str) -> String {
        let tree = self.effective.tree.as_ref().ok().and_then(|tree| tree.get(key));
        match tree.map(|tree| (&tree.value, tree)) {
            Some((Value::Table(table), _)) if expected.starts_with("a table with") => {
                format!("one with {}", table.len())
            }
            Some((_, tree)) => describe(tree, &self.effective.text),
            None => "this".to_owned(),
        }
    }

    fn type_help(&self, key: &KeyPath, expected: &str) -> Option<String> {
        let tree = self.effective.tree.as_ref().ok()?.get(key)?;
        match &tree.value {
            Value::String(text) if expected.contains("number") && text.trim().parse::<f64>().is_ok() => {
                Some(format!("numbers stand without quotes: {}", text.trim()))
            }
            Value::Table(_) if self.kind.keys().is_list_of_tables(&key.to_string()) => {
                Some(format!("an element of `{key}` is written with double brackets: [[{key}]]"))
            }
            Value::Integer(_) | Value::Float(_) | Value::String(_) if expected == "an array" => {
                Some(format!("lists are written in brackets: [{}, …]", describe(tree, &self.effective.text)))
            }
            Value::Float(Some(number)) if expected.starts_with("a whole number") && number.fract() == 0.0 => {
                Some(format!("write it without a decimal point: {number}"))
            }
            Value::Array(_) if expected == "a table" && !key.is_root() => {
                Some(format!("`{key}` stands once, in single brackets: [{key}]"))
            }
            _ => None,
        }
    }

    fn unknown_name(&self, key: KeyPath, part: Part, name: &str, known: &[String]) -> Problem {
        let place = if part == Part::Key { parent_of(&key) } else { key.clone() };
        let help = match did_you_mean(name, known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None if known.len() == 1 => format!("write {}", list(known)),
            None => format!("write one of {}", list(known)),
        };
        let message = format!("unknown word `{}` for `{place}`", quoted(name));
        let mut problem = self.problem(ProblemKind::UnknownName, key, part, message, Some(help.clone()));
        if !help.starts_with("write") {
            problem.notes.insert(0, format!("known words: {}", list(known)));
        }
        problem
    }
}

fn read_text(path: &Path, kind: FileKind) -> Result<String, CaseError> {
    let unreadable = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => CaseError::Missing { path: path.to_owned(), kind },
        _ => CaseError::Unreadable { path: path.to_owned(), source },
    };
    // The kind and the size come first: to open a pipe can wait for ever, and to read a device never ends.
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(CaseError::Folder { path: path.to_owned(), kind });
    }
    if !metadata.is_file() {
        return Err(CaseError::NotRegular { path: path.to_owned(), kind });
    }
    if metadata.len() > SIZE_LIMIT {
        return Err(CaseError::TooLarge { path: path.to_owned(), kind, size: metadata.len() });
    }
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(SIZE_LIMIT + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 > SIZE_LIMIT {
        return Err(CaseError::TooLarge { path: path.to_owned(), kind, size: bytes.len() as u64 });
    }
    String::from_utf8(bytes).map_err(|error| not_utf8(path, error.as_bytes(), error.utf8_error().valid_up_to()))
}

fn not_utf8(path: &Path, bytes: &[u8], offset: usize) -> CaseError {
    let guess = match bytes {
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Some("UTF-16 text"),
        [0x1F, 0x8B, ..] => Some("a gzip file"),
        [b'P', b'K', 3, 4, ..] => Some("a zip file"),
        [0x89, b'H', b'D', b'F', ..] => Some("an HDF5 file"),
        _ => None,
    };
    let line = bytes.iter().take(offset).filter(|&&byte| byte == b'\n').count() + 1;
    CaseError::NotUtf8 { path: path.to_owned(), offset, line, guess }
}

/// Leaves out a missing key where an unknown key looks like it, in the same table or fallen from the top level into
/// another one: one mistake, one message.
fn without_consequences(faults: Vec<Fault>) -> Vec<Fault> {
    let is_consequence = |fault: &Fault| match (&fault.kind, &fault.place) {
        (FaultKind::MissingKey { name: missing }, Some((table, _))) => faults.iter().any(|other| match other {
            Fault { kind: FaultKind::UnknownKey { name, known }, place: Some((key, _)) } => {
                let is_typo = || did_you_mean(name, known.iter().map(String::as_str)) == Some(missing);
                let is_misplaced = table.is_root() && name == missing;
                is_misplaced || (parent_of(key) == *table && is_typo())
            }
            _ => false,
        }),
        _ => false,
    };
    faults.iter().filter(|fault| !is_consequence(fault)).cloned().collect()
}

fn parent_of(key: &KeyPath) -> KeyPath {
    let segments = key.segments();
    segments[..segments.len().saturating_sub(1)].iter().cloned().collect()
}

fn in_quotes(key: &KeyPath, root: &str) -> String {
    if key.is_root() { root.to_owned() } else { format!("`{key}`") }
}

/// A description as the end of a sentence.
fn in_passing(description: &str) -> String {
    let mut characters = description.trim_end_matches('.').chars();
    let first = characters.next().map(|first| first.to_lowercase().to_string());
    first.unwrap_or_default() + characters.as_str()
}

/// Names in backquotes, with commas.
pub(crate) fn list<S: AsRef<str>>(names: &[S]) -> String {
    let shown: Vec<_> = names.iter().take(LISTED_NAMES).map(|name| format!("`{}`", quoted(name.as_ref()))).collect();
    let rest = names.len().saturating_sub(LISTED_NAMES);
    if rest > 0 { format!("{} and {rest} more", shown.join(", ")) } else { shown.join(", ") }
}

/// A value as a message names it: scalars as they are written, the rest by kind.
fn describe(tree: &Tree, text: &str) -> String {
    match &tree.value {
        Value::Array(elements) if elements.is_empty() => "an empty array".to_owned(),
        Value::Array(elements) => format!("an array of {}", elements.len()),
        Value::Table(_) => "a table".to_owned(),
        Value::Date => "a date".to_owned(),
        _ => quoted(text.get(tree.span.clone()).unwrap_or("this").lines().next().unwrap_or("this")),
    }
}
