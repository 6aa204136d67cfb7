//! The region of a body, cut into the boxes of its material points.

use tsutsumi::grid::{Grid, Side};
use tsutsumi::tensor::Vector;
use tsutsumi_reference::finite_elements::{GaussPoint, gauss_points};

use crate::{BodyShape, BoxShape, SphereShape};

/// The part of a lattice box that must be covered to make a material point. Lighter ones would make nodes so light that they
/// govern the time step; their volume goes to the others that the surface cuts.
const SMALLEST_PART: f64 = 0.1;

/// Columns per axis along which the covered part of a box is measured.
const COLUMNS: usize = 16;

/// A box of a material point at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PointBox<const D: usize> {
    /// Its numbers along the axes of the lattice.
    pub(crate) place: [usize; D],
    /// Its centre (m): the centroid of what it covers.
    pub(crate) position: Vector<D>,
    /// Half its edges (m).
    pub(crate) half_size: Vector<D>,
}

/// The region that a body fills.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Region<const D: usize> {
    lower: Vector<D>,
    upper: Vector<D>,
    /// The ball that cuts the box, by its centre and radius (m).
    ball: Option<(Vector<D>, f64)>,
    /// Where the lattice begins and the edges of its boxes (m).
    origin: Vector<D>,
    edge: Vector<D>,
    counts: Vector<D>,
}

impl<const D: usize> Region<D> {
    /// The region of a shape on a grid, with so many points per cell along each axis.
    ///
    /// A box is divided evenly; the lattice of a ball is that of the grid, so that no point straddles a grid line.
    pub(crate) fn new(shape: &BodyShape, grid: &Grid<D>, per_cell: &[usize]) -> Self {
        let (lower, upper) = bounds(shape, grid);
        let per_cell = Vector::<D>::from_fn(|axis, _| per_cell.get(axis).copied().unwrap_or(1) as f64);
        match shape {
            BodyShape::Box(_) => {
                let wish = (upper - lower).component_div(&grid.spacing()).component_mul(&per_cell);
                let counts = wish.map(|count| count.round().max(1.0));
                let edge = (upper - lower).component_div(&counts);
                Region { lower, upper, ball: None, origin: lower, edge, counts }
            }
            BodyShape::Sphere(SphereShape { center, radius, .. }) => {
                let edge = grid.spacing().component_div(&per_cell);
                let first = (lower - grid.origin()).component_div(&edge).map(f64::floor);
                let counts = ((upper - grid.origin()).component_div(&edge) - first).map(f64::ceil);
                let origin = grid.origin() + first.component_mul(&edge);
                Region { lower, upper, ball: Some((vector(center), *radius)), origin, edge, counts }
            }
        }
    }

    /// The number of lattice boxes, an upper bound for that of the points.
    pub(crate) fn num_boxes(&self) -> f64 {
        self.counts.product()
    }

    /// The part of a side of the whole box that one point stands for (m²; m in 2-D, 1 in 1-D).
    pub(crate) fn side_area(&self, side: Side) -> f64 {
        (0..D).filter(|&axis| axis != side.axis).map(|axis| self.edge[axis]).product()
    }

    /// The volume of a lattice box (m³).
    pub(crate) fn box_volume(&self) -> f64 {
        self.edge.product()
    }

    /// True for a box between grid lines.
    pub(crate) fn fills_cells(&self, grid: &Grid<D>) -> bool {
        let is_line = |place: &f64| (place - place.round()).abs() < 1e-6;
        let is_between = [self.lower, self.upper].iter().all(|corner| grid.in_spacings(corner).iter().all(is_line));
        self.ball.is_none() && is_between
    }

