use super::{CellOnAxis, ShapeFunction, Weights};

/// Quadratic B-splines, one per node: smooth gradients, so that forces change smoothly when a particle crosses a grid line.
///
/// # Equation
///
/// ```text
/// N(x) = ¾ − x²                for |x| ≤ ½           x: distance from the node in spacings
///        ½ (3/2 − |x|)²        for ½ ≤ |x| ≤ 3/2
/// ```
///
/// At the ends of the grid the missing node is continued linearly, as described at [`CubicBSpline`]: within half a spacing of the
/// end the functions are the linear ones. The grid needs three cells along each axis.
///
/// # Reference
///
/// M. Steffen, R. M. Kirby and M. Berzins (2008), Int. J. Numer. Methods Eng. 76, 922–948; the ends are our own choice.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QuadraticBSpline;

/// Cubic B-splines, one per node: curvatures too are continuous.
///
/// # Equation
///
/// ```text
/// N(x) = 2/3 − x² + ½ |x|³     for |x| ≤ 1           x: distance from the node in spacings
///        (2 − |x|)³ / 6        for 1 ≤ |x| ≤ 2
/// ```
///
/// In the cells at the ends of the grid the function of the node that would follow beyond the end, number −1, belongs to the
/// nodes 0 and 1, as if its value were 2 v₀ − v₁:
///
/// ```text
/// N₀ ← N₀ + 2 N₋₁      N₁ ← N₁ − N₋₁
/// ```
///
/// and likewise at the upper end. Linear fields are then exact in every cell, no weight is negative, and the end node alone
/// decides there (N₀ = 1): a support at the end of the grid holds the material as with [`Linear`](super::Linear). On other grid
/// lines the neighbours have a say too, and a support only slows the material down. The grid needs three cells along each axis.
///
/// # Reference
///
/// M. Steffen, R. M. Kirby and M. Berzins (2008), Int. J. Numer. Methods Eng. 76, 922–948: the functions. The continuation gives
/// zero curvature at the ends, the natural spline.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CubicBSpline;

impl ShapeFunction for QuadraticBSpline {
    const WIDTH: usize = 4;
    const REACH: f64 = 0.0;

    #[inline(always)]
    fn first_node(&self, at: CellOnAxis) -> usize {
        first_node(at)
    }

    #[inline(always)]
    fn weights(&self, at: CellOnAxis, position: f64, half_size: f64) -> Weights {
        let (first, Weights { value, gradient }) = self.reached_weights(at, position, half_size);
        let is_upper = first > first_node(at);
        let placed = |[a, b, c, zero]: [f64; 4]| if is_upper { [zero, a, b, c] } else { [a, b, c, zero] };
        Weights { value: placed(value), gradient: placed(gradient) }
    }

    const REACHED: usize = 3;

    /// The nearest inner node and its neighbours; all in selects, so that loops over points become vectors.
    #[inline(always)]
    fn reached_weights(&self, at: CellOnAxis, position: f64, _half_size: f64) -> (usize, Weights) {
        let last_inner = f64::from(at.num_cells as u32) - 1.0;
        let inside = if position < last_inner { position } else { last_inner };
        let inside = if inside > 1.0 { inside } else { 1.0 };
        // Numbers from 2⁵² on are whole, and their lowest bits are those of an integer.
        const WHOLE: f64 = (1_u64 << 52) as f64;
        let nearest = inside + WHOLE;
        let x = position - (nearest - WHOLE);
        // Within half a spacing of the ends the functions go on as the straight lines that they are at half a spacing.
        let curved = x.clamp(-0.5, 0.5);
        let above = (x - curved).max(0.0);
        let below = above - (x - curved);
        let (low, high) = (0.5 - curved, 0.5 + curved);
        let (first, last) = (0.5 * low * low + below, 0.5 * high * high + above);
        let value = [first, 1.0 - (first + last), last, 0.0];
        (nearest.to_bits() as u32 as usize - 1, Weights { value, gradient: [-low, -2.0 * curved, high, 0.0] })
    }
}

impl ShapeFunction for CubicBSpline {
    const WIDTH: usize = 4;
    const REACH: f64 = 0.0;

    #[inline(always)]
    fn first_node(&self, at: CellOnAxis) -> usize {
        first_node(at)
    }

