use super::Increment;
use crate::tensor::{Sym3, Vector};

/// Particles whose histories stand together: few enough for the cache, many enough to hide a virtual call.
pub(crate) const BLOCK: usize = 64;

/// Particles that are handled side by side, in the lanes of vectors; a block is a multiple of it.
pub(crate) const LANES: usize = 8;

/// A tensor for each particle of a block, component by component: xx, yy, zz, xy, yz, zx.
pub(super) type TensorBlock = [[f64; BLOCK]; 6];

/// The motions of the particles of a block in a step, component by component. Beyond its last particle stands anything.
#[derive(Debug, Clone)]
pub struct IncrementBlock {
    /// The strain increments (–).
    pub(crate) strain: TensorBlock,
    /// The axial vectors of the spin increments (rad).
    pub(crate) spin: [[f64; BLOCK]; 3],
    /// How long they take (s).
    pub(crate) duration: f64,
    /// True when nothing leaves the plane: strains yz and zx and the spins about x and y are zero.
    pub(super) in_plane: bool,
}

impl IncrementBlock {
    /// No motion within this time (s), with room for motions in space of this dimension.
    pub(crate) fn within(duration: f64, dimension: usize) -> Self {
        IncrementBlock { strain: [[0.0; BLOCK]; 6], spin: [[0.0; BLOCK]; 3], duration, in_plane: dimension < 3 }
    }

    /// The motion of particle number `p` of the block.
    #[inline(always)]
    pub fn at(&self, p: usize) -> Increment {
        let spin = Vector::<3>::new(self.spin[0][p], self.spin[1][p], self.spin[2][p]);
        Increment { strain: tensor::<6>(&self.strain, p), spin, duration: self.duration }
    }
}

/// Room for the stresses of a block on their way through a law.
#[derive(Debug, Clone)]
pub struct StressBlock {
    /// Those at the start of the step (Pa), turned with the material.
    pub(super) old: TensorBlock,
    /// Those at its end (Pa).
    pub(super) new: TensorBlock,
    /// Their work (J).
    pub(super) work: [f64; BLOCK],
}

impl StressBlock {
    /// Room for any block.
    pub fn new() -> Self {
        StressBlock { old: [[0.0; BLOCK]; 6], new: [[0.0; BLOCK]; 6], work: [0.0; BLOCK] }
    }
}

impl Default for StressBlock {
    fn default() -> Self {
        StressBlock::new()
    }
}

/// The tensor number `p` of a block whose first `C` components can be other than zero: all six, or the four of plane strain.
#[inline(always)]
pub(super) fn tensor<const C: usize>(components: &TensorBlock, p: usize) -> Sym3 {
    let [xx, yy, zz, xy, yz, zx] = components;
    let (yz, zx) = if C > 4 { (yz[p], zx[p]) } else { (0.0, 0.0) };
    Sym3 { xx: xx[p], yy: yy[p], zz: zz[p], xy: xy[p], yz, zx }
}

/// Puts the first `C` components of a tensor in place number `p` of a block.
#[inline(always)]
pub(super) fn set_tensor<const C: usize>(components: &mut TensorBlock, p: usize, tensor: Sym3) {
    let Sym3 { xx, yy, zz, xy, yz, zx } = tensor;
    for (component, value) in components.iter_mut().zip([xx, yy, zz, xy, yz, zx]).take(C) {
        component[p] = value;
    }
}