    /// The Gauss points of the elements of a box that [fills cells](Region::fills_cells), two lattice boxes per axis and
    /// element, x fastest. Each stands for a lattice box, and its own box reaches to the nearest sides of the element.
    pub(crate) fn gauss_points(&self) -> Vec<PointBox<D>> {
        let axes: [Vec<GaussPoint>; D] = std::array::from_fn(|axis| {
            gauss_points(self.lower[axis], self.upper[axis], (self.counts[axis] / 2.0).round() as usize)
        });
        let point = |number: usize| {
            let place = place_of(number, std::array::from_fn(|axis| axes[axis].len()));
            PointBox {
                place,
                position: Vector::from_fn(|axis, _| axes[axis][place[axis]].place),
                half_size: Vector::from_fn(|axis, _| axes[axis][place[axis]].half_length),
            }
        };
        (0..axes.iter().map(Vec::len).product()).map(point).collect()
    }

    /// The points, x fastest. Their volumes add up to that of the region.
    pub(crate) fn points(&self) -> Vec<PointBox<D>> {
        let counts: [usize; D] = std::array::from_fn(|axis| self.counts[axis] as usize);
        let mut points = Vec::new();
        // The volumes of the boxes that the ball cuts (m³): all of them, and those kept.
        let (mut cut, mut kept) = (0.0, 0.0);
        let mut is_cut = Vec::new();
        for number in 0..counts.iter().product() {
            let place = place_of(number, counts);
            let Some((volume, point)) = self.point(place) else { continue };
            let is_whole = volume == self.edge.product();
            if !is_whole {
                cut += volume;
            }
            if is_whole || volume >= SMALLEST_PART * self.edge.product() {
                kept += if is_whole { 0.0 } else { volume };
                points.push(point);
                is_cut.push(!is_whole);
            }
        }
        let growth = (cut / kept).powf(1.0 / D as f64);
        for (point, _) in points.iter_mut().zip(is_cut).filter(|(_, is_cut)| *is_cut) {
            point.half_size *= growth;
        }
        points
    }

    /// The point of a lattice box with the volume it covers (m³); `None` where the box is outside.
    fn point(&self, place: [usize; D]) -> Option<(f64, PointBox<D>)> {
        let whole = PointBox {
            place,
            position: Vector::from_fn(|axis, _| self.origin[axis] + (place[axis] as f64 + 0.5) * self.edge[axis]),
            half_size: self.edge * 0.5,
        };
        let Some((center, radius)) = self.ball else { return Some((self.edge.product(), whole)) };
        let lower = (whole.position - whole.half_size).sup(&self.lower);
        let upper = (whole.position + whole.half_size).inf(&self.upper);
        let farthest = (lower - center).abs().sup(&(upper - center).abs());
        let is_inside = farthest.norm() <= radius;
        // Round-off at the ends of the region makes no cut.
        let is_clipped = (upper - lower).component_div(&self.edge).min() < 1.0 - 1e-9;
        if is_inside && !is_clipped {
            return Some((self.edge.product(), whole));
        }
        let (volume, position) = covered(lower, upper, center, radius)?;
        let part = volume / (upper - lower).product();
        let half_size = (upper - lower) * (0.5 * part.powf(1.0 / D as f64));
        Some((volume, PointBox { place, position, half_size }))
    }

    /// True when the free surface is met from a point inside in the direction of a side before a cut of the body: by the end
    /// of the grid, or by the box that a ball is confined to.
    pub(crate) fn is_free(&self, grid: &Grid<D>, point: &Vector<D>, side: Side) -> bool {
        let axis = side.axis;
        let end = if side.upper { self.upper[axis] } else { self.lower[axis] };
        match self.ball {
            Some((center, radius)) => {
                let across = (point - center).norm_squared() - (point[axis] - center[axis]).powi(2);
                let surface = center[axis] + side.sign() * (radius * radius - across).max(0.0).sqrt();
                side.sign() * (surface - end) <= 1e-9 * self.edge[axis]
            }
            None => {
                let end_of_grid = if side.upper { grid.end()[axis] } else { grid.origin()[axis] };
                (end - end_of_grid).abs() > 1e-6 * self.edge[axis]
            }
        }
    }
}

