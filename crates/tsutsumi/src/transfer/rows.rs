use std::ops::{AddAssign, Mul};

use crate::lanes::{AddProduct, Four, Vectors};

/// Numbers at the nodes of a row along x as they lie in memory, the components of a node and then those of the next: `V` vectors of four.
#[derive(Clone, Copy)]
pub(super) struct Row<X: Vectors, const V: usize>([Four<X>; V]);

impl<X: Vectors, const V: usize> Row<X, V> {
    /// Zeros to begin a sum with: −0, since only x − 0 is x whatever x is, and costs nothing.
    #[inline(always)]
    pub(super) fn zeros(vectors: X) -> Self {
        Row([Four::splat(vectors, -0.0); V])
    }

    /// One number for each node, the same for all its `components`.
    #[inline(always)]
    pub(super) fn of_nodes(vectors: X, components: usize, of_node: impl Fn(usize) -> f64) -> Self {
        Row::from_fn(vectors, |place| of_node(place / components))
    }

    /// One number for each of `D` components, the same for all nodes.
    #[inline(always)]
    pub(super) fn of_components<const D: usize>(vectors: X, components: Four<X>) -> Self {
        let components = components.to_array();
        Row::from_fn(vectors, |place| components[place % D])
    }

    #[inline(always)]
    pub(super) fn from_fn(vectors: X, at: impl Fn(usize) -> f64) -> Self {
        let mut row = Row::zeros(vectors);
        for v in 0..V {
            row.0[v] = Four::new(vectors, [at(4 * v), at(4 * v + 1), at(4 * v + 2), at(4 * v + 3)]);
        }
        row
    }

    /// The numbers of a row, with zeros after them.
    #[inline(always)]
    pub(super) fn of_numbers(vectors: X, numbers: &[f64]) -> Self {
        let mut row = Row::zeros(vectors);
        for (four, numbers) in row.0.iter_mut().zip(numbers.chunks(4)) {
            *four = first_lanes(vectors, numbers);
        }
        row
    }

    /// The sum of the products, vector by vector.
    #[inline(always)]
    pub(super) fn dot(self, vectors: X, other: Self) -> Four<X> {
        let mut sum = Four::splat(vectors, -0.0);
        for v in 0..V {
            sum.add_product(self.0[v], other.0[v]);
        }
        sum
    }

    /// Adds products of rows and numbers to the numbers of a row.
    #[inline(always)]
    pub(super) fn add_products<const N: usize>(vectors: X, products: [(&Self, f64); N], values: &mut [f64]) {
        for (v, values) in values.chunks_mut(4).enumerate().take(V) {
            let mut sum = first_lanes(vectors, values);
            for (row, factor) in products {
                sum.add_product(row.0[v], factor);
            }
            values.copy_from_slice(&sum.to_array()[..values.len()]);
        }
    }

    /// Adds the numbers to those of a row.
    #[inline(always)]
    pub(super) fn add_to(self, vectors: X, values: &mut [f64]) {
        for (four, values) in self.0.into_iter().zip(values.chunks_mut(4)) {
            let sum = (first_lanes(vectors, values) + four).to_array();
            values.copy_from_slice(&sum[..values.len()]);
        }
    }
}

/// At most four numbers, with zeros after them.
#[inline(always)]
pub(super) fn first_lanes<X: Vectors>(vectors: X, values: &[f64]) -> Four<X> {
    if let Some(four) = values.first_chunk() {
        return Four::new(vectors, *four);
    }
    match *values {
        [a, b, c] => Four::new(vectors, [a, b, c, 0.0]),
        [a, b] => Four::new(vectors, [a, b, 0.0, 0.0]),
        [a] => Four::new(vectors, [a, 0.0, 0.0, 0.0]),
        _ => Four::splat(vectors, 0.0),
    }
}

impl<X: Vectors, const V: usize> AddProduct<Row<X, V>> for Row<X, V> {
    #[inline(always)]
    fn add_product(&mut self, a: Self, b: Self) {
        for v in 0..V {
            self.0[v].add_product(a.0[v], b.0[v]);
        }
    }
}

impl<X: Vectors, const V: usize> AddProduct<f64> for Row<X, V> {
    #[inline(always)]
    fn add_product(&mut self, a: Self, b: f64) {
        for v in 0..V {
            self.0[v].add_product(a.0[v], b);
        }
    }
}

impl<X: Vectors, const V: usize> AddAssign for Row<X, V> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for v in 0..V {
            self.0[v] += other.0[v];
        }
    }
}

impl<X: Vectors, const V: usize> Mul for Row<X, V> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for v in 0..V {
            self.0[v] *= other.0[v];
        }
        self
    }
}

impl<X: Vectors, const V: usize> Mul<f64> for Row<X, V> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, factor: f64) -> Self {
        for v in 0..V {
            self.0[v] = self.0[v] * factor;
        }
        self
    }
}
