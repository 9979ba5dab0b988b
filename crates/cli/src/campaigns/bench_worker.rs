use std::path::PathBuf;

use cranny_bench::{Sandbox, WorkerProgram};
use strum::VariantArray as _;

use crate::failure::Failure;

/// Parses the sandbox mode of external programs.
pub fn sandbox(text: &str) -> Result<Sandbox, String> {
    let known = || Sandbox::VARIANTS.iter().map(|sandbox| sandbox.name()).collect::<Vec<_>>().join(", ");
    text.parse().map_err(|_| format!("give one of {}", known()))
}

/// Returns this program as a worker.
pub fn worker() -> Result<WorkerProgram, Failure> {
    let program: PathBuf = std::env::current_exe()?;
    let limits = cranny_file::are_limits_lifted().then_some("--large-files");
    let arguments = ["bench", "worker"].into_iter().chain(limits).map(str::to_owned).collect();
    Ok(WorkerProgram { program, arguments })
}
