//! The command `tsutsumi` with the built-in laws.

use std::process::ExitCode;

use tsutsumi_case::Registry;

fn main() -> ExitCode {
    tsutsumi_cli::main_with(&Registry::built_in())
}
