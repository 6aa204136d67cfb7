//! Checks and small bodies for everybody's tests: those of the library and those of a law written elsewhere.
//!
//! | module | what is in it |
//! |---|---|
//! | [`body`] | a box of soil on its grid, made in a few lines: [`Body`](body::Body) |
//! | [`reading`] | what is read off a body: surface particles, surface height, cell pressures |
//! | [`compare`] | [`assert_close`](compare::assert_close), the observed order of convergence |
//! | [`law`] | [`check_law`]: what every constitutive law must satisfy |
//! | [`shape`] | [`check_shape`]: what every shape function must satisfy |
//! | [`soils`] | soils with the parameters of their laws, and where they are from |
//! | [`snapshot`] | [`Numbers`](snapshot::Numbers): snapshots of curves, compared with a tolerance |
//! | [`noise`] | numbers without a pattern, the same in every run |
//!
//! A testkit reports by panicking: a body that cannot be built is a mistake in the test.

pub mod body;
pub mod compare;
pub mod law;
pub mod noise;
pub mod reading;
pub mod shape;
pub mod snapshot;
pub mod soils;

pub use law::check_law;
pub use shape::check_shape;
