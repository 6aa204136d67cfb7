//! What simulations of saturated ground are held against: exact solutions, with equation, validity, source and units.
//!
//! | module | problem |
//! |---|---|
//! | [`consolidation`] | one-dimensional consolidation of a layer under a load that is put on at once or as a ramp |
//!
//! and what they are made of: [`ground`], the parameters of a saturated elastic ground, and [`laplace`], numerical
//! inversion of the Laplace transform.

pub mod consolidation;
pub mod ground;
pub mod laplace;
