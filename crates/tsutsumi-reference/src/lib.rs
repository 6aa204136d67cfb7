//! What simulations of saturated ground are held against: exact solutions, with equation, validity, source and units.
//!
//! | module | problem |
//! |---|---|
//! | [`consolidation`] | one-dimensional consolidation of a layer under a load that is put on at once or as a ramp |

mod bessel;
pub mod consolidation;
pub mod elastic_column;
mod gauss_legendre;
pub mod large_strain;
mod modes;
pub mod self_weight;
pub mod sliding_block;
pub mod telegraph;
