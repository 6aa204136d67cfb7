//! A preconditioner whose work per cell and whose effect do not depend on the size of the grid.

use std::ops::Range;

use super::coarsest::Coarsest;
use super::envelope::BadPivot;
use super::lattice::Lattice;
use super::passage::Passage;
use super::smoother::Smoother;
use super::stencil_matrix::{GRAIN, StencilMatrix};
use crate::parallel;

/// Edge of the first blocks, in cells, and of the blocks of blocks.
const FACTORS: [i32; 2] = [4, 2];

/// So many blocks are solved for directly: small levels cost more in calls than in numbers.
pub(super) const MOST_DIRECT: usize = 64;

/// The smoother on the blocks damps the part of the spectrum above 1/this of its largest eigenvalue: what blocks of blocks cannot represent.
const SMOOTHED_RANGE_OF_BLOCKS: f64 = 6.0;

/// The same on the grid follows from the matrix, between these. By experiment: below the first, 7 instead of 12, an iteration more is needed.
const SMOOTHED_RANGE: [f64; 2] = [12.0, 100.0];

/// The patterns in which pressures leave the volume change of full cells next to alone: smooth fields, and smooth fields times the signs
/// (−1)^(i+j) of two axes.
const PATTERNS: [&[u8]; 3] = [&[0], &[0, 0b011], &[0, 0b011, 0b101, 0b110]];

/// One symmetric multigrid cycle.
///
/// # Equation
///
/// ```text
/// B = 2S − S A S + Σ_q (1 − S A) P_q B_q P_qᵀ (1 − A S)
/// ```
///
/// `S` is a Chebyshev polynomial of D⁻¹A, see [`Smoother`], `P_q` the linear interpolation from blocks of cells times the signs of the
/// pattern q, `B_q` the same cycle for the matrix of the blocks. It is positive definite whatever the matrices of the blocks are, as long
/// as they are too.
///
/// On a full grid K_vᵀ M⁻¹ K_v couples a cell with those across its corners only: a chessboard of pressures costs as little as a uniform one, and
/// each colour is a grid of its own. So blocks get an unknown for the smooth part and one for the chessboard (in 3-D one for that of each plane).
/// The conductance ties the colours together; in the patterns it is a plain sum and difference, so each has a matrix of its own.
///
/// All is in single precision and scaled to a diagonal of ones: the preconditioner need not be exact, only the same for the whole solution.
#[derive(Debug, Clone, Default)]
pub(super) struct Multigrid {
    dimension: usize,
    lattices: Vec<Lattice>,
    passages: Vec<Passage>,
    grid: Level,
    /// The levels of blocks for each pattern, and the factor of the last one.
    blocks: Vec<(Vec<Level>, Coarsest)>,
}

/// The matrix of one level, scaled, and work arrays.
#[derive(Debug, Clone, Default)]
struct Level {
    /// The matrix as it is; empty on the grid itself, whose matrix stands elsewhere.
    matrix: StencilMatrix<f64>,
    scaled: StencilMatrix<f32>,
    /// √A_ii, its inverse (zero without a cell).
    root: Vec<f32>,
    inverse_root: Vec<f32>,
    smoother: Smoother,
    right: Vec<f32>,
    residual: Vec<f32>,
    solution: Vec<f32>,
    product: Vec<f32>,
}

/// A diagonal entry that is not positive, at a site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BadDiagonal {
    pub(super) site: usize,
    pub(super) value: f64,
}

impl Multigrid {
    /// Makes the levels for a lattice. Blocks are coarsened until there are at most `most_direct`, at least one.
    pub(super) fn rebuild(&mut self, dimension: usize, most_direct: usize, lattice: &Lattice) {
        self.dimension = dimension;
        self.grid.resize(lattice);
        let mut depth = 0;
        loop {
            let fine = if depth == 0 { lattice } else { &self.lattices[depth - 1] };
            if fine.num_cells() <= if depth == 0 { 1 } else { most_direct } {
                break;
            }
            if self.passages.len() == depth {
                self.passages.push(Passage::default());
                self.lattices.push(Lattice::default());
            }
            let factor = FACTORS[depth.min(1)];
            let (finer, coarser) = self.lattices.split_at_mut(depth);
            let fine = finer.last().unwrap_or(lattice);
            let num_patterns = if depth == 0 { PATTERNS[dimension - 1].len() } else { 1 };
            self.passages[depth].rebuild(dimension, factor, num_patterns, fine, &mut coarser[0]);
            depth += 1;
        }
        self.passages.truncate(depth);
        self.lattices.truncate(depth);
        self.blocks.resize_with(PATTERNS[dimension - 1].len(), Default::default);
        for (levels, coarsest) in &mut self.blocks {
            levels.resize_with(depth, Level::default);
            for (level, lattice) in levels.iter_mut().zip(&self.lattices) {
                level.resize(lattice);
                level.matrix.resize(lattice);
            }
            if let Some(lattice) = self.lattices.last() {
                coarsest.rebuild(lattice);
            }
        }
    }

