//! The command as its users meet it: exit codes, messages, results folders, Ctrl-C.
//!
//! How a case file is read has its tests in `tsutsumi-case`; here is what the program does about it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test reports by panicking")]

mod calibrate;
mod desk;
mod element_test;
mod endings;
mod folders;
mod information;
mod refusals;
mod runs;
mod study;
