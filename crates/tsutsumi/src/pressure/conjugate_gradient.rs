//! The conjugate gradient method, preconditioned by a multigrid cycle.

use std::ops::Range;

use super::lattice::Lattice;
use super::multigrid::Multigrid;
use super::stencil_matrix::{GRAIN, StencilMatrix};
use super::tied::TiedCells;
use crate::parallel;

/// The error at which the pressures count as solved for, relative to their change in the step. Both are measured by their energy,
/// xᵀA x: the work that the water's compression, its flow and the acceleration of the soil have in them.
///
/// It is the change that counts, not the pressure: what a step gets wrong is never made good, so errors may add up over millions
/// of steps, but never beyond this part of all that the pressures have moved. Measured against the right-hand side, which holds
/// the water stored under the whole pressure, quiet steps would not be solved for at all.
///
/// By experiment: over 6000 steps of consolidation under a strip load the outflow then is 4e-10 off that of the direct solver, and no more
/// so at the end than after the first thousand; with 1e-4 it is 8e-7, with 1e-6 6e-9, with 1e-8 1e-11.
pub(super) const RELATIVE_ERROR: f64 = 1e-7;

/// With a starting residual of so many roundings of the right-hand side there is nothing to improve.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Far more iterations than a positive definite system has been seen to need.
const MOST_ITERATIONS: usize = 1000;

/// Work arrays, by site, kept from step to step.
#[derive(Debug, Clone, Default)]
pub(super) struct ConjugateGradient {
    residual: Vec<f64>,
    direction: Vec<f64>,
    product: Vec<f64>,
}

/// Values in single precision, over or times √A_ii, with 1/√A_ii.
type Scaled<'a> = (&'a [f32], &'a [f32]);
type ScaledMut<'a> = (&'a mut [f32], &'a [f32]);

/// Why the iteration stopped without an answer.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Breakdown {
    /// A direction of non-positive curvature: the matrix is not positive definite. `site` is its largest component.
    Indefinite { site: usize, quotient: f64 },
    /// Too many iterations.
    NotConverged { site: usize, iterations: usize, residual: f64 },
}

/// A matrix and the sets of tied cells that come to it.
#[derive(Clone, Copy)]
pub(super) struct System<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) matrix: &'a StencilMatrix<f64>,
    pub(super) ties: &'a [TiedCells],
}

impl System<'_> {
    /// A x into `product`; returns xᵀA x.
    fn multiply(&self, x: &[f64], product: &mut [f64]) -> f64 {
        let work = |(product, sites): (&mut [f64], Range<usize>)| {
            self.matrix.multiply(self.lattice, sites.clone(), x, product);
            parallel::vectorized(|| dot(product, &x[sites]))
        };
        let mut energy = parallel::fold((&mut product[..], 0..x.len()), GRAIN, &work, &|a, b| a + b);
        for tie in self.ties {
            energy += tie.add_product(x, product);
        }
        energy
    }
}

impl ConjugateGradient {
    /// Makes room for a lattice.
    pub(super) fn resize(&mut self, lattice: &Lattice) {
        for work in [&mut self.residual, &mut self.direction, &mut self.product] {
            work.clear();
            work.resize(lattice.num_sites(), 0.0);
        }
    }