    /// Takes the values of a matrix.
    ///
    /// # Errors
    /// The first diagonal entry that is not positive.
    pub(super) fn measure(&mut self, lattice: &Lattice, matrix: &StencilMatrix<f64>) -> Result<(), BadDiagonal> {
        self.grid.find_roots(lattice, matrix)?;
        let (bound, range) = match (self.passages.first_mut(), self.lattices.first()) {
            (Some(passage), Some(coarse)) => {
                let blocks = self.blocks.iter_mut().map(|(levels, _)| &mut levels[0].matrix);
                let bound = passage.coarsen(lattice, matrix, PATTERNS[self.dimension - 1], coarse, blocks);
                let range = bound / passage.least_eigenvalue(coarse);
                let [least, most] = SMOOTHED_RANGE;
                (bound, if range >= least { range.min(most) } else { least })
            }
            // A single cell.
            _ => (1.0, SMOOTHED_RANGE[0]),
        };
        self.grid.scale(lattice, matrix, bound, range);
        for (levels, coarsest) in &mut self.blocks {
            measure_blocks(&self.lattices, &mut self.passages, levels)?;
            if let (Some(lattice), Some(level)) = (self.lattices.last(), levels.last()) {
                let outcome = coarsest.measure(lattice, &level.matrix);
                outcome.map_err(|BadPivot { row, pivot }| BadDiagonal { site: lattice.site_of(row), value: pivot })?;
            }
        }
        Ok(())
    }

    /// The residual, to be set before [`Multigrid::cycle`]: r/√A_ii by site.
    pub(super) fn right_mut(&mut self) -> (&mut [f32], &[f32]) {
        (&mut self.grid.right, &self.grid.inverse_root)
    }

    /// What [`Multigrid::cycle`] found, times √A_ii, and 1/√A_ii.
    pub(super) fn solution(&self) -> (&[f32], &[f32]) {
        (&self.grid.solution, &self.grid.inverse_root)
    }

    /// One cycle, from zero.
    pub(super) fn cycle(&mut self, lattice: &Lattice) {
        self.grid.smooth_from_zero(lattice);
        if let Some(passage) = self.passages.first_mut() {
            self.grid.find_residual(lattice);
            let patterns = PATTERNS[self.dimension - 1];
            let mut rights: [&mut [f32]; 4] = Default::default();
            for (right, (levels, _)) in rights.iter_mut().zip(&mut self.blocks) {
                *right = &mut levels[0].right;
            }
            passage.restrict(
                lattice.runs(),
                patterns,
                &self.grid.residual,
                &self.grid.root,
                &mut rights[..patterns.len()],
            );
            let (lattices, passages) = (&self.lattices, &mut self.passages);
            for (levels, coarsest) in &mut self.blocks {
                cycle_blocks(lattices, &mut passages[1..], levels, coarsest);
            }
            let mut solutions: [&mut [f32]; 4] = Default::default();
            for (solution, (levels, _)) in solutions.iter_mut().zip(&mut self.blocks) {
                *solution = &mut levels[0].solution;
            }
            passages[0].prolong(
                lattice.runs(),
                patterns,
                &mut solutions[..patterns.len()],
                &self.grid.root,
                &mut self.grid.solution,
            );
        }
        self.grid.find_residual(lattice);
        self.grid.smooth(lattice);
    }
}

/// Fills the levels of a pattern behind the first, whose matrix is there, and scales all but the last.
fn measure_blocks(lattices: &[Lattice], passages: &mut [Passage], levels: &mut [Level]) -> Result<(), BadDiagonal> {
    for (depth, coarse) in lattices.iter().enumerate().skip(1) {
        let (finer, coarser) = levels.split_at_mut(depth);
        let (level, lattice) = (&mut finer[depth - 1], &lattices[depth - 1]);
        let matrix = std::mem::take(&mut level.matrix);
        level.find_roots(lattice, &matrix)?;
        let blocks = std::iter::once(&mut coarser[0].matrix);
        let bound = passages[depth].coarsen(lattice, &matrix, &[0], coarse, blocks);
        level.scale(lattice, &matrix, bound, SMOOTHED_RANGE_OF_BLOCKS);
        level.matrix = matrix;
    }
    Ok(())
}

/// The cycle of the first of these levels, from zero.
fn cycle_blocks(lattices: &[Lattice], passages: &mut [Passage], levels: &mut [Level], coarsest: &mut Coarsest) {
    let Some((level, coarser)) = levels.split_first_mut() else { return };
    let Some((lattice, lattices)) = lattices.split_first() else { return };
    let (Some((passage, passages)), Some(_)) = (passages.split_first_mut(), coarser.first()) else {
        coarsest.solve(lattice, &level.right, &mut level.solution);
        return;
    };
    level.scale_right();
    level.smooth_from_zero(lattice);
    level.find_residual(lattice);
    passage.restrict(lattice.runs(), &[0], &level.residual, &level.root, &mut [&mut coarser[0].right]);
    cycle_blocks(lattices, passages, coarser, coarsest);
    passage.prolong(lattice.runs(), &[0], &mut [&mut coarser[0].solution], &level.root, &mut level.solution);
    level.find_residual(lattice);
    level.smooth(lattice);
    level.unscale_solution();
}

