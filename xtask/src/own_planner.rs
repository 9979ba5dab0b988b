//! Planner of an external crate: builds `examples/own_planner`, and runs a campaign with its planner.

use crate::step::{self, Readiness, Surroundings};

/// Returns ready: no additional tools are needed.
pub fn readiness(_: &Surroundings) -> Readiness {
    Readiness::Ready
}

/// Builds the example in the target folder of the tests, with which it shares dependencies, and runs a small campaign.
///
/// # Errors
/// If it does not build, or not all trials are run and solved.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let manifest = here.root.join("examples/own_planner/Cargo.toml").display().to_string();
    let results = here.root.join("target/tmp/own_planner.db");
    // Left by an earlier run; it may not exist.
    let _ = std::fs::remove_file(&results);
    let results = results.display().to_string();
    let build = ["run", "--release", "--quiet", "--locked", "--manifest-path", &manifest, "--"];
    let campaign =
        ["bench", "run", "--scenarios", "021", "--planners", "two-trees,reach", "--runs", "3", "-o"];
    let words = [&build[..], &campaign, &[&results]].concat();
    let mut command = here.cargo(&words);
    command.env("CARGO_TARGET_DIR", here.root.join("target"));
    step::succeed(command)
}
