//! From a file to a test that can begin.

use std::path::PathBuf;

use tsutsumi::element::Specimen;
use tsutsumi::tensor::Sym3;

use super::schema::{ElementTestFile, TestInitial};
use crate::file_checks::Checks;
use crate::registry::MaterialRequest;
use crate::{CaseError, CaseSource, FileKind, KeyPath, Registry};

/// An element test that has been read and checked.
#[derive(Debug, Clone)]
pub struct ElementTest {
    pub(crate) source: CaseSource,
    pub(crate) file: ElementTestFile,
}

impl ElementTest {
    /// Reads an element test and checks what can be checked before it begins. `settings` are `key=value`, put on the file.
    ///
    /// # Errors
    /// Everything that is wrong with the file, each with its place.
    pub fn read(path: impl Into<PathBuf>, registry: &Registry, settings: &[String]) -> Result<Self, CaseError> {
        let source = CaseSource::read_kind(&path.into(), FileKind::ElementTest)?;
        let set = |source: CaseSource, setting: &String| source.with_override(setting);
        Self::open(settings.iter().try_fold(source, set)?, registry)
    }

    /// An element test from a text in memory, as if it were the file `path`.
    ///
    /// # Errors
    /// As [`ElementTest::read`].
    pub fn from_text(path: impl Into<PathBuf>, text: &str, registry: &Registry) -> Result<Self, CaseError> {
        Self::open(CaseSource::from_text_of_kind(path, text, FileKind::ElementTest), registry)
    }

    pub(crate) fn open(source: CaseSource, registry: &Registry) -> Result<Self, CaseError> {
        let file: ElementTestFile = source.parse_at(&KeyPath::root())?;
        let mut checks = Checks::new(&source, &file);
        checks.all();
        checks.finish()?;
        let test = ElementTest { source, file };
        let specimen = test.specimen(registry)?;
        let mut checks = Checks::new(&test.source, &test.file);
        checks.figures(&super::record::columns(&test.file, specimen.outputs()));
        checks.finish()?;
        Ok(test)
    }

    /// The title of the test.
    pub fn title(&self) -> &str {
        &self.file.title
    }

    /// The specimen before the test.
    pub(crate) fn specimen(&self, registry: &Registry) -> Result<Specimen, CaseError> {
        let stress = initial_stress(&self.file.initial);
        let request = MaterialRequest {
            source: &self.source,
            place: "material".into(),
            name: "specimen",
            conductivity_law: "constant",
            particles: 0..1,
            stresses: &[stress].into_iter().collect(),
            history: self.file.initial.history.is_some().then(|| KeyPath::from("initial").key("history")),
        };
        let group = registry.group(&self.file.material.law, &request)?;
        Ok(Specimen::of_group(group, stress).with_tolerance(self.file.tolerance))
    }
}

/// The effective stress before the test (Pa, positive in tension).
fn initial_stress(initial: &TestInitial) -> Sym3 {
    let TestInitial { mean_stress, axial_stress, radial_stress, components, .. } = *initial;
    match components {
        Some([xx, yy, zz, xy, yz, zx]) => Sym3 { xx, yy, zz, xy, yz, zx },
        None => {
            let radial = -radial_stress.or(mean_stress).unwrap_or(0.0);
            Sym3::diagonal(radial, radial, -axial_stress.or(mean_stress).unwrap_or(0.0))
        }
    }
}
