//! The stiffness: moduli that bound it, and the tangent that is it.

use tsutsumi::law::ConstitutiveLaw;
use tsutsumi::tensor::{Matrix6, Sym3};

use super::{LawPath, LawViolation, Point};

impl LawPath {
    /// Along each axis and in each plane, by a small compression or shear from the present state.
    pub(super) fn moduli_bound_the_stiffness<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
    ) -> Result<(), LawViolation> {
        let compression = law.p_wave_modulus(point.stress, &point.state);
        let shear = law.s_wave_modulus(point.stress, &point.state);
        if !(compression.is_finite() && shear.is_finite()) {
            return Err(LawViolation::NotFinite { increment, what: "a wave modulus" });
        }
        let size = 1e-3 * self.strain;
        for &component in self.components() {
            let strain = unit(component) * -size;
            let change = point.update(law, increment, strain)?.stress - point.stress;
            // In Kelvin components the shear stiffness is 2 G.
            let kelvin = change.to_kelvin()[component] / -size;
            // The stiffness may grow over the small increment itself.
            if component < 3 && kelvin > compression * (1.0 + 1e-3) {
                return Err(LawViolation::CompressionModulus { increment, stiffness: kelvin, bound: compression });
            }
            if component >= 3 && 0.5 * kelvin > shear * (1.0 + 1e-3) {
                return Err(LawViolation::ShearModulus { increment, stiffness: 0.5 * kelvin, bound: shear });
            }
        }
        Ok(())
    }
}

/// The tensor whose Kelvin components are zero but for one, which is 1.
fn unit(component: usize) -> Sym3 {
    Sym3::from_kelvin(&Matrix6::identity().column(component).into_owned())
}

/// The tangent against one-sided and central difference quotients, where the stress has a derivative.
pub(super) fn tangent_is_the_derivative<L: ConstitutiveLaw>(
    law: &L,
    increment: usize,
    point: &Point<L::State>,
    strain: Sym3,
    columns: &[usize],
) -> Result<(), LawViolation> {
    let tangent =
        law.tangent(point.stress, point.state, strain).map_err(|source| LawViolation::Failed { increment, source })?;
    if !tangent.iter().all(|value| value.is_finite()) {
        return Err(LawViolation::NotFinite { increment, what: "the tangent" });
    }
    // Rounding of the stress over this step is 1e-8 of a modulus, curvature over it 1e-4 of its change in an increment.
    let step = 1e-4 * strain.norm();
    let scale = tangent.norm();
    let center = point.update(law, increment, strain)?.stress.to_kelvin();
    for &column in columns {
        let nudge = unit(column) * step;
        let forward = (point.update(law, increment, strain + nudge)?.stress.to_kelvin() - center) / step;
        let backward = (center - point.update(law, increment, strain - nudge)?.stress.to_kelvin()) / step;
        // A kink, as at first yield: there is no derivative.
        if (forward - backward).norm() > 1e-2 * scale {
            continue;
        }
        let off = ((forward + backward) * 0.5 - tangent.column(column)).norm();
        if off > 1e-4 * scale {
            return Err(LawViolation::Tangent { increment, column, off });
        }
    }
    Ok(())
}
