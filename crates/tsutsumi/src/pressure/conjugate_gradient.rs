//! The conjugate gradient method with the diagonal as preconditioner.

/// The residual, relative to the right-hand side, at which the pressures count as solved for.
pub(super) const RELATIVE_RESIDUAL: f64 = 1e-11;

/// Work arrays, kept from step to step.
#[derive(Debug, Clone, Default)]
pub(super) struct ConjugateGradient {
    residual: Vec<f64>,
    direction: Vec<f64>,
    product: Vec<f64>,
    scaled: Vec<f64>,
}

/// Why the iteration stopped without an answer.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Breakdown {
    /// A direction of non-positive curvature: the matrix is not positive definite. `row` is its largest component.
    Indefinite { row: usize, quotient: f64 },
    /// Too many iterations.
    NotConverged { row: usize, iterations: usize, residual: f64 },
}

impl ConjugateGradient {
    /// Makes room for systems of `size` unknowns.
    pub(super) fn resize(&mut self, size: usize) {
        for work in [&mut self.residual, &mut self.direction, &mut self.product, &mut self.scaled] {
            work.resize(size, 0.0);
        }
    }

    /// Solves A x = b, starting from `x`. `multiply(v, out)` sets out = A v. Returns the number of iterations.
    pub(super) fn solve(
        &mut self,
        mut multiply: impl FnMut(&[f64], &mut [f64]),
        diagonal: &[f64],
        right: &[f64],
        x: &mut [f64],
    ) -> Result<usize, Breakdown> {
        let size = right.len();
        let norm = dot(right, right).sqrt();
        if norm == 0.0 {
            x.fill(0.0);
            return Ok(0);
        }
        if let Some(row) = diagonal.iter().position(|&d| d <= 0.0 || d.is_nan()) {
            return Err(Breakdown::Indefinite { row, quotient: diagonal[row] });
        }
        multiply(x, &mut self.product);
        for i in 0..size {
            self.residual[i] = right[i] - self.product[i];
            self.scaled[i] = self.residual[i] / diagonal[i];
        }
        self.direction.copy_from_slice(&self.scaled);
        let mut rz = dot(&self.residual, &self.scaled);
        // In exact arithmetic `size` iterations are enough; rounding may ask for more.
        let limit = 10 * size + 100;
        for iteration in 0..=limit {
            let residual = dot(&self.residual, &self.residual).sqrt() / norm;
            if residual <= RELATIVE_RESIDUAL {
                return Ok(iteration);
            }
            if iteration == limit || !residual.is_finite() {
                let row = largest(&self.residual);
                return Err(Breakdown::NotConverged { row, iterations: iteration, residual });
            }
            multiply(&self.direction, &mut self.product);
            let curvature = dot(&self.direction, &self.product);
            if curvature <= 0.0 || curvature.is_nan() {
                let quotient = curvature / dot(&self.direction, &self.direction);
                return Err(Breakdown::Indefinite { row: largest(&self.direction), quotient });
            }
            let alpha = rz / curvature;
            for i in 0..size {
                x[i] += alpha * self.direction[i];
                self.residual[i] -= alpha * self.product[i];
                self.scaled[i] = self.residual[i] / diagonal[i];
            }
            let rz_new = dot(&self.residual, &self.scaled);
            let beta = rz_new / rz;
            rz = rz_new;
            for i in 0..size {
                self.direction[i] = self.scaled[i] + beta * self.direction[i];
            }
        }
        unreachable!("the loop returns at its last iteration")
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn largest(values: &[f64]) -> usize {
    let mut row = 0;
    for (i, value) in values.iter().enumerate() {
        if value.abs() > values[row].abs() {
            row = i;
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    fn solve(matrix: &DMatrix<f64>, right: &[f64]) -> Result<(Vec<f64>, usize), Breakdown> {
        let mut solver = ConjugateGradient::default();
        solver.resize(right.len());
        let mut x = vec![0.0; right.len()];
        let multiply = |v: &[f64], out: &mut [f64]| {
            out.copy_from_slice((matrix * DVector::from_column_slice(v)).as_slice());
        };
        let diagonal: Vec<f64> = matrix.diagonal().iter().copied().collect();
        let iterations = solver.solve(multiply, &diagonal, right, &mut x)?;
        Ok((x, iterations))
    }

    #[test]
    fn reaches_the_stated_residual() {
        // The 1-D Laplacian with a mass term, 60 unknowns.
        let matrix = DMatrix::from_fn(60, 60, |i, j| match i.abs_diff(j) {
            0 => 2.01,
            1 => -1.0,
            _ => 0.0,
        });
        let right: Vec<f64> = (0..60).map(|i| (i as f64).sin()).collect();
        let (x, iterations) = solve(&matrix, &right).unwrap();
        let residual = &matrix * DVector::from_vec(x) - DVector::from_column_slice(&right);
        assert!(residual.norm() <= 2.0 * RELATIVE_RESIDUAL * DVector::from_column_slice(&right).norm());
        assert!(iterations <= 60, "{iterations}");
    }

    #[test]
    fn indefinite_and_not_finite_systems_are_named() {
        let indefinite = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        assert!(matches!(solve(&indefinite, &[1.0, -1.0]), Err(Breakdown::Indefinite { .. })));
        let negative = DMatrix::from_row_slice(1, 1, &[-1.0]);
        assert!(matches!(solve(&negative, &[1.0]), Err(Breakdown::Indefinite { row: 0, .. })));
        let identity = DMatrix::identity(2, 2);
        assert!(matches!(solve(&identity, &[f64::NAN, 0.0]), Err(Breakdown::NotConverged { .. })));
    }
}
