//! Long checks under adverse conditions: interrupted commands, planners that sabotage, and damaged input for every reader.

use crate::step::{self, Readiness, Surroundings};

/// Checks for a Python.
pub fn interruption_readiness(here: &Surroundings) -> Readiness {
    if here.command("python3", &["--version"]).output().is_ok() {
        Readiness::Ready
    } else {
        Readiness::Missing("no `python3`".to_owned())
    }
}

/// Checks for a Python and for the namespaces of the sandbox.
pub fn sabotage_readiness(here: &Surroundings) -> Readiness {
    let words = ["--user", "--map-root-user", "--mount", "--pid", "--net", "--fork", "true"];
    match here.command("unshare", &words).output() {
        Ok(output) if output.status.success() => interruption_readiness(here),
        _ => Readiness::Missing("no user namespaces, or no `unshare` of util-linux".to_owned()),
    }
}

/// Runs a campaign of `reach` beside planners that attack it.
///
/// # Errors
/// If an outcome of `reach` or, by a test at 1 %, its times differ from those of a campaign of its own.
pub fn sabotage(here: &Surroundings) -> Result<(), String> {
    let program = here.built_program()?.display().to_string();
    step::succeed(here.command("python3", &["benchmarks/sabotage.py", &program, "4"]))
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
