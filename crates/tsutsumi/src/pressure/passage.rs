//! The way between a lattice and a coarser one.

use std::ops::Range;

use super::lattice::{Lattice, Parts, Place, Run};
use super::stencil_matrix::{GRAIN, STRIP, StencilMatrix};
use crate::parallel;

/// Blocks of `factor` cells per axis, each a cell of the coarser lattice, and the interpolation between the two.
///
/// Values are interpolated linearly between the centres of the blocks. At a block without cells stands the mean of the blocks around
/// it, so that uniform fields stay uniform up to the edge of the body.
#[derive(Debug, Clone, Default)]
pub(super) struct Passage {
    factor: i32,
    dimension: usize,
    /// The lines of blocks next to each run, and where its row of interpolated values is kept.
    lines: Vec<Lines>,
    row_bounds: Vec<usize>,
    /// Where the sites of the runs start, and of the slabs of the coarser lattice.
    run_bounds: Vec<usize>,
    slabs: Vec<Slab>,
    slab_bounds: Vec<usize>,
    margin: Vec<MarginSite>,
    margin_neighbors: Vec<u32>,
    rows: Vec<f32>,
    /// What the cells of every block sum up to, see [`Sources`], and where the sums of each slab start.
    sums: Vec<f64>,
    sum_bounds: Vec<usize>,
    /// Work arrays: the blocks, z first, and the coarse sites with cells.
    blocks: Vec<[i32; 3]>,
    has_cells: Vec<bool>,
}

/// The lines of blocks between which a run's values are interpolated.
#[derive(Debug, Clone, Copy, Default)]
struct Lines {
    /// The block along x at which they start.
    first: i32,
    /// How many blocks of each take part.
    len: usize,
    /// The coarse site of each line's first block and its weight.
    corners: [(u32, f32); 4],
}

/// The blocks with the same number along the last axis.
#[derive(Debug, Clone, Copy)]
struct Slab {
    number: i32,
    /// The runs that lie in it, and those that its values reach.
    own: (u32, u32),
    reached: (u32, u32),
}

/// A coarse site without cells, and its neighbours with cells.
#[derive(Debug, Clone, Copy)]
struct MarginSite {
    site: u32,
    neighbors: (u32, u32),
}

impl Passage {
    /// Finds the blocks of `fine`, makes `coarse` the lattice of them, and room for the sums of so many patterns.
    pub(super) fn rebuild(
        &mut self,
        dimension: usize,
        factor: i32,
        num_patterns: usize,
        fine: &Lattice,
        coarse: &mut Lattice,
    ) {
        (self.dimension, self.factor) = (dimension, factor);
        let mut blocks = std::mem::take(&mut self.blocks);
        blocks.clear();
        for run in fine.runs() {
            let [from, to] = [run.place[0], run.place[0] + run.len as i32 - 1].map(|x| x.div_euclid(factor));
            let [_, y, z] = run.place.map(|place| place.div_euclid(factor));
            blocks.extend((from..=to).map(|x| [z, y, x]));
        }
        blocks.sort_unstable();
        blocks.dedup();
        coarse.rebuild(dimension, 1, blocks.iter().map(|&[z, y, x]| [x, y, z]));
        self.blocks = blocks;
        self.list_lines(fine, coarse);
        self.list_slabs(fine, coarse);
        self.list_margin(coarse);
        self.rows.clear();
        self.rows.resize(self.row_bounds.last().copied().unwrap_or(0), 0.0);
        let per_block = num_patterns * sums_per_pattern(coarse);
        self.sums.clear();
        self.sums.resize(coarse.num_sites() * per_block, 0.0);
        self.sum_bounds.clear();
        self.sum_bounds.extend(self.slab_bounds.iter().map(|site| site * per_block));
    }

    /// The block of a place along an axis, the next nearest one, and the weight of that.
    fn between(&self, place: i32) -> (i32, i32, f32) {
        let block = place.div_euclid(self.factor);
        let from_center = (place.rem_euclid(self.factor) as f32 + 0.5) / self.factor as f32 - 0.5;
        (block, block + if from_center > 0.0 { 1 } else { -1 }, from_center.abs())
    }

    fn list_lines(&mut self, fine: &Lattice, coarse: &Lattice) {
        self.lines.clear();
        self.row_bounds.clear();
        self.row_bounds.push(0);
        self.run_bounds.clear();
        for run in fine.runs() {
            let first = run.place[0].div_euclid(self.factor) - 1;
            let last = (run.place[0] + run.len as i32 - 1).div_euclid(self.factor) + 1;
            let len = (last - first + 1) as usize;
            let mut corners = [(0, 0.0); 4];
            for (number, corner) in corners[..self.num_corners()].iter_mut().enumerate() {
                let along = |axis: usize, place: i32| match (axis < self.dimension, number >> (axis - 1) & 1) {
                    (false, _) => (0, 1.0),
                    (true, 0) => (self.between(place).0, 1.0 - self.between(place).2),
                    (true, _) => (self.between(place).1, self.between(place).2),
                };
                let ((y, weight_y), (z, weight_z)) = (along(1, run.place[1]), along(2, run.place[2]));
                // The margin of the coarser lattice holds the whole line.
                *corner = (coarse.site([first, y, z]).unwrap_or(0) as u32, weight_y * weight_z);
            }
            self.lines.push(Lines { first, len, corners });
            self.row_bounds.push(self.row_bounds.last().copied().unwrap_or(0) + 2 * len);
            // The first part starts with the margin, the last one ends with it.
            self.run_bounds.push(if self.run_bounds.is_empty() { 0 } else { run.site });
        }
        self.run_bounds.push(fine.num_sites());
    }

