//! What every shape function must satisfy: [`check_shape`].
//!
//! ```
//! use tsutsumi::shape::Linear;
//! use tsutsumi_testkit::shape::check_shape;
//!
//! check_shape(&Linear).unwrap();
//! ```

use tsutsumi::shape::{CellOnAxis, MAX_WIDTH, ShapeFunction, Weights};

use crate::noise::Noise;

/// Where a shape function breaks its contract.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The cell.
    pub at: CellOnAxis,
    /// The point (spacings from the origin of the grid).
    pub position: f64,
    /// Half the box around it (spacings).
    pub half_size: f64,
}

/// How a shape function breaks its contract.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeViolation {
    /// More nodes than a stencil may have, or fewer than two.
    #[error("WIDTH is {width}, a stencil has 2 to {MAX_WIDTH} nodes per axis")]
    Width {
        /// The nodes per axis.
        width: usize,
    },
    /// The stencil of a cell has nodes beyond the end of the grid.
    #[error("the stencil of {at:?} ends at node {last}, beyond the end of the grid")]
    Stencil {
        /// The cell.
        at: CellOnAxis,
        /// Its last node.
        last: usize,
    },
    /// A node beyond WIDTH has a weight, so that the loops miss a part.
    #[error("{place:?}: node {local} of the stencil has a weight, beyond WIDTH")]
    Support {
        /// Where.
        place: Place,
        /// The node's number in the stencil.
        local: usize,
    },
    /// The weights of the nodes that a point reaches are not those of the stencil: the sums over particles ask for them.
    #[error("{place:?}: `reached_weights` has another weight for node {local} of the stencil than `weights`")]
    Reached {
        /// Where.
        place: Place,
        /// The node's number in the stencil.
        local: usize,
    },
    /// A value is negative, or not a number: nodes could get negative masses.
    #[error("{place:?}: node {local} of the stencil has the value {value:e}")]
    Negative {
        /// Where.
        place: Place,
        /// The node's number in the stencil.
        local: usize,
        /// Its value (–).
        value: f64,
    },
    /// A sum over the nodes is not what a constant or a linear field demands.
    #[error("{place:?}: {sum} is {found:e}, expected {expected:e}")]
    Sum {
        /// Where.
        place: Place,
        /// Which sum.
        sum: &'static str,
        /// What it is.
        found: f64,
        /// What it must be.
        expected: f64,
    },
    /// The gradient is not the derivative of the value.
    #[error("{place:?}: the gradient at node {local} is {off:e} off the difference quotient")]
    Gradient {
        /// Where.
        place: Place,
        /// The node's number in the stencil.
        local: usize,
        /// The difference (–).
        off: f64,
    },
    /// A node's value jumps on the line between two cells.
    #[error("{place:?}: the value of node {node} jumps by {jump:e} to the next cell")]
    Jump {
        /// Where, in the lower cell.
        place: Place,
        /// The number of the node along the axis.
        node: usize,
        /// The jump (–).
        jump: f64,
    },
    /// The lower and the upper end of the grid are not alike.
    #[error("{place:?}: the mirrored point has weights that are {off:e} off the mirrored ones")]
    Mirror {
        /// Where.
        place: Place,
        /// The largest difference (–).
        off: f64,
    },
}

/// Sums of four products of numbers up to 10 lose some epsilons; differences over the shortest box, 0.1, ten times as many.
const ROUND_OFF: f64 = 1e-13;

/// Checks a shape function in every cell of grids from the smallest that holds a stencil to nine cells: partition of unity,
/// linear completeness, no negative value, gradients against differences, stencil within the grid, continuity from cell to cell,
/// ends that are alike and where the end node decides alone.
///
/// # Errors
/// The first violation.
pub fn check_shape<S: ShapeFunction>(shape: &S) -> Result<(), ShapeViolation> {
    if S::WIDTH < 2 || S::WIDTH > MAX_WIDTH {
        return Err(ShapeViolation::Width { width: S::WIDTH });
    }
    for num_cells in S::WIDTH - 1..=9 {
        for cell in 0..num_cells {
            check_cell(shape, CellOnAxis { cell, num_cells })?;
        }
    }
    Ok(())
}

fn check_cell<S: ShapeFunction>(shape: &S, at: CellOnAxis) -> Result<(), ShapeViolation> {
    let last = shape.first_node(at) + S::WIDTH - 1;
    if last > at.num_cells {
        return Err(ShapeViolation::Stencil { at, last });
    }
    let (lower, upper) = (at.cell as f64, at.cell as f64 + 1.0);
    let mut noise = Noise::new(at.cell as u64);
    let random = std::array::from_fn::<_, 20, _>(|_| 0.5 + 0.5 * noise.number());
    for xi in [0.0, 1e-9, 0.25, 0.5, 0.75, 1.0 - 1e-9, 1.0].into_iter().chain(random) {
        for half_size in [0.0, 0.05, 0.125, 0.25, 0.4, 0.5] {
            let place = Place { at, position: lower + xi, half_size };
            check_values(shape, place)?;
            check_gradients(shape, place)?;
            check_mirror(shape, place)?;
        }
    }
    // Points that the boxes of the cell's particles reach: forces act there.
    for part in 0..=10 {
        let position = lower - S::REACH + f64::from(part) / 10.0 * (1.0 + 2.0 * S::REACH);
        check_values(shape, Place { at, position: position.clamp(0.0, at.num_cells as f64), half_size: 0.0 })?;
    }
    if at.cell + 1 < at.num_cells {
        check_line(shape, Place { at, position: upper, half_size: 0.0 })?;
        check_line(shape, Place { at, position: upper, half_size: 0.25 })?;
    }
    check_ends(shape, at)
}

