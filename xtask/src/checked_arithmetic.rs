//! The tests of the rooms that compute, with overflow checks and debug assertions, which the one profile leaves out.

use crate::step::{self, Readiness, Surroundings};

/// Rooms in which an index or a count could go wrong unseen.
const ROOMS: [&str; 8] = [
    "cranny-spatial",
    "cranny-shape",
    "cranny-robot",
    "cranny-grasp",
    "cranny-collision",
    "cranny-task",
    "cranny-path",
    "cranny-plan",
];

/// It needs nothing that the other steps do not.
pub fn readiness(_: &Surroundings) -> Readiness {
    Readiness::Ready
}

/// Builds and runs them in a folder of their own.
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
