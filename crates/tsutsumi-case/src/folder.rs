//! Where results go: never over something that is not theirs.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};

use crate::{CaseSource, ResultsError};

/// What a run writes at the top of its folder.
pub(crate) const CASE: &str = "case.toml";
pub(crate) const HISTORY: &str = "history.csv";
pub(crate) const MANIFEST: &str = "manifest.json";
pub(crate) const PARTICLES: &str = "particles.pvd";
pub(crate) const GRID: &str = "grid.pvd";
pub(crate) const FAILED_POINT: &str = "failed-point.toml";
/// The folders below, and how the names of a run's files in them begin.
pub(crate) const FIELDS: &str = "fields";
pub(crate) const FIGURES: &str = "figures";
const FIELD_STEMS: [&str; 2] = ["particles-", "grid-"];
const FIGURE_STEMS: [&str; 4] = ["settlement.", "pressure.", "particles.", "particles-peak."];

/// Makes a folder for the results: the one asked for, or a new one under `results/` named after the case.
///
/// With `force` the files of an earlier run in it are removed; whatever else it holds stays.
pub(crate) fn claim(source: &CaseSource, out: Option<&Path>, force: bool) -> Result<PathBuf, ResultsError> {
    let folder = match out {
        Some(path) => path.to_owned(),
        None if force => default_folder(source, 1),
        None => return claim_numbered(source),
    };
    if folder.exists() && !folder.is_dir() {
        return Err(ResultsError::NotAFolder { path: folder });
    }
    fs::create_dir_all(&folder).map_err(write_error(&folder))?;
    let found = files_of_a_run(&folder).map_err(write_error(&folder))?;
    if let (false, Some(file)) = (force, found.first()) {
        let file = file.strip_prefix(&folder).unwrap_or(file).to_owned();
        return Err(ResultsError::Occupied { path: folder, file });
    }
    if found.iter().any(|file| is_same_file(file, source.path())) {
        return Err(ResultsError::OverTheCase { path: source.path().to_owned() });
    }
    for file in found {
        fs::remove_file(&file).map_err(write_error(&file))?;
    }
    Ok(folder)
}

/// Makes a folder whose manifest lists the files that are its own. With `force`, the files of an earlier manifest are removed; whatever
/// else the folder holds stays. False if it holds something, and no such manifest.
pub(crate) fn claim_listed(
    folder: &Path,
    manifest: &str,
    force: bool,
    files_of: impl Fn(&str) -> Option<Vec<String>>,
) -> Result<bool, ResultsError> {
    if folder.exists() && !folder.is_dir() {
        return Err(ResultsError::NotAFolder { path: folder.to_owned() });
    }
    fs::create_dir_all(folder).map_err(write_error(folder))?;
    let held = fs::read_to_string(folder.join(manifest)).ok().and_then(|text| files_of(&text));
    let is_empty = fs::read_dir(folder).map_err(write_error(folder))?.next().is_none();
    match held {
        Some(files) if force => remove_listed(folder, &files).map(|()| true),
        Some(_) => Err(ResultsError::Occupied { path: folder.to_owned(), file: manifest.into() }),
        None => Ok(is_empty),
    }
}

/// Removes files of a folder. Names that lead out of it are not its own.
fn remove_listed(folder: &Path, files: &[String]) -> Result<(), ResultsError> {
    let is_inside = |name: &&String| Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
    for path in files.iter().filter(is_inside).map(|name| folder.join(name)) {
        match fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(write_error(&path)(error)),
            _ => {}
        }
    }
    Ok(())
}

/// The first folder of the series that nobody has: making it claims it, also against runs at the same time.
pub(crate) fn claim_numbered(source: &CaseSource) -> Result<PathBuf, ResultsError> {
    let mut number = 1;
    loop {
        let folder = default_folder(source, number);
        if let Some(parent) = folder.parent() {
            fs::create_dir_all(parent).map_err(write_error(parent))?;
        }
        match fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(write_error(&folder)(error)),
        }
    }
}

fn default_folder(source: &CaseSource, number: u32) -> PathBuf {
    let name = case_name(source.path());
    Path::new("results").join(if number == 1 { name } else { format!("{name}-{number}") })
}

/// What a case is called: its file name, where `case` stands for the name of the folder.
fn case_name(path: &Path) -> String {
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let folder = path.parent().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    match (stem.strip_prefix("case"), folder) {
        (Some(rest), Some(folder)) if rest.is_empty() || rest.starts_with('-') => folder + rest,
        _ => stem,
    }
}

/// The files in a folder that have the names of a run's.
fn files_of_a_run(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found: Vec<PathBuf> = [MANIFEST, CASE, HISTORY, PARTICLES, GRID, FAILED_POINT]
        .iter()
        .map(|name| folder.join(name))
        .filter(|path| path.exists())
        .collect();
    for (below, stems) in [(FIELDS, &FIELD_STEMS[..]), (FIGURES, &FIGURE_STEMS[..])] {
        let entries = match fs::read_dir(folder.join(below)) {
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            entries => entries?,
        };
        for entry in entries {
            let path = entry?.path();
            let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            let written = [".vtu", ".svg", ".png"].iter().any(|extension| name.ends_with(extension));
            if written && stems.iter().any(|stem| name.starts_with(stem)) {
                found.push(path);
            }
        }
    }
    Ok(found)
}

/// Whether two paths lead to one file that is there.
pub(crate) fn is_same_file(one: &Path, other: &Path) -> bool {
    match (fs::canonicalize(one), fs::canonicalize(other)) {
        (Ok(one), Ok(other)) => one == other,
        _ => false,
    }
}

pub(crate) fn write_error(path: &Path) -> impl FnOnce(io::Error) -> ResultsError {
    let path = path.to_owned();
    move |source| ResultsError::Write { path, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_is_called_by_its_file_or_its_folder() {
        assert_eq!(case_name(Path::new("paper-cases/poroelastic-column/case.toml")), "poroelastic-column");
        assert_eq!(case_name(Path::new("paper-cases/poroelastic-column/case-1d.toml")), "poroelastic-column-1d");
        assert_eq!(case_name(Path::new("slope.toml")), "slope");
        assert_eq!(case_name(Path::new("case.toml")), "case");
    }
}
