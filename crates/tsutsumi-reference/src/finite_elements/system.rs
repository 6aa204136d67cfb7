//! The sparse linear system of a step. This is the only module that knows faer.

use faer::Col;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};

/// A sparse square system, factorised by LU with the symbolic part kept.
#[derive(Default)]
pub(super) struct System {
    entries: Vec<Triplet<usize, usize, f64>>,
    symbolic: Option<SymbolicLu<usize>>,
    factors: Option<Lu<usize, f64>>,
    /// Factors that bring the largest entry of every row, then of every column, to one: stiffnesses and conductances are
    /// fifteen orders of magnitude apart.
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
}

/// The matrix has no usable factors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Singular;

impl System {
    /// Forgets the entries and the factors.
    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.factors = None;
    }

    /// True when [`System::factorize`] has succeeded since the last [`System::clear`].
    pub(super) fn is_factorized(&self) -> bool {
        self.factors.is_some()
    }

    /// Adds to an entry. Every matrix of a system must add to the same entries.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.entries.push(Triplet::new(row, column, value));
    }

    /// Factorises the matrix of `size` rows that was added up.
    pub(super) fn factorize(&mut self, size: usize) -> Result<(), Singular> {
        self.equilibrate(size);
        let matrix =
            SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &self.entries).map_err(|_| Singular)?;
        let symbolic = match self.symbolic.take() {
            Some(symbolic) => symbolic,
            None => SymbolicLu::try_new(matrix.symbolic()).map_err(|_| Singular)?,
        };
        self.symbolic = Some(symbolic.clone());
        self.factors = Some(Lu::try_new_with_symbolic(symbolic, matrix.as_ref()).map_err(|_| Singular)?);
        Ok(())
    }

    /// Scales the rows and columns of the entries.
    fn equilibrate(&mut self, size: usize) {
        self.row_scale = vec![0.0; size];
        self.column_scale = vec![0.0; size];
        let inverse = |largest: f64| if largest > 0.0 { 1.0 / largest } else { 1.0 };
        for entry in &self.entries {
            self.row_scale[entry.row] = self.row_scale[entry.row].max(entry.val.abs());
        }
        self.row_scale.iter_mut().for_each(|scale| *scale = inverse(*scale));
        for entry in &mut self.entries {
            entry.val *= self.row_scale[entry.row];
            self.column_scale[entry.col] = self.column_scale[entry.col].max(entry.val.abs());
        }
        self.column_scale.iter_mut().for_each(|scale| *scale = inverse(*scale));
        for entry in &mut self.entries {
            entry.val *= self.column_scale[entry.col];
        }
    }

    /// Replaces a right-hand side by the solution.
    pub(super) fn solve(&self, right: &mut [f64]) -> Result<(), Singular> {
        let factors = self.factors.as_ref().ok_or(Singular)?;
        let mut column = Col::from_fn(right.len(), |row| right[row] * self.row_scale[row]);
        factors.solve_in_place(column.as_mut().as_mat_mut());
        for (row, value) in right.iter_mut().enumerate() {
            *value = column[row] * self.column_scale[row];
        }
        match right.iter().all(|value| value.is_finite()) {
            true => Ok(()),
            false => Err(Singular),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [[2, -1], [1, 0]] x = [1, 3] has x = [3, 5]; repeated entries are summed.
    #[test]
    fn a_system_with_a_zero_on_its_diagonal_is_solved() {
        let mut system = System::default();
        for scale in [1.0, 2.0] {
            system.clear();
            assert!(!system.is_factorized());
            for (row, column, value) in [(0, 0, 0.5), (0, 1, -1.0), (0, 0, 1.5), (1, 0, 1.0)] {
                system.add(row, column, scale * value);
            }
            system.factorize(2).unwrap();
            let mut right = [scale, 3.0 * scale];
            system.solve(&mut right).unwrap();
            assert!((right[0] - 3.0).abs() < 1e-14 && (right[1] - 5.0).abs() < 1e-14, "{right:?}");
        }
    }
}