fn weights_at<S: ShapeFunction>(shape: &S, place: Place) -> Weights {
    shape.weights(place.at, place.position, place.half_size)
}

/// Whether the end of the grid cuts the box, which moves its middle.
fn is_cut(place: Place) -> bool {
    place.position < place.half_size || place.position > place.at.num_cells as f64 - place.half_size
}

/// Σ N = 1, Σ N x_I = x, N ≥ 0, nothing beyond WIDTH.
fn check_values<S: ShapeFunction>(shape: &S, place: Place) -> Result<(), ShapeViolation> {
    let weights = weights_at(shape, place);
    for (local, (&value, &gradient)) in weights.value.iter().zip(&weights.gradient).enumerate() {
        if local >= S::WIDTH && (value != 0.0 || gradient != 0.0) {
            return Err(ShapeViolation::Support { place, local });
        }
        if value.is_nan() || value < -ROUND_OFF {
            return Err(ShapeViolation::Negative { place, local, value });
        }
    }
    check_reached(shape, place, &weights)?;
    expect_sum(place, "Σ N", weights.value.iter().sum(), 1.0)?;
    if !is_cut(place) {
        expect_sum(place, "Σ N x", first_moment(shape, place.at, &weights.value), place.position)?;
    }
    Ok(())
}

/// Σ G = 0, Σ G x_I = 1, and G the derivative of N.
fn check_gradients<S: ShapeFunction>(shape: &S, place: Place) -> Result<(), ShapeViolation> {
    let weights = weights_at(shape, place);
    expect_sum(place, "Σ G", weights.gradient.iter().sum(), 0.0)?;
    expect_sum(place, "Σ G x", first_moment(shape, place.at, &weights.gradient), 1.0)?;
    let step = 1e-6;
    let xi = place.position - place.at.cell as f64;
    if xi < step || xi > 1.0 - step || is_cut(Place { half_size: place.half_size + step, ..place }) {
        return Ok(());
    }
    let moved = |by: f64| weights_at(shape, Place { position: place.position + by, ..place }).value;
    let (before, after) = (moved(-step), moved(step));
    for local in 0..S::WIDTH {
        let off = (weights.gradient[local] - (after[local] - before[local]) / (2.0 * step)).abs();
        // The step times a jump of the second derivative, up to 1/2l = 10, and 1e-16 over the step.
        if off.is_nan() || off > 1e-5 {
            return Err(ShapeViolation::Gradient { place, local, off });
        }
    }
    Ok(())
}

/// What is true seen from one end of the grid is true from the other.
fn check_mirror<S: ShapeFunction>(shape: &S, place: Place) -> Result<(), ShapeViolation> {
    let num_cells = place.at.num_cells;
    let mirrored = CellOnAxis { cell: num_cells - 1 - place.at.cell, num_cells };
    let other = weights_at(shape, Place { at: mirrored, position: num_cells as f64 - place.position, ..place });
    let here = weights_at(shape, place);
    let (first, mirrored_first) = (shape.first_node(place.at), shape.first_node(mirrored));
    // By node number: stencils need not be mirrored, their weights do.
    for node in 0..=num_cells {
        let here = of_node::<S>(&here, first, node);
        let there = of_node::<S>(&other, mirrored_first, num_cells - node);
        let off = (here.0 - there.0).abs().max((here.1 + there.1).abs());
        // Points a rounding away from a kink of N may see the other slope there: only values are compared on grid lines.
        let is_on_line = place.half_size == 0.0 && place.position.fract() == 0.0;
        let off = if is_on_line { (here.0 - there.0).abs() } else { off };
        if off > 10.0 * ROUND_OFF {
            return Err(ShapeViolation::Mirror { place, off });
        }
    }
    Ok(())
}

/// On the line between two cells both give every node the same value.
fn check_line<S: ShapeFunction>(shape: &S, place: Place) -> Result<(), ShapeViolation> {
    let next = CellOnAxis { cell: place.at.cell + 1, ..place.at };
    let (lower, upper) = (weights_at(shape, place), weights_at(shape, Place { at: next, ..place }));
    let (first, next_first) = (shape.first_node(place.at), shape.first_node(next));
    for node in 0..=place.at.num_cells {
        let jump = of_node::<S>(&lower, first, node).0 - of_node::<S>(&upper, next_first, node).0;
        if jump.abs() > ROUND_OFF {
            return Err(ShapeViolation::Jump { place, node, jump });
        }
    }
    Ok(())
}

