use super::Condition;
use crate::tensor::Sym3;

/// What happens to the volume while a specimen is sheared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Drainage {
    /// The water flows freely: in a triaxial test the radial effective stress stays, in simple shear the vertical one.
    #[default]
    Drained,
    /// No water leaves or enters: the volume stays.
    Undrained,
    /// The mean effective stress stays.
    ConstantMeanStress,
}

/// How a specimen is held and driven: six linear conditions, and how fast the value of each grows with the loading parameter.
///
/// # Equation
///
/// ```text
/// a_i : σ' + b_i : ε = c_i + λ r_i      i = 1 … 6,   c_i the value at the start
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loading {
    /// What is held or driven.
    pub conditions: [Condition; 6],
    /// The rates r_i: the change of each value per unit of the loading parameter λ. 0 for what is held.
    pub rates: [f64; 6],
}

/// σ'_xx − σ'_yy: radial stresses stay alike.
const RADIAL_DIFFERENCE: Condition = Condition::of_stress(Sym3::diagonal(1.0, -1.0, 0.0));

impl Loading {
    /// Five quantities that are held, and one that is driven: λ is its change.
    pub fn driving(driven: Condition, held: [Condition; 5]) -> Self {
        let [a, b, c, d, e] = held;
        Loading { conditions: [driven, a, b, c, d, e], rates: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0] }
    }

    /// Isotropic loading: the three normal stresses change alike, shear stresses stay. Drive the mean stress or the volumetric strain.
    pub fn isotropic(driven: Condition) -> Self {
        let [xx, _, zz, xy, yz, zx] = Condition::stress_components();
        let difference = Condition::of_stress(xx.stress - zz.stress);
        Self::driving(driven, [RADIAL_DIFFERENCE, difference, xy, yz, zx])
    }

    /// Uniaxial strain: the oedometer, and consolidation at rest (K₀). Drive the axial strain or stress.
    pub fn uniaxial_strain(driven: Condition) -> Self {
        let [xx, yy, _, xy, yz, zx] = Condition::strain_components();
        Self::driving(driven, [xx, yy, xy, yz, zx])
    }

    /// Triaxial compression and extension. Drive the axial strain or the stress difference.
    pub fn triaxial(drainage: Drainage, driven: Condition) -> Self {
        let [xx, _, _, xy, yz, zx] = Condition::stress_components();
        let kept = match drainage {
            Drainage::Drained => xx,
            Drainage::Undrained => Condition::VOLUMETRIC_STRAIN,
            Drainage::ConstantMeanStress => Condition::MEAN_STRESS,
        };
        Self::driving(driven, [kept, RADIAL_DIFFERENCE, xy, yz, zx])
    }

    /// Direct simple shear in the plane zx, between rigid rings: no horizontal strain. Drive the shear strain or stress.
    pub fn simple_shear(drainage: Drainage, driven: Condition) -> Self {
        let [xx, yy, _, xy, yz, _] = Condition::strain_components();
        let kept = match drainage {
            Drainage::Drained => Condition::AXIAL_STRESS,
            Drainage::Undrained => Condition::VOLUMETRIC_STRAIN,
            Drainage::ConstantMeanStress => Condition::MEAN_STRESS,
        };
        Self::driving(driven, [kept, xx, yy, xy, yz])
    }
}