    /// Solves A x = b for b by cell, starting from `x`, which is by site and zero where there are no cells. Returns the number of iterations.
    pub(super) fn solve(
        &mut self,
        system: System,
        preconditioner: &mut Multigrid,
        right: &[f64],
        x: &mut [f64],
    ) -> Result<usize, Breakdown> {
        system.multiply(x, &mut self.product);
        system.lattice.spread(right, &mut self.residual);
        let mut scale = self.start(preconditioner);
        if scale == 0.0 {
            return Ok(0);
        }
        let mut energies = Energies::default();
        self.scale_residual(preconditioner, scale);
        let mut of_residual = self.precondition(system.lattice, preconditioner, scale);
        self.set_out(preconditioner, scale);
        for iteration in 1..=MOST_ITERATIONS {
            let curvature = system.multiply(&self.direction, &mut self.product);
            if curvature <= 0.0 {
                let quotient = curvature / dot(&self.direction, &self.direction);
                return Err(Breakdown::Indefinite { site: largest(&self.direction), quotient });
            }
            let step = of_residual / curvature;
            if energies.are_settled(step * of_residual) {
                self.advance(step, x);
                return Ok(iteration);
            }
            scale = of_residual.sqrt();
            self.reduce(preconditioner, step, scale);
            if !step.is_finite() {
                return Err(self.not_converged(iteration, right));
            }
            let next = self.precondition(system.lattice, preconditioner, scale);
            self.turn(preconditioner, scale, [step, next / of_residual], x);
            of_residual = next;
        }
        Err(self.not_converged(MOST_ITERATIONS, right))
    }

    /// The residual b − A x, for b where it shall stand and A x in `product`. Returns its norm, scaled by the diagonal, or zero when it is round-off.
    fn start(&mut self, preconditioner: &mut Multigrid) -> f64 {
        let (_, inverse_root) = preconditioner.right_mut();
        let work = |(residual, product, inverse_root): (&mut [f64], &[f64], &[f32])| {
            let (mut of_residual, mut of_right) = (0.0, 0.0);
            for ((r, product), inverse) in residual.iter_mut().zip(product).zip(inverse_root) {
                let (right, weight) = (*r, f64::from(*inverse));
                *r = right - product;
                of_residual += (*r * weight).powi(2);
                of_right += (right * weight).powi(2);
            }
            (of_residual, of_right)
        };
        let pieces = (&mut self.residual[..], &self.product[..], inverse_root);
        let sum = |a: (f64, f64), b: (f64, f64)| (a.0 + b.0, a.1 + b.1);
        let (of_residual, of_right): (f64, f64) = parallel::fold(pieces, GRAIN, &work, &sum);
        if of_residual <= ROUNDING * ROUNDING * of_right { 0.0 } else { of_residual.sqrt() }
    }

    /// The residual over `scale`, which keeps single precision in its range, to the preconditioner.
    fn scale_residual(&self, preconditioner: &mut Multigrid, scale: f64) {
        let per_scale = 1.0 / scale;
        let work = |(right, inverse_root, residual): (&mut [f32], &[f32], &[f64])| {
            parallel::vectorized(|| {
                for ((b, inverse), r) in right.iter_mut().zip(inverse_root).zip(residual) {
                    *b = (r * f64::from(*inverse) * per_scale) as f32;
                }
            });
        };
        let (right, inverse_root) = preconditioner.right_mut();
        parallel::for_each((right, inverse_root, &self.residual[..]), GRAIN, &work);
    }

    /// r ← r − α A p, and over `scale` to the preconditioner.
    fn reduce(&mut self, preconditioner: &mut Multigrid, step: f64, scale: f64) {
        let per_scale = 1.0 / scale;
        let work = |((right, inverse_root), (residual, product)): (ScaledMut, (&mut [f64], &[f64]))| {
            parallel::vectorized(|| {
                let residuals = residual.iter_mut().zip(product);
                for ((b, inverse), (r, product)) in right.iter_mut().zip(inverse_root).zip(residuals) {
                    *r -= step * product;
                    *b = (*r * f64::from(*inverse) * per_scale) as f32;
                }
            });
        };
        let of_residual = (&mut self.residual[..], &self.product[..]);
        parallel::for_each((preconditioner.right_mut(), of_residual), GRAIN, &work);
    }

    /// Applies the preconditioner to the residual over `scale`; returns rᵀB r.
    fn precondition(&self, lattice: &Lattice, preconditioner: &mut Multigrid, scale: f64) -> f64 {
        preconditioner.cycle(lattice);
        let (solution, inverse_root) = preconditioner.solution();
        let work = |(residual, solution, inverse_root): (&[f64], &[f32], &[f32])| -> f64 {
            parallel::vectorized(|| dot_scaled(residual, solution, inverse_root))
        };
        scale * parallel::sum((&self.residual[..], solution, inverse_root), GRAIN, &work)
    }

