//! A planner from a crate outside: `examples/own_planner` builds, and its planner takes part in a campaign.

use crate::step::{self, Readiness, Surroundings};

/// It needs nothing that the other steps do not.
pub fn readiness(_: &Surroundings) -> Readiness {
    Readiness::Ready
}

/// Builds it beside what the tests built, of which it shares the crates of others, and runs a small campaign.
///
/// # Errors
/// If it does not build, or not all trials are run and solved.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let manifest = here.root.join("examples/own_planner/Cargo.toml").display().to_string();
    let results = here.root.join("target/tmp/own_planner.db");
    // Of a run before; without one there is nothing to take away.
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
