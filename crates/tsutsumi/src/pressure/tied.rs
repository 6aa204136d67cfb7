//! Nodes that move as one, seen from the pressure system: a correction of rank one for each such set.

use super::StepView;
use crate::grid::Tie;
use crate::tensor::Vector;

/// What one set of tied nodes adds to the matrix.
///
/// # Equation
///
/// ```text
/// A = A₀ + Σ_t s_t g_t g_tᵀ      g_t = Σ_{I∈t} K_v,I·e_t      s_t = c_t / m_t      c_t = Σ_{I∈t} m_I c_I / m_t
/// ```
///
/// `A₀` is the matrix with the tied motions held, `e_t` the axis along which the nodes move together, `m_t` their mass. One
/// c for the set, the mean of its nodes by mass, keeps the matrix symmetric where the conductivity varies: it is the inertia
/// of the water against the one acceleration of all. With c_t ≥ 0 it stays positive definite.
///
/// # Reference
///
/// The inverse of the corrected matrix: Sherman and Morrison (1950), Ann. Math. Statist. 21, 124–127, one set after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct TiedCells {
    /// g of every active cell, by slot (m²; 2-D: m, 1-D: –).
    divergence: Vec<f64>,
    /// s (s/kg).
    strength: f64,
    /// A_t⁻¹ g, by slot, where A_t holds the sets before this one.
    direction: Vec<f64>,
    /// s / (1 + s gᵀ A_t⁻¹ g).
    damping: f64,
}

impl TiedCells {
    /// Makes room for `size` places: those of the cells by slot, or sites, see [`TiedCells::measure`].
    pub(super) fn resize(&mut self, size: usize) {
        self.divergence.resize(size, 0.0);
        self.direction.resize(size, 0.0);
    }

    /// Sums g over the nodes of a tie. `cells_of_node` lists the entries (slot × stencil length + local node) that meet at
    /// the active node with this place; `place_of` gives the place of a slot's values.
    pub(super) fn measure<'a, const D: usize>(
        &mut self,
        at: &StepView<D>,
        tie: &Tie,
        strength: f64,
        divergence: &[Vector<D>],
        cells_of_node: impl Fn(usize) -> &'a [u32],
        place_of: impl Fn(usize) -> usize,
    ) {
        self.strength = strength;
        self.divergence.fill(0.0);
        let stencil_len = at.transfer.stencil_len();
        for node in tie.nodes() {
            // A tie holds active nodes only.
            let Ok(place) = at.active.nodes().binary_search(node) else { continue };
            for &entry in cells_of_node(place) {
                self.divergence[place_of(entry as usize / stencil_len)] += divergence[entry as usize][tie.axis()];
            }
        }
    }

    /// s (s/kg).
    pub(super) fn strength(&self) -> f64 {
        self.strength
    }

    /// Adds s g gᵀ x to a product; returns s (gᵀ x)².
    pub(super) fn add_product(&self, x: &[f64], product: &mut [f64]) -> f64 {
        let along = dot(&self.divergence, x);
        let factor = self.strength * along;
        for (product, g) in product.iter_mut().zip(&self.divergence) {
            *product += factor * g;
        }
        factor * along
    }

    /// Prepares [`TiedCells::correct`]. `solve` turns a right-hand side of the matrix without this set into the solution.
    ///
    /// # Errors
    /// The pivot 1 + s gᵀ A_t⁻¹ g where it is not positive: the matrix is not positive definite then.
    pub(super) fn factorize(&mut self, solve: impl FnOnce(&mut [f64])) -> Result<(), f64> {
        self.direction.copy_from_slice(&self.divergence);
        solve(&mut self.direction);
        let pivot = 1.0 + self.strength * dot(&self.divergence, &self.direction);
        // NaN fails the comparison too.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return Err(pivot);
        }
        self.damping = self.strength / pivot;
        Ok(())
    }

    /// Turns the solution x without this set into the one with it: x − s z (gᵀ x) / (1 + s gᵀ z), z = A_t⁻¹ g.
    pub(super) fn correct(&self, x: &mut [f64]) {
        let factor = self.damping * dot(&self.divergence, x);
        for (x, z) in x.iter_mut().zip(&self.direction) {
            *x -= factor * z;
        }
    }

    /// The slot on which the set acts most.
    pub(super) fn main_slot(&self) -> usize {
        let mut main = 0;
        for (slot, g) in self.divergence.iter().enumerate() {
            if g.abs() > self.divergence[main].abs() {
                main = slot;
            }
        }
        main
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// Two sets over four cells against a dense factorisation of the whole matrix.
    #[test]
    fn corrections_one_after_the_other_give_the_inverse_of_the_whole() {
        let held = DMatrix::<f64>::from_fn(4, 4, held_entry);
        let sets = [([1.0, -2.0, 0.5, 0.0], 3.0), ([0.0, 1.0, 1.0, -4.0], 0.7)];
        let mut whole = held.clone();
        let factor = held.cholesky().unwrap();
        let solve = |x: &mut [f64]| {
            let solution = factor.solve(&DVector::from_column_slice(x));
            x.copy_from_slice(solution.as_slice());
        };
        let mut tied: Vec<TiedCells> = Vec::new();
        for (divergence, strength) in sets {
            let g = DVector::from_column_slice(&divergence);
            whole += &g * g.transpose() * strength;
            let mut set = TiedCells { divergence: divergence.to_vec(), strength, ..TiedCells::default() };
            set.resize(4);
            set.factorize(|x| {
                solve(x);
                tied.iter().for_each(|before| before.correct(x));
            })
            .unwrap();
            tied.push(set);
        }
        let right = [1.0, 2.0, -1.0, 0.3];
        let mut x = right;
        solve(&mut x);
        tied.iter().for_each(|set| set.correct(&mut x));
        let expected = whole.clone().cholesky().unwrap().solve(&DVector::from_column_slice(&right));
        // Condition about 30: a few dozen epsilons.
        assert!((DVector::from_column_slice(&x) - &expected).norm() < 1e-14 * 30.0 * expected.norm());

        let mut product = vec![0.0; 4];
        let energy: f64 = tied.iter().map(|set| set.add_product(&x, &mut product)).sum();
        for i in 0..4 {
            let expected: f64 = (0..4).map(|j| (whole[(i, j)] - held_entry(i, j)) * x[j]).sum();
            assert!((product[i] - expected).abs() < 1e-13);
        }
        // A sum of four terms around ten.
        assert!((energy - dot(&product, &x)).abs() < 1e-13);
    }

    /// The matrix with the ties held, entry by entry.
    fn held_entry(i: usize, j: usize) -> f64 {
        if i == j { 2.5 } else { -0.5 / (1.0 + i.abs_diff(j) as f64) }
    }

    #[test]
    fn a_set_that_takes_more_than_there_is_makes_the_matrix_indefinite() {
        let mut set = TiedCells { divergence: vec![1.0], strength: -3.0, ..TiedCells::default() };
        set.resize(1);
        // A₀ = 2: A = 2 − 3 < 0, the pivot is 1 − 3/2.
        assert_eq!(set.factorize(|x| x[0] /= 2.0), Err(-0.5));
    }
}
