//! The studies of the repository: the paper's column with the numbers of its three figures, and the book's example.
//!
//! The paper's study runs with the automatic step in place of the paper's; the two agree within 2e-3 of the largest values
//! (`poroelastic_column.rs`).

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
    /// Runs a study of the repository with one more setting.
    fn new(file: &str, setting: &str) -> Self {
        let name = file.replace(['/', '.'], "-");
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
        let folder = std::env::temp_dir().join(format!("tsutsumi-{name}-{}", std::process::id()));
        let study = Study::read(file, &Registry::built_in(), &[setting.to_owned()]).unwrap();
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
    let studied = Studied::new("paper-cases/poroelastic-column/study.toml", "time.step=auto");
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

/// The example of the book's page on studies, in longer steps: settlements approach theory with the square of the spacing.
#[test]
fn the_example_of_the_book_is_of_second_order() {
    let studied = Studied::new("book/cases/spacing.toml", "time.step=0.05");
    assert_eq!(studied.summary.outcome, Outcome::Finished);
    assert_eq!((studied.summary.rows.len(), studied.summary.orders.len()), (8, 6));
    for order in studied.summary.orders.iter().filter(|order| order.sizes[0] > 0.5) {
        // The step of 0.05 s adds an error of 5e-5 of the settlement, a tenth of the grid's at 0.5 m and of the other sign:
        // the last order looks higher by ln(1/0.9)/ln 2 = 0.15.
        assert!((1.95..2.2).contains(&order.max) && (1.95..2.2).contains(&order.rms), "{order:?}");
    }
}

/// Every study of the repository can be read, with all its cases and references; those that no test runs are run by
/// `book/pictures.sh`.
#[test]
fn every_study_can_be_read() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut count = 0;
    for folder in fs::read_dir(root.join("paper-cases")).unwrap() {
        for file in fs::read_dir(folder.unwrap().path()).unwrap().map(|file| file.unwrap().path()) {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            if name.ends_with(".toml") && name.contains("study") {
                let study = Study::read(&file, &Registry::built_in(), &[]);
                study.unwrap_or_else(|error| panic!("{}: {}", file.display(), error.render(false)));
                count += 1;
            }
        }
    }
    assert!(count >= 8, "{count} studies");
}
