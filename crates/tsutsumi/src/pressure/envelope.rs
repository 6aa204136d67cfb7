//! Factorisation of a symmetric positive definite matrix stored by its envelope.
//!
//! Row `i` keeps the entries from its first non-zero to the diagonal. A column of cells is a tridiagonal matrix; the
//! factor fits into the same envelope, so nothing is allocated when values change.

/// A symmetric matrix, or its factor, stored by rows within its lower envelope.
///
/// # Equation
///
/// ```text
/// A = L D Lᵀ      L_ii = 1      D_ii > 0
/// ```
///
/// Cholesky's factorisation without roots: one division per row. The factor holds 1/D_ii on its diagonal.
#[derive(Debug, Clone, Default)]
pub(super) struct Envelope {
    /// First column of each row.
    first: Vec<u32>,
    /// Where each row ends in `values`, behind its diagonal.
    end: Vec<usize>,
    values: Vec<f64>,
}

/// A pivot D_ii that is not positive, at a row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BadPivot {
    pub(super) row: usize,
    pub(super) pivot: f64,
}

impl Envelope {
    /// Sets the shape: `first[i]` is the first column of row `i`, at most `i`. Reuses memory.
    pub(super) fn set_shape(&mut self, first: impl Iterator<Item = u32>) {
        self.first.clear();
        self.end.clear();
        let mut end = 0_usize;
        for (row, column) in first.enumerate() {
            end += row + 1 - column as usize;
            self.first.push(column);
            self.end.push(end);
        }
        self.values.clear();
        self.values.resize(end, 0.0);
    }

    pub(super) fn clear_values(&mut self) {
        self.values.fill(0.0);
    }

    /// The place of the entry (row, column) of the lower triangle among all.
    #[inline]
    pub(super) fn place(&self, row: usize, column: usize) -> usize {
        self.end[row] - 1 - (row - column)
    }

    /// All entries, row by row.
    #[inline]
    pub(super) fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Adds to the entry (row, column) of the lower triangle.
    #[inline]
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        let place = self.place(row, column);
        self.values[place] += value;
    }

    /// Replaces the matrix A by its factor.
    ///
    /// # Equation
    ///
    /// ```text
    /// u_ij = A_ij − Σ_k u_ik L_jk      L_ij = u_ij / D_jj      D_ii = A_ii − Σ_j u_ij L_ij
    /// ```
    pub(super) fn factorize(&mut self) -> Result<(), BadPivot> {
        let Envelope { first, end, values } = self;
        let mut start = 0;
        for (i, (&first_i, &end_i)) in first.iter().zip(&*end).enumerate() {
            let (done, rest) = values.split_at_mut(start);
            start = end_i;
            let first_i = first_i as usize;
            // The last one is the diagonal: a row is never empty.
            let Some((pivot, row)) = rest[..i + 1 - first_i].split_last_mut() else { continue };
            let (first, end) = (&first[first_i..i], &end[first_i..i]);
            for (j, (&first_j, &end_j)) in first.iter().zip(end).enumerate() {
                let (before, at) = row.split_at_mut(j);
                let shared = j.min(first_i + j - first_j as usize);
                at[0] -= dot(&before[j - shared..], &done[end_j - 1 - shared..end_j - 1]);
            }
            for (entry, &end_j) in row.iter_mut().zip(end) {
                let scaled = *entry * done[end_j - 1];
                *pivot -= *entry * scaled;
                *entry = scaled;
            }
            // NaN fails the comparison too.
            if !(*pivot > 0.0 && pivot.is_finite()) {
                return Err(BadPivot { row: i, pivot: *pivot });
            }
            *pivot = 1.0 / *pivot;
        }
        Ok(())
    }

    /// Solves L D Lᵀ x = b in place, after [`Envelope::factorize`].
    pub(super) fn solve(&self, x: &mut [f64]) {
        let Envelope { first, end, values } = self;
        let mut rest = &values[..];
        for (i, &first) in first.iter().enumerate() {
            let first = first as usize;
            let (row, below) = rest.split_at(i + 1 - first);
            rest = below;
            x[i] -= dot(&row[..i - first], &x[first..i]);
        }
        for (x, &end) in x.iter_mut().zip(end) {
            *x *= values[end - 1];
        }
        let mut rest = &values[..];
        for (i, &first) in first.iter().enumerate().rev() {
            let first = first as usize;
            let (above, row) = rest.split_at(rest.len() - (i + 1 - first));
            rest = above;
            let xi = x[i];
            for (x, l) in x[first..i].iter_mut().zip(row) {
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
