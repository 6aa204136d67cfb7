//! Loops over the active nodes that write to fields of the whole grid.

use crate::parallel::{self, Pieces};
use crate::tensor::Vector;

/// Nodes in a piece of a loop.
const GRAIN: usize = 2048;

/// The values of a field at some active nodes, in ascending order, and around them.
struct ActiveValues<'a, const D: usize> {
    nodes: &'a [u32],
    /// The place of the first node among the active ones.
    place: usize,
    /// The node whose values come first.
    first: usize,
    values: &'a mut [Vector<D>],
}

impl<const D: usize> Pieces for ActiveValues<'_, D> {
    fn count(&self) -> usize {
        self.nodes.len()
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let (left, right) = self.nodes.split_at(at);
        let first = right.first().map_or(self.first + self.values.len(), |&node| node as usize);
        let (lower, upper) = self.values.split_at_mut(first - self.first);
        (
            ActiveValues { nodes: left, place: self.place, first: self.first, values: lower },
            ActiveValues { nodes: right, place: self.place + at, first, values: upper },
        )
    }
}

/// Sets a field at every active node: `value(place among the active nodes, node)`.
pub(super) fn set<const D: usize>(
    nodes: &[u32],
    values: &mut [Vector<D>],
    value: impl Fn(usize, usize) -> Vector<D> + Sync,
) {
    let work = |piece: ActiveValues<D>| {
        for (number, &node) in piece.nodes.iter().enumerate() {
            piece.values[node as usize - piece.first] = value(piece.place + number, node as usize);
        }
    };
    parallel::for_each(ActiveValues { nodes, place: 0, first: 0, values }, GRAIN, &work);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn active_nodes_are_set_and_others_left() {
        let nodes: Vec<u32> = (0..20_000).filter(|node| node % 3 != 1).collect();
        let mut values = vec![Vector::<1>::new(-1.0); 20_000];
        set(&nodes, &mut values, |place, node| Vector::<1>::new((place + node) as f64));
        for (node, value) in values.iter().enumerate() {
            let expected = nodes.binary_search(&(node as u32)).map_or(-1.0, |place| (place + node) as f64);
            assert_eq!(value[0], expected);
        }
    }
}
