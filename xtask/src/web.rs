//! The viewer's page: its types, its unit tests, its build, and the page with the program in a real browser.

use std::path::PathBuf;

use crate::gltf;
use crate::step::{self, Readiness, Surroundings};

/// Names the browser of the tests.
const CHROMIUM: &str = "CRANNY_CHROMIUM";

/// Where systems have it.
const PLACES: [&str; 4] =
    ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome", "/snap/bin/chromium"];

/// Names the program of the tests.
const PROGRAM: &str = "CRANNY_BIN";

/// Whether Node is here with the packages of `web/`, and a Chromium.
pub fn readiness(here: &Surroundings) -> Readiness {
    match (gltf::readiness(here), chromium()) {
        (Readiness::Ready, None) => {
            Readiness::Missing(format!("no Chromium: install one, or name it in {CHROMIUM}"))
        }
        (ready_or_not, _) => ready_or_not,
    }
}

/// Builds the program, with the page in it, and runs both in a browser, after the page's types and unit tests.
///
/// # Errors
/// If any of these fails.
pub fn check(here: &Surroundings) -> Result<(), String> {
    step::succeed(here.cargo(&["build", "--release", "-p", "cranny-cli"]))?;
    let mut test = here.command("npm", &["test"]);
    test.current_dir(here.root.join("web"));
    test.env(PROGRAM, program(here));
    if let Some(chromium) = chromium() {
        test.env(CHROMIUM, chromium);
    }
    step::succeed(test)
}

fn chromium() -> Option<PathBuf> {
    let named = std::env::var_os(CHROMIUM).map(PathBuf::from);
    let known = PLACES.iter().map(PathBuf::from).find(|place| place.is_file());
    named.filter(|file| file.is_file()).or(known)
}

/// Where cargo puts the program.
fn program(here: &Surroundings) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| here.root.join("target"), PathBuf::from);
    here.root.join(target).join("release").join(format!("cranny{}", std::env::consts::EXE_SUFFIX))
}
