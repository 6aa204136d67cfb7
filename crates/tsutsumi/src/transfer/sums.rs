use std::ops::{AddAssign, Mul};

/// What belongs to a node, row or layer of a stencil along an axis.
#[derive(Clone, Copy)]
pub(super) struct AxisWeights<W> {
    /// N (–) and its gradient (1/m).
    pub(super) value: W,
    pub(super) gradient: W,
    /// N times the way from the point there (m).
    pub(super) moment: W,
}

/// Sums over nodes: `T` is a vector of the grid, for one particle or several.
#[derive(Clone, Copy)]
pub(super) struct Sums<T, const D: usize> {
    pub(super) velocity: T,
    pub(super) acceleration: T,
    /// With the gradient along an axis in place of the value.
    pub(super) gradient: [T; D],
    /// With the value times the way along an axis.
    pub(super) moment: [T; D],
}

impl<T: Copy + AddAssign, const D: usize> Sums<T, D> {
    /// Nothing summed yet. −0 is best: only x − 0 is x whatever x is, and costs nothing.
    #[inline(always)]
    pub(super) fn zeros(zero: T) -> Self {
        Sums { velocity: zero, acceleration: zero, gradient: [zero; D], moment: [zero; D] }
    }

    /// Adds what a node, row or layer has, with its weights along an axis; only along the axes before this one does it vary so far. Along an axis
    /// that space does not have there is one part, which is all. Accelerations (`A`) and moments (`M`) only if they are wanted.
    #[inline(always)]
    pub(super) fn add<W: Copy, const A: bool, const M: bool>(
        &mut self,
        part: &Self,
        axis: usize,
        weights: &AxisWeights<W>,
    ) where
        T: Mul<W, Output = T>,
    {
        if axis >= D {
            *self = *part;
            return;
        }
        self.velocity += part.velocity * weights.value;
        if A {
            self.acceleration += part.acceleration * weights.value;
        }
        for j in 0..axis {
            self.gradient[j] += part.gradient[j] * weights.value;
            if M {
                self.moment[j] += part.moment[j] * weights.value;
            }
        }
        self.gradient[axis] += part.velocity * weights.gradient;
        if M {
            self.moment[axis] += part.velocity * weights.moment;
        }
    }
}
