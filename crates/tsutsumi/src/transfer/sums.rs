use std::ops::{AddAssign, Mul};

use crate::lanes::AddProduct;

/// What belongs to a node, row or layer of a stencil along an axis.
#[derive(Clone, Copy)]
pub(super) struct AxisWeights<W> {
    /// N (–) and its gradient (1/m).
    pub(super) value: W,
    pub(super) gradient: W,
}

/// Sums over nodes: `T` is a vector of the grid, for one particle or several.
#[derive(Clone, Copy)]
pub(super) struct Sums<T, const D: usize> {
    pub(super) velocity: T,
    pub(super) acceleration: T,
    /// With the gradient along an axis in place of the value.
    pub(super) gradient: [T; D],
    /// With the value times the steps along an axis from a node to the last one, until [`Sums::finish_moment`] makes the moment of it.
    pub(super) moment: [T; D],
}

impl<T: Copy + AddAssign, const D: usize> Sums<T, D> {
    /// Nothing summed yet. −0 is best: only x − 0 is x whatever x is, and costs nothing.
    #[inline(always)]
    pub(super) fn zeros(zero: T) -> Self {
        Sums { velocity: zero, acceleration: zero, gradient: [zero; D], moment: [zero; D] }
    }

    /// Adds what the next node, row or layer has, with its weights along an axis; only along the axes before this one does it vary so far. Along
    /// an axis that space does not have there is one part, which is all. Accelerations (`A`) and moments (`M`) only if they are wanted.
    #[inline(always)]
    pub(super) fn add<W: Copy, const A: bool, const M: bool>(
        &mut self,
        part: &Self,
        axis: usize,
        weights: &AxisWeights<W>,
    ) where
        T: AddProduct<W>,
    {
        if axis >= D {
            *self = *part;
            return;
        }
        if M {
            // All that came before is a step farther from the last.
            self.moment[axis] += self.velocity;
        }
        self.velocity.add_product(part.velocity, weights.value);
        if A {
            self.acceleration.add_product(part.acceleration, weights.value);
        }
        for j in 0..axis {
            self.gradient[j].add_product(part.gradient[j], weights.value);
            if M {
                self.moment[j].add_product(part.moment[j], weights.value);
            }
        }
        self.gradient[axis].add_product(part.velocity, weights.gradient);
    }

    /// The moment along an axis, Σ N v (x_I − X_p), by the way from the point to the last node (m) and minus that from node to node (m):
    ///
    /// ```text
    /// x_I − X_p = (x_last − X_p) − h (last − I)
    /// ```
    #[inline(always)]
    pub(super) fn finish_moment<W: Copy>(&mut self, axis: usize, to_last: W, minus_spacing: W)
    where
        T: Mul<W, Output = T> + AddProduct<W>,
    {
        let mut moment = self.velocity * to_last;
        moment.add_product(self.moment[axis], minus_spacing);
        self.moment[axis] = moment;
    }
}
