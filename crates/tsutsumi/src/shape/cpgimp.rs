use super::{CellOnAxis, ShapeFunction, Weights};

/// Linear shape functions averaged over the particle's box, which stretches with the material (contiguous-particle GIMP).
///
/// The boxes of a body stay side by side while it deforms along the axes, so that a uniform stress stays in equilibrium. Shear
/// and rotation do not change them: each axis stretches by itself.
///
/// # Equation
///
/// ```text
/// S_I(x_p) = 1/2l ∫ N_I dx over x_p − l … x_p + l      ∂S_I/∂x = (N_I(x_p + l) − N_I(x_p − l)) / 2l
/// l ← l (1 + Δt ∂v/∂x)
/// ```
///
/// `l` is half the box. A box that reaches beyond the end of the grid is cut there. One that is stretched beyond two spacings is
/// averaged over two: the stencil holds no more nodes. The grid needs three cells along each axis.
///
/// # Reference
///
/// S. G. Bardenhagen and E. M. Kober (2004), Comput. Model. Eng. Sci. 5, 477–495; the stretching boxes: P. C. Wallstedt and
/// J. E. Guilkey (2008), J. Comput. Phys. 227, 9628–9642.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CpGimp;

impl ShapeFunction for CpGimp {
    const WIDTH: usize = 4;
    const REACH: f64 = 0.5;

    #[inline(always)]
    fn first_node(&self, at: CellOnAxis) -> usize {
        first_node(at)
    }

    #[inline(always)]
    fn weights(&self, at: CellOnAxis, position: f64, half_size: f64) -> Weights {
        box_weights(at, position, half_size)
    }
}

/// A node on each side of the cell; at the ends of the grid the stencil moves inwards. In 32 bits, so that loops over points become vectors.
#[inline(always)]
pub(super) fn first_node(at: CellOnAxis) -> usize {
    (at.cell as u32).saturating_sub(1).min((at.num_cells as u32).saturating_sub(3)) as usize
}

/// The linear functions averaged over a box.
#[inline(always)]
pub(super) fn box_weights(at: CellOnAxis, position: f64, half_size: f64) -> Weights {
    let first = f64::from(first_node(at) as u32);
    let half_size = half_size.min(1.0);
    let from = (position - half_size).max(0.0);
    let to = (position + half_size).min(f64::from(at.num_cells as u32));
    // A point: the functions are straight in its cell, whose mean and slopes say what they are beside its centre. Choices instead of
    // branches: loops over points become vectors.
    let is_point = to - from < SHORTEST;
    // Forces act on points beyond the cell, too.
    let cell = f64::from(at.cell as u32).max(position.ceil() - 1.0).min(position.floor());
    let from = if is_point { cell } else { from };
    let to = if is_point { cell + 1.0 } else { to };
    let beside = if is_point { position - cell - 0.5 } else { 0.0 };
    let per_length = 1.0 / (to - from);
    let mut weights = Weights::default();
    for k in 0..4 {
        let node = first + k as f64;
        let (start, end) = (Hat::at(from - node), Hat::at(to - node));
        let mean = (end.integral - start.integral) * per_length;
        weights.gradient[k] = (start.drop - end.drop) * per_length;
        weights.value[k] = mean + weights.gradient[k] * beside;
    }
    weights
}

/// Boxes shorter than this part of a spacing count as points: differences over them would lose half of their digits.
const SHORTEST: f64 = 1e-8;

/// The linear shape function of the node at 0, N = 1 − |x| up to ±1.
struct Hat {
    /// 1 − N.
    drop: f64,
    /// The integral of N from 0.
    integral: f64,
}

impl Hat {
    #[inline(always)]
    fn at(x: f64) -> Self {
        let x = x.clamp(-1.0, 1.0);
        let drop = x.abs();
        Hat { drop, integral: x * (1.0 - 0.5 * drop) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::shape::Linear;

    proptest! {
        /// Σ S = 1, Σ S x_I = x_p, Σ ∂S = 0, Σ ∂S x_I = 1: boxes that straddle grid lines included.
        #[test]
        fn partition_of_unity_and_linear_completeness(cell in 1_usize..9, xi in 0.0..1.0_f64, half in 0.0..0.5_f64) {
            let at = CellOnAxis { cell, num_cells: 10 };
            let position = cell as f64 + xi;
            let weights = CpGimp.weights(at, position, half);
            let node = |k: usize| (CpGimp.first_node(at) + k) as f64;
            let sum = |values: &[f64; 4], power: i32| (0..4).map(|k| values[k] * node(k).powi(power)).sum::<f64>();
            // Differences over a box of length 2l lose ε/2l.
            let lost = 1e-14 / half.max(1e-8);
            prop_assert!((sum(&weights.value, 0) - 1.0).abs() < lost);
            prop_assert!((sum(&weights.value, 1) - position).abs() < 10.0 * lost);
            prop_assert!(sum(&weights.gradient, 0).abs() < lost);
            prop_assert!((sum(&weights.gradient, 1) - 1.0).abs() < 10.0 * lost);
        }

        /// A box inside a cell: the linear functions at its centre.
        #[test]
        fn inside_a_cell_the_mean_is_the_value_at_the_centre(cell in 0_usize..10, xi in 0.1..0.9_f64, part in 0.0..1.0_f64) {
            let at = CellOnAxis { cell, num_cells: 10 };
            let half = part * xi.min(1.0 - xi);
            let (mean, value) = (CpGimp.weights(at, cell as f64 + xi, half), Linear.weights(at, cell as f64 + xi, half));
            let shift = cell - CpGimp.first_node(at);
            for k in 0..2 {
                prop_assert!((mean.value[k + shift] - value.value[k]).abs() < 1e-6);
                prop_assert!((mean.gradient[k + shift] - value.gradient[k]).abs() < 1e-6);
            }
        }
    }

    /// At the ends of the grid the stencil moves inwards, and a box that sticks out is cut.
    #[test]
    fn stencils_stay_in_the_grid() {
        let first = [0, 1, 2, 4].map(|cell| CpGimp.first_node(CellOnAxis { cell, num_cells: 5 }));
        assert_eq!(first, [0, 0, 1, 2]);
        let at = CellOnAxis { cell: 0, num_cells: 5 };
        let (cut, whole) = (CpGimp.weights(at, 0.1, 0.3), CpGimp.weights(at, 0.2, 0.2));
        for k in 0..4 {
            assert!(
                (cut.value[k] - whole.value[k]).abs() < 1e-15 && (cut.gradient[k] - whole.gradient[k]).abs() < 1e-15
            );
        }
        // Half of a box in each of two cells: 3/4 of the middle node, by the area under the hat.
        let at = CellOnAxis { cell: 2, num_cells: 5 };
        let weights = CpGimp.weights(at, 2.0, 0.5);
        assert_eq!((weights.value, weights.gradient), ([0.125, 0.75, 0.125, 0.0], [-0.5, 0.0, 0.5, 0.0]));
    }
}
