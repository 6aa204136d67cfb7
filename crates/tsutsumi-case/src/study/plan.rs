//! From a study file to runs that can begin: variants with their cases, references opened, every name checked.

use std::path::PathBuf;

use super::reference::{OpenReference, ReferenceKind, open_solution, open_table, run_columns};
use super::runs::{WantedRun, is_run, swept_refinements, wanted_runs};
use super::schema::{StudyFile, StudyProblem};
use super::setting::Setting;
use crate::FileKind;
use crate::build::build;
use crate::deserializer::Part;
use crate::error::{Problem, ProblemKind, quoted};
use crate::file_checks::Checks;
use crate::run::{read_case, refuse_unstable};
use crate::{Case, CaseError, CaseSource, KeyPath, Registry};

/// A study that has been read and checked, with all of its cases.
pub struct Study {
    pub(super) source: CaseSource,
    pub(super) file: StudyFile,
    /// The variants, and behind them the reference runs.
    pub(super) runs: Vec<PlannedRun>,
    pub(super) references: Vec<OpenReference>,
}

/// A run of a study before it begins.
pub(super) struct PlannedRun {
    pub(super) name: String,
    pub(super) label: String,
    pub(super) is_reference: bool,
    pub(super) allow_unstable: bool,
    /// The problem that it belongs to.
    pub(super) problem: Option<String>,
    pub(super) source: CaseSource,
    pub(super) case: Case,
    /// The columns of its history.
    pub(super) columns: Vec<String>,
}

impl Study {
    /// Reads a study with all its cases and references, and checks what can be checked before anything runs.
    ///
    /// `settings` are `key=value`, put on the case of every run after what the study sets.
    ///
    /// # Errors
    /// Everything that is wrong with the study, each with its place in the file; what is wrong with a case because of a
    /// value that the study sets is shown where the study sets it.
    pub fn read(path: impl Into<PathBuf>, registry: &Registry, settings: &[String]) -> Result<Self, CaseError> {
        Self::open(CaseSource::read_kind(&path.into(), FileKind::Study)?, registry, settings)
    }

    /// A study from a text in memory, as if it were the file `path`.
    ///
    /// # Errors
    /// As [`Study::read`].
    pub fn from_text(path: impl Into<PathBuf>, text: &str, registry: &Registry) -> Result<Self, CaseError> {
        Self::open(CaseSource::from_text_of_kind(path, text, FileKind::Study), registry, &[])
    }

    fn open(source: CaseSource, registry: &Registry, settings: &[String]) -> Result<Self, CaseError> {
        let mut file: StudyFile = source.parse_at(&KeyPath::root())?;
        let wanted = wanted_runs(&source, &file, settings)?;
        file.refinements.extend(swept_refinements(&wanted));
        let mut checks = Checks::new(&source, &file);
        checks.names(&wanted);
        checks.finish()?;
        let mut planner = Planner { source: &source, file: &file, registry, problems: Vec::new() };
        let runs: Vec<_> = wanted.iter().map(|run| planner.plan(run)).collect();
        let references = planner.references(&runs);
        planner.finish()?;
        // With no problem left, nothing is missing.
        let study = Study {
            file: file.clone(),
            runs: runs.into_iter().flatten().collect(),
            references: references.into_iter().flatten().collect(),
            source: source.clone(),
        };
        let mut checks = Checks::new(&source, &file);
        let references: Vec<&str> = study.references.iter().map(|reference| reference.name.as_str()).collect();
        let variants: Vec<_> = study.variants().map(|(_, run)| (run.name.as_str(), run.columns.as_slice())).collect();
        checks.meaning(&variants, &references);
        checks.finish()?;
        Ok(study)
    }

    /// The title of the study.
    pub fn title(&self) -> &str {
        &self.file.title
    }

    /// The names of the runs: the variants, and behind them the references that are runs.
    pub fn runs(&self) -> impl Iterator<Item = &str> {
        self.runs.iter().map(|run| run.name.as_str())
    }

    /// The problem that a run belongs to.
    pub(super) fn problem_of(&self, run: &PlannedRun) -> Option<&StudyProblem> {
        self.file.problems.iter().find(|problem| run.problem.as_ref() == Some(&problem.name))
    }

    /// The part of the time of a run that is compared, `[from, to]` (s).
    pub(super) fn window_of(&self, run: &PlannedRun) -> Option<[f64; 2]> {
        self.problem_of(run).and_then(|problem| problem.window).or(self.file.comparison.window)
    }

    /// The variants among the runs.
    pub(super) fn variants(&self) -> impl Iterator<Item = (usize, &PlannedRun)> {
        self.runs.iter().enumerate().filter(|(_, run)| !run.is_reference)
    }
}

/// Opens what a study asks for, and collects what is wrong.
struct Planner<'a> {
    source: &'a CaseSource,
    file: &'a StudyFile,
    registry: &'a Registry,
    problems: Vec<Problem>,
}

