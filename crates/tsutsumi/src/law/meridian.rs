use crate::tensor::{Matrix6, Sym3};

/// A stress in its meridian plane: mean stress σ_m and √J₂ (Pa, tension positive), and the direction of its deviator.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meridian {
    pub(super) mean: f64,
    /// √J₂ = √(½ s:s), not negative.
    pub(super) shear: f64,
    /// The deviator over √J₂ (–); zero where there is none.
    direction: Sym3,
}

/// A return to a yield surface within the meridian plane: the new point, and how it moves with the trial point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Return {
    pub(super) mean: f64,
    pub(super) shear: f64,
    /// [[∂σ_m/∂σ_m,tr, ∂σ_m/∂√J₂,tr], [∂√J₂/∂σ_m,tr, ∂√J₂/∂√J₂,tr]] (–).
    pub(super) derivative: [[f64; 2]; 2],
}

impl Meridian {
    pub(super) fn of(stress: Sym3) -> Self {
        let deviator = stress.deviator();
        let shear = (0.5 * deviator.double_dot(deviator)).sqrt();
        let direction = if shear > 0.0 { deviator * (1.0 / shear) } else { Sym3::ZERO };
        Meridian { mean: stress.trace() / 3.0, shear, direction }
    }

    /// The stress with the same direction elsewhere in the plane.
    pub(super) fn stress_at(&self, mean: f64, shear: f64) -> Sym3 {
        Sym3::IDENTITY * mean + self.direction * shear
    }

    /// The consistent tangent of a return from this trial state, from moduli K and G (Pa).
    ///
    /// ```text
    /// δσ_m,tr = K tr δε      δ√J₂,tr = G n : δε      δs = n δ√J₂ + √J₂/√J₂,tr (2 G δe − n G n : δε)      n = s_tr/√J₂,tr
    /// ```
    pub(super) fn tangent(&self, end: &Return, bulk_modulus: f64, shear_modulus: f64) -> Matrix6 {
        let unit = Sym3::IDENTITY.to_kelvin();
        let direction = self.direction.to_kelvin();
        let share = if self.shear > 0.0 { end.shear / self.shear } else { end.derivative[1][1] };
        let deviatoric = Matrix6::identity() - unit * unit.transpose() / 3.0;
        let [mean_row, shear_row] = end.derivative.map(|[by_mean, by_shear]| {
            unit.transpose() * (by_mean * bulk_modulus) + direction.transpose() * (by_shear * shear_modulus)
        });
        unit * mean_row
            + direction * (shear_row - direction.transpose() * (share * shear_modulus))
            + deviatoric * (2.0 * share * shear_modulus)
    }
}