    fn num_corners(&self) -> usize {
        1 << (self.dimension - 1)
    }

    fn list_slabs(&mut self, fine: &Lattice, coarse: &Lattice) {
        self.slabs.clear();
        self.slab_bounds.clear();
        let (factor, dimension) = (self.factor, self.dimension);
        // Across the last axis; a line is one slab.
        let height = |place: Place| if dimension == 1 { 0 } else { place[dimension - 1] };
        let runs_below = |limit: i32| fine.runs().partition_point(|run| height(run.place) < limit) as u32;
        coarse.visit_sites(|site, place| {
            let number = height(place);
            if self.slabs.last().is_none_or(|slab| slab.number != number) {
                let start = number * factor;
                let own = (runs_below(start), runs_below(start + factor));
                let reached = (runs_below(start - factor / 2), runs_below(start + factor + factor / 2));
                self.slab_bounds.push(site);
                self.slabs.push(Slab { number, own, reached });
            }
        });
        self.slab_bounds.push(coarse.num_sites());
    }

    fn list_margin(&mut self, coarse: &Lattice) {
        self.margin.clear();
        self.margin_neighbors.clear();
        let mut has_cells = std::mem::take(&mut self.has_cells);
        has_cells.clear();
        has_cells.resize(coarse.num_sites(), false);
        for run in coarse.runs() {
            has_cells[run.site..run.site + run.len].fill(true);
        }
        coarse.visit_sites(|site, [x, y, z]| {
            if has_cells[site] {
                return;
            }
            let first = self.margin_neighbors.len() as u32;
            for (dz, dy, dx) in
                (-1..=1).flat_map(|dz| (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (dz, dy, dx))))
            {
                if let Some(neighbor) = coarse.site([x + dx, y + dy, z + dz])
                    && has_cells[neighbor]
                {
                    self.margin_neighbors.push(neighbor as u32);
                }
            }
            self.margin.push(MarginSite { site: site as u32, neighbors: (first, self.margin_neighbors.len() as u32) });
        });
        self.has_cells = has_cells;
    }

    /// The eigenvalue of D⁻¹ A for the shortest smooth wave that blocks represent, over as many cells as two blocks have, from the sums of [`Passage::coarsen`].
    ///
    /// ```text
    /// λ = [Σ_I Σ_J s_i s_j A_ij + 2 (1 − cos(π/f)) f²/D Σ_IJ W_IJ |x_I − x_J|²] / Σ_i A_ii      x in blocks, pattern of ones
    /// ```
    pub(super) fn least_eigenvalue(&self, coarse: &Lattice) -> f64 {
        let per_block = self.sums.len() / coarse.num_sites().max(1);
        let (mut own, mut diagonal, mut pull) = (0.0, 0.0, 0.0);
        for of_block in self.sums.chunks_exact(per_block.max(1)) {
            own += of_block[0];
            diagonal += of_block[1];
            for (offset, of_edge) in coarse.offsets().iter().zip(&of_block[2..]) {
                pull += f64::from(offset.square()) * of_edge.max(0.0);
            }
        }
        let edge = f64::from(self.factor);
        let wave = 2.0 * (1.0 - (std::f64::consts::PI / edge).cos());
        (own + wave * edge * edge / self.dimension as f64 * pull) / diagonal
    }

    /// Runs in a piece of a loop.
    fn grain(&self) -> usize {
        let runs = self.lines.len().max(1);
        (GRAIN * runs / self.run_bounds.last().map_or(1, |&sites| sites.max(1))).max(1)
    }

    /// Adds to `fine` the values of the blocks, interpolated and multiplied by `scale`; `blocks` holds them for every pattern, and is
    /// changed where there are no cells.
    pub(super) fn prolong(
        &mut self,
        runs: &[Run],
        patterns: &[u8],
        blocks: &mut [&mut [f32]],
        scale: &[f32],
        fine: &mut [f32],
    ) {
        self.fill_margin(blocks);
        let grain = self.grain();
        let blocks: &[&mut [f32]] = blocks;
        let Passage { factor, dimension, ref lines, ref row_bounds, ref run_bounds, ref mut rows, .. } = *self;
        let work = |(fine, rows, numbers): (Parts<f32>, Parts<f32>, Range<usize>)| {
            for ((number, fine), row) in numbers.zip(fine.each()).zip(rows.each()) {
                let (run, lines) = (&runs[number], &lines[number]);
                let (even, odd) = row.split_at_mut(lines.len);
                interpolate_lines(&lines.corners[..1 << (dimension - 1)], run, patterns, blocks, even, odd);
                let fine = &mut fine[run.site - run_bounds[number]..][..run.len];
                let scale = &scale[run.site..][..run.len];
                parallel::vectorized(
                    #[inline(always)]
                    || match factor {
                        4 => expand::<4>(run, lines.first, even, odd, scale, fine),
                        _ => expand::<2>(run, lines.first, even, odd, scale, fine),
                    },
                );
            }
        };
        let pieces = (Parts::new(run_bounds, fine), Parts::new(row_bounds, &mut rows[..]), 0..lines.len());
        parallel::for_each(pieces, grain, &work);
    }

    /// The transpose of [`Passage::prolong`]: sums the values of the cells, multiplied by `scale`, for every pattern into `blocks`.
    pub(super) fn restrict(
        &mut self,
        runs: &[Run],
        patterns: &[u8],
        fine: &[f32],
        scale: &[f32],
        blocks: &mut [&mut [f32]],
    ) {
        let grain = self.grain();
        let Passage { factor, ref lines, ref row_bounds, ref mut rows, .. } = *self;
        let work = |(rows, numbers): (Parts<f32>, Range<usize>)| {
            for (number, row) in numbers.zip(rows.each()) {
                let (run, lines) = (&runs[number], &lines[number]);
                let (even, odd) = row.split_at_mut(lines.len);
                let (fine, scale) = (&fine[run.site..][..run.len], &scale[run.site..][..run.len]);
                parallel::vectorized(
                    #[inline(always)]
                    || match factor {
                        4 => collect::<4>(run, lines.first, fine, scale, even, odd),
                        _ => collect::<2>(run, lines.first, fine, scale, even, odd),
                    },
                );
            }
        };
        parallel::for_each((Parts::new(row_bounds, &mut rows[..]), 0..lines.len()), grain, &work);
        for (&pattern, blocks) in patterns.iter().zip(blocks.iter_mut()) {
            self.sum_lines(runs, pattern, blocks);
        }
        self.empty_margin(blocks);
    }

    /// Adds the rows of the runs to the lines of blocks around them.
    fn sum_lines(&self, runs: &[Run], pattern: u8, blocks: &mut [f32]) {
        let Passage { lines, row_bounds, rows, slabs, slab_bounds, .. } = self;
        let work = |(blocks, numbers): (Parts<f32>, Range<usize>)| {
            for (number, blocks) in numbers.zip(blocks.each()) {
                let (slab, start) = (&slabs[number], slab_bounds[number]);
                blocks.fill(0.0);
                for run in slab.reached.0 as usize..slab.reached.1 as usize {
                    let (even, odd) = rows[row_bounds[run]..row_bounds[run + 1]].split_at(lines[run].len);
                    let (sign, sign_odd) = line_signs(&runs[run], pattern);
                    for &(site, weight) in &lines[run].corners[..self.num_corners()] {
                        let Some(place) = (site as usize).checked_sub(start).filter(|&place| place < blocks.len())
                        else {
                            continue;
                        };
                        let (even_weight, odd_weight) = (weight * sign, weight * sign_odd);
                        let blocks = &mut blocks[place..][..even.len()];
                        for ((block, even), odd) in blocks.iter_mut().zip(even).zip(odd) {
                            *block += even_weight * even + odd_weight * odd;
                        }
                    }
                }
            }
        };
        parallel::for_each((Parts::new(slab_bounds, blocks), 0..slabs.len()), self.slab_grain(), &work);
    }

    fn slab_grain(&self) -> usize {
        let fine = self.run_bounds.last().copied().unwrap_or(0).max(1);
        (GRAIN * self.slabs.len().max(1) / fine).max(1)
    }

    /// Means of the blocks around, where there are no cells.
    fn fill_margin(&self, blocks: &mut [&mut [f32]]) {
        for blocks in blocks.iter_mut() {
            for margin in &self.margin {
                let neighbors = &self.margin_neighbors[margin.neighbors.0 as usize..margin.neighbors.1 as usize];
                let sum: f32 = neighbors.iter().map(|&site| blocks[site as usize]).sum();
                blocks[margin.site as usize] = sum / neighbors.len().max(1) as f32;
            }
        }
    }

    /// The transpose of [`Passage::fill_margin`].
    fn empty_margin(&self, blocks: &mut [&mut [f32]]) {
        for blocks in blocks.iter_mut() {
            for margin in &self.margin {
                let neighbors = &self.margin_neighbors[margin.neighbors.0 as usize..margin.neighbors.1 as usize];
                let share = std::mem::take(&mut blocks[margin.site as usize]) / neighbors.len().max(1) as f32;
                neighbors.iter().for_each(|&site| blocks[site as usize] += share);
            }
        }
    }

    /// The matrix between the blocks, for fields that follow a pattern: what cells of the same block have in common stays, and what pulls
    /// cells of neighbouring blocks together acts between their centres.
    ///
    /// # Equation
    ///
    /// ```text
    /// Ā_II = Σ_{i∈I} Σ_j s_i s_j A_ij + Σ_J W_IJ      Ā_IJ = −W_IJ      W_IJ = max(0, −Σ_{i∈I, j∈J} s_i s_j A_ij d_ij / f)
    /// ```
    ///
    /// `d_ij` is the distance of the cells (cells along the axis of the largest), `f` the edge of a block, `s` the pattern's signs. A field
    /// that rises by g from cell to cell costs the same on both lattices: without d/f it would cost f times as much on the coarser.
    ///
    /// # Reference
    ///
    /// The factor: D. Braess (1995), Computing 55, 379–393, known from later texts.
    ///
    /// `blocks` gets one matrix for each pattern. Returns the bound of Gershgorin on the eigenvalues of D⁻¹ A.
    pub(super) fn coarsen<'a>(
        &mut self,
        fine: &Lattice,
        matrix: &StencilMatrix<f64>,
        patterns: &[u8],
        coarse: &Lattice,
        blocks: impl Iterator<Item = &'a mut StencilMatrix<f64>>,
    ) -> f64 {
        let grain = self.slab_grain();
        let sources = Sources { fine, matrix, patterns, factor: self.factor, coarse, stride: sums_per_pattern(coarse) };
        let Passage { slabs, slab_bounds, sums, sum_bounds, .. } = self;
        let work = |(sums, numbers): (Parts<f64>, Range<usize>)| {
            let mut bound = 0.0_f64;
            for (number, sums) in numbers.zip(sums.each()) {
                let (slab, start) = (&slabs[number], slab_bounds[number]);
                sums.fill(0.0);
                for run in slab.own.0 as usize..slab.own.1 as usize {
                    bound = bound.max(match *patterns {
                        [pattern] => sources.sum_rows([pattern], run, start, sums),
                        [smooth, chessboard] => sources.sum_rows([smooth, chessboard], run, start, sums),
                        _ => sources.sum_rows(
                            std::array::from_fn::<_, 4, _>(|number| patterns[number]),
                            run,
                            start,
                            sums,
                        ),
                    });
                    sources.sum_edges(run, start, sums);
                }
            }
            bound
        };
        let bound = parallel::fold((Parts::new(sum_bounds, &mut sums[..]), 0..slabs.len()), grain, &work, &f64::max);
        for (number, blocks) in blocks.enumerate() {
            straighten(coarse, sums, patterns.len() * sources.stride, number * sources.stride);
            fill_coarse(coarse, sums, patterns.len() * sources.stride, number * sources.stride, blocks);
        }
        bound
    }
}

