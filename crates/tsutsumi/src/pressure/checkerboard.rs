//! Softer water against the checkerboard, the pattern of pressures that the volume change of cells does not see.

use super::StepView;
use crate::grid::Side;

/// The signs of the four cells of a block in the checkerboard.
const SIGNS: [f64; 4] = [1.0, -1.0, -1.0, 1.0];

/// What the stabilisation adds to the continuity equations of every 2×2 block of cells, in each plane of the axes.
///
/// # Equation
///
/// ```text
/// S t_c (t·Δp_w)     t = (+1, −1, −1, +1)     Δp_w = p_w − p_w|t     S = θ · mean of C over the four cells
/// ```
///
/// It is the compressibility of water that would be softer for twists t·Δp: a pressure wave with the phases φ_x and φ_y from cell to
/// cell sees C (1 + 16 θ sin²(φ_x/2) sin²(φ_y/2)) for C. Pressures that vary along one axis only, and linear ones, have no twist.
/// It acts on increments, so flow that has become steady keeps its pressures. The matrix stays symmetric, gains no entry, and
/// what is added is positive semidefinite.
///
/// # Reference
///
/// Ours. The scale, that of the undrained ground and not of the skeleton, keeps undrained waves right: book, "Noise of the pressure".
#[derive(Debug, Clone, Default)]
pub(super) struct Checkerboard {
    /// θ (–).
    softening: f64,
    /// The slots of the blocks.
    blocks: Vec<[u32; 4]>,
    /// S of every block (m³/s per Pa).
    storage: Vec<f64>,
}

impl Checkerboard {
    /// The stabilisation with θ = `softening`; 0 leaves everything as it is.
    pub(super) fn new(softening: f64) -> Self {
        Checkerboard { softening, ..Checkerboard::default() }
    }

    /// True when nothing is added.
    pub(super) fn is_off(&self) -> bool {
        self.softening == 0.0
    }

    /// Finds the blocks of four active cells.
    pub(super) fn rebuild<const D: usize>(&mut self, at: &StepView<D>) {
        self.blocks.clear();
        if self.is_off() {
            return;
        }
        let above = |cell: usize, axis: usize| at.grid.neighbor(cell, Side { axis, upper: true });
        let slot = |cell: Option<usize>| cell.and_then(|cell| at.active.slot(cell)).map(|slot| slot as u32);
        for (first, &cell) in at.active.cells().iter().enumerate() {
            for (a, b) in (0..D).flat_map(|a| (a + 1..D).map(move |b| (a, b))) {
                let (along_a, along_b) = (above(cell as usize, a), above(cell as usize, b));
                let opposite = along_a.and_then(|cell| above(cell, b));
                if let (Some(second), Some(third), Some(fourth)) = (slot(along_a), slot(along_b), slot(opposite)) {
                    self.blocks.push([first as u32, second, third, fourth]);
                }
            }
        }
        // Capacity for the most there can be, so that later steps do not allocate.
        self.storage.reserve(self.blocks.len());
    }

    /// Takes the storage C of the cells (m³/s per Pa), by slot.
    pub(super) fn measure(&mut self, storage_of: impl Fn(usize) -> f64) {
        let sum = |block: &[u32; 4]| block.iter().map(|&slot| storage_of(slot as usize)).sum::<f64>();
        self.storage.clear();
        self.storage.extend(self.blocks.iter().map(|block| 0.25 * self.softening * sum(block)));
    }

    /// Adds S t tᵀ p to a product.
    pub(super) fn add_product(&self, p: &[f64], product: &mut [f64]) {
        for (block, storage) in self.blocks.iter().zip(&self.storage) {
            let twist: f64 = block.iter().zip(SIGNS).map(|(&slot, sign)| sign * p[slot as usize]).sum();
            for (&slot, sign) in block.iter().zip(SIGNS) {
                product[slot as usize] += sign * storage * twist;
            }
        }
    }

    /// Calls `add(slot, other slot, entry)` for every entry of S t tᵀ.
    pub(super) fn visit_entries(&self, mut add: impl FnMut(u32, u32, f64)) {
        for (block, storage) in self.blocks.iter().zip(&self.storage) {
            for (&a, sign_a) in block.iter().zip(SIGNS) {
                for (&b, sign_b) in block.iter().zip(SIGNS) {
                    add(a, b, sign_a * sign_b * storage);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three by three cells in a plane, numbered with x fastest.
    fn three_by_three() -> Checkerboard {
        let blocks = vec![[0, 1, 3, 4], [1, 2, 4, 5], [3, 4, 6, 7], [4, 5, 7, 8]];
        let mut checkerboard = Checkerboard { blocks, ..Checkerboard::new(0.5) };
        checkerboard.measure(|slot| 1.0 + slot as f64);
        checkerboard
    }

    #[test]
    fn pressures_without_a_twist_are_let_through() {
        // Any profile along x, any along y, in exact numbers.
        let pressure: Vec<f64> = (0..9).map(|cell| [3.0, -1.0, 8.0][cell % 3] + [2.0, 7.0, 0.0][cell / 3]).collect();
        let mut product = vec![0.0; 9];
        three_by_three().add_product(&pressure, &mut product);
        assert_eq!(product, [0.0; 9]);
    }

    /// Product and entries are the same matrix, and it is symmetric.
    #[test]
    fn product_and_entries_agree() {
        let checkerboard = three_by_three();
        let mut matrix = [[0.0; 9]; 9];
        checkerboard.visit_entries(|a, b, value| matrix[a as usize][b as usize] += value);
        for column in 0..9 {
            let mut unit = vec![0.0; 9];
            unit[column] = 1.0;
            let mut product = vec![0.0; 9];
            checkerboard.add_product(&unit, &mut product);
            for row in 0..9 {
                assert_eq!(product[row], matrix[row][column]);
                assert_eq!(matrix[column][row], matrix[row][column]);
            }
        }
        // The first block: θ = ½ times the mean of C = 1, 2, 4, 5.
        assert_eq!(matrix[0][0], 1.5);
    }
}