impl Level {
    fn resize(&mut self, lattice: &Lattice) {
        self.scaled.resize(lattice);
        self.scaled.forget_diagonal();
        for work in [
            &mut self.root,
            &mut self.inverse_root,
            &mut self.right,
            &mut self.residual,
            &mut self.solution,
            &mut self.product,
        ] {
            work.clear();
            work.resize(lattice.num_sites(), 0.0);
        }
    }

    /// The square roots of the diagonal.
    fn find_roots(&mut self, lattice: &Lattice, matrix: &StencilMatrix<f64>) -> Result<(), BadDiagonal> {
        let work = |(root, inverse, sites): (&mut [f32], &mut [f32], Range<usize>)| {
            let mut bad = None;
            lattice.visit_runs(&sites, |_, from, len| {
                let values = &matrix.diagonal()[from..][..len];
                let is_bad = |value: &f64| *value <= 0.0 || value.is_nan();
                let number = values.iter().position(is_bad);
                bad = bad.or(number.map(|number| BadDiagonal { site: from + number, value: values[number] }));
                let roots = root[from - sites.start..][..len].iter_mut().zip(&mut inverse[from - sites.start..][..len]);
                parallel::vectorized(|| {
                    for ((root, inverse), &value) in roots.zip(values) {
                        (*root, *inverse) = (value.sqrt() as f32, (1.0 / value.sqrt()) as f32);
                    }
                });
            });
            bad
        };
        let pieces = (&mut self.root[..], &mut self.inverse_root[..], 0..lattice.num_sites());
        match parallel::fold(pieces, GRAIN, &work, &Option::or) {
            Some(bad) => Err(bad),
            None => Ok(()),
        }
    }

    /// The scaled matrix D^(−½) A D^(−½), and the smoother for eigenvalues up to `bound`.
    fn scale(&mut self, lattice: &Lattice, matrix: &StencilMatrix<f64>, bound: f64, range: f64) {
        let inverse = &self.inverse_root;
        let (_, scaled) = self.scaled.entries_mut();
        for (number, (scaled, offset)) in scaled.iter_mut().zip(lattice.offsets()).enumerate() {
            let entries = matrix.upper(number);
            let work = |(scaled, sites): (&mut [f32], Range<usize>)| {
                lattice.visit_stretches(&sites, |run, from, len| {
                    let neighbor = from.wrapping_add_signed(lattice.shift(run, offset)[0]);
                    let scaled = &mut scaled[from - sites.start..][..len];
                    let roots = inverse[from..][..len].iter().zip(&inverse[neighbor..][..len]);
                    parallel::vectorized(|| {
                        for ((scaled, &entry), (a, b)) in scaled.iter_mut().zip(&entries[from..][..len]).zip(roots) {
                            *scaled = (entry * (f64::from(*a) * f64::from(*b))) as f32;
                        }
                    });
                });
            };
            parallel::for_each((&mut scaled[..], 0..lattice.num_sites()), GRAIN, &work);
        }
        self.smoother = Smoother::new(bound / range, bound);
    }

    /// x = S b.
    fn smooth_from_zero(&mut self, lattice: &Lattice) {
        let Level { scaled, smoother, right, solution, product, .. } = self;
        smoother.apply(scaled, lattice, right, solution, product);
    }

    /// r = b − A x.
    fn find_residual(&mut self, lattice: &Lattice) {
        let Level { scaled, right, residual, solution, .. } = self;
        let work = |(residual, sites): (&mut [f32], Range<usize>)| {
            scaled.multiply(lattice, sites.clone(), solution, residual);
            parallel::vectorized(|| residual.iter_mut().zip(&right[sites]).for_each(|(r, b)| *r = b - *r));
        };
        parallel::for_each((&mut residual[..], 0..right.len()), GRAIN, &work);
    }

    /// x += S r. The right side is lost.
    fn smooth(&mut self, lattice: &Lattice) {
        let Level { scaled, smoother, residual, solution, right, product, .. } = self;
        smoother.add(scaled, lattice, residual, solution, [product, right]);
    }

    fn scale_right(&mut self) {
        self.right.iter_mut().zip(&self.inverse_root).for_each(|(b, inverse)| *b *= inverse);
    }

    fn unscale_solution(&mut self) {
        self.solution.iter_mut().zip(&self.inverse_root).for_each(|(x, inverse)| *x *= inverse);
    }
}
