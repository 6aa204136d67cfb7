//! The recorded quantities: their names in files, and their words and units in figures.

/// How a column of the record is shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shown {
    /// The title of an axis, with the unit in round brackets.
    pub(crate) title: String,
    /// What recorded numbers are multiplied by.
    pub(crate) factor: f64,
}

/// Columns with their words, shown units and factors.
const SHOWN: [(&str, &str, &str, f64); 21] = [
    ("stage", "stage", "", 1.0),
    ("increment", "increment", "", 1.0),
    ("cycle", "cycles", "", 1.0),
    ("time", "time", "s", 1.0),
    ("mean_stress", "mean effective stress p′", "kPa", 1e-3),
    ("stress_difference", "stress difference q", "kPa", 1e-3),
    ("deviatoric_stress", "deviatoric stress q", "kPa", 1e-3),
    ("axial_stress", "vertical effective stress", "kPa", 1e-3),
    ("radial_stress", "horizontal effective stress", "kPa", 1e-3),
    ("shear_stress", "shear stress τ", "kPa", 1e-3),
    ("volumetric_strain", "volumetric strain", "%", 100.0),
    ("axial_strain", "axial strain", "%", 100.0),
    ("deviatoric_strain", "deviatoric strain", "%", 100.0),
    ("shear_strain", "shear strain γ", "%", 100.0),
    ("excess_pressure", "excess pore pressure", "kPa", 1e-3),
    ("pore_pressure_ratio", "pore pressure ratio", "–", 1.0),
    ("void_ratio", "void ratio", "–", 1.0),
    ("stress.xx", "stress xx", "kPa", 1e-3),
    ("stress.yy", "stress yy", "kPa", 1e-3),
    ("stress.zz", "stress zz", "kPa", 1e-3),
    ("stress.zx", "stress zx", "kPa", 1e-3),
];

/// How a column is shown; one that is not listed by its name, as it is recorded.
pub(crate) fn shown(column: &str) -> Shown {
    match SHOWN.iter().find(|(name, ..)| *name == column) {
        Some((_, words, "", factor)) => Shown { title: (*words).to_owned(), factor: *factor },
        Some((_, words, unit, factor)) => Shown { title: format!("{words} ({unit})"), factor: *factor },
        None => Shown { title: column.to_owned(), factor: 1.0 },
    }
}