/// Sums of a block for one pattern: that of its rows, that of its diagonal, and the pull of the neighbour at each offset.
fn sums_per_pattern(coarse: &Lattice) -> usize {
    2 + coarse.offsets().len()
}

/// The signs of a pattern on a run: at even and at odd x.
fn line_signs(run: &Run, pattern: u8) -> (f32, f32) {
    let parity = |axis: usize| run.place[axis] & i32::from(pattern >> axis & 1);
    let even = if (parity(1) ^ parity(2)) & 1 == 1 { -1.0 } else { 1.0 };
    (even, if pattern & 1 == 1 { -even } else { even })
}

/// The values of the lines of blocks beside a run, for cells at even and at odd x.
fn interpolate_lines(
    corners: &[(u32, f32)],
    run: &Run,
    patterns: &[u8],
    blocks: &[&mut [f32]],
    even: &mut [f32],
    odd: &mut [f32],
) {
    even.fill(0.0);
    odd.fill(0.0);
    for (&pattern, blocks) in patterns.iter().zip(blocks) {
        let (sign, sign_odd) = line_signs(run, pattern);
        for &(site, weight) in corners {
            let line = &blocks[site as usize..][..even.len()];
            for ((even, odd), block) in even.iter_mut().zip(odd.iter_mut()).zip(line) {
                *even += weight * sign * block;
                *odd += weight * sign_odd * block;
            }
        }
    }
}

