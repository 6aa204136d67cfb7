//! The study of the paper's column: the numbers of its three figures, with the automatic step in place of the paper's.
//!
//! The two steps agree within 2e-3 of the largest values (`poroelastic_column.rs`); the study itself is the paper's.

use std::fs;
use std::path::{Path, PathBuf};

use tsutsumi_case::study::{Study, StudyOptions, StudySummary, run_study};
use tsutsumi_case::{Outcome, Registry, Silent};
use tsutsumi_testkit::snapshot::Numbers;

/// The results of a study, removed at the end.
struct Studied {
    folder: PathBuf,
    summary: StudySummary,
}

impl Studied {
    fn new() -> Self {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../paper-cases/poroelastic-column/study.toml");
        let folder = std::env::temp_dir().join(format!("tsutsumi-paper-study-{}", std::process::id()));
        let study = Study::read(file, &Registry::built_in(), &["time.step=auto".to_owned()]).unwrap();
        let options = StudyOptions { out: Some(folder.clone()), ..Default::default() };
        let summary = run_study(&study, &Registry::built_in(), &options, &Silent).unwrap();
        Studied { folder, summary }
    }

    /// The numbers of a figure: every so many lines, commas as blanks, empty cells as dashes.
    fn figure(&self, name: &str, every: usize) -> String {
        let text = fs::read_to_string(self.folder.join(format!("figures/{name}.csv"))).unwrap();
        let mut lines = text.lines();
        let head = lines.next().unwrap().replace(',', "\n");
        let cell = |cell: &str| match cell.parse::<f64>() {
            Ok(number) => format!("{number:15.7e}"),
            Err(_) => format!("{:>15}", "-"),
        };
        let row = |line: &str| line.split(',').map(cell).collect::<Vec<_>>().join(" ") + "\n";
        let rows: String = lines.step_by(every).map(row).collect();
        format!("{head}\n{rows}")
    }
}

impl Drop for Studied {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

#[test]
fn the_figures_of_the_paper() {
    let studied = Studied::new();
    assert_eq!(studied.summary.outcome, Outcome::Finished);
    for figure in ["figure-3", "figure-4", "figure-5"] {
        for ending in ["svg", "png"] {
            assert!(studied.folder.join(format!("figures/{figure}.{ending}")).exists(), "{figure}.{ending}");
        }
    }
    // Against theory: the paper's "slightly smaller" settlement, and the pressure of the lowest cell within the grid's error
    // (0.3 % of its largest value, see the book's "Verification").
    let row = |variant: &str, quantity: &str| {
        let rows = studied.summary.rows.iter();
        let mut rows = rows.filter(|row| row.variant == variant && row.quantity.as_deref() == Some(quantity));
        rows.find(|row| row.reference.as_deref() == Some("theory")).unwrap().errors.unwrap()
    };
    for variant in ["mpm1", "mpm2"] {
        assert!(row(variant, "base.pressure").relative() < 3e-3);
        assert!((0.04..0.05).contains(&row(variant, "settlement.particles").relative()));
    }
    // The same program gives the same numbers but for the order of floating-point operations on other machines.
    Numbers { relative: 1e-6 }.settings().bind(|| {
        insta::assert_snapshot!("figure_3", studied.figure("figure-3", 4));
        insta::assert_snapshot!("figure_4", studied.figure("figure-4", 10));
        // Values stand at the outputs, rates between them: two lines of every twenty.
        insta::assert_snapshot!("figure_5", studied.figure("figure-5", 19));
    });
}