    /// The first direction: p ← B r.
    fn set_out(&mut self, preconditioner: &Multigrid, scale: f64) {
        let work = |(direction, (solution, inverse_root)): (&mut [f64], Scaled)| {
            parallel::vectorized(|| {
                for (p, (z, inverse)) in direction.iter_mut().zip(solution.iter().zip(inverse_root)) {
                    *p = scale * f64::from(*z) * f64::from(*inverse);
                }
            });
        };
        parallel::for_each((&mut self.direction[..], preconditioner.solution()), GRAIN, &work);
    }

    /// x ← x + α p, and the next direction: p ← B r + β p, with `[α, β]`.
    fn turn(&mut self, preconditioner: &Multigrid, scale: f64, [step, conjugation]: [f64; 2], x: &mut [f64]) {
        let work = |((x, direction), (solution, inverse_root)): ((&mut [f64], &mut [f64]), Scaled)| {
            parallel::vectorized(|| {
                let preconditioned = solution.iter().zip(inverse_root);
                for ((x, p), (z, inverse)) in x.iter_mut().zip(direction).zip(preconditioned) {
                    *x += step * *p;
                    *p = scale * f64::from(*z) * f64::from(*inverse) + conjugation * *p;
                }
            });
        };
        parallel::for_each(((x, &mut self.direction[..]), preconditioner.solution()), GRAIN, &work);
    }

    /// x ← x + α p.
    fn advance(&self, step: f64, x: &mut [f64]) {
        let work = |(x, direction): (&mut [f64], &[f64])| {
            parallel::vectorized(|| x.iter_mut().zip(direction).for_each(|(x, p)| *x += step * p));
        };
        parallel::for_each((x, &self.direction[..]), GRAIN, &work);
    }

    fn not_converged(&self, iterations: usize, right: &[f64]) -> Breakdown {
        let residual = (dot(&self.residual, &self.residual) / dot(right, right)).sqrt();
        Breakdown::NotConverged { site: largest(&self.residual), iterations, residual }
    }
}

/// The energy of the error, from those of the corrections so far.
///
/// # Equation
///
/// ```text
/// ‖x − x_k‖²_A = Σ_{j≥k} α_j r_jᵀB r_j
/// ```
///
/// The sum so far is the energy of the change. What is still to come is taken to fall as it fell last, in geometric progression.
///
/// # Reference
///
/// Hestenes and Stiefel (1952), J. Res. Natl. Bur. Stand. 49, 409–436, th. 6:1; the use of it for stopping: Strakoš and Tichý (2002), ETNA 13, 56–80 (known from later texts).
#[derive(Debug, Clone, Copy, Default)]
struct Energies {
    sum: f64,
    last: f64,
}

impl Energies {
    /// Adds the energy of a correction; true when what is to come is small enough.
    fn are_settled(&mut self, correction: f64) -> bool {
        self.sum += correction;
        // Never trusts a single good iteration for more than two digits.
        let ratio = if self.last > 0.0 { (correction / self.last).max(1e-4) } else { 1.0 };
        self.last = correction;
        correction == 0.0
            || (ratio < 1.0 && correction * ratio / (1.0 - ratio) <= RELATIVE_ERROR * RELATIVE_ERROR * self.sum)
    }
}

/// Sums side by side: as many as two vectors hold.
const SUMS: usize = 8;

