//! What simulations of saturated ground are held against: exact solutions, with equation, validity, source and units.
//!
//! | module | problem |
//! |---|---|
//! | [`consolidation`] | one-dimensional consolidation of a layer under a load that is put on at once or as a ramp |
//! | [`finite_elements`] | any case: the u–p finite element method that the paper compares with |

pub mod consolidation;
pub mod finite_elements;
