//! Tests of the computing crates with overflow checks and debug assertions, which the release profile omits.

use crate::step::{self, Readiness, Surroundings};

/// Crates in which a wrong index or count could go unnoticed.
const ROOMS: [&str; 9] = [
    "cranny-spatial",
    "cranny-shape",
    "cranny-robot",
    "cranny-grasp",
    "cranny-collision",
    "cranny-sense",
    "cranny-task",
    "cranny-path",
    "cranny-plan",
];

/// Returns ready: no additional tools are needed.
pub fn readiness(_: &Surroundings) -> Readiness {
    Readiness::Ready
}

/// Builds and runs these tests in a target folder of their own.
///
/// # Errors
/// If one fails.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let mut words = vec!["test", "--release", "--lib", "--tests"];
    for room in ROOMS {
        words.extend(["-p", room]);
    }
    let mut command = here.cargo(&words);
    command
        .env("CARGO_TARGET_DIR", here.root.join("target/checked"))
        .env("CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS", "true")
        .env("CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS", "true");
    step::succeed(command)
}
