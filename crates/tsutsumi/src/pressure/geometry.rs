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

/// Fills `boxes` with one box per active cell; `open` are the sides without material beyond.
///
/// With [`Quadrature::Cell`] (the paper) it is the whole cell. With [`Quadrature::MaterialPoints`] it reaches to every
/// side with material beyond, and to the boxes of the cell's own particles where there is none.
pub(super) fn fill_boxes<const D: usize>(
    quadrature: Quadrature,
    at: &StepView<D>,
    particles: &Particles<D>,
    open: &[(u32, Side)],
    boxes: &mut Vec<FilledBox<D>>,
) {
    boxes.clear();
    boxes.extend(at.active.cells().iter().map(|&cell| {
        let lower = at.grid.cell_origin(cell as usize);
        FilledBox { lower, upper: lower + at.grid.spacing() }
    }));
    if quadrature == Quadrature::MaterialPoints {
        shrink_boxes(at, particles, open, boxes);
    }
}

/// Makes the boxes at the surface as small as their particles.
fn shrink_boxes<const D: usize>(
    at: &StepView<D>,
    particles: &Particles<D>,
    open: &[(u32, Side)],
    boxes: &mut [FilledBox<D>],
) {
    // Sides towards empty cells or the end of the grid start from the opposite side and grow with the particles.
    let spacing = at.grid.spacing();
    for &(slot, side) in open {
        let origin = at.grid.cell_origin(at.active.cells()[slot as usize] as usize);
        let filled = &mut boxes[slot as usize];
        match side.upper {
            true => filled.upper[side.axis] = origin[side.axis],
            false => filled.lower[side.axis] = origin[side.axis] + spacing[side.axis],
        }
    }
    for (p, &cell) in particles.cell.iter().enumerate() {
        let Some(slot) = at.active.slot(cell as usize) else { continue };
        let filled = &mut boxes[slot];
        // A box that holds the particle's has nothing to gain, least of all the whole cells inside the body.
        let (from, to) = (particles.position[p] - particles.half_size[p], particles.position[p] + particles.half_size[p]);
        if (0..D).all(|axis| filled.lower[axis] <= from[axis] && to[axis] <= filled.upper[axis]) {
            continue;
        }
        let cell_lower = at.grid.cell_origin(cell as usize);
        for axis in 0..D {
            let (low, high) = (cell_lower[axis], cell_lower[axis] + spacing[axis]);
            filled.lower[axis] = filled.lower[axis].min(from[axis].max(low));
            filled.upper[axis] = filled.upper[axis].max(to[axis].min(high));
        }
    }
}

/// The sides of active cells without material beyond.
pub(super) fn open_sides<const D: usize>(at: &StepView<D>) -> impl Iterator<Item = (u32, Side)> {
    let sides = |(slot, &cell): (usize, &u32)| Side::all::<D>().map(move |side| (slot as u32, cell as usize, side));
    let has_none = |cell, side| at.grid.neighbor(cell, side).and_then(|other| at.active.slot(other)).is_none();
    let all = at.active.cells().iter().enumerate().flat_map(sides);
    all.filter(move |&(_, cell, side)| has_none(cell, side)).map(|(slot, _, side)| (slot, side))
}

/// The smallest filled part of an active cell along an axis (–): 1 with [`Quadrature::Cell`].
pub(super) fn smallest_fill<const D: usize>(quadrature: Quadrature, at: &StepView<D>, particles: &Particles<D>) -> f64 {
    let open: Vec<_> = open_sides(at).collect();
    let mut boxes = Vec::new();
    fill_boxes(quadrature, at, particles, &open, &mut boxes);
    let parts = |filled: &FilledBox<D>| (filled.upper - filled.lower).component_mul(&at.grid.inverse_spacing()).min();
    boxes.iter().map(parts).fold(1.0, f64::min)
}