/// The weight of the nearest other block for the cell with this number within its block.
#[inline(always)]
fn outer_weight<const F: usize>(within: usize) -> f32 {
    ((within as f32 + 0.5) / F as f32 - 0.5).abs()
}

/// The blocks along a run: that of its first cell and the number of that cell within it, and how many cells stand before the first whole
/// block and in whole blocks.
struct Whole {
    block: usize,
    within: usize,
    before: usize,
    cells: usize,
}

impl Whole {
    #[inline(always)]
    fn new<const F: usize>(run: &Run, first: i32) -> Self {
        let within = run.place[0].rem_euclid(F as i32) as usize;
        let block = (run.place[0].div_euclid(F as i32) - first) as usize;
        let before = ((F - within) % F).min(run.len);
        Whole { block, within, before, cells: (run.len - before) / F * F }
    }

    /// The first whole block.
    fn first(&self) -> usize {
        self.block + usize::from(self.within > 0)
    }
}

/// Adds the interpolated values to a run's cells.
#[inline(always)]
fn expand<const F: usize>(run: &Run, first: i32, even: &[f32], odd: &[f32], scale: &[f32], fine: &mut [f32]) {
    let whole = Whole::new::<F>(run, first);
    let mut add = |block: usize, within: usize, cell: usize| {
        fine[cell] += scale[cell] * between::<F>(within, &even[block - 1..][..3], &odd[block - 1..][..3]);
    };
    for cell in 0..whole.before {
        add(whole.block, whole.within + cell, cell);
    }
    let (block, num_blocks) = (whole.first(), whole.cells / F);
    for cell in whole.before + whole.cells..run.len {
        add(block + num_blocks, cell - whole.before - whole.cells, cell);
    }
    if num_blocks == 0 {
        return;
    }
    let cells = fine[whole.before..].chunks_exact_mut(F).zip(scale[whole.before..].chunks_exact(F));
    let rows = even[block - 1..][..num_blocks + 2].windows(3).zip(odd[block - 1..][..num_blocks + 2].windows(3));
    for ((fine, scale), (even, odd)) in cells.zip(rows) {
        for within in 0..F {
            fine[within] += scale[within] * between::<F>(within, even, odd);
        }
    }
}

