//! The program `cranny`, with the built-in planners.

use std::process::ExitCode;

use cranny_plan::Registry;

fn main() -> ExitCode {
    cranny_cli::main(&Registry::default())
}
