//! Shape functions N_I and their gradients G_Ip = ∇N_I(X_p).
//!
//! A shape function is a one-dimensional formula. The product over the axes, and every loop, is the library's: see
//! [`Transfer`](crate::transfer::Transfer).

mod bspline;
mod cpgimp;
mod gimp;
mod linear;

pub use bspline::{CubicBSpline, QuadraticBSpline};
pub use cpgimp::CpGimp;
pub use gimp::Gimp;
pub use linear::Linear;

/// The most nodes along one axis that a cell's points may touch.
pub const MAX_WIDTH: usize = 4;

/// A point's weights at the nodes of its cell's stencil along one axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Weights {
    /// N of each node (–).
    pub value: [f64; MAX_WIDTH],
    /// dN/dξ of each node, ξ measured in spacings (–).
    pub gradient: [f64; MAX_WIDTH],
}

/// A cell's place along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellOnAxis {
    /// The number of the cell along the axis.
    pub cell: usize,
    /// The number of cells along the axis.
    pub num_cells: usize,
}

/// A one-dimensional shape function. `check_shape` of the testkit says whether one keeps this contract.
///
/// All points of one cell share a stencil: the nodes `first_node .. first_node + WIDTH`. Nodes of the stencil that a
/// point does not reach get zeros.
#[doc(alias = "Eq. (7)")]
pub trait ShapeFunction: Send + Sync + 'static {
    /// Nodes per axis in the stencil of a cell, from 2 to [`MAX_WIDTH`].
    const WIDTH: usize;

    /// How far the boxes of a cell's points may reach beyond it (spacings); 0 where boxes play no part.
    const REACH: f64;

    /// Whether the box follows the stretch of the material; otherwise it keeps the size that it had at the start.
    const BOX_STRETCHES: bool = true;

    /// The first node of a cell's stencil.
    fn first_node(&self, at: CellOnAxis) -> usize;

    /// The weights of a point of this cell.
    ///
    /// `position` is measured in spacings from the origin of the grid, `half_size` is half the particle's length in
    /// spacings. Values sum to 1, gradients to 0.
    fn weights(&self, at: CellOnAxis, position: f64, half_size: f64) -> Weights;

    /// Nodes per axis that a point reaches, at least two, where it is fewer than the stencil has, and the same wherever the point is.
    const REACHED: usize = Self::WIDTH;

    /// The number of the first node that a point of this cell reaches, and the weights from that node on: what [`weights`](Self::weights) says,
    /// without the zeros. The sums over particles ask for these.
    #[inline(always)]
    fn reached_weights(&self, at: CellOnAxis, position: f64, half_size: f64) -> (usize, Weights) {
        (self.first_node(at), self.weights(at, position, half_size))
    }
}
