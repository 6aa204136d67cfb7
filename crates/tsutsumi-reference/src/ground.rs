//! The parameters of a linear elastic, saturated ground that the coupled reference solutions share.

/// A linear elastic, isotropic skeleton filled with a compressible fluid; the grains are incompressible (Biot's α = 1).
///
/// # Equation
///
/// ```text
/// σ = σ' − p_w I        σ' = λ tr(ε) I + 2 G ε        tr(ε̇) + (n/K^f) ṗ_w = (k/γ_w) ∇²p_w
/// ```
///
/// Stress and strain are positive in tension, the pressure in compression.
///
/// # Validity
///
/// `young`, `conductivity`, `unit_weight` and `fluid_modulus` above zero, `poisson` between −1 and 0.5 (both excluded),
/// `porosity` between 0 and 1. Nothing is checked here: other values give infinities or NaN.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Young's modulus E of the drained skeleton (Pa).
    pub young: f64,
    /// Poisson's ratio ν of the drained skeleton (–), below 0.5.
    pub poisson: f64,
    /// Hydraulic conductivity k (m/s).
    pub conductivity: f64,
    /// Unit weight of the fluid γ_w (N/m³), to which the conductivity belongs.
    pub unit_weight: f64,
    /// Porosity n (–).
    pub porosity: f64,
    /// Bulk modulus of the fluid K^f (Pa); `inf` for an incompressible fluid.
    pub fluid_modulus: f64,
}

impl Ground {
    /// The shear modulus G = E/(2(1+ν)) (Pa).
    pub fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// The drained bulk modulus K = E/(3(1−2ν)) (Pa).
    pub fn bulk_modulus(&self) -> f64 {
        self.young / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// Lamé's first parameter λ = K − 2G/3 (Pa).
    pub fn lame_modulus(&self) -> f64 {
        self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }

    /// The oedometric modulus λ + 2G (Pa).
    pub fn oedometric_modulus(&self) -> f64 {
        self.lame_modulus() + 2.0 * self.shear_modulus()
    }

    /// The mobility of the fluid k/γ_w (m²/(Pa s)).
    pub fn mobility(&self) -> f64 {
        self.conductivity / self.unit_weight
    }

    /// The compressibility of the fluid per volume of ground n/K^f (1/Pa).
    pub fn fluid_compressibility(&self) -> f64 {
        self.porosity / self.fluid_modulus
    }

    /// The storage under uniaxial strain 1/(λ+2G) + n/K^f (1/Pa).
    pub fn storage(&self) -> f64 {
        1.0 / self.oedometric_modulus() + self.fluid_compressibility()
    }

    /// The coefficient of consolidation c = (k/γ_w) / (1/(λ+2G) + n/K^f) (m²/s).
    pub fn consolidation_coefficient(&self) -> f64 {
        self.mobility() / self.storage()
    }

    /// Skempton's coefficient B = 1/(1 + n K/K^f) (–): the share of an undrained mean stress that the fluid takes.
    pub fn skempton_coefficient(&self) -> f64 {
        1.0 / (1.0 + self.fluid_compressibility() * self.bulk_modulus())
    }

    /// The undrained Poisson's ratio ν_u = (3ν + B(1−2ν)) / (3 − B(1−2ν)) (–).
    pub fn undrained_poisson(&self) -> f64 {
        let coupling = self.skempton_coefficient() * (1.0 - 2.0 * self.poisson);
        (3.0 * self.poisson + coupling) / (3.0 - coupling)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND: Ground = Ground {
        young: 10e6,
        poisson: 0.2,
        conductivity: 1e-5,
        unit_weight: 9800.0,
        porosity: 0.4,
        fluid_modulus: 2.2e9,
    };

    /// The constants as the independent program that made the curves of Mandel's problem prints them.
    #[test]
    fn constants_agree_with_an_independent_program() {
        let printed = [
            (GROUND.shear_modulus(), 4166.666666666667e3),
            (GROUND.bulk_modulus(), 5555.555555555556e3),
            (GROUND.oedometric_modulus(), 11111.11111111111e3),
            (GROUND.consolidation_coefficient(), 0.011315009874917709),
            (GROUND.skempton_coefficient(), 0.9989909182643794),
            (GROUND.undrained_poisson(), 0.4996216897856242),
        ];
        for (value, expected) in printed {
            // Round-off of a few operations.
            assert!((value / expected - 1.0).abs() < 1e-14, "{value} is not {expected}");
        }
    }

    #[test]
    fn an_incompressible_fluid_takes_everything() {
        let ground = Ground { fluid_modulus: f64::INFINITY, ..GROUND };
        assert_eq!(ground.skempton_coefficient(), 1.0);
        // ν_u = (3ν + 1 − 2ν)/(3 − 1 + 2ν) = ½
        assert!((ground.undrained_poisson() - 0.5).abs() < 1e-15);
    }

    #[test]
    fn it_is_read_by_the_names_of_its_fields_and_no_others() {
        let text = r#"{ "young": 10e6, "poisson": 0.2, "conductivity": 1e-5, "unit_weight": 9800.0, "porosity": 0.4,
            "fluid_modulus": 2.2e9 }"#;
        assert_eq!(serde_json::from_str::<Ground>(text).unwrap(), GROUND);
        let misspelt = text.replace("young", "youngs");
        assert!(serde_json::from_str::<Ground>(&misspelt).unwrap_err().to_string().contains("youngs"));
    }
}
