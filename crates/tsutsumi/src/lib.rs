//! # Tsutsumi: the material point method for saturated ground
//!
//! The soil skeleton is carried by material points, its momentum balance is solved on a background grid, and the pore
//! pressure is solved by finite differences at the centres of the grid's cells, after
//! Goto, Morinaka, Oka, Higo and Kimoto, "Deformation analysis of a solid–liquid two-phase porous body by a coupled
//! MPM–FDM method" (in Japanese).
//!
//! Everything is generic over the dimension of space `D` = 1, 2 or 3. [`solver::Solver::step`] is the paper's algorithm,
//! line for line. Search this documentation for `Eq. (9)` to find an equation of the paper.
//!
//! Units are SI. Stress and strain are positive in tension, pore pressure is positive in compression.
//!
//! The modules are floors: each uses only those above it in this list.
//!
//! | module | what is in it |
//! |---|---|
//! | [`tensor`] | vectors and matrices of space, the symmetric 3-D tensor |
//! | [`grid`] | the background grid, its node and cell fields, the active part |
//! | [`shape`] | shape functions |
//! | [`particles`] | the material points |
//! | [`law`] | constitutive laws of the effective stress |
//! | [`element`] | element tests: one specimen under mixed control of stress and strain |
//! | [`transfer`] | sums from particles to nodes and back |
//! | [`velocity`] | velocity updates: MPM①, MPM②, FLIP, APIC, TPIC, XPIC, FMPM |
//! | [`damping`] | damping of the nodes' motion, for states of rest |
//! | [`pressure`] | pore pressure, coupled with the momentum balance |
//! | [`boundary`] | supports and loads |
//! | [`solver`] | one time step |

pub mod boundary;
pub mod damping;
pub mod element;
pub mod grid;
pub mod law;
pub mod particles;
pub mod pressure;
pub mod shape;
pub mod solver;
pub mod tensor;
pub mod transfer;
pub mod velocity;