/// The value of the cell with this number within its block, from those of the block before, its own and the next one.
#[inline(always)]
fn between<const F: usize>(within: usize, even: &[f32], odd: &[f32]) -> f32 {
    let row = if within.is_multiple_of(2) { even } else { odd };
    let outer = outer_weight::<F>(within);
    let neighbor = if within < F / 2 { row[0] } else { row[2] };
    (1.0 - outer) * row[1] + outer * neighbor
}

/// The transpose of [`expand`].
#[inline(always)]
fn collect<const F: usize>(run: &Run, first: i32, fine: &[f32], scale: &[f32], even: &mut [f32], odd: &mut [f32]) {
    even.fill(0.0);
    odd.fill(0.0);
    let whole = Whole::new::<F>(run, first);
    let mut add = |block: usize, within: usize, cell: usize| {
        share::<F>(within, scale[cell] * fine[cell], &mut even[block - 1..][..3], &mut odd[block - 1..][..3]);
    };
    for cell in 0..whole.before {
        add(whole.block, whole.within + cell, cell);
    }
    let (block, num_blocks) = (whole.first(), whole.cells / F);
    for cell in whole.before + whole.cells..run.len {
        add(block + num_blocks, cell - whole.before - whole.cells, cell);
    }
    let (fine, scale) = (&fine[whole.before..][..whole.cells], &scale[whole.before..][..whole.cells]);
    for (number, (fine, scale)) in fine.chunks(BLOCKS * F).zip(scale.chunks(BLOCKS * F)).enumerate() {
        let (fine, scale) = (fine.as_chunks::<F>().0, scale.as_chunks::<F>().0);
        let block = block + number * BLOCKS;
        share_blocks(&mut even[block - 1..][..fine.len() + 2], 0, fine, scale);
        share_blocks(&mut odd[block - 1..][..fine.len() + 2], 1, fine, scale);
    }
}

/// Whole blocks whose shares are found before any is added: a vector that takes up again what another has just stored would wait for it.
const BLOCKS: usize = 128;

/// The shares of the even or the odd cells of at most [`BLOCKS`] whole blocks; the row starts with the block before.
#[inline(always)]
fn share_blocks<const F: usize>(row: &mut [f32], parity: usize, fine: &[[f32; F]], scale: &[[f32; F]]) {
    // For the blocks before, their own and the next ones: the shares of place i of the row, zero where there are none.
    let [mut before, mut own, mut after] = [[0.0; BLOCKS + 2]; 3];
    let shares = before.iter_mut().zip(&mut own[1..]).zip(&mut after[2..]);
    for (((before, own), after), (fine, scale)) in shares.zip(fine.iter().zip(scale)) {
        for within in (parity..F).step_by(2) {
            let outer = outer_weight::<F>(within);
            let value = scale[within] * fine[within];
            *own += (1.0 - outer) * value;
            *(if within < F / 2 { &mut *before } else { &mut *after }) += outer * value;
        }
    }
    for (row, ((before, own), after)) in row.iter_mut().zip(before.iter().zip(&own).zip(&after)) {
        *row += before + own + after;
    }
}

/// The transpose of [`between`].
#[inline(always)]
fn share<const F: usize>(within: usize, value: f32, even: &mut [f32], odd: &mut [f32]) {
    let row = if within.is_multiple_of(2) { even } else { odd };
    let outer = outer_weight::<F>(within);
    row[1] += (1.0 - outer) * value;
    row[if within < F / 2 { 0 } else { 2 }] += outer * value;
}

/// What the entries of the blocks' matrix are summed from.
///
/// The sums stand block by block, and for each pattern: the row sums, the diagonal (with the first pattern only), and the pull towards the neighbour at each offset of the
/// coarser lattice.
#[derive(Clone, Copy)]
struct Sources<'a> {
    fine: &'a Lattice,
    matrix: &'a StencilMatrix<f64>,
    patterns: &'a [u8],
    factor: i32,
    coarse: &'a Lattice,
    /// Sums of a block for one pattern.
    stride: usize,
}

