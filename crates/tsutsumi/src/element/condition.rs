use super::Specimen;
use crate::tensor::Sym3;

/// A linear quantity of stress and strain, a : σ' + b : ε, that a test holds, drives or watches.
///
/// The named ones are those of soil mechanics: stresses and strains positive in compression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// The coefficients a of the effective stress.
    pub stress: Sym3,
    /// The coefficients b of the strain.
    pub strain: Sym3,
}

/// Unit coefficients: in a double contraction each shear component counts twice.
const UNIT: [Sym3; 6] = [
    Sym3::diagonal(1.0, 0.0, 0.0),
    Sym3::diagonal(0.0, 1.0, 0.0),
    Sym3::diagonal(0.0, 0.0, 1.0),
    Sym3 { xy: 0.5, ..Sym3::ZERO },
    Sym3 { yz: 0.5, ..Sym3::ZERO },
    Sym3 { zx: 0.5, ..Sym3::ZERO },
];

impl Condition {
    /// The mean effective stress p' = −⅓ tr σ' (Pa).
    pub const MEAN_STRESS: Condition = Self::of_stress(Sym3::diagonal(-1.0 / 3.0, -1.0 / 3.0, -1.0 / 3.0));
    /// The axial, or vertical, effective stress −σ'_zz (Pa).
    pub const AXIAL_STRESS: Condition = Self::of_stress(Sym3::diagonal(0.0, 0.0, -1.0));
    /// The radial, or horizontal, effective stress −σ'_xx (Pa).
    pub const RADIAL_STRESS: Condition = Self::of_stress(Sym3::diagonal(-1.0, 0.0, 0.0));
    /// The stress difference of the triaxial test, q = σ'_xx − σ'_zz (Pa): positive in compression, negative in extension.
    pub const STRESS_DIFFERENCE: Condition = Self::of_stress(Sym3::diagonal(1.0, 0.0, -1.0));
    /// The shear stress τ = σ'_zx (Pa) on horizontal planes.
    pub const SHEAR_STRESS: Condition = Self::of_stress(UNIT[5]);
    /// The axial, or vertical, strain ε_a = −ε_zz (–).
    pub const AXIAL_STRAIN: Condition = Self::of_strain(Sym3::diagonal(0.0, 0.0, -1.0));
    /// The volumetric strain ε_v = −tr ε (–).
    pub const VOLUMETRIC_STRAIN: Condition = Self::of_strain(Sym3::diagonal(-1.0, -1.0, -1.0));
    /// The engineering shear strain γ = 2 ε_zx (–) of horizontal planes.
    pub const SHEAR_STRAIN: Condition = Self::of_strain(Sym3 { zx: 1.0, ..Sym3::ZERO });

    /// A combination of stress components.
    pub const fn of_stress(stress: Sym3) -> Self {
        Condition { stress, strain: Sym3::ZERO }
    }

    /// A combination of strain components.
    pub const fn of_strain(strain: Sym3) -> Self {
        Condition { stress: Sym3::ZERO, strain }
    }

    /// The six stress components (Pa) xx, yy, zz, xy, yz, zx.
    pub fn stress_components() -> [Self; 6] {
        UNIT.map(Self::of_stress)
    }

    /// The six strain components (–, tensor shear) xx, yy, zz, xy, yz, zx.
    pub fn strain_components() -> [Self; 6] {
        UNIT.map(Self::of_strain)
    }

    /// The quantity for a stress (Pa) and a strain (–).
    pub fn value(&self, stress: Sym3, strain: Sym3) -> f64 {
        self.stress.double_dot(stress) + self.strain.double_dot(strain)
    }

    /// The quantity for a specimen as it is.
    pub fn of(&self, specimen: &Specimen) -> f64 {
        self.value(specimen.stress(), specimen.strain())
    }
}
