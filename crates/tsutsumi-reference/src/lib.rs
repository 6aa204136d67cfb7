//! What simulations of saturated ground are held against: exact solutions, with equation, validity, source and units.
//!
//! | module | problem |
//! |---|---|
//! | [`consolidation`] | one-dimensional consolidation of a layer under a load that is put on at once or as a ramp |

pub mod consolidation;
mod gauss_legendre;
pub mod large_strain;
mod modes;
pub mod self_weight;
