//! What is wrong with a file, all of it at once.

use crate::error::Problem;
use crate::{CaseError, CaseSource, KeyPath};

/// Collects what is wrong with a file. What there is to check stands with each kind of file.
pub(crate) struct Checks<'a, F> {
    source: &'a CaseSource,
    pub(crate) file: &'a F,
    problems: Vec<Problem>,
}

impl<'a, F> Checks<'a, F> {
    pub(crate) fn new(source: &'a CaseSource, file: &'a F) -> Self {
        Checks { source, file, problems: Vec::new() }
    }

    /// Notes a problem, shown where its key stands. An empty `help` shows none.
    pub(crate) fn report(&mut self, key: impl Into<KeyPath>, message: impl Into<String>, help: impl Into<String>) {
        self.problems.push(self.source.invalid_problem(key.into(), message.into(), help.into()));
    }

    pub(crate) fn finish(self) -> Result<(), CaseError> {
        match self.problems.is_empty() {
            true => Ok(()),
            false => Err(CaseError::content(self.problems)),
        }
    }
}