impl Sources<'_> {
    /// Sums of a block.
    fn per_block(&self) -> usize {
        self.patterns.len() * self.stride
    }

    /// Adds the row sums for these patterns, all that there are, and the diagonal of a run's cells to their blocks; `sums` starts at the coarse
    /// site `start`. Returns the bound of Gershgorin over these rows.
    fn sum_rows<const P: usize>(&self, patterns: [u8; P], number: usize, start: usize, sums: &mut [f64]) -> f64 {
        let mut rows = [[0.0; STRIP]; P];
        let Run { place: [x, y, z], len, site, .. } = self.fine.runs()[number];
        let [first, line_y, line_z] = [x, y, z].map(|place| place.div_euclid(self.factor));
        let own = self.coarse.site([first, line_y, line_z]).unwrap_or(start) - start;
        let (end, mut from, mut bound) = (x + len as i32, x, 0.0_f64);
        while from < end {
            let block = from.div_euclid(self.factor);
            let to = end.min(block * self.factor + STRIP as i32);
            let sites = site + (from - x) as usize..site + (to - x) as usize;
            let of_strip = &mut sums[(own + (block - first) as usize) * self.per_block()..];
            let within = (from - block * self.factor) as usize;
            bound = bound.max(parallel::vectorized(
                #[inline(always)]
                || self.matrix.sum_rows(self.fine, number, sites.clone(), patterns, &mut rows),
            ));
            for (pattern, rows) in rows.iter().enumerate() {
                self.add_blocks(within, &rows[..sites.len()], &mut of_strip[pattern * self.stride..]);
            }
            self.add_blocks(within, &self.matrix.diagonal()[sites], &mut of_strip[1..]);
            from = to;
        }
        bound
    }

    /// Adds the values of cells to the first of the sums of their blocks; the first cell has the number `within` in its block.
    #[inline(always)]
    fn add_blocks(&self, within: usize, values: &[f64], sums: &mut [f64]) {
        let per_block = self.per_block();
        let add = |number: usize, sum: f64| sums[number * per_block] += sum;
        match self.factor {
            4 => visit_blocks::<4>(within, values, 0..4, add),
            _ => visit_blocks::<2>(within, values, 0..2, add),
        }
    }

    /// Adds the entries between the cells of a run and those in other blocks.
    fn sum_edges(&self, number: usize, start: usize, sums: &mut [f64]) {
        let Run { place: [x, y, z], len, site, .. } = self.fine.runs()[number];
        let [first, line_y, line_z] = [x, y, z].map(|place| place.div_euclid(self.factor));
        // The margin of the coarser lattice holds all lines beside the run's.
        let line = |to_y: i32, to_z: i32| self.coarse.site([first, line_y + to_y, line_z + to_z]).unwrap_or(start);
        let own = line(0, 0) - start;
        for (entries, offset) in self.fine.offsets().iter().enumerate() {
            let [dx, dy, dz] = offset.to;
            let entries = &self.matrix.upper(entries)[site..][..len];
            let weight = f64::from(offset.distance()) / f64::from(self.factor);
            let to_y = (y + dy).div_euclid(self.factor) - line_y;
            let to_z = (z + dz).div_euclid(self.factor) - line_z;
            // Cells whose neighbour lies in a block further along x, and the others; those may be neighbours within the block.
            let to_others = (to_y, to_z) != (0, 0);
            if dx == 0 && !to_others {
                continue;
            }
            let below = if (to_z, to_y) < (0, 0) { line(to_y, to_z) - start } else { own };
            // A pair of blocks is kept by the lower of them: along x alone, or across, the neighbour may be that one.
            let place = |to_x: i32| {
                let number = to_x + 3 * to_y + 9 * to_z;
                let (to_x, edge) = if number > 0 { (0, number) } else { (to_x as isize, -number) };
                (below.wrapping_add_signed(to_x), 2 + (edge as usize).saturating_sub(1))
            };
            let signs: [f64; 4] = std::array::from_fn(|number| {
                let flips = self.patterns.get(number).is_some_and(|&pattern| offset.flips(pattern));
                if flips { weight } else { -weight }
            });
            let (across, within) = self.split(dx);
            self.add_edges(x, entries, across, place(dx.signum()), signs, sums);
            if to_others {
                self.add_edges(x, entries, within, place(0), signs, sums);
            }
        }
    }

    /// The cells of a block, by their numbers in it, whose neighbours `dx` cells on lie in the next block, and the others.
    fn split(&self, dx: i32) -> (Range<usize>, Range<usize>) {
        let (factor, reach) = (self.factor as usize, dx.unsigned_abs() as usize);
        if dx > 0 {
            let edge = factor.saturating_sub(reach);
            (edge..factor, 0..edge)
        } else {
            let edge = reach.min(factor);
            (0..edge, edge..factor)
        }
    }

    /// Adds the entries at `part` of every block, of a run from `x` on, to the edges from `(block, edge)` on, with a sign for each pattern.
    fn add_edges(
        &self,
        x: i32,
        entries: &[f64],
        part: Range<usize>,
        (block, edge): (usize, usize),
        signs: [f64; 4],
        sums: &mut [f64],
    ) {
        if part.is_empty() {
            return;
        }
        let (per_block, stride, signs) = (self.per_block(), self.stride, &signs[..self.patterns.len()]);
        let sums = &mut sums[block * per_block + edge..];
        let add = |number: usize, sum: f64| {
            for (pattern, sign) in signs.iter().enumerate() {
                sums[number * per_block + pattern * stride] += sign * sum;
            }
        };
        let within = x.rem_euclid(self.factor) as usize;
        match self.factor {
            4 => visit_blocks::<4>(within, entries, part, add),
            _ => visit_blocks::<2>(within, entries, part, add),
        }
    }
}

