//! A folder of its own for each test, the command run in it, and what it left there.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A saturated column in 1-D that runs in milliseconds; `end = 50.0`, output every 10 s.
pub(crate) const COLUMN_1D: &str = include_str!("column-1d.toml");
/// A saturated column in 2-D with a fixed step, a little below the limit.
pub(crate) const COLUMN: &str = include_str!("column.toml");

/// A temporary folder to work in.
pub(crate) struct Desk(TempDir);

impl Desk {
    /// An empty one.
    pub(crate) fn new() -> Self {
        Desk(TempDir::with_prefix("tsutsumi-").unwrap())
    }

    /// One with a case file.
    pub(crate) fn with(name: &str, text: impl AsRef<[u8]>) -> Self {
        let desk = Desk::new();
        fs::write(desk.path(name), text).unwrap();
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The command in this folder, without a terminal.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tsutsumi"));
        command.args(arguments).current_dir(self.0.path());
        command.env_remove("CLICOLOR_FORCE").env_remove("FORCE_COLOR");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs the command to its end.
    pub(crate) fn tsutsumi(&self, arguments: &[&str]) -> Ended {
        let Output { status, stdout, stderr } = self.command(arguments).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap().replace(self.canonical().to_str().unwrap(), "FOLDER");
        Ended { code: status.code(), stdout: text(stdout), stderr: text(stderr) }
    }

    /// Runs the command and demands success.
    pub(crate) fn succeeds(&self, arguments: &[&str]) -> Ended {
        let ended = self.tsutsumi(arguments);
        assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
        ended
    }

    /// The folder as the system calls it: its path can hold links.
    fn canonical(&self) -> PathBuf {
        self.0.path().canonicalize().unwrap()
    }

    /// What is in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        names(self.0.path())
    }

    pub(crate) fn results(&self, folder: &str) -> Results {
        Results(self.path(folder))
    }
}

/// What the command said, and how it ended.
#[derive(Debug, PartialEq)]
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// A results folder.
pub(crate) struct Results(PathBuf);

impl Results {
    pub(crate) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    pub(crate) fn names(&self, part: &str) -> Vec<String> {
        names(&self.0.join(part))
    }

    pub(crate) fn manifest(&self) -> Value {
        serde_json::from_str(&self.text("manifest.json")).unwrap()
    }

    pub(crate) fn history(&self) -> History {
        History::read(&self.text("history.csv"))
    }

    /// The times and files of a `.pvd`, each file there and whole.
    pub(crate) fn collection(&self, name: &str) -> Vec<(f64, String)> {
        let text = self.text(name);
        let document = roxmltree::Document::parse(&text).unwrap();
        let entries = document.descendants().filter(|node| node.has_tag_name("DataSet")).map(|node| {
            let file = node.attribute("file").unwrap().to_owned();
            let bytes = fs::read(self.0.join(&file)).unwrap();
            assert!(bytes.trim_ascii_end().ends_with(b"</VTKFile>"), "{file}");
            (node.attribute("timestep").unwrap().parse().unwrap(), file)
        });
        entries.collect()
    }

    /// The names of the figures, each there as SVG that is XML and as PNG.
    pub(crate) fn figures(&self) -> Vec<String> {
        let figures = self.0.join("figures");
        let mut kinds = BTreeMap::<String, Vec<String>>::new();
        for name in names(&figures) {
            let (stem, kind) = name.rsplit_once('.').unwrap();
            let bytes = fs::read(figures.join(&name)).unwrap();
            match kind {
                "svg" => {
                    let text = String::from_utf8(bytes).unwrap();
                    let document = roxmltree::Document::parse(&text).unwrap();
                    assert_eq!(document.root_element().tag_name().name(), "svg", "{name}");
                }
                "png" => assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.len() > 1000, "{name}"),
                _ => panic!("{name} is no figure"),
            }
            kinds.entry(stem.to_owned()).or_default().push(kind.to_owned());
        }
        assert!(kinds.values().all(|kinds| kinds == &["png", "svg"]), "{kinds:?}");
        kinds.into_keys().collect()
    }

    /// All files but the manifest, which tells the wall time: what must be the same in every run.
    pub(crate) fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        let mut files = BTreeMap::new();
        for part in ["", "fields", "figures"] {
            for name in names(&self.0.join(part)) {
                let path = self.0.join(part).join(&name);
                if path.is_file() && name != "manifest.json" {
                    files.insert(format!("{part}/{name}"), fs::read(path).unwrap());
                }
            }
        }
        files
    }
}

/// `history.csv`, complete rows only.
#[derive(Debug, PartialEq)]
pub(crate) struct History {
    pub(crate) columns: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl History {
    /// Demands that every row is complete.
    fn read(text: &str) -> Self {
        assert!(text.ends_with('\n'), "the last row is not complete: {text}");
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let columns = lines.next().unwrap();
        let rows: Vec<_> = lines.collect();
        for row in &rows {
            assert_eq!(row.len(), columns.len(), "{row:?}");
            assert!(row.iter().all(|cell| cell.parse::<f64>().is_ok()), "{row:?}");
        }
        History { columns, rows }
    }

    pub(crate) fn column(&self, name: &str) -> Vec<f64> {
        let place = self.columns.iter().position(|column| column == name).unwrap();
        self.rows.iter().map(|row| row[place].parse().unwrap()).collect()
    }
}

/// The names in a folder, sorted; none where there is no folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A text with replacements, each of which must find its place.
pub(crate) fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the case does not hold {from:?}");
        text.replacen(from, to, 1)
    })
}

pub(crate) fn snapshot(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}
