//! What simulations of saturated ground are held against: exact solutions, with equation, validity, source and units.
//!
//! | module | problem |
//! |---|---|
//! | [`consolidation`] | one-dimensional consolidation of a layer under a load that is put on at once or as a ramp |
//! | [`mandel`] | a slab squeezed between rigid plates (plane strain): pressure rises before it falls |
//! | [`cryer`] | a sphere under pressure, drained all around |
//! | [`de_leeuw`] | a long cylinder under radial pressure, drained all around |
//! | [`waves`] | steady harmonic loads and smooth load steps on a column with inertia, three models |
//!
//! and what they are made of: [`ground`], the parameters of a saturated elastic ground, and [`laplace`], numerical
//! inversion of the Laplace transform.

pub mod consolidation;
pub mod cryer;
pub mod de_leeuw;
mod drained_body;
pub mod ground;
pub mod laplace;
pub mod mandel;
pub mod waves;