/// Σ a_i b_i, in a few sums side by side.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (a, b) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for i in 0..SUMS {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Σ a_i b_i c_i, likewise.
#[inline(always)]
fn dot_scaled(a: &[f64], b: &[f32], c: &[f32]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (a, b, c) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS), c.chunks_exact(SUMS));
    let rests = a.remainder().iter().zip(b.remainder()).zip(c.remainder());
    let rest: f64 = rests.map(|((a, b), c)| a * f64::from(*b) * f64::from(*c)).sum();
    for ((a, b), c) in a.zip(b).zip(c) {
        for i in 0..SUMS {
            sums[i] += a[i] * f64::from(b[i]) * f64::from(c[i]);
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn largest(values: &[f64]) -> usize {
    let mut site = 0;
    for (i, value) in values.iter().enumerate() {
        if value.abs() > values[site].abs() {
            site = i;
        }
    }
    site
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::super::multigrid::{BadDiagonal, MOST_DIRECT};
    use super::super::stencil_matrix::STRIP;
    use super::*;
    use crate::pressure::lattice::Place;

    /// Every second cell of a box or so, numbered by x first.
    fn ragged(dimension: usize, edge: i32, holes: u64) -> Vec<[i32; 3]> {
        let along = |axis: usize| if axis < dimension { edge } else { 1 };
        let places = (0..along(2)).flat_map(|z| (0..along(1)).flat_map(move |y| (0..along(0)).map(move |x| [x, y, z])));
        places.enumerate().filter(|(number, _)| holes >> (number % 61) & 1 == 0).map(|(_, place)| place).collect()
    }

    /// A matrix on a lattice, filled by `entry(cell, other cell)` where the matrix reaches, and the same as a dense one.
    fn fill(
        lattice: &Lattice,
        places: &[[i32; 3]],
        entry: impl Fn(usize, usize) -> f64,
    ) -> (StencilMatrix<f64>, DMatrix<f64>) {
        let mut matrix = StencilMatrix::default();
        matrix.resize(lattice);
        let mut dense = DMatrix::zeros(places.len(), places.len());
        let (diagonal, upper) = matrix.entries_mut();
        for (cell, place) in places.iter().enumerate() {
            let site = lattice.site(*place).unwrap();
            diagonal[site] = entry(cell, cell);
            dense[(cell, cell)] = entry(cell, cell);
            for (number, offset) in lattice.offsets().iter().enumerate() {
                let neighbor = std::array::from_fn(|axis| place[axis] + offset.to[axis]);
                if let Some(other) = places.iter().position(|place| *place == neighbor) {
                    upper[number][site] = entry(cell, other);
                    dense[(cell, other)] = entry(cell, other);
                    dense[(other, cell)] = entry(cell, other);
                }
            }
        }
        (matrix, dense)
    }

    fn by_site(lattice: &Lattice, by_cell: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; lattice.num_sites()];
        lattice.spread(by_cell, &mut values);
        values
    }

    /// Solves with the matrix; returns the solution by cell and the iterations.
    fn solve(
        lattice: &Lattice,
        dimension: usize,
        most_direct: usize,
        matrix: &StencilMatrix<f64>,
        right: &[f64],
    ) -> Result<(Vec<f64>, usize), Breakdown> {
        let mut multigrid = Multigrid::default();
        multigrid.rebuild(dimension, most_direct, lattice);
        multigrid.measure(lattice, matrix).unwrap();
        let mut iteration = ConjugateGradient::default();
        iteration.resize(lattice);
        let mut x = vec![0.0; lattice.num_sites()];
        let system = System { lattice, matrix, ties: &[] };
        let iterations = iteration.solve(system, &mut multigrid, right, &mut x)?;
        let mut solution = vec![0.0; right.len()];
        lattice.gather(&x, &mut solution);
        Ok((solution, iterations))
    }

    /// Products run over the margins between lines: nothing is left there, and at the cells it is the dense product. The places are boxes with
    /// lines of equal length, and bodies with holes, steps and islands.
    #[test]
    fn products_are_those_of_the_dense_matrix_and_zero_where_there_are_no_cells() {
        for (dimension, edge, reach) in [(1, 50, 2), (2, 12, 1), (2, 12, 3), (3, 6, 1), (3, 5, 2)] {
            for holes in [0, 0b1000_0110_0001_1100_0010, 0x5a5a_0f0f_3c3c_1234] {
                let places = ragged(dimension, edge, holes);
                let mut lattice = Lattice::default();
                lattice.rebuild(dimension, reach, places.iter().copied());
                let (matrix, dense) = fill(&lattice, &places, |a, b| 1.0 + ((a.min(b) * 31 + a.max(b)) % 7) as f64);
                let x: Vec<f64> = (0..places.len()).map(|cell| 1.0 + (cell % 5) as f64).collect();
                let mut product = vec![0.0; lattice.num_sites()];
                let system = System { lattice: &lattice, matrix: &matrix, ties: &[] };
                system.multiply(&by_site(&lattice, &x), &mut product);
                // Small whole numbers: every sum is exact.
                let expected = dense * DVector::from_vec(x);
                assert_eq!(product, by_site(&lattice, expected.as_slice()), "{dimension}-D, {reach}, {holes:x}");
            }
        }
    }

    proptest! {
        /// Random positive definite matrices on ragged bodies, against a dense factorisation.
        #[test]
        fn solves_like_a_dense_factorisation(
            dimension in 1_usize..=3,
            reach in 1_i32..=3,
            holes in any::<u64>(),
            values in prop::collection::vec(-1.0..1.0_f64, 97),
        ) {
            let places = ragged(dimension, [40, 9, 5][dimension - 1], holes);
            prop_assume!(!places.is_empty());
            let mut lattice = Lattice::default();
            lattice.rebuild(dimension, reach, places.iter().copied());
            let neighbors = 2.0 * lattice.offsets().len() as f64;
            let entry = |a: usize, b: usize| if a == b { 1.01 * neighbors } else { values[(a.min(b) * 31 + a.max(b)) % 97] };
            let (matrix, dense) = fill(&lattice, &places, entry);
            let right: Vec<f64> = (0..places.len()).map(|cell| values[cell % 97] + 0.1).collect();
            let expected = dense.clone().cholesky().unwrap().solve(&DVector::from_column_slice(&right));
            for most_direct in [1, MOST_DIRECT] {
                let (solution, iterations) = solve(&lattice, dimension, most_direct, &matrix, &right).unwrap();
                let error = DVector::from_vec(solution) - &expected;
                let energy = |x: &DVector<f64>| x.dot(&(&dense * x)).sqrt();
                // What the estimate promises, and a factor where the last iterations are uneven.
                prop_assert!(energy(&error) <= 10.0 * RELATIVE_ERROR * energy(&expected));
                prop_assert!(iterations <= 40, "{}", iterations);
            }
        }
    }

    /// Changes the diagonal of a matrix so that each of its rows sums to a storage of 1e-3.
    fn sum_rows_to_storage(lattice: &Lattice, places: &[Place], matrix: &mut StencilMatrix<f64>) {
        let mut sums = vec![0.0; lattice.num_sites()];
        for (number, run) in lattice.runs().iter().enumerate() {
            let sites = run.site..run.site + run.len;
            let mut rows = [[0.0; STRIP]];
            matrix.sum_rows(lattice, number, sites.clone(), [0], &mut rows);
            let len = sites.len();
            sums[sites].copy_from_slice(&rows[0][..len]);
        }
        for place in places {
            let site = lattice.site(*place).unwrap();
            matrix.entries_mut().0[site] += 1e-3 - sums[site];
        }
    }

    /// The preconditioner as a matrix: symmetric and positive definite, on a body with a hole and an island.
    #[test]
    fn a_cycle_is_symmetric_and_positive_definite() {
        for (dimension, edge, most_direct) in
            [(1, 30, 1), (2, 11, 1), (3, 5, 1), (1, 30, MOST_DIRECT), (2, 11, MOST_DIRECT)]
        {
            let places = ragged(dimension, edge, 0b1000_0110_0001_1100_0010);
            let mut lattice = Lattice::default();
            lattice.rebuild(dimension, 1, places.iter().copied());
            // A rotated Laplacian with little storage: corners pull more than sides.
            let (mut matrix, _) = fill(&lattice, &places, |a, b| {
                let apart: i32 = (0..3).map(|axis| (places[a][axis] - places[b][axis]).abs()).sum();
                if a == b {
                    1e-3
                } else {
                    -[0.0, 0.01, 1.0, 0.3][apart as usize] - if dimension == 1 { 1.0 } else { 0.0 }
                }
            });
            sum_rows_to_storage(&lattice, &places, &mut matrix);
            let mut multigrid = Multigrid::default();
            multigrid.rebuild(dimension, most_direct, &lattice);
            multigrid.measure(&lattice, &matrix).unwrap();
            let size = places.len();
            let mut cycle = DMatrix::<f64>::zeros(size, size);
            for column in 0..size {
                let site = lattice.site(places[column]).unwrap();
                let (right, _) = multigrid.right_mut();
                right.fill(0.0);
                right[site] = 1.0;
                multigrid.cycle(&lattice);
                let (solution, _) = multigrid.solution();
                for row in 0..size {
                    cycle[(row, column)] = f64::from(solution[lattice.site(places[row]).unwrap()]);
                }
            }
            let asymmetry = (&cycle - cycle.transpose()).amax();
            // Single precision, some thousand operations deep.
            assert!(asymmetry < 1e-4 * cycle.amax(), "{dimension}-D: {asymmetry}");
            let least = ((&cycle + cycle.transpose()) * 0.5).symmetric_eigenvalues().min();
            assert!(least > 0.0, "{dimension}-D: {least}");
        }
    }

    /// L + C − b K with the Laplacians L along the axes and K across the corners, as with γΔt < k/g: nearly singular for short waves along an axis, stiffest for
    /// the chessboard.
    #[test]
    fn steps_shorter_than_the_waters_inertia_need_a_dozen_iterations() {
        let places = ragged(2, 48, 0);
        let mut lattice = Lattice::default();
        lattice.rebuild(2, 1, places.iter().copied());
        for push in [0.5, 0.8, 0.9] {
            let (mut matrix, _) = fill(&lattice, &places, |a, b| {
                let apart: i32 = (0..2).map(|axis| (places[a][axis] - places[b][axis]).abs()).sum();
                [1e-3, -1.0, 0.5 * push][apart as usize]
            });
            sum_rows_to_storage(&lattice, &places, &mut matrix);
            let right: Vec<f64> = (0..places.len()).map(|cell| if cell == 700 { 1.0 } else { 1e-3 }).collect();
            let (_, iterations) = solve(&lattice, 2, MOST_DIRECT, &matrix, &right).unwrap();
            assert!(iterations <= 12, "{push}: {iterations}");
        }
    }

    #[test]
    fn indefinite_and_not_finite_systems_are_named() {
        let places = ragged(1, 2, 0);
        let mut lattice = Lattice::default();
        lattice.rebuild(1, 1, places.iter().copied());
        let (indefinite, _) = fill(&lattice, &places, |a, b| if a == b { 1.0 } else { 2.0 });
        assert!(matches!(solve(&lattice, 1, 1, &indefinite, &[1.0, -1.0]), Err(Breakdown::Indefinite { .. })));
        let (identity, _) = fill(&lattice, &places, |a, b| if a == b { 1.0 } else { 0.0 });
        assert!(matches!(solve(&lattice, 1, 1, &identity, &[f64::NAN, 0.0]), Err(Breakdown::NotConverged { .. })));
        assert_eq!(solve(&lattice, 1, 1, &identity, &[0.0, 0.0]), Ok((vec![0.0, 0.0], 0)));
        let (negative, _) = fill(&lattice, &places, |a, _| if a == 0 { 1.0 } else { -1.0 });
        let mut multigrid = Multigrid::default();
        multigrid.rebuild(1, 1, &lattice);
        let site = lattice.site(places[1]).unwrap();
        assert_eq!(multigrid.measure(&lattice, &negative), Err(BadDiagonal { site, value: -1.0 }));
    }
}