/// The numbers along the axes of the lattice box with this number, x fastest.
fn place_of<const D: usize>(number: usize, counts: [usize; D]) -> [usize; D] {
    let mut rest = number;
    std::array::from_fn(|axis| {
        let place = rest % counts[axis];
        rest /= counts[axis];
        place
    })
}

/// The smallest box around a shape, within the grid (m).
pub(crate) fn bounds<const D: usize>(shape: &BodyShape, grid: &Grid<D>) -> (Vector<D>, Vector<D>) {
    match shape {
        BodyShape::Box(BoxShape { min, max }) => (vector(min), vector(max)),
        BodyShape::Sphere(SphereShape { center, radius, within }) => {
            let (center, reach) = (vector::<D>(center), Vector::repeat(*radius));
            let (mut lower, mut upper) = ((center - reach).sup(&grid.origin()), (center + reach).inf(&grid.end()));
            if let Some(BoxShape { min, max }) = within {
                (lower, upper) = (lower.sup(&vector(min)), upper.inf(&vector(max)));
            }
            (lower, upper)
        }
    }
}

fn vector<const D: usize>(numbers: &[f64]) -> Vector<D> {
    // Lengths were validated; a missing number would be a zero.
    Vector::from_fn(|axis, _| numbers.get(axis).copied().unwrap_or(0.0))
}

