//! The command `tsutsumi` with the built-in laws, and those in shared libraries.

use std::process::ExitCode;

use tsutsumi_case::Registry;
use tsutsumi_umat::Umat;

fn main() -> ExitCode {
    tsutsumi_cli::main_with(&Registry::built_in().law::<Umat>("umat"))
}
