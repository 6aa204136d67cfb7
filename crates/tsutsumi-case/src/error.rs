//! What is wrong with a case file, and how it is told.

use std::fmt;
use std::io;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use annotate_snippets::{
    Annotation, AnnotationKind, Group, Level, Origin, Padding, Renderer, Snippet, normalize_untrusted_str as printable,
};
use thiserror::Error;

use crate::file_kind::{FileKind, SIZE_LIMIT};
use crate::key_path::KeyPath;

/// Problems shown in full; more are counted.
const SHOWN_PROBLEMS: usize = 20;
/// Characters of a source line shown; longer lines are cut around the place.
const SHOWN_COLUMNS: usize = 120;
/// Characters of a message shown.
const SENTENCE_CHARACTERS: usize = 600;
/// Characters of a name or value from the file that a message repeats.
const QUOTED_CHARACTERS: usize = 40;

/// What is wrong with a case or study file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CaseError {
    /// There is no such file.
    #[error("there is no {} file `{}`", kind.name(), path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// What the file should have been.
        kind: FileKind,
    },
    /// The path is a folder.
    #[error("`{}` is a folder, not a {} file", path.display(), kind.name())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the file should have been.
        kind: FileKind,
    },
    /// The path is a device, a pipe or a socket.
    #[error("`{}` is not a regular file", path.display())]
    NotRegular {
        /// The path.
        path: PathBuf,
        /// What the file should have been.
        kind: FileKind,
    },
    /// The file is larger than [`SIZE_LIMIT`].
    #[error("`{}` is too large for a {} file: {} bytes", path.display(), kind.name(), size)]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What the file should have been.
        kind: FileKind,
        /// Its size, or how much of it had been read when it turned out too large (bytes).
        size: u64,
    },
    /// The file is not text.
    #[error("`{}` is not UTF-8 text: see byte {offset} (line {line})", path.display())]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// Position of the first bad byte, from 0.
        offset: usize,
        /// Its line, from 1.
        line: usize,
        /// What the file seems to be, if that can be told.
        guess: Option<&'static str>,
    },
    /// There is nothing in the file.
    #[error("the {} file `{}` is empty", kind.name(), path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// What the file should have been.
        kind: FileKind,
    },
    /// The file cannot be read.
    #[error("cannot read `{}`", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        source: io::Error,
    },
    /// The content is wrong, in the order of the file.
    #[error("{}", summary(.0))]
    Content(Vec<Problem>),
}

/// One thing that is wrong in the content of a case file or of an override.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// What sort of problem.
    pub kind: ProblemKind,
    /// The key it is about.
    pub key: KeyPath,
    /// What is wrong: lower case, names the key and the value.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// What else is good to know.
    pub notes: Vec<String>,
    /// Where it stands.
    pub location: Location,
}

/// What sort of problem a [`Problem`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ProblemKind {
    /// The text is not TOML.
    Syntax,
    /// An override that cannot be applied.
    Override,
    /// A key that nobody reads.
    UnknownKey,
    /// A key that has to be there.
    MissingKey,
    /// A value of the wrong type.
    WrongType,
    /// A word that is not among the known ones.
    UnknownName,
    /// A value that makes no sense, by itself or beside others.
    Invalid,
}

/// Where a problem stands: in the file as it was read, or in an override.
#[derive(Debug, Clone, PartialEq)]
pub struct Location {
    /// The case file.
    pub path: PathBuf,
    /// The text that `span` counts in: that of the file, or `--set key=value`.
    pub text: Arc<str>,
    /// The place, in bytes of `text`; `None` is the text as a whole.
    pub span: Option<Range<usize>>,
    /// Whether `text` is an override.
    pub is_override: bool,
}

impl CaseError {
    /// The problems in the content; none if the file could not be read.
    pub fn problems(&self) -> &[Problem] {
        match self {
            Self::Content(problems) => problems,
            _ => &[],
        }
    }

    /// All errors as one: `Ok` if there is none; the first one of those that are not about content, if any.
    pub fn all(errors: impl IntoIterator<Item = CaseError>) -> Result<(), CaseError> {
        let mut all = Vec::new();
        for error in errors {
            match error {
                Self::Content(problems) => all.extend(problems),
                other => return Err(other),
            }
        }
        match all.is_empty() {
            true => Ok(()),
            false => Err(Self::content(all)),
        }
    }

    /// Problems in the order of the file, those in overrides last.
    pub(crate) fn content(mut problems: Vec<Problem>) -> Self {
        problems.sort_by_key(|problem| (problem.location.is_override, problem.location.start()));
        Self::Content(problems)
    }

