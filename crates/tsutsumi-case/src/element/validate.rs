//! Whether the numbers and words of an element test make sense together.

use super::schema::{
    Amplitude, DrainageKind, ElementTestFile, PathCondition, Resistance, Stage, StageKind, Target, Until,
};
use crate::KeyPath;
use crate::error::{did_you_mean, quoted};
use crate::file_checks::Checks;
use crate::source::list;

impl Checks<'_, ElementTestFile> {
    /// What does not depend on the law.
    pub(super) fn all(&mut self) {
        self.initial();
        if !(self.file.tolerance > 0.0 && self.file.tolerance <= 0.01) {
            self.report("tolerance", "`tolerance` must be greater than 0 and at most 0.01", "");
        }
        if self.file.output.every == 0 {
            self.report("output.every", "`output.every` must be 1 or more", "");
        }
        if self.file.stages.is_empty() {
            self.report("stages", "the test has no stages", "add `[[stages]]` with a `kind`");
        }
        for (index, stage) in self.file.stages.iter().enumerate() {
            self.stage(&KeyPath::from("stages").index(index), stage);
        }
        if let Some(resistance) = &self.file.resistance {
            self.resistance(resistance);
        }
    }

    fn initial(&mut self) {
        let initial = self.file.initial.clone();
        let by_axes = initial.axial_stress.is_some() || initial.radial_stress.is_some();
        let ways = [initial.mean_stress.is_some(), by_axes, initial.components.is_some()];
        let help = "give `mean_stress`, or `axial_stress` and `radial_stress`, or `components`";
        if ways.iter().filter(|is_given| **is_given).count() > 1 {
            self.report("initial", "the stress is given in more than one way", help);
        } else if by_axes && (initial.axial_stress.is_none() || initial.radial_stress.is_none()) {
            self.report("initial", "one of `axial_stress` and `radial_stress` is missing", help);
        }
        let place = KeyPath::from("initial");
        self.finite(&place, "mean_stress", initial.mean_stress);
        self.finite(&place, "axial_stress", initial.axial_stress);
        self.finite(&place, "radial_stress", initial.radial_stress);
        if initial.components.is_some_and(|components| components.iter().any(|c| !c.is_finite())) {
            self.report(place.clone().key("components"), "`initial.components` must be finite", "");
        }
        self.positive(&place, "void_ratio", initial.void_ratio);
    }

    fn finite(&mut self, place: &KeyPath, name: &str, value: Option<f64>) {
        if value.is_some_and(|value| !value.is_finite()) {
            let key = place.clone().key(name);
            self.report(key.clone(), format!("`{key}` must be finite"), "");
        }
    }

    fn positive(&mut self, place: &KeyPath, name: &str, value: Option<f64>) {
        if value.is_some_and(|value| !(value.is_finite() && value > 0.0)) {
            let key = place.clone().key(name);
            self.report(key.clone(), format!("`{key}` must be greater than 0"), "");
        }
    }

    fn stage(&mut self, place: &KeyPath, stage: &Stage) {
        self.stage_keys(place, stage);
        if let Some(target) = &stage.to {
            self.target(&place.clone().key("to"), stage.kind, target);
        }
        if let Some(amplitude) = &stage.amplitude {
            self.amplitude(&place.clone().key("amplitude"), stage, amplitude);
        }
        if let Some(until) = &stage.until {
            self.until(&place.clone().key("until"), stage, until);
        }
        if let Some(conditions) = &stage.conditions {
            self.conditions(&place.clone().key("conditions"), conditions);
        }
        self.positive(place, "increment", stage.increment);
        if stage.increments == Some(0) {
            self.report(place.clone().key("increments"), "a stage needs one increment at least", "");
        }
    }

    /// Which keys belong to which stage.
    fn stage_keys(&mut self, place: &KeyPath, stage: &Stage) {
        self.time_keys(place, stage);
        if stage.kind == StageKind::Increment {
            return self.increment_keys(place, stage);
        }
        let kind = stage.kind.name();
        for (name, is_given) in [("strain", stage.strain.is_some()), ("spin", stage.spin.is_some())] {
            if is_given {
                self.report(place.clone().key(name), format!("`{name}` is for the kind \"increment\""), "");
            }
        }
        let is_path = stage.kind == StageKind::Path;
        let ways = [("to", stage.to.is_some()), ("amplitude", stage.amplitude.is_some())];
        match (is_path, ways.iter().filter(|(_, is_given)| *is_given).count(), stage.conditions.is_some()) {
            (true, 0, true) | (false, 1, false) => {}
            (true, ..) => {
                self.report(place, "a path needs `conditions`, and neither `to` nor `amplitude`", "");
            }
            (false, _, true) => {
                self.report(place.clone().key("conditions"), "`conditions` are for the kind \"path\"", "");
            }
            (false, 0, _) => {
                let help = "add `to` with a value at the end, or an `amplitude` for a cyclic one";
                self.report(place, "nothing tells where the stage goes", help);
            }
            (false, ..) => self.report(place, "a stage has either `to` or an `amplitude`", ""),
        }
        let is_sheared = matches!(stage.kind, StageKind::Triaxial | StageKind::SimpleShear);
        if stage.drainage.is_some() && !is_sheared {
            let message = format!("`drainage` is not for the kind \"{kind}\"");
            self.report(place.clone().key("drainage"), message, "it is for \"triaxial\" and \"simple-shear\"");
        }
        if stage.amplitude.is_some() && !is_sheared {
            let message = format!("the kind \"{kind}\" cannot be cyclic");
            self.report(place.clone().key("amplitude"), message, "\"triaxial\" and \"simple-shear\" can");
        }
        let is_cyclic = stage.amplitude.is_some();
        let of_cycles = [
            ("until", stage.until.is_some()),
            ("increment", stage.increment.is_some()),
            ("driven_by", stage.driven_by.is_some()),
        ];
        for (name, _) in of_cycles.iter().filter(|(_, is_given)| *is_given && !is_cyclic) {
            self.report(
                place.clone().key(*name),
                format!("`{name}` belongs to cyclic stages, with an `amplitude`"),
                "",
            );
        }
        if is_cyclic && stage.increments.is_some() {
            let help = "give the size of one: `increment`";
            self.report(place.clone().key("increments"), "`increments` belongs to monotonic stages", help);
        }
        if is_cyclic && stage.until.is_none() {
            self.report(place, "nothing tells when the cyclic stage ends", "add `until = { cycles = … }`");
        }
        if stage.driven_by.is_some() && stage.amplitude.is_some_and(|amplitude| amplitude.strain.is_some()) {
            self.report(place.clone().key("driven_by"), "an amplitude of strain is driven by strain", "");
        }
    }

    fn time_keys(&mut self, place: &KeyPath, stage: &Stage) {
        self.positive(place, "duration", stage.duration);
        self.positive(place, "rate", stage.rate);
        match stage.amplitude {
            Some(_) if stage.duration.is_some() => {
                let help = "give how fast the driven quantity changes: `rate`";
                self.report(place.clone().key("duration"), "`duration` belongs to monotonic stages", help);
            }
            None if stage.rate.is_some() => {
                let help = "give how long the stage takes: `duration`";
                self.report(place.clone().key("rate"), "`rate` belongs to cyclic stages, with an `amplitude`", help);
            }
            _ => {}
        }
    }

    /// One increment has nothing but its strain, spin and duration. They may be anything, as what a run asks of a law may be: not even numbers.
    fn increment_keys(&mut self, place: &KeyPath, stage: &Stage) {
        let strange = [
            ("drainage", stage.drainage.is_some()),
            ("to", stage.to.is_some()),
            ("amplitude", stage.amplitude.is_some()),
            ("driven_by", stage.driven_by.is_some()),
            ("increments", stage.increments.is_some()),
            ("increment", stage.increment.is_some()),
            ("until", stage.until.is_some()),
            ("conditions", stage.conditions.is_some()),
        ];
        for (name, _) in strange.iter().filter(|(_, is_given)| *is_given) {
            self.report(place.clone().key(*name), format!("`{name}` is not for the kind \"increment\""), "");
        }
        if stage.strain.is_none() {
            self.report(place, "an increment needs its `strain`", "write the components xx, yy, zz, xy, yz, zx");
        }
    }

    fn target(&mut self, place: &KeyPath, kind: StageKind, target: &Target) {
        let known: &[&str] = match kind {
            StageKind::Isotropic => &["mean_stress", "volumetric_strain"],
            StageKind::Oedometer => &["axial_stress", "axial_strain"],
            StageKind::Triaxial => &["axial_strain", "stress_difference"],
            StageKind::SimpleShear => &["shear_strain", "shear_stress"],
            StageKind::Path | StageKind::Increment => &[],
        };
        let given: Vec<_> = target.all().into_iter().filter_map(|(name, _, value)| Some((name, value?))).collect();
        let help = format!("write one of {}", list(known));
        match given.as_slice() {
            [(name, _)] if !known.contains(name) && !known.is_empty() => {
                let message = format!("the kind \"{}\" cannot go to `{name}`", kind.name());
                self.report(place.clone().key(*name), message, help);
            }
            [(name, value)] => self.finite(place, name, Some(*value)),
            _ if known.is_empty() => {}
            _ => self.report(place, "a stage goes to one quantity", help),
        }
    }

    fn amplitude(&mut self, place: &KeyPath, stage: &Stage, amplitude: &Amplitude) {
        let given: Vec<_> = amplitude.all().into_iter().filter_map(|(name, value)| Some((name, value?))).collect();
        match given.as_slice() {
            [(name, value)] => self.positive(place, name, Some(*value)),
            _ => {
                self.report(place, "an amplitude is of one quantity", "write one of `stress_ratio`, `stress`, `strain`")
            }
        }
        if let (Some(increment), [(_, amplitude)]) = (stage.increment, given.as_slice())
            && given[0].0 == "strain"
            && increment > *amplitude
        {
            self.report(place, "the amplitude is smaller than the `increment`", "");
        }
    }

    fn until(&mut self, place: &KeyPath, stage: &Stage, until: &Until) {
        self.positive(place, "cycles", Some(until.cycles));
        self.positive(place, "single_strain", until.single_strain);
        self.positive(place, "double_strain", until.double_strain);
        self.positive(place, "pore_pressure_ratio", until.pore_pressure_ratio);
        if until.pore_pressure_ratio.is_some() {
            self.needs_undrained(&place.clone().key("pore_pressure_ratio"), stage);
        }
    }

    fn needs_undrained(&mut self, key: &KeyPath, stage: &Stage) {
        if stage.drainage != Some(DrainageKind::Undrained) {
            let help = "add `drainage = \"undrained\"`";
            self.report(key, "a drained stage has no pore pressure ratio", help);
        }
    }

    fn conditions(&mut self, place: &KeyPath, conditions: &[PathCondition]) {
        if conditions.len() != 6 {
            let message = format!("a path has six conditions, not {}", conditions.len());
            self.report(place, message, "one for each component of the strain that is to be found");
        }
        for (index, condition) in conditions.iter().enumerate() {
            let place = place.clone().index(index);
            let coefficients = [condition.stress, condition.strain].into_iter().flatten();
            let numbers: Vec<f64> = coefficients.flat_map(|c| [c.xx, c.yy, c.zz, c.xy, c.yz, c.zx]).collect();
            if numbers.iter().all(|number| *number == 0.0) || numbers.iter().any(|number| !number.is_finite()) {
                let help = "give finite coefficients: `stress = { zz = 1.0 }`";
                self.report(&place, "the condition is about nothing", help);
            }
            if condition.to.is_some() && condition.by.is_some() {
                self.report(&place, "a condition goes `to` a value or changes `by` one, not both", "");
            }
            self.finite(&place, "to", condition.to);
            self.finite(&place, "by", condition.by);
        }
    }

    fn resistance(&mut self, resistance: &Resistance) {
        let Some(last) = self.file.stages.last().filter(|stage| stage.amplitude.is_some()) else {
            self.report("resistance", "the last stage is not cyclic", "give it an `amplitude`");
            return;
        };
        if resistance.stress_ratios.is_empty() {
            self.report("resistance.stress_ratios", "there are no stress ratios", "");
        }
        if resistance.stress_ratios.iter().any(|ratio| !(ratio.is_finite() && *ratio > 0.0)) {
            self.report("resistance.stress_ratios", "stress ratios must be greater than 0", "");
        }
        if resistance.criteria.is_empty() {
            self.report("resistance.criteria", "nothing tells what counts as liquefaction", "");
        }
        for (index, criterion) in resistance.criteria.iter().enumerate() {
            let place = KeyPath::from("resistance").key("criteria").index(index);
            let given: Vec<_> = criterion.all().into_iter().filter_map(|(name, value)| Some((name, value?))).collect();
            match given.as_slice() {
                [(name, value)] => {
                    self.positive(&place, name, Some(*value));
                    if *name == "pore_pressure_ratio" {
                        self.needs_undrained(&place, last);
                    }
                }
                _ => {
                    let help = "write one of `single_strain`, `double_strain`, `pore_pressure_ratio`";
                    self.report(&place, "a criterion is about one quantity", help);
                }
            }
        }
    }

    /// The figures, once the columns are known.
    pub(super) fn figures(&mut self, columns: &[String]) {
        for (index, figure) in self.file.figures.iter().enumerate() {
            let place = KeyPath::from("figures").index(index);
            let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            if figure.name.is_empty() || !figure.name.chars().all(is_plain) {
                let help = "the name becomes that of a file: lower-case letters, digits, hyphens";
                self.report(place.clone().key("name"), format!("`{}` is no name", quoted(&figure.name)), help);
            }
            if self.file.figures[..index].iter().any(|other| other.name == figure.name) {
                let message = format!("two figures are called `{}`", quoted(&figure.name));
                self.report(place.clone().key("name"), message, "");
            }
            for (key, column) in [("x", &figure.x), ("y", &figure.y)] {
                if !columns.contains(column) {
                    let help = match did_you_mean(column, columns.iter().map(String::as_str)) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!("there are {}", list(columns)),
                    };
                    self.report(place.clone().key(key), format!("there is no column `{}`", quoted(column)), help);
                }
            }
            let num_stages = self.file.stages.len();
            let stages = figure.stages.iter().flatten();
            if let Some(stage) = stages.into_iter().find(|stage| !(1..=num_stages).contains(*stage)) {
                let message = format!("there is no stage {stage}");
                self.report(place.key("stages"), message, format!("stages count from 1 to {num_stages}"));
            }
        }
    }
}

impl StageKind {
    /// The word for it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::Oedometer => "oedometer",
            Self::Triaxial => "triaxial",
            Self::SimpleShear => "simple-shear",
            Self::Path => "path",
            Self::Increment => "increment",
        }
    }
}
