use super::cpgimp::{box_weights, first_node};
use super::{CellOnAxis, ShapeFunction, Weights};

/// Linear shape functions averaged over a box around the particle that keeps its first size (uniform GIMP).
///
/// The forces change smoothly when a particle passes from cell to cell: with [`Linear`](super::Linear) they jump, by the stress
/// times the particle's volume, which spoils large deformations. Where the material is stretched or pressed together much, gaps
/// or overlaps open between the boxes; [`CpGimp`](super::CpGimp) closes them.
///
/// # Equation
///
/// ```text
/// S_I(x_p) = 1/2l ∫ N_I dx over x_p − l … x_p + l      ∂S_I/∂x = (N_I(x_p + l) − N_I(x_p − l)) / 2l
/// ```
///
/// `l` is half the box at the start. A box that reaches beyond the end of the grid is cut there. The grid needs three cells along
/// each axis.
///
/// # Reference
///
/// S. G. Bardenhagen and E. M. Kober (2004), Comput. Model. Eng. Sci. 5, 477–495.
// ANCHOR: shape
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Gimp;

impl ShapeFunction for Gimp {
    const WIDTH: usize = 4;
    const REACH: f64 = 0.5;
    const BOX_STRETCHES: bool = false;

    #[inline(always)]
    fn first_node(&self, at: CellOnAxis) -> usize {
        first_node(at)
    }

    #[inline(always)]
    fn weights(&self, at: CellOnAxis, position: f64, half_size: f64) -> Weights {
        box_weights(at, position, half_size)
    }
}
// ANCHOR_END: shape