/// At the ends of the grid the end node decides alone, so that supports hold there.
fn check_ends<S: ShapeFunction>(shape: &S, at: CellOnAxis) -> Result<(), ShapeViolation> {
    for end in [0, at.num_cells] {
        if end == at.cell || (end == at.num_cells && end == at.cell + 1) {
            let place = Place { at, position: end as f64, half_size: 0.0 };
            let found = of_node::<S>(&weights_at(shape, place), shape.first_node(at), end).0;
            expect_sum(place, "N of the end node", found, 1.0)?;
        }
    }
    Ok(())
}

/// Value and gradient of a node of the axis; zeros outside the stencil.
fn of_node<S: ShapeFunction>(weights: &Weights, first: usize, node: usize) -> (f64, f64) {
    match node.checked_sub(first) {
        Some(local) if local < S::WIDTH => (weights.value[local], weights.gradient[local]),
        _ => (0.0, 0.0),
    }
}

/// The weights of the reached nodes are those of the stencil, the others are zero.
fn check_reached<S: ShapeFunction>(shape: &S, place: Place, weights: &Weights) -> Result<(), ShapeViolation> {
    let (first, reached) = shape.reached_weights(place.at, place.position, place.half_size);
    for local in 0..S::WIDTH {
        let expected = match (shape.first_node(place.at) + local).checked_sub(first) {
            Some(k) if k < S::REACHED => (reached.value[k], reached.gradient[k]),
            _ => (0.0, 0.0),
        };
        if (weights.value[local], weights.gradient[local]) != expected {
            return Err(ShapeViolation::Reached { place, local });
        }
    }
    Ok(())
}

fn first_moment<S: ShapeFunction>(shape: &S, at: CellOnAxis, of: &[f64; MAX_WIDTH]) -> f64 {
    let first = shape.first_node(at);
    of.iter().enumerate().map(|(local, weight)| weight * (first + local) as f64).sum()
}

fn expect_sum(place: Place, sum: &'static str, found: f64, expected: f64) -> Result<(), ShapeViolation> {
    let off = (found - expected).abs();
    if off.is_nan() || off > 10.0 * ROUND_OFF {
        return Err(ShapeViolation::Sum { place, sum, found, expected });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline};

    use super::*;

    #[test]
    fn the_shape_functions_of_the_library_pass() {
        check_shape(&Linear).unwrap();
        check_shape(&Gimp).unwrap();
        check_shape(&CpGimp).unwrap();
        check_shape(&QuadraticBSpline).unwrap();
        check_shape(&CubicBSpline).unwrap();
    }

    /// Linear functions with a fault.
    struct Faulty(fn(f64) -> Weights);

    impl ShapeFunction for Faulty {
        const WIDTH: usize = 2;
        const REACH: f64 = 0.0;

        fn first_node(&self, at: CellOnAxis) -> usize {
            at.cell
        }

        fn weights(&self, at: CellOnAxis, position: f64, _half_size: f64) -> Weights {
            (self.0)(position - at.cell as f64)
        }
    }

    #[test]
    fn faults_are_found() {
        let steep = Faulty(|xi| Weights { value: [1.0 - xi, xi, 0.0, 0.0], gradient: [-2.0, 2.0, 0.0, 0.0] });
        assert!(matches!(check_shape(&steep), Err(ShapeViolation::Sum { sum: "Σ G x", .. })));
        let flat = Faulty(|_| Weights { value: [0.5, 0.5, 0.0, 0.0], gradient: [-1.0, 1.0, 0.0, 0.0] });
        assert!(matches!(check_shape(&flat), Err(ShapeViolation::Sum { sum: "Σ N x", .. })));
        let wide = Faulty(|xi| Weights { value: [1.0 - xi, xi, 1e-3, -1e-3], gradient: [-1.0, 1.0, 0.0, 0.0] });
        assert!(matches!(check_shape(&wide), Err(ShapeViolation::Support { local: 2, .. })));
        assert!(matches!(check_shape(&Misplaced), Err(ShapeViolation::Reached { local: 0, .. })));
    }

    /// Quadratic splines that forget where the nodes that a point reaches begin.
    struct Misplaced;

    impl ShapeFunction for Misplaced {
        const WIDTH: usize = QuadraticBSpline::WIDTH;
        const REACH: f64 = QuadraticBSpline::REACH;
        const REACHED: usize = QuadraticBSpline::REACHED;

        fn first_node(&self, at: CellOnAxis) -> usize {
            QuadraticBSpline.first_node(at)
        }

        fn weights(&self, at: CellOnAxis, position: f64, half_size: f64) -> Weights {
            QuadraticBSpline.weights(at, position, half_size)
        }

        fn reached_weights(&self, at: CellOnAxis, position: f64, half_size: f64) -> (usize, Weights) {
            (QuadraticBSpline.first_node(at), QuadraticBSpline.reached_weights(at, position, half_size).1)
        }
    }
}
