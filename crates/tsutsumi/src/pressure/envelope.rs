//! Cholesky factorisation of a symmetric positive definite matrix stored by its envelope.
//!
//! Row `i` keeps the entries from its first non-zero to the diagonal. A column of cells is a tridiagonal matrix; the
//! factor fits into the same envelope, so nothing is allocated when values change.

/// A symmetric matrix, or its Cholesky factor, stored by rows within its lower envelope.
#[derive(Debug, Clone, Default)]
pub(super) struct Envelope {
    /// First column of each row.
    first: Vec<u32>,
    /// Where the entry (i, 0) of each row would stand in `values`; wraps around below zero.
    base: Vec<usize>,
    values: Vec<f64>,
}

/// A pivot that is not positive, at a row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BadPivot {
    pub(super) row: usize,
    pub(super) pivot: f64,
}

impl Envelope {
    /// Sets the shape: `first[i]` is the first column of row `i`, at most `i`. Reuses memory.
    pub(super) fn set_shape(&mut self, first: impl Iterator<Item = u32>) {
        self.first.clear();
        self.base.clear();
        let mut end = 0_usize;
        for (row, column) in first.enumerate() {
            self.first.push(column);
            self.base.push(end.wrapping_sub(column as usize));
            end += row + 1 - column as usize;
        }
        self.values.clear();
        self.values.resize(end, 0.0);
    }

    pub(super) fn num_rows(&self) -> usize {
        self.first.len()
    }

    pub(super) fn clear_values(&mut self) {
        self.values.fill(0.0);
    }

    #[inline]
    fn place(&self, row: usize, column: usize) -> usize {
        self.base[row].wrapping_add(column)
    }

    /// Adds to the entry (row, column); only the lower triangle is kept.
    #[inline]
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        let place = self.place(row, column);
        self.values[place] += value;
    }

    #[inline]
    fn row(&self, row: usize) -> (usize, &[f64]) {
        let first = self.first[row] as usize;
        (first, &self.values[self.place(row, first)..=self.place(row, row)])
    }

    /// Replaces the matrix A by its factor L, A = L Lᵀ.
    pub(super) fn factorize(&mut self) -> Result<(), BadPivot> {
        for i in 0..self.num_rows() {
            let first_i = self.first[i] as usize;
            for j in first_i..i {
                let from = first_i.max(self.first[j] as usize);
                let dot = self.dot_rows(i, j, from, j);
                let place = self.place(i, j);
                self.values[place] = (self.values[place] - dot) / self.values[self.place(j, j)];
            }
            let pivot = self.values[self.place(i, i)] - self.dot_rows(i, i, first_i, i);
            // NaN fails the comparison too.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(BadPivot { row: i, pivot });
            }
            let place = self.place(i, i);
            self.values[place] = pivot.sqrt();
        }
        Ok(())
    }

    /// Σ_k L_ik L_jk over the columns `from..to`.
    #[inline]
    fn dot_rows(&self, i: usize, j: usize, from: usize, to: usize) -> f64 {
        let a = &self.values[self.place(i, from)..self.place(i, to)];
        let b = &self.values[self.place(j, from)..self.place(j, to)];
        dot(a, b)
    }

    /// Solves L Lᵀ x = b in place, after [`Envelope::factorize`].
    pub(super) fn solve(&self, x: &mut [f64]) {
        for i in 0..self.num_rows() {
            let (first, row) = self.row(i);
            let last = row.len() - 1;
            x[i] = (x[i] - dot(&row[..last], &x[first..i])) / row[last];
        }
        for i in (0..self.num_rows()).rev() {
            let (first, row) = self.row(i);
            let last = row.len() - 1;
            x[i] /= row[last];
            let xi = x[i];
            for (l, x) in row[..last].iter().zip(&mut x[first..i]) {
                *x -= l * xi;
            }
        }
    }
}

/// Σ a_i b_i, in four sums side by side: each addition waits for the one before.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a, rest_a) = a.as_chunks::<4>();
    let (b, rest_b) = b.as_chunks::<4>();
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    sums[0] + sums[1] + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;

    fn envelope_of(matrix: &DMatrix<f64>) -> Envelope {
        let size = matrix.nrows();
        let first = |i: usize| (0..=i).find(|&j| matrix[(i, j)] != 0.0).unwrap_or(i) as u32;
        let mut envelope = Envelope::default();
        envelope.set_shape((0..size).map(first));
        for i in 0..size {
            for j in first(i) as usize..=i {
                envelope.add(i, j, matrix[(i, j)]);
            }
        }
        envelope
    }

    proptest! {
        /// Against nalgebra's dense Cholesky, on random sparse diagonally dominant matrices.
        #[test]
        fn solves_like_a_dense_factorisation(
            size in 1_usize..12,
            entries in prop::collection::vec((0_usize..12, 0_usize..12, -1.0..1.0_f64), 0..30),
            right in prop::collection::vec(-1.0..1.0_f64, 12),
        ) {
            let mut matrix = DMatrix::from_diagonal_element(size, size, 0.1);
            for (i, j, value) in entries {
                if i < size && j < size && i != j {
                    matrix[(i, j)] += value;
                    matrix[(j, i)] += value;
                    matrix[(i, i)] += value.abs();
                    matrix[(j, j)] += value.abs();
                }
            }
            let right = DVector::from_iterator(size, right.into_iter().take(size));
            let expected = matrix.clone().cholesky().unwrap().solve(&right);
            let mut envelope = envelope_of(&matrix);
            envelope.factorize().unwrap();
            let mut solution = right.as_slice().to_vec();
            envelope.solve(&mut solution);
            let difference = DVector::from_vec(solution) - &expected;
            prop_assert!(difference.norm() <= 1e-11 * expected.norm().max(1e-3));
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused_at_its_row() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        assert_eq!(envelope_of(&matrix).factorize(), Err(BadPivot { row: 1, pivot: -3.0 }));
        let not_a_number = DMatrix::from_row_slice(1, 1, &[f64::NAN]);
        assert!(envelope_of(&not_a_number).factorize().is_err());
    }
}
