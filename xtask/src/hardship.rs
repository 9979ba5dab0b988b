//! Long checks under adverse conditions: interrupted commands, and damaged input for every reader.

use crate::step::{self, Readiness, Surroundings};

/// Checks for a Python.
pub fn interruption_readiness(here: &Surroundings) -> Readiness {
    if here.command("python3", &["--version"]).output().is_ok() {
        Readiness::Ready
    } else {
        Readiness::Missing("no `python3`".to_owned())
    }
}

/// Interrupts each command that runs longer than a second at two random moments, by Ctrl-C and by `kill -9`.
///
/// # Errors
/// If a repetition fails or a hidden file stays.
pub fn interrupt(here: &Surroundings) -> Result<(), String> {
    let program = here.built_program()?.display().to_string();
    step::succeed(here.command("python3", &["benchmarks/interrupt.py", &program, "2"]))
}

/// Checks for cargo-fuzz, which builds the fuzz targets.
pub fn fuzzing_readiness(here: &Surroundings) -> Readiness {
    if here.cargo_answers(&["fuzz", "--version"]) {
        Readiness::Ready
    } else {
        Readiness::Missing("no cargo-fuzz: `cargo install cargo-fuzz`".to_owned())
    }
}

/// Feeds each reader with damaged input for a minute.
///
/// # Errors
/// If a reader crashes, or takes too long or too much memory.
pub fn fuzz(here: &Surroundings) -> Result<(), String> {
    step::succeed(here.command("fuzz/run", &["60"]))
}
