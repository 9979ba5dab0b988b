//! Checker of certificates: its own tests. It is a workspace of its own, so that it depends on nothing.

use crate::step::{self, Readiness, Surroundings};

/// Returns ready: no additional tools are needed.
pub fn readiness(_: &Surroundings) -> Readiness {
    Readiness::Ready
}

/// Runs the tests of `checker/`.
///
/// # Errors
/// If they fail.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let manifest = here.root.join("checker/Cargo.toml").display().to_string();
    let mut command = here.cargo(&["test", "--release", "--quiet", "--locked", "--manifest-path", &manifest]);
    command.env("CARGO_TARGET_DIR", here.root.join("target/checker"));
    step::succeed(command)
}