    /// The error for people, in the manner of a compiler. Ends without a newline.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let Self::Content(problems) = self else {
            return self.render_file_error(&renderer);
        };
        let mut blocks: Vec<_> =
            problems.iter().take(SHOWN_PROBLEMS).map(|problem| problem.render(&renderer)).collect();
        if let Some(last) = count_line(problems) {
            blocks.push(renderer.render(&[Group::with_title(Level::ERROR.primary_title(last))]));
        }
        blocks.join("\n\n")
    }

    fn render_file_error(&self, renderer: &Renderer) -> String {
        let mut group = Group::with_title(Level::ERROR.primary_title(printable(&self.to_string())));
        if let Self::Unreadable { source, .. } = self {
            group = group.element(Level::NOTE.message(printable(&source.to_string())));
        }
        if let Some(help) = self.file_help() {
            group = group.element(Level::HELP.message(help));
        }
        renderer.render(&[group])
    }

    fn file_help(&self) -> Option<String> {
        let help = match self {
            Self::Missing { path, .. } if path.is_relative() => match std::env::current_dir() {
                Ok(folder) => format!("the path is taken from the folder `{}`", printable(&folder.to_string_lossy())),
                Err(_) => return None,
            },
            Self::Folder { path, kind } => {
                let file = path.join(format!("{}.toml", kind.name()));
                format!("give the file in it, such as `{}`", file.display())
            }
            Self::NotRegular { kind, .. } => {
                format!("a {} is read from a file, not from a device or a pipe", kind.name())
            }
            Self::TooLarge { .. } => format!("the limit is {SIZE_LIMIT} bytes: is this a results file?"),
            Self::NotUtf8 { guess: Some(guess), .. } => format!("it looks like {guess}: save it as UTF-8"),
            Self::NotUtf8 { .. } => "save it as UTF-8".to_owned(),
            Self::Empty { kind: FileKind::Study, .. } => {
                "a study needs at least title, case and variants (`tsutsumi schema --study` tells it all)".to_owned()
            }
            Self::Empty { .. } => "a case needs at least title, dimension, grid, time, materials, bodies and output \
                                   (`tsutsumi schema` tells it all)"
                .to_owned(),
            _ => return None,
        };
        Some(help)
    }
}

fn summary(problems: &[Problem]) -> String {
    match problems {
        [] => "the case file has a problem".to_owned(),
        [only] => only.to_string(),
        [first, rest @ ..] => format!("{first} (and {} more)", rest.len()),
    }
}

fn count_line(problems: &[Problem]) -> Option<String> {
    let path = printable(&problems.first()?.location.path.to_string_lossy());
    match (problems.len(), problems.len().saturating_sub(SHOWN_PROBLEMS)) {
        (..=1, _) => None,
        (count, 0) => Some(format!("{count} problems in `{path}`")),
        (count, hidden) => Some(format!("{count} problems in `{path}`, of which {hidden} are not shown")),
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", sentence(&self.message))?;
        match self.location.line_and_column() {
            _ if self.location.is_override => write!(formatter, " ({})", sentence(&self.location.text)),
            Some((line, column)) => write!(formatter, " ({}:{line}:{column})", self.location.path.display()),
            None => write!(formatter, " ({})", self.location.path.display()),
        }
    }
}

impl Problem {
    fn render(&self, renderer: &Renderer) -> String {
        let mut group = self.location.show(Level::ERROR.primary_title(sentence(&self.message)));
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(sentence(help)));
        }
        for note in &self.notes {
            group = group.element(Level::NOTE.message(sentence(note)));
        }
        self.location.with_column_of_file(renderer.render(&[group]))
    }
}

/// A line of source, cut to a sensible length, with the place in it.
#[derive(Debug, PartialEq)]
struct Excerpt {
    line: String,
    span: Range<usize>,
}

impl Location {
    /// Line and column of the place, both from 1, the column in characters.
    pub fn line_and_column(&self) -> Option<(usize, usize)> {
        let start = floor_boundary(&self.text, self.span.as_ref()?.start);
        let before = &self.text[..start];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line = before.bytes().filter(|&byte| byte == b'\n').count() + 1;
        Some((line, before[line_start..].chars().filter(|&c| c != '\u{feff}').count() + 1))
    }

    fn start(&self) -> usize {
        self.span.as_ref().map_or(0, |span| span.start)
    }

