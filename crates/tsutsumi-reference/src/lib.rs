//! What simulations of saturated ground are held against: exact solutions, with equation, validity, source and units, and
//! a finite element method.
//!
//! | module | problem |
//! |---|---|
//! | [`consolidation`] | one-dimensional consolidation of a layer under a load that is put on at once or as a ramp |
//! | [`self_weight`] | consolidation of a layer under its own weight |
//! | [`large_strain`] | consolidation of a layer that loses a large part of its thickness (Xie and Leo) |
//! | [`mandel`] | a slab squeezed between rigid plates (plane strain): pressure rises before it falls |
//! | [`de_leeuw`] | a long cylinder under radial pressure, drained all around |
//! | [`cryer`] | a sphere under pressure, drained all around |
//! | [`waves`] | steady harmonic loads and smooth load steps on a column with inertia, three models |
//! | [`telegraph`] | the damped wave in a saturated half-space under a load put on at once |
//! | [`elastic_column`] | an elastic column at rest under gravity and a load; a vibrating bar |
//! | [`heavy_column`] | an elastic column pressed together by its own weight, large strains |
//! | [`vortex`] | a ring that turns within a block at rest: a manufactured solution at large strains |
//! | [`sliding_block`] | a block on a slope with dry friction; safety of an infinite slope with seepage |
//! | [`bearing`] | bearing capacity of a strip footing (Prandtl, Reissner) |
//! | [`seepage`] | steady seepage through a dam with vertical faces (Dupuit, Charny) |
//! | [`dam_break`] | collapse of a column of water: Ritter's solution, measurements of Martin and Moyce |
//! | [`column_collapse`] | run-out and height of collapsed columns of grains: published scaling laws |
//! | [`finite_elements`] | any case: the u–p finite element method that the paper compares with |
//!
//! and what they are made of: [`ground`], the parameters of a saturated elastic ground, and [`laplace`], numerical
//! inversion of the Laplace transform.
//!
//! Parameters are plain structs that can be read from a file (`serde`) and describe themselves (`schemars`). Their
//! values are taken as they are: outside the range that a field's documentation gives, results mean nothing or are not
//! numbers.

pub mod bearing;
mod bessel;
#[cfg(test)]
mod closeness;
pub mod column_collapse;
pub mod consolidation;
pub mod cryer;
pub mod dam_break;
pub mod de_leeuw;
mod drained_body;
pub mod elastic_column;
pub mod finite_elements;
mod gauss_legendre;
pub mod ground;
pub mod heavy_column;
pub mod laplace;
pub mod large_strain;
pub mod mandel;
mod modes;
pub mod seepage;
pub mod self_weight;
pub mod sliding_block;
pub mod telegraph;
pub mod vortex;
pub mod waves;
