//! Calibrations: parameters of a law from measured element tests.
//!
//! ```no_run
//! use tsutsumi_case::Registry;
//! use tsutsumi_case::calibration::{Calibration, CalibrationOptions, calibrate};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let registry = Registry::built_in();
//! let calibration = Calibration::read("element-tests/calibration/calibration.toml", &registry)?;
//! let summary = calibrate(&calibration, &registry, &CalibrationOptions::default(), &|| false)?;
//! println!("{}", summary.table());
//! # Ok(())
//! # }
//! ```
//!
//! | module | what is in it |
//! |---|---|
//! | `schema`, `plan` | the file, its checks, the data |
//! | `range` | a parameter within its bounds, as the search sees it |
//! | `misfit` | how far element tests are from the data |
//! | `search` | the parameters with the least misfit |
//! | `output` | a calibration from its file to its folder |

mod misfit;
mod output;
mod plan;
mod range;
pub(crate) mod schema;
mod search;

pub use misfit::CurveReport;
pub use output::{CalibrationError, CalibrationOptions, CalibrationSummary, FittedParameter, calibrate};
pub use plan::Calibration;
pub use schema::*;

/// The JSON Schema of calibrations.
pub fn schema() -> serde_json::Value {
    crate::json_schema::calibration_schema()
}

#[cfg(test)]
mod tests;
