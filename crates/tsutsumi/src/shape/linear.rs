use super::{CellOnAxis, ShapeFunction, Weights};

/// Linear shape functions: the isoparametric element of the paper on a grid of boxes.
///
/// # Equation
///
/// ```text
/// N_0 = 1 − ξ      N_1 = ξ      ξ = 0…1 within the cell
/// ```
///
/// # Reference
///
/// Goto et al., sec. 2.1; Sulsky, Chen and Schreyer (1994), Comput. Methods Appl. Mech. Eng. 118, 179–196.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Linear;

impl ShapeFunction for Linear {
    const WIDTH: usize = 2;
    const REACH: f64 = 0.0;

    #[inline(always)]
    fn first_node(&self, at: CellOnAxis) -> usize {
        at.cell
    }

    #[inline(always)]
    fn weights(&self, at: CellOnAxis, position: f64, _half_size: f64) -> Weights {
        let xi = position - f64::from(at.cell as u32);
        Weights { value: [1.0 - xi, xi, 0.0, 0.0], gradient: [-1.0, 1.0, 0.0, 0.0] }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn partition_of_unity_and_linear_completeness(cell in 0_usize..50, xi in 0.0..1.0_f64) {
            let at = CellOnAxis { cell, num_cells: 50 };
            let position = cell as f64 + xi;
            let weights = Linear.weights(at, position, 0.25);
            let node = |k: usize| (Linear.first_node(at) + k) as f64;
            let sum = |values: &[f64; 4], power: i32| (0..2).map(|k| values[k] * node(k).powi(power)).sum::<f64>();
            prop_assert!((sum(&weights.value, 0) - 1.0).abs() < 1e-14);
            prop_assert!((sum(&weights.value, 1) - position).abs() < 1e-13);
            prop_assert!(sum(&weights.gradient, 0).abs() < 1e-14);
            prop_assert!((sum(&weights.gradient, 1) - 1.0).abs() < 1e-13);
        }
    }
}
