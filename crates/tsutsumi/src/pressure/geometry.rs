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

/// Fills `boxes` with one box per active cell: the whole cell.
pub(super) fn fill_boxes<const D: usize>(at: &StepView<D>, boxes: &mut Vec<FilledBox<D>>) {
    boxes.clear();
    boxes.extend(at.active.cells().iter().map(|&cell| {
        let lower = at.grid.cell_origin(cell as usize);
        FilledBox { lower, upper: lower + at.grid.spacing() }
    }));
}

/// The sides of the active cells without material beyond.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    /// Slots and sides.
    pub(super) sides: Vec<(u32, Side)>,
}

impl Surface {
    /// Finds the sides.
    pub(super) fn rebuild<const D: usize>(&mut self, at: &StepView<D>) {
        let size = at.active.cells().len();
        self.sides.clear();
        // As many as so many cells can have, wherever they are.
        self.sides.reserve(2 * D * size);
        for (slot, &cell) in at.active.cells().iter().enumerate() {
            for side in Side::all::<D>() {
                if at.grid.neighbor(cell as usize, side).and_then(|other| at.active.slot(other)).is_none() {
                    self.sides.push((slot as u32, side));
                }
            }
        }
    }
}

/// Makes the boxes at the surface as small as their particles: they reach to every side with material beyond, and to the boxes of the
/// cell's own particles where there is none. The other boxes are left as they are.
pub(super) fn shrink_boxes<const D: usize>(
    at: &StepView<D>,
    particles: &Particles<D>,
    surface: &Surface,
    boxes: &mut [FilledBox<D>],
) {
    let spacing = at.grid.spacing();
    for sides in surface.sides.chunk_by(|(slot, _), (next, _)| slot == next) {
        let slot = sides[0].0 as usize;
        let cell_lower = at.grid.cell_origin(at.active.cells()[slot] as usize);
        let filled = &mut boxes[slot];
        // Sides towards empty cells or the end of the grid start from the opposite side and grow with the particles.
        for &(_, side) in sides {
            match side.upper {
                true => filled.upper[side.axis] = cell_lower[side.axis],
                false => filled.lower[side.axis] = cell_lower[side.axis] + spacing[side.axis],
            }
        }
        for &p in at.active.particles_of(slot) {
            let (position, half_size) = (particles.position[p as usize], particles.half_size[p as usize]);
            let (from, to) = (position - half_size, position + half_size);
            for axis in 0..D {
                let (low, high) = (cell_lower[axis], cell_lower[axis] + spacing[axis]);
                filled.lower[axis] = filled.lower[axis].min(from[axis].max(low));
                filled.upper[axis] = filled.upper[axis].max(to[axis].min(high));
            }
        }
    }
}

/// The smallest filled part of an active cell along an axis (–): 1 with [`Quadrature::Cell`].
pub(super) fn smallest_fill<const D: usize>(quadrature: Quadrature, at: &StepView<D>, particles: &Particles<D>) -> f64 {
    if quadrature == Quadrature::Cell {
        return 1.0;
    }
    let mut surface = Surface::default();
    surface.rebuild(at);
    let mut boxes = Vec::new();
    fill_boxes(at, &mut boxes);
    shrink_boxes(at, particles, &surface, &mut boxes);
    let parts = |filled: &FilledBox<D>| (filled.upper - filled.lower).component_mul(&at.grid.inverse_spacing()).min();
    boxes.iter().map(parts).fold(1.0, f64::min)
}
