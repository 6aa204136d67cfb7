//! What happened to a specimen, row by row.

use tsutsumi::element::{Condition, ExcessPressure, Specimen};
use tsutsumi::tensor::Sym3;

use super::schema::ElementTestFile;

/// The columns before those that a test or a law adds.
const COLUMNS: [&str; 27] = [
    "stage",
    "increment",
    "cycle",
    "strain.xx",
    "strain.yy",
    "strain.zz",
    "strain.xy",
    "strain.yz",
    "strain.zx",
    "stress.xx",
    "stress.yy",
    "stress.zz",
    "stress.xy",
    "stress.yz",
    "stress.zx",
    "mean_stress",
    "stress_difference",
    "deviatoric_stress",
    "axial_stress",
    "radial_stress",
    "shear_stress",
    "volumetric_strain",
    "axial_strain",
    "deviatoric_strain",
    "shear_strain",
    "excess_pressure",
    "pore_pressure_ratio",
];

/// The columns that are counts.
const COUNTS: [&str; 2] = ["stage", "increment"];

/// All columns of a test: the time if a stage takes some, the void ratio if it is known, and the law's own as `law.NAME`.
pub(crate) fn columns(file: &ElementTestFile, outputs: &[&str]) -> Vec<String> {
    let time = takes_time(file).then(|| "time".to_owned());
    let void_ratio = file.initial.void_ratio.map(|_| "void_ratio".to_owned());
    let own = outputs.iter().map(|name| format!("law.{name}"));
    COLUMNS.into_iter().map(str::to_owned).chain(time).chain(void_ratio).chain(own).collect()
}

fn takes_time(file: &ElementTestFile) -> bool {
    file.stages.iter().any(|stage| stage.duration.is_some() || stage.rate.is_some())
}

/// A table of what was recorded, in SI units; strains and stresses by component are positive in tension, quantities with a name positive
/// in compression.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    /// The names of the columns.
    pub columns: Vec<String>,
    /// The rows, each as long as there are columns.
    pub rows: Vec<Vec<f64>>,
}

impl Record {
    /// The values of a column, if there is one of that name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let place = self.columns.iter().position(|column| column == name)?;
        Some(self.rows.iter().map(|row| row[place]).collect())
    }

    /// The record as CSV with all digits.
    pub(super) fn to_csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns)?;
        for row in &self.rows {
            writer.write_record(row.iter().zip(&self.columns).map(|(value, name)| written(*value, name)))?;
        }
        writer.into_inner().map_err(|error| error.into_error().into())
    }
}

fn written(value: f64, column: &str) -> String {
    if COUNTS.contains(&column) { format!("{value}") } else { format!("{value:.16e}") }
}

/// Where a test is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Place {
    /// The stage, from 1.
    pub(super) stage: usize,
    /// Increments made in the stage.
    pub(super) increment: usize,
    /// Cycles made in the stage.
    pub(super) cycle: f64,
}

/// Writes rows.
pub(super) struct Recorder {
    pub(super) record: Record,
    takes_time: bool,
    void_ratio: Option<f64>,
    /// The volumetric strain that was set to zero on the way (–).
    forgotten: f64,
    /// Where the last row is of, with its stress and strain.
    last: Option<(Place, Sym3, Sym3)>,
}

impl Recorder {
    pub(super) fn new(file: &ElementTestFile, specimen: &Specimen) -> Self {
        let record = Record { columns: columns(file, specimen.outputs()), rows: Vec::new() };
        Recorder {
            record,
            takes_time: takes_time(file),
            void_ratio: file.initial.void_ratio,
            forgotten: 0.0,
            last: None,
        }
    }

    /// Counts strains from here on; the void ratio remembers.
    pub(super) fn zero_strain(&mut self, specimen: &mut Specimen) {
        self.forgotten += Condition::VOLUMETRIC_STRAIN.of(specimen);
        specimen.zero_strain();
    }

    /// Writes a row, unless the last one was the same.
    pub(super) fn write(&mut self, place: Place, specimen: &Specimen, water: Option<ExcessPressure>) {
        let (stress, strain) = (specimen.stress(), specimen.strain());
        if self.last == Some((place, stress, strain)) {
            return;
        }
        self.last = Some((place, stress, strain));
        let of = |condition: Condition| condition.value(stress, strain);
        let mut row = vec![place.stage as f64, place.increment as f64, place.cycle];
        row.extend(components(strain));
        row.extend(components(stress));
        row.extend([of(Condition::MEAN_STRESS), of(Condition::STRESS_DIFFERENCE), stress.deviatoric_stress()]);
        row.extend([Condition::AXIAL_STRESS, Condition::RADIAL_STRESS, Condition::SHEAR_STRESS].map(of));
        row.extend([of(Condition::VOLUMETRIC_STRAIN), of(Condition::AXIAL_STRAIN), strain.deviatoric_strain()]);
        row.push(of(Condition::SHEAR_STRAIN));
        row.extend(water.map_or([0.0, 0.0], |water| [water.pressure(specimen), water.ratio(specimen)]));
        row.extend(self.takes_time.then(|| specimen.time()));
        row.extend(self.void_ratio.map(|e| {
            // The strain is logarithmic, and the grains keep their volume.
            (1.0 + e) * (-(self.forgotten + of(Condition::VOLUMETRIC_STRAIN))).exp() - 1.0
        }));
        row.extend(specimen.output_values());
        self.record.rows.push(row);
    }
}

fn components(tensor: Sym3) -> [f64; 6] {
    let Sym3 { xx, yy, zz, xy, yz, zx } = tensor;
    [xx, yy, zz, xy, yz, zx]
}