/// The volume (m³) and centroid (m) of the part of a box inside a ball; `None` where there is none.
///
/// Exact along the last axis, by the midpoint rule across it.
fn covered<const D: usize>(
    lower: Vector<D>,
    upper: Vector<D>,
    center: Vector<D>,
    radius: f64,
) -> Option<(f64, Vector<D>)> {
    if (0..D).any(|axis| lower[axis] >= upper[axis]) {
        return None;
    }
    let width = (upper - lower) / COLUMNS as f64;
    let area: f64 = (0..D - 1).map(|axis| width[axis]).product();
    let mut volume = 0.0;
    let mut moment = Vector::<D>::zeros();
    for column in 0..COLUMNS.pow(D as u32 - 1) {
        let mut rest = column;
        let mut point = Vector::<D>::from_fn(|axis, _| {
            let place = rest % COLUMNS;
            rest /= COLUMNS;
            lower[axis] + (place as f64 + 0.5) * width[axis]
        });
        let across: f64 = (0..D - 1).map(|axis| (point[axis] - center[axis]).powi(2)).sum();
        let half_chord = (radius * radius - across).max(0.0).sqrt();
        let from = lower[D - 1].max(center[D - 1] - half_chord);
        let to = upper[D - 1].min(center[D - 1] + half_chord);
        if to > from {
            point[D - 1] = 0.5 * (from + to);
            volume += area * (to - from);
            moment += point * (area * (to - from));
        }
    }
    (volume > 0.0).then(|| (volume, moment / volume))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn sphere(center: &[f64], radius: f64, within: Option<(&[f64], &[f64])>) -> BodyShape {
        let within = within.map(|(min, max)| BoxShape { min: min.to_vec(), max: max.to_vec() });
        BodyShape::Sphere(SphereShape { center: center.to_vec(), radius, within })
    }

    fn volume<const D: usize>(points: &[PointBox<D>]) -> f64 {
        points.iter().map(|point| (point.half_size * 2.0).product()).sum()
    }

    fn first_moment<const D: usize>(points: &[PointBox<D>]) -> Vector<D> {
        points.iter().map(|point| point.position * (point.half_size * 2.0).product()).sum()
    }

    /// π R² for a disc, 4/3 π R³ for a ball, wherever they stand on the grid.
    #[test]
    fn discs_and_balls_have_their_volume_and_centre() {
        let disc = sphere(&[1.03, 0.98], 0.73, None);
        let grid = Grid::<2>::new(Vector::zeros(), Vector::repeat(0.1), [20, 20]).unwrap();
        let points = Region::new(&disc, &grid, &[2, 2]).points();
        // Where the edge is steep the midpoint rule with columns of w = 0.05/16 is off by up to 0.2 √(2R) w^1.5 at each of four
        // places: 1e-4 of the area.
        assert!((volume(&points) / (PI * 0.73 * 0.73) - 1.0).abs() < 1e-4);
        assert!((first_moment(&points) / volume(&points) - Vector::<2>::new(1.03, 0.98)).norm() < 1e-3);

        let ball = sphere(&[1.03, 0.98, 1.0], 0.73, None);
        let grid = Grid::<3>::new(Vector::zeros(), Vector::repeat(0.2), [10, 10, 10]).unwrap();
        let points = Region::new(&ball, &grid, &[2, 2, 2]).points();
        assert!((volume(&points) / (4.0 / 3.0 * PI * 0.73_f64.powi(3)) - 1.0).abs() < 1e-4);
        assert!((first_moment(&points) / volume(&points) - Vector::<3>::new(1.03, 0.98, 1.0)).norm() < 2e-3);
    }

    /// An eighth of a ball: its volume, and its centroid at 3/8 R from each of the planes that cut it.
    #[test]
    fn an_eighth_of_a_ball_is_cut_by_the_ends_of_the_grid() {
        let grid = Grid::<3>::new(Vector::zeros(), Vector::repeat(0.1), [12, 12, 12]).unwrap();
        let points = Region::new(&sphere(&[0.0; 3], 1.0, None), &grid, &[2, 2, 2]).points();
        assert!((volume(&points) / (PI / 6.0) - 1.0).abs() < 1e-4);
        let centroid = first_moment(&points) / volume(&points);
        assert!((centroid - Vector::<3>::repeat(0.375)).norm() < 1e-3, "{centroid}");
        let smallest = points.iter().map(|point| (point.half_size * 2.0).product()).fold(f64::INFINITY, f64::min);
        assert!(smallest >= SMALLEST_PART * 0.05_f64.powi(3));
        // Every box is around a point of the ball.
        assert!(points.iter().all(|point| point.position.norm() < 1.0));
    }

    /// A quarter of a disc, cut by a box whose sides are not on the lattice.
    #[test]
    fn a_box_cuts_a_disc() {
        let grid = Grid::<2>::new(Vector::zeros(), Vector::repeat(0.1), [20, 20]).unwrap();
        let quarter = sphere(&[1.012, 1.034], 0.7, Some((&[0.0, 1.034], &[1.012, 2.0])));
        let region = Region::new(&quarter, &grid, &[2, 2]);
        let points = region.points();
        assert!((volume(&points) / (PI * 0.49 / 4.0) - 1.0).abs() < 1e-4);
        let centroid = first_moment(&points) / volume(&points) - Vector::<2>::new(1.012, 1.034);
        let expected = 4.0 * 0.7 / (3.0 * PI);
        assert!((centroid - Vector::<2>::new(-expected, expected)).norm() < 2e-3, "{centroid}");
        // Outwards the surface is free, towards the box it is not.
        let at = |axis, upper| region.is_free(&grid, &Vector::<2>::new(0.6, 1.2), Side { axis, upper });
        assert_eq!([at(0, false), at(0, true), at(1, false), at(1, true)], [true, false, false, true]);
    }

    #[test]
    fn a_box_is_divided_evenly_and_is_free_but_at_the_ends_of_the_grid() {
        let grid = Grid::<2>::new(Vector::zeros(), Vector::repeat(1.0), [3, 4]).unwrap();
        let shape = BodyShape::Box(BoxShape { min: vec![0.0, 0.5], max: vec![2.0, 3.0] });
        let region = Region::new(&shape, &grid, &[2, 2]);
        let points = region.points();
        assert_eq!(points.len(), 4 * 5);
        assert_eq!((points[5].place, points[5].position), ([1, 1], Vector::<2>::new(0.75, 1.25)));
        assert_eq!(volume(&points), 5.0);
        let free = Side::all::<2>().map(|side| region.is_free(&grid, &points[0].position, side));
        assert_eq!(free.collect::<Vec<_>>(), [false, true, true, true]);
        assert_eq!(region.side_area(Side { axis: 1, upper: true }), 0.5);
    }
}