    /// The title and the place of a problem, in the manner of a compiler.
    fn show<'a>(&self, title: annotate_snippets::Title<'a>) -> Group<'a> {
        let path = printable(&self.path.to_string_lossy());
        let Some((excerpt, (line, _))) = self.excerpt().zip(self.line_and_column()) else {
            return title.element(Origin::path(path)).element(Padding);
        };
        let annotation: Annotation<'a> = AnnotationKind::Primary.span(excerpt.span);
        let snippet = Snippet::source(excerpt.line).annotation(annotation);
        title.element(match self.is_override {
            true => snippet.line_numbering(false),
            false => snippet.line_start(line).path(path),
        })
    }

    /// A cut line has its place in another column than the file: puts the column of the file into the rendered text.
    fn with_column_of_file(&self, rendered: String) -> String {
        let Some((excerpt, (line, column))) = self.excerpt().zip(self.line_and_column()) else {
            return rendered;
        };
        let shown = excerpt.line.get(..excerpt.span.start).unwrap_or_default().chars().count() + 1;
        match shown == column || self.is_override {
            true => rendered,
            false => rendered.replacen(&format!(":{line}:{shown}"), &format!(":{line}:{column}"), 1),
        }
    }

    fn excerpt(&self) -> Option<Excerpt> {
        let span = self.span.clone()?;
        let start = floor_boundary(&self.text, span.start);
        let end = floor_boundary(&self.text, span.end).max(start);
        let line_start = self.text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = self.text[start..].find('\n').map_or(self.text.len(), |at| at + start);
        let line = self.text[line_start..line_end].trim_end_matches('\r');
        let start = (start - line_start).min(line.len());
        let end = (end - line_start).clamp(start, line.len());
        Some(cut(line, start..end))
    }
}

/// The part of a line around a place, with `…` where something was cut off.
fn cut(line: &str, span: Range<usize>) -> Excerpt {
    let line_without_mark = line.strip_prefix('\u{feff}').unwrap_or(line);
    let mark = line.len() - line_without_mark.len();
    let (line, span) = (line_without_mark, span.start.saturating_sub(mark)..span.end.saturating_sub(mark));
    if line.chars().take(SHOWN_COLUMNS + 1).count() <= SHOWN_COLUMNS {
        return Excerpt { line: line.to_owned(), span };
    }
    let (before, place, after) = (&line[..span.start], &line[span.clone()], &line[span.end..]);
    let place = first_characters(place, SHOWN_COLUMNS / 2);
    let after = if place.len() < span.len() { &line[span.start + place.len()..] } else { after };
    let room = SHOWN_COLUMNS.saturating_sub(place.chars().count());
    let kept_before = last_characters(before, room / 2);
    let kept_after = first_characters(after, room - kept_before.chars().count());
    let kept_before = match kept_after.len() == after.len() {
        true => last_characters(before, room - kept_after.chars().count()),
        false => kept_before,
    };
    let opening = if kept_before.len() < before.len() { "… " } else { "" };
    let closing = if kept_after.len() < after.len() { " …" } else { "" };
    let start = opening.len() + kept_before.len();
    Excerpt { line: format!("{opening}{kept_before}{place}{kept_after}{closing}"), span: start..start + place.len() }
}

fn first_characters(text: &str, count: usize) -> &str {
    text.char_indices().nth(count).map_or(text, |(at, _)| &text[..at])
}

fn last_characters(text: &str, count: usize) -> &str {
    match count {
        0 => "",
        _ => text.char_indices().rev().nth(count - 1).map_or(text, |(at, _)| &text[at..]),
    }
}

/// The last character boundary at or before a position.
fn floor_boundary(text: &str, at: usize) -> usize {
    let at = at.min(text.len());
    (0..=at).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0)
}

/// A message without control characters, and not without end.
fn sentence(text: &str) -> String {
    let shown = first_characters(text, SENTENCE_CHARACTERS);
    let ellipsis = if shown.len() < text.len() { "…" } else { "" };
    printable(&format!("{}{ellipsis}", shown.replace(['\n', '\r'], " ")))
}

/// A name or value from the file, cut to a length that fits into a message.
pub(crate) fn quoted(text: &str) -> String {
    let shown = first_characters(text, QUOTED_CHARACTERS);
    match shown.len() < text.len() {
        true => format!("{shown}…"),
        false => shown.to_owned(),
    }
}

/// The known name that was most likely meant, if one is near enough.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = plain(first_characters(name, 2 * QUOTED_CHARACTERS));
    let scored = known.into_iter().map(|candidate| (likeness(&name, &plain(candidate)), candidate));
    let best = scored.max_by(|(left, _), (right, _)| left.total_cmp(right));
    best.filter(|&(score, _)| score >= 0.6).map(|(_, candidate)| candidate)
}

fn plain(name: &str) -> String {
    name.to_lowercase().replace(['-', ' '], "_")
}

/// 1 for the same, 0 for nothing in common; a whole word within a longer name counts as near.
fn likeness(name: &str, candidate: &str) -> f64 {
    let edits = strsim::normalized_damerau_levenshtein(name, candidate);
    let (short, long) = if name.len() < candidate.len() { (name, candidate) } else { (candidate, name) };
    let is_part = short.len() >= 3 && (long.starts_with(short) || long.ends_with(short));
    if is_part { edits.max(0.7) } else { edits }
}