    #[inline(always)]
    fn weights(&self, at: CellOnAxis, position: f64, _half_size: f64) -> Weights {
        spline_weights(at, position, |x| {
            let distance = x.abs();
            let rest = (2.0 - distance).max(0.0);
            let inner = (2.0 / 3.0 - x * x * (1.0 - 0.5 * distance), x * (1.5 * distance - 2.0));
            let outer = (rest * rest * rest / 6.0, (-0.5 * rest * rest).copysign(-x));
            let is_inner = distance < 1.0;
            (if is_inner { inner.0 } else { outer.0 }, if is_inner { inner.1 } else { outer.1 })
        })
    }
}

/// A node on each side of the cell; at the ends of the grid the stencil moves inwards. A grid has fewer than 2³⁰ cells, and in 32 bits loops over
/// points become vectors.
#[inline(always)]
fn first_node(at: CellOnAxis) -> usize {
    (at.cell as u32).saturating_sub(1).min((at.num_cells as u32).saturating_sub(3)) as usize
}

/// The weights of a spline, given as value and slope at a distance from its node.
#[inline(always)]
fn spline_weights(at: CellOnAxis, position: f64, spline: impl Fn(f64) -> (f64, f64)) -> Weights {
    let first = first_node(at) as f64;
    let mut weights = Weights::default();
    for k in 0..4 {
        (weights.value[k], weights.gradient[k]) = spline(position - first - k as f64);
    }
    if at.cell == 0 {
        weights.continue_linearly(spline(position + 1.0), 0, 1);
    }
    if at.cell + 1 == at.num_cells {
        weights.continue_linearly(spline(position - at.num_cells as f64 - 1.0), 3, 2);
    }
    weights
}

impl Weights {
    /// Gives the weight of a node beyond the end of the grid to the end node and the one before it.
    #[inline(always)]
    fn continue_linearly(&mut self, beyond: (f64, f64), end: usize, before: usize) {
        self.value[end] += 2.0 * beyond.0;
        self.value[before] -= beyond.0;
        self.gradient[end] += 2.0 * beyond.1;
        self.gradient[before] -= beyond.1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Gimp;

    /// Away from the ends the quadratic B-spline is the hat averaged over a box as long as a cell.
    #[test]
    fn quadratic_splines_are_means_of_hats_over_a_spacing() {
        for step in 0..=20 {
            let (at, position) = (CellOnAxis { cell: 3, num_cells: 8 }, 3.0 + f64::from(step) / 20.0);
            let (spline, mean) = (QuadraticBSpline.weights(at, position, 0.0), Gimp.weights(at, position, 0.5));
            for k in 0..4 {
                assert!((spline.value[k] - mean.value[k]).abs() < 1e-15, "{position}: {spline:?} {mean:?}");
                assert!((spline.gradient[k] - mean.gradient[k]).abs() < 1e-15, "{position}: {spline:?} {mean:?}");
            }
        }
    }

    /// Values at the nodes and half way: 1/8, 3/4, 1/8 and 1/2, 1/2; 1/6, 2/3, 1/6 and 1/48, 23/48, 23/48, 1/48.
    #[test]
    fn known_values() {
        let at = CellOnAxis { cell: 3, num_cells: 8 };
        let close = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
        assert!(close(QuadraticBSpline.weights(at, 3.0, 0.0).value, [0.125, 0.75, 0.125, 0.0]));
        assert!(close(QuadraticBSpline.weights(at, 3.5, 0.0).value, [0.0, 0.5, 0.5, 0.0]));
        assert!(close(CubicBSpline.weights(at, 3.0, 0.0).value, [1.0, 4.0, 1.0, 0.0].map(|n| n / 6.0)));
        assert!(close(CubicBSpline.weights(at, 3.5, 0.0).value, [1.0, 23.0, 23.0, 1.0].map(|n| n / 48.0)));
    }

    /// In the first half spacing the quadratic functions are linear; the cubic ones are the natural spline x³/6 − x + 1.
    #[test]
    fn ends_are_natural() {
        let at = CellOnAxis { cell: 0, num_cells: 5 };
        for x in [0.0, 0.1, 0.4, 0.5] {
            let quadratic = QuadraticBSpline.weights(at, x, 0.0).value;
            assert!((quadratic[0] - (1.0 - x)).abs() < 1e-15 && (quadratic[1] - x).abs() < 1e-15);
            let cubic = CubicBSpline.weights(at, x, 0.0).value;
            assert!((cubic[0] - (x * x * x / 6.0 - x + 1.0)).abs() < 1e-15);
        }
    }
}
