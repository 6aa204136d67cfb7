/// How the hydraulic conductivity follows the porosity.
///
/// The porosity itself follows the volume of the skeleton whatever the law, as the grains are incompressible:
///
/// ```text
/// n = 1 − (1 − n₀) / J        J = V / V₀
/// ```
pub trait ConductivityLaw: Send + Sync {
    /// The conductivity at a porosity n (–), up to a factor that is the same for all n.
    fn relative(&self, porosity: f64) -> f64;

    /// Brings conductivities (m/s) from old porosities to new ones: one virtual call for many particles.
    ///
    /// # Equation
    ///
    /// ```text
    /// k ← k · relative(n) / relative(n_old)
    /// ```
    fn update_block(&self, old: &[f64], new: &[f64], conductivities: &mut [f64]) {
        for ((conductivity, &old), &new) in conductivities.iter_mut().zip(old).zip(new) {
            *conductivity *= self.relative(new) / self.relative(old);
        }
    }
}

/// The conductivity stays what it was: for small strains.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ConstantConductivity;

impl ConductivityLaw for ConstantConductivity {
    fn relative(&self, _porosity: f64) -> f64 {
        1.0
    }

    fn update_block(&self, _old: &[f64], _new: &[f64], _conductivities: &mut [f64]) {}
}

/// The conductivity of Xie and Leo, for which large consolidation has a closed form.
///
/// # Equation
///
/// ```text
/// k = k₀ ((1+e)/(1+e₀))² = k₀ J²        1 + e = 1/(1−n)
/// ```
///
/// # Reference
///
/// K. H. Xie and C. J. Leo (2004), Comput. Geotech. 31, 301–314.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct XieLeo;

impl ConductivityLaw for XieLeo {
    fn relative(&self, porosity: f64) -> f64 {
        (1.0 - porosity).powi(-2)
    }
}

/// The conductivity of Kozeny and Carman, for grains of one size.
///
/// # Equation
///
/// ```text
/// k ∝ n³ / (1−n)²
/// ```
///
/// # Reference
///
/// P. C. Carman (1937), Trans. Inst. Chem. Eng. 15, 150–166.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct KozenyCarman;

impl ConductivityLaw for KozenyCarman {
    fn relative(&self, porosity: f64) -> f64 {
        porosity.powi(3) / (1.0 - porosity).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From n = 0.5 to 0.4: 1 + e goes from 2 to 5/3, e from 1 to 2/3.
    #[test]
    fn conductivities_follow_the_porosity() {
        let after = |law: &dyn ConductivityLaw| {
            let mut conductivity = [3e-5];
            law.update_block(&[0.5], &[0.4], &mut conductivity);
            conductivity[0]
        };
        assert_eq!(after(&ConstantConductivity), 3e-5);
        assert!((after(&XieLeo) - 3e-5 * 25.0 / 36.0).abs() < 1e-19);
        // n³/(1−n)² = e³/(1+e): 8/27 over 5/3, against 1 over 2.
        assert!((after(&KozenyCarman) - 3e-5 * 16.0 / 45.0).abs() < 1e-19);
    }

    /// Many small steps lead where one does.
    #[test]
    fn the_way_does_not_matter() {
        let mut conductivity = [1.0];
        for step in 0..1000 {
            let n = |step: i32| 0.6 - 0.3 * f64::from(step) / 1000.0;
            KozenyCarman.update_block(&[n(step)], &[n(step + 1)], &mut conductivity);
        }
        let expected = KozenyCarman.relative(0.3) / KozenyCarman.relative(0.6);
        assert!((conductivity[0] / expected - 1.0).abs() < 1e-12);
    }
}
