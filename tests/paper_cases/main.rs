//! The cases under `paper-cases/`, run from their files, against exact solutions.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test reports by panicking")]

mod claims;
mod cryer;
mod curves;
mod liquefaction;
mod mandel;
mod poroelastic_column;
mod pressure_noise;
mod study;
mod variants;
mod waves;
mod xie_leo;