/// Calls `add(number, sum)` for each block with the sum of the values of its cells at `part`; the first cell has the number `within` in its block.
#[inline(always)]
fn visit_blocks<const F: usize>(within: usize, values: &[f64], part: Range<usize>, mut add: impl FnMut(usize, f64)) {
    let (before, values) = values.split_at(((F - within) % F).min(values.len()));
    let (blocks, after) = values.as_chunks::<F>();
    let first = usize::from(!before.is_empty());
    let sum_of_some = |values: &[f64], from: usize| -> f64 {
        let [start, end] = [part.start, part.end].map(|number| number.saturating_sub(from).min(values.len()));
        values[start..end].iter().sum()
    };
    if !before.is_empty() {
        add(0, sum_of_some(before, within));
    }
    for (number, block) in blocks.iter().enumerate() {
        add(first + number, block[part.clone()].iter().sum());
    }
    if !after.is_empty() {
        add(first + blocks.len(), sum_of_some(after, 0));
    }
}

/// Shares pushes across the corners of blocks, which a matrix with no positive entries beside its diagonal cannot hold, among the pulls along the axes.
///
/// Such pushes come with γΔt < k/g. The corners of a square push alike where the ground is uniform: a field that rises evenly then costs the same as before.
///
/// ```text
/// w Σ (± g_x ± g_y)² = Σ_axes 2 w g²
/// ```
fn straighten(coarse: &Lattice, sums: &mut [f64], per_block: usize, place: usize) {
    let pull = |site: usize, edge: usize| site * per_block + place + 2 + edge;
    for (run, cells) in coarse.runs().iter().enumerate() {
        for (corner, offset) in coarse.offsets().iter().enumerate() {
            let sides = Sides::of(coarse, run, offset.to);
            if sides.count == 0 {
                continue;
            }
            for site in cells.site..cells.site + cells.len {
                let push = sums[pull(site, corner)];
                if push >= 0.0 {
                    continue;
                }
                sums[pull(site, corner)] = 0.0;
                for &(shift, side) in sides.each() {
                    sums[pull(site.wrapping_add_signed(shift), side)] += sides.share * push;
                }
            }
        }
    }
}

/// The edges along the axes of the square or box of blocks between a block and one across its corner.
struct Sides {
    /// How far away (sites) the lower block of each is, and the number of its offset.
    edges: [(isize, usize); 12],
    count: usize,
    /// One over the number of parallel ones.
    share: f64,
}

impl Sides {
    fn of(lattice: &Lattice, run: usize, corner: Place) -> Self {
        let mut sides = Sides { edges: [(0, 0); 12], count: 0, share: 0.5 };
        let axes = corner.iter().filter(|&&step| step != 0).count();
        if axes < 2 {
            return sides;
        }
        sides.share = 1.0 / (1 << (axes - 1)) as f64;
        for axis in (0..3).filter(|&axis| corner[axis] != 0) {
            let along: Place = std::array::from_fn(|other| i32::from(other == axis));
            let Some(number) = lattice.offset_to(along) else { continue };
            for others in 0..8_u8 {
                let takes_part = |other: usize| others >> other & 1 == 1;
                if (0..3).any(|other| takes_part(other) && (other == axis || corner[other] == 0)) {
                    continue;
                }
                let lower: Place = std::array::from_fn(|other| match other == axis {
                    true => corner[axis].min(0),
                    false => i32::from(takes_part(other)) * corner[other],
                });
                sides.edges[sides.count] = (lattice.shift_to(run, lower), number);
                sides.count += 1;
            }
        }
        sides
    }

    fn each(&self) -> &[(isize, usize)] {
        &self.edges[..self.count]
    }
}

