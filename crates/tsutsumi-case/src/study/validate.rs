//! Whether the names and numbers of a study make sense together.

use super::quantity::Quantity;
use super::runs::{WantedRun, is_run};
use super::schema::{Figure, FigureKind, Reference, StudyFile};
use crate::KeyPath;
use crate::error::{did_you_mean, quoted};
use crate::file_checks::Checks;
use crate::source::list;

/// Longest name of a run or figure, which becomes that of a folder or file.
const MAX_NAME: usize = 100;

impl Checks<'_, StudyFile> {
    /// The names of everything, and what does not depend on the cases.
    pub(super) fn names(&mut self, runs: &[WantedRun]) {
        if runs.iter().all(|run| run.is_reference) {
            self.report("variants", "the study has no variants", "add `[[variants]]` with a `name`");
        }
        self.run_names(runs);
        let figures = self.file.figures.iter().map(|figure| figure.name.as_str()).collect();
        self.file_names("figures", figures);
        let refinements = self.file.refinements.iter().map(|refinement| refinement.name.as_str()).collect();
        self.file_names("refinements", refinements);
        for (index, reference) in self.file.references.iter().enumerate() {
            self.reference(&KeyPath::from("references").index(index), reference);
        }
        self.refinements(runs);
        self.problems(runs);
        self.window(&"comparison.window".into(), self.file.comparison.window);
        for (index, figure) in self.file.figures.iter().enumerate() {
            self.figure_keys(&KeyPath::from("figures").index(index), figure);
        }
    }

    fn run_names(&mut self, runs: &[WantedRun]) {
        let mut known: Vec<String> = Vec::new();
        let others = self.file.references.iter().enumerate().filter(|(_, reference)| !is_run(reference));
        let others = others.map(|(index, reference)| (&reference.name, KeyPath::from("references").index(index)));
        let all: Vec<_> = runs.iter().map(|run| (&run.name, run.place.clone())).chain(others).collect();
        for (name, place) in all {
            self.file_name(&place.clone().key("name"), name);
            // Some file systems do not tell upper from lower case.
            let plain = name.to_lowercase();
            if known.contains(&plain) {
                let help = match place.to_string().starts_with("sweeps") {
                    true => "put all values that differ into the name: \"{grid.spacing}\"",
                    false => "variants and references need names of their own, whatever their case",
                };
                self.report(place.key("name"), format!("two are called `{}`", quoted(name)), help);
            }
            known.push(plain);
        }
    }

    fn file_names(&mut self, table: &str, names: Vec<&str>) {
        for (index, name) in names.iter().enumerate() {
            let key = KeyPath::from(table).index(index).key("name");
            self.file_name(&key, name);
            if names[..index].iter().any(|other| other.eq_ignore_ascii_case(name)) {
                self.report(key, format!("two {table} are called `{}`", quoted(name)), "");
            }
        }
    }

    /// A name becomes that of a folder or file on every system.
    fn file_name(&mut self, key: &KeyPath, name: &str) {
        let forbidden = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
        let why = match name {
            _ if name.trim().is_empty() => "is empty".to_owned(),
            _ if name.chars().count() > MAX_NAME => format!("is longer than {MAX_NAME} characters"),
            _ if name.starts_with(['.', ' ']) || name.ends_with(['.', ' ']) => {
                "begins or ends with a dot or a blank".to_owned()
            }
            _ => match name.chars().find(|&c| forbidden(c)) {
                Some(c) => format!("holds {c:?}"),
                None => return,
            },
        };
        self.report(key, format!("`{key}` {why}"), "the name becomes that of a folder or file");
    }

    fn reference(&mut self, place: &KeyPath, reference: &Reference) {
        let is_a_run = reference.set.is_some() || reference.case.is_some();
        let kinds = [reference.solution.is_some(), reference.file.is_some(), is_a_run];
        match kinds.iter().filter(|is_given| **is_given).count() {
            1 => {}
            0 => self.report(
                place,
                format!("nothing tells where the numbers of `{}` come from", quoted(&reference.name)),
                "give an exact `solution`, a `file`, or what a reference run is to `set`",
            ),
            _ => self.report(
                place,
                format!("`{}` has more than one source", quoted(&reference.name)),
                "give one of `solution`, `file`, and `set` or `case`",
            ),
        }
        let not_here = |is_given: bool, name: &'static str| is_given.then_some(name);
        let misplaced = [
            not_here(!kinds[0] && !reference.parameters.is_empty(), "parameters"),
            not_here(!kinds[1] && reference.time.is_some(), "time"),
        ];
        for name in misplaced.into_iter().flatten() {
            let home = if name == "time" { "a `file`" } else { "a `solution`" };
            self.report(place.clone().key(name), format!("`{name}` belongs to a reference with {home}"), "");
        }
        if !is_run(reference) && reference.quantities.is_empty() {
            self.report(
                place,
                format!("`{}` stands for no quantity", quoted(&reference.name)),
                "add `quantities = { \"base.pressure\" = … }`",
            );
        }
        for column in reference.quantities.keys().filter(|column| Quantity::read(column).is_rate) {
            let help = "name the column; its rate follows by itself";
            self.report(place.clone().key("quantities").key(column), "a rate cannot be given", help);
        }
    }

    fn refinements(&mut self, runs: &[WantedRun]) {
        let variants: Vec<&str> = runs.iter().filter(|run| !run.is_reference).map(|run| run.name.as_str()).collect();
        for (index, refinement) in self.file.refinements.iter().enumerate() {
            let place = KeyPath::from("refinements").index(index);
            self.known_names(&place.clone().key("variants"), "variant", &refinement.variants, &variants);
            let sizes = place.clone().key("sizes");
            if refinement.sizes.len() != refinement.variants.len() {
                let message = format!("{} variants have {} sizes", refinement.variants.len(), refinement.sizes.len());
                self.report(&sizes, message, "");
            } else if refinement.variants.len() < 2 {
                self.report(&place, "a refinement needs two variants at least", "");
            }
            let is_good = refinement.sizes.iter().all(|size| size.is_finite() && *size > 0.0)
                && refinement.sizes.is_sorted_by(|coarse, fine| coarse > fine);
            if !is_good {
                self.report(&sizes, "the sizes must be positive and fall from variant to variant", "");
            }
        }
    }

    fn problems(&mut self, runs: &[WantedRun]) {
        let names: Vec<&str> = self.file.problems.iter().map(|problem| problem.name.as_str()).collect();
        self.file_names("problems", names.clone());
        let file = self.file;
        let tables: [(&str, Vec<&Option<String>>); 3] = [
            ("variants", file.variants.iter().map(|variant| &variant.problem).collect()),
            ("sweeps", file.sweeps.iter().map(|sweep| &sweep.problem).collect()),
            ("references", file.references.iter().map(|reference| &reference.problem).collect()),
        ];
        for (table, wanted) in tables {
            for (index, name) in wanted.into_iter().enumerate() {
                let place = KeyPath::from(table).index(index).key("problem");
                self.known_name(place, "problem", name.as_deref(), &names);
            }
        }
        let references: Vec<&str> = file.references.iter().map(|reference| reference.name.as_str()).collect();
        for (index, problem) in file.problems.iter().enumerate() {
            let place = KeyPath::from("problems").index(index);
            if runs.iter().all(|run| run.problem.as_ref() != Some(&problem.name)) {
                let help = format!("add `problem = \"{}\"` to variants or sweeps", quoted(&problem.name));
                self.report(&place, format!("no variant belongs to `{}`", quoted(&problem.name)), help);
            }
            let wanted = problem.reference.as_deref();
            self.known_name(place.clone().key("reference"), "reference", wanted, &references);
            self.window(&place.key("window"), problem.window);
        }
    }

    fn known_name(&mut self, place: KeyPath, what: &str, name: Option<&str>, known: &[&str]) {
        let Some(name) = name.filter(|name| !known.contains(name)) else { return };
        let help = match did_you_mean(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if known.is_empty() => format!("the study has no {what}"),
            None => format!("write one of {}", list(known)),
        };
        self.report(place, format!("there is no {what} `{}`", quoted(name)), help);
    }

    fn known_names(&mut self, place: &KeyPath, what: &str, names: &[String], known: &[&str]) {
        for (index, name) in names.iter().enumerate() {
            self.known_name(place.clone().index(index), what, Some(name), known);
        }
    }

    fn window(&mut self, key: &KeyPath, window: Option<[f64; 2]>) {
        if let Some([from, to]) = window
            && (from >= to || from.is_nan() || to.is_nan())
        {
            self.report(key, format!("`{key}` must begin before it ends"), "write [from, to] in seconds");
        }
    }

    /// Which keys belong to which kind of figure.
    fn figure_keys(&mut self, place: &KeyPath, figure: &Figure) {
        use FigureKind::{Convergence, Lines, Particles};
        let given: [(&str, bool, &[FigureKind]); 12] = [
            ("variants", figure.variants.is_some(), &[Lines]),
            ("references", figure.references.is_some(), &[Lines, Convergence]),
            ("quantities", figure.quantities.is_some(), &[Lines, Convergence]),
            ("below", !figure.below.is_empty(), &[Lines]),
            ("right", !figure.right.is_empty(), &[Lines]),
            ("window", figure.window.is_some(), &[Lines]),
            ("second_label", figure.second_label.is_some(), &[Lines]),
            ("variant", figure.variant.is_some(), &[Particles]),
            ("time", figure.time.is_some(), &[Particles]),
            ("magnification", figure.magnification.is_some(), &[Particles]),
            ("refinements", figure.refinements.is_some(), &[Convergence]),
            ("error", figure.error.is_some(), &[Convergence]),
        ];
        for (name, _, _) in given.iter().filter(|(_, is_given, kinds)| *is_given && !kinds.contains(&figure.kind)) {
            let kind = figure.kind.name();
            self.report(place.clone().key(*name), format!("`{name}` is not for figures of the kind \"{kind}\""), "");
        }
        let needed: &[(&str, bool)] = match figure.kind {
            Lines => &[("quantities", figure.quantities.as_ref().is_some_and(|names| !names.is_empty()))],
            Particles => &[("variant", figure.variant.is_some()), ("time", figure.time.is_some())],
            Convergence => &[],
        };
        for (name, _) in needed.iter().filter(|(_, is_given)| !is_given) {
            let message = format!("`{}` lacks `{name}`", quoted(&figure.name));
            self.report(place, message, format!("a figure of the kind \"{}\" needs it", figure.kind.name()));
        }
        if !figure.below.is_empty() && !figure.right.is_empty() {
            self.report(place.clone().key("right"), "a figure has one second axis, `below` or at the `right`", "");
        }
        if figure.magnification.is_some_and(|factor| !(factor.is_finite() && factor > 0.0)) {
            let key = place.clone().key("magnification");
            self.report(key.clone(), format!("`{key}` must be greater than 0"), "");
        }
        self.window(&place.clone().key("window"), figure.window);
    }

    /// What depends on the cases: which quantities there are, and the names in figures.
    ///
    /// `variants` are their names with the columns of their histories.
    pub(super) fn meaning(&mut self, variants: &[(&str, &[String])], references: &[&str]) {
        let mut columns: Vec<&str> = Vec::new();
        for column in variants.iter().flat_map(|(_, columns)| *columns) {
            if !columns.contains(&column.as_str()) {
                columns.push(column);
            }
        }
        let compared = self.file.comparison.quantities.as_deref().unwrap_or_default();
        self.quantities(&"comparison.quantities".into(), compared, &columns);
        for (index, reference) in self.file.references.iter().enumerate() {
            let place = KeyPath::from("references").index(index).key("quantities");
            for name in reference.quantities.keys() {
                self.quantity(&place.clone().key(name), name, &columns);
            }
        }
        for (index, problem) in self.file.problems.iter().enumerate() {
            self.quantity(&KeyPath::from("problems").index(index).key("error"), &problem.error, &columns);
        }
        let variants: Vec<&str> = variants.iter().map(|(name, _)| *name).collect();
        for (index, figure) in self.file.figures.iter().enumerate() {
            let place = KeyPath::from("figures").index(index);
            self.figure(&place, figure, &variants, references);
            self.figure_quantities(&place, figure, &columns);
        }
    }

    fn figure(&mut self, place: &KeyPath, figure: &Figure, variants: &[&str], references: &[&str]) {
        let key = |name: &str| place.clone().key(name);
        self.known_names(&key("variants"), "variant", figure.variants.as_deref().unwrap_or_default(), variants);
        self.known_names(&key("references"), "reference", figure.references.as_deref().unwrap_or_default(), references);
        let refinements: Vec<&str> = self.file.refinements.iter().map(|one| one.name.as_str()).collect();
        let wanted = figure.refinements.as_deref().unwrap_or_default();
        self.known_names(&key("refinements"), "refinement", wanted, &refinements);
        if figure.kind == FigureKind::Convergence && refinements.is_empty() {
            self.report(place, "the study has no refinement to draw", "add `[[refinements]]`");
        }
        self.known_name(key("variant"), "variant", figure.variant.as_deref(), variants);
    }

    fn figure_quantities(&mut self, place: &KeyPath, figure: &Figure, columns: &[&str]) {
        let first = figure.quantities.as_deref().unwrap_or_default();
        for (name, quantities) in [("quantities", first), ("below", &figure.below), ("right", &figure.right)] {
            let key = place.clone().key(name);
            self.quantities(&key, quantities, columns);
            let units: Vec<String> = quantities.iter().map(|name| Quantity::read(name).measure().unit).collect();
            if figure.kind == FigureKind::Lines && units.windows(2).any(|pair| pair[0] != pair[1]) {
                let help = "put the others on a second axis: `below` or `right`";
                self.report(key, format!("the quantities of one axis have different units: {}", list(&units)), help);
            }
        }
    }

    fn quantities(&mut self, place: &KeyPath, names: &[String], columns: &[&str]) {
        for (index, name) in names.iter().enumerate() {
            self.quantity(&place.clone().index(index), name, columns);
        }
    }

    fn quantity(&mut self, place: &KeyPath, name: &str, columns: &[&str]) {
        let column = Quantity::read(name).column;
        if columns.contains(&column.as_str()) {
            return;
        }
        let help = match did_you_mean(&column, columns.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are {}", list(columns)),
        };
        self.report(place, format!("no variant has a quantity `{}`", quoted(&column)), help);
    }
}

impl FigureKind {
    fn name(self) -> &'static str {
        match self {
            Self::Lines => "lines",
            Self::Particles => "particles",
            Self::Convergence => "convergence",
        }
    }
}
