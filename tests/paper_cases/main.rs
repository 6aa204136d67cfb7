//! The cases of the paper, run from their files, against exact solutions.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test reports by panicking")]

mod poroelastic_column;
mod study;
