use super::Increment;
use crate::tensor::{Sym3, Vector};

/// Particles whose histories stand together: few enough for the cache, many enough to hide a virtual call.
pub(crate) const BLOCK: usize = 64;

/// Particles that are handled side by side, in the lanes of vectors; a block is a multiple of it.
pub(crate) const LANES: usize = 8;

/// One number for each of some particles.
pub(crate) type Lanes = [f64; LANES];

/// The motions of the particles of a block in a step, component by component. Beyond its last particle stands anything.
#[derive(Debug, Clone)]
pub struct IncrementBlock {
    /// Components xx, yy, zz, xy, yz, zx of the strain increments (–).
    pub(crate) strain: [[f64; BLOCK]; 6],
    /// The axial vectors of the spin increments (rad).
    pub(crate) spin: [[f64; BLOCK]; 3],
    /// How long they take (s).
    pub(crate) duration: f64,
}

impl IncrementBlock {
    /// No motion within this time (s).
    pub(crate) fn within(duration: f64) -> Self {
        IncrementBlock { strain: [[0.0; BLOCK]; 6], spin: [[0.0; BLOCK]; 3], duration }
    }

    /// The motion of particle number `p` of the block.
    #[inline(always)]
    pub fn at(&self, p: usize) -> Increment {
        let spin = Vector::<3>::new(self.spin[0][p], self.spin[1][p], self.spin[2][p]);
        Increment { strain: tensor(&self.strain, p), spin, duration: self.duration }
    }
}

/// The tensor number `p` of a list that stands component by component.
#[inline(always)]
pub(super) fn tensor(components: &[[f64; BLOCK]; 6], p: usize) -> Sym3 {
    let [xx, yy, zz, xy, yz, zx] = components;
    Sym3 { xx: xx[p], yy: yy[p], zz: zz[p], xy: xy[p], yz: yz[p], zx: zx[p] }
}

/// Puts a tensor in place number `p` of such a list.
#[inline(always)]
pub(super) fn set_tensor(components: &mut [[f64; BLOCK]; 6], p: usize, tensor: Sym3) {
    let Sym3 { xx, yy, zz, xy, yz, zx } = tensor;
    for (component, value) in components.iter_mut().zip([xx, yy, zz, xy, yz, zx]) {
        component[p] = value;
    }
}