/// The matrix from the sums of the blocks, of which there are `per_block` each; those for its pattern start with number `place`.
fn fill_coarse(coarse: &Lattice, sums: &[f64], per_block: usize, place: usize, blocks: &mut StencilMatrix<f64>) {
    let (diagonal, upper) = blocks.entries_mut();
    let pull = |site: usize, edge: usize| sums[site * per_block + place + 2 + edge].max(0.0);
    for (number, run) in coarse.runs().iter().enumerate() {
        for site in run.site..run.site + run.len {
            let of_block = &sums[site * per_block + place..];
            // Something must remain where there is next to no water, and round-off or a short step leave nothing.
            let mut sum = of_block[0].max(1e-6 * sums[site * per_block + 1]);
            for (edge, offset) in coarse.offsets().iter().enumerate() {
                let [_, below] = coarse.shift(number, offset);
                upper[edge][site] = -pull(site, edge);
                sum += pull(site, edge) + pull(site.wrapping_add_signed(below), edge);
            }
            diagonal[site] = sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// vᵀ P u = uᵀ Pᵀ v on lines longer than the shares that are found at a time, which start and end within blocks. Weights are eighths, values small
    /// whole numbers: every sum is exact.
    #[test]
    fn restriction_is_the_transpose_of_prolongation() {
        for (factor, from, len) in [(4, 0, 1536), (4, 3, 1101), (4, -2, 7), (2, 1, 700), (2, 0, 512)] {
            let mut lattice = Lattice::default();
            lattice.rebuild(1, 1, (from..from + len).map(|x| [x, 0, 0]));
            let (mut passage, mut coarse) = (Passage::default(), Lattice::default());
            passage.rebuild(1, factor, 1, &lattice, &mut coarse);
            let by_site = |lattice: &Lattice, modulus: usize| {
                let by_cell: Vec<f32> = (0..lattice.num_cells()).map(|cell| (cell * cell % modulus) as f32).collect();
                let mut values = vec![0.0; lattice.num_sites()];
                lattice.spread(&by_cell, &mut values);
                values
            };
            let (cells, blocks) = (by_site(&lattice, 7), by_site(&coarse, 5));
            let ones = vec![1.0; lattice.num_sites()];
            let (mut prolonged, mut margins_filled) = (vec![0.0; lattice.num_sites()], blocks.clone());
            passage.prolong(lattice.runs(), &[0], &mut [&mut margins_filled], &ones, &mut prolonged);
            let mut restricted = vec![0.0; coarse.num_sites()];
            passage.restrict(lattice.runs(), &[0], &cells, &ones, &mut [&mut restricted]);
            let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
            assert_eq!(dot(&cells, &prolonged), dot(&blocks, &restricted), "{factor}, {from}, {len}");
            assert!(dot(&cells, &prolonged) > 0.0);
        }
    }

    /// 8×8 blocks of 4×4 cells, each cell pulled by its neighbours with 1 and pushed by those across its corners with b/2: 112 pairs of blocks along the axes
    /// with four pulls and six pushes between them, 98 across corners with one push; distances count by a quarter of a block.
    #[test]
    fn pushes_across_corners_weaken_the_pulls_along_the_axes() {
        let mut lattice = Lattice::default();
        lattice.rebuild(2, 1, (0..32).flat_map(|y| (0..32).map(move |x| [x, y, 0])));
        for push in [0.0, 0.4, 0.8] {
            let mut matrix = StencilMatrix::default();
            matrix.resize(&lattice);
            let (diagonal, upper) = matrix.entries_mut();
            for (entries, offset) in upper.iter_mut().zip(lattice.offsets()) {
                let corner = offset.to[0] * offset.to[1] != 0;
                for site in lattice.runs().iter().flat_map(|run| run.site..run.site + run.len) {
                    diagonal[site] = 3.0;
                    entries[site] = if corner { 0.5 * push } else { -1.0 };
                }
            }
            // No cells beyond the edges.
            for run in lattice.runs() {
                for (entries, offset) in upper.iter_mut().zip(lattice.offsets()) {
                    let [dx, dy, _] = offset.to;
                    if run.place[1] + dy > 31 {
                        entries[run.site..run.site + run.len].fill(0.0);
                    }
                    match dx {
                        1 => entries[run.site + run.len - 1] = 0.0,
                        -1 => entries[run.site] = 0.0,
                        _ => {}
                    }
                }
            }
            let (mut passage, mut coarse, mut blocks) =
                (Passage::default(), Lattice::default(), StencilMatrix::default());
            passage.rebuild(2, 4, 1, &lattice, &mut coarse);
            blocks.resize(&coarse);
            passage.coarsen(&lattice, &matrix, &[0], &coarse, std::iter::once(&mut blocks));
            let upper: f64 = (0..4).map(|offset| blocks.upper(offset).iter().sum::<f64>()).sum();
            let expected = 112.0 * (1.0 - 0.75 * push) - 2.0 * 98.0 * push / 8.0;
            // Some hundred roundings.
            assert!((upper + expected).abs() < 1e-12 * 112.0, "{push}: {upper} {expected}");
            // 2 · 31 · 32 pulls and 2 · 31² pushes, each in two rows.
            let own = 3.0 * 1024.0 - 2.0 * 1984.0 + push * 1922.0;
            let wave = 2.0 * (1.0 - std::f64::consts::FRAC_1_SQRT_2);
            let least = (own + wave * 8.0 * expected) / (3.0 * 1024.0);
            assert!((passage.least_eigenvalue(&coarse) - least).abs() < 1e-12, "{push}");
        }
    }
}
