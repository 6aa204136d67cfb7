//! The part of each cell that the material fills: a box, from which face distances and areas follow.

use super::{Quadrature, StepView};
use crate::grid::Side;
use crate::particles::Particles;
use crate::tensor::Vector;

/// The filled box of a cell: its corners (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FilledBox<const D: usize> {
    pub(super) lower: Vector<D>,
    pub(super) upper: Vector<D>,
}

impl<const D: usize> FilledBox<D> {
    /// Where the cell's pressure stands (m).
    pub(super) fn center(&self) -> Vector<D> {
        (self.lower + self.upper) * 0.5
    }

    /// From the centre to the sides normal to `axis` (m).
    pub(super) fn half_extent(&self, axis: usize) -> f64 {
        0.5 * (self.upper[axis] - self.lower[axis])
    }

    /// The wetted area of the sides normal to `axis` (m²; m in 2-D, 1 in 1-D).
    pub(super) fn side_area(&self, axis: usize) -> f64 {
        (0..D).filter(|&other| other != axis).map(|other| self.upper[other] - self.lower[other]).product()
    }
}

/// Fills `boxes` with one box per active cell.
///
/// With [`Quadrature::Cell`] (the paper) it is the whole cell. With [`Quadrature::MaterialPoints`] it reaches to every
/// side with material beyond, and to the boxes of the cell's own particles where there is none.
pub(super) fn fill_boxes<const D: usize>(
    quadrature: Quadrature,
    at: &StepView<D>,
    particles: &Particles<D>,
    boxes: &mut Vec<FilledBox<D>>,
) {
    boxes.clear();
    for &cell in at.active.cells() {
        let lower = at.grid.cell_origin(cell as usize);
        boxes.push(FilledBox { lower, upper: lower + at.grid.spacing() });
    }
    if quadrature == Quadrature::Cell {
        return;
    }
    // Sides towards empty cells or the end of the grid start from the opposite side and grow with the particles.
    for (slot, &cell) in at.active.cells().iter().enumerate() {
        let whole = boxes[slot];
        for side in Side::all::<D>() {
            let beyond = at.grid.neighbor(cell as usize, side).and_then(|other| at.active.slot(other));
            if beyond.is_none() {
                let (corner, opposite) = match side.upper {
                    true => (&mut boxes[slot].upper, whole.lower),
                    false => (&mut boxes[slot].lower, whole.upper),
                };
                corner[side.axis] = opposite[side.axis];
            }
        }
    }
    for p in 0..particles.len() {
        let cell = particles.cell[p] as usize;
        let Some(slot) = at.active.slot(cell) else { continue };
        let cell_lower = at.grid.cell_origin(cell);
        let filled = &mut boxes[slot];
        for axis in 0..D {
            let (low, high) = (cell_lower[axis], cell_lower[axis] + at.grid.spacing()[axis]);
            let (from, to) = (
                particles.position[p][axis] - particles.half_size[p][axis],
                particles.position[p][axis] + particles.half_size[p][axis],
            );
            filled.lower[axis] = filled.lower[axis].min(from.max(low));
            filled.upper[axis] = filled.upper[axis].max(to.min(high));
        }
    }
}

/// The smallest filled part of an active cell along an axis (–): 1 with [`Quadrature::Cell`].
pub(super) fn smallest_fill<const D: usize>(quadrature: Quadrature, at: &StepView<D>, particles: &Particles<D>) -> f64 {
    let mut boxes = Vec::new();
    fill_boxes(quadrature, at, particles, &mut boxes);
    let parts = |filled: &FilledBox<D>| (filled.upper - filled.lower).component_mul(&at.grid.inverse_spacing()).min();
    boxes.iter().map(parts).fold(1.0, f64::min)
}