impl Planner<'_> {
    fn plan(&mut self, wanted: &WantedRun) -> Option<PlannedRun> {
        match self.open(wanted) {
            Ok(run) => Some(run),
            Err(error) => {
                self.report(error, wanted);
                None
            }
        }
    }

    fn open(&self, wanted: &WantedRun) -> Result<PlannedRun, CaseError> {
        let (name, key) = match &wanted.case {
            Some(case) => (case, wanted.place.clone().key("case")),
            None => (&self.file.case, KeyPath::from("case")),
        };
        let path = self.source.beside(name);
        let source = CaseSource::read(&path).map_err(|error| {
            self.source.invalid(key, error.to_string(), "paths count from the folder of the study file")
        })?;
        let source = wanted.settings.iter().try_fold(source, |source, set| source.with_override(&set.assignment))?;
        let case = read_case(&source)?;
        let columns = columns_of(&source, &case, self.registry, wanted.allow_unstable)?;
        Ok(PlannedRun {
            name: wanted.name.clone(),
            label: wanted.label.clone().unwrap_or_else(|| wanted.name.clone()),
            is_reference: wanted.is_reference,
            allow_unstable: wanted.allow_unstable,
            problem: wanted.problem.clone(),
            source,
            case,
            columns,
        })
    }

    /// Keeps the problems of a run: each once, though many runs may share it.
    fn report(&mut self, error: CaseError, wanted: &WantedRun) {
        for problem in error.problems() {
            let problem = self.relocated(problem, wanted);
            let is_known = |other: &Problem| other.message == problem.message && other.location == problem.location;
            if !self.problems.iter().any(is_known) {
                self.problems.push(problem);
            }
        }
    }

    /// A problem of a case, shown in the study where that sets the value.
    fn relocated(&self, problem: &Problem, wanted: &WantedRun) -> Problem {
        let mut problem = problem.clone();
        let set = |setting: &&Setting| {
            problem.location.is_override && *problem.location.text == *format!("--set {}", setting.assignment)
        };
        let place = wanted.settings.iter().find(set).and_then(|setting| setting.place.clone());
        if let Some(place) = &place {
            let is_key = matches!(problem.kind, ProblemKind::UnknownKey | ProblemKind::Override);
            problem.location = self.source.place_of(place, if is_key { Part::Key } else { Part::Value });
            let in_file = |note: String| match note.split_once("; ") {
                Some((_, in_file)) if note.starts_with("set by ") => Some(in_file.replace("the file", "the case file")),
                None if note.starts_with("set by ") => None,
                _ => Some(note),
            };
            problem.notes = problem.notes.into_iter().filter_map(in_file).collect();
        }
        problem.help =
            problem.help.map(|help| help.replace("`--allow-unstable`", "`allow_unstable = true` beside `set`"));
        let is_of_all =
            problem.key == KeyPath::from("case") || place.is_some_and(|place| place.starts_with(&"set".into()));
        if !is_of_all {
            let what = if wanted.is_reference { "reference" } else { "variant" };
            problem.notes.push(format!("in the {what} `{}`", quoted(&wanted.name)));
        }
        problem
    }

    /// Opens the references. `runs` are the variants, and behind them the reference runs in their order.
    fn references(&mut self, runs: &[Option<PlannedRun>]) -> Vec<Option<OpenReference>> {
        let num_reference_runs = self.file.references.iter().filter(|reference| is_run(reference)).count();
        let mut next_run = runs.len() - num_reference_runs;
        let mut references = Vec::new();
        for (index, reference) in self.file.references.iter().enumerate() {
            let place = KeyPath::from("references").index(index);
            let kind = match (&reference.solution, &reference.file) {
                (Some(name), _) => open_solution(self.source, &place, name, reference),
                (None, Some(file)) => open_table(self.source, &place, file, reference),
                (None, None) => {
                    let run = next_run;
                    next_run += 1;
                    let known = runs[run].as_ref().map_or(&[][..], |run| &run.columns);
                    // What a run that could not be opened would have is not known.
                    match runs[run] {
                        Some(_) => run_columns(self.source, &place, reference, known)
                            .map(|columns| ReferenceKind::Run(run, columns)),
                        None => continue,
                    }
                }
            };
            let label = reference.label.clone().unwrap_or_else(|| reference.name.clone());
            match kind {
                Ok(kind) => {
                    let (name, problem) = (reference.name.clone(), reference.problem.clone());
                    references.push(Some(OpenReference { name, label, problem, kind }));
                }
                Err(error) => self.problems.extend(error.problems().iter().cloned()),
            }
        }
        references
    }

    fn finish(self) -> Result<(), CaseError> {
        match self.problems.is_empty() {
            true => Ok(()),
            false => Err(CaseError::content(self.problems)),
        }
    }
}

/// The columns that the history of a case will have; the case is built for that, so that what cannot begin is found now.
fn columns_of(
    source: &CaseSource,
    case: &Case,
    registry: &Registry,
    allow_unstable: bool,
) -> Result<Vec<String>, CaseError> {
    match case.dimension {
        1 => columns_in::<1>(source, case, registry, allow_unstable),
        2 => columns_in::<2>(source, case, registry, allow_unstable),
        _ => columns_in::<3>(source, case, registry, allow_unstable),
    }
}

fn columns_in<const D: usize>(
    source: &CaseSource,
    case: &Case,
    registry: &Registry,
    allow_unstable: bool,
) -> Result<Vec<String>, CaseError> {
    let simulation = build::<D>(source, case, registry)?;
    if !allow_unstable {
        refuse_unstable(source, case, simulation.model())?;
    }
    Ok(simulation.reading_names())
}
