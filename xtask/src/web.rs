//! Tests of the viewer's page: its types, its unit tests, its build, and the page with the program in a real browser.

pub mod films;
pub mod gltf;

use std::path::PathBuf;

use crate::step::{self, Readiness, Surroundings};

/// Environment variable that names the browser of the tests.
const CHROMIUM: &str = "CRANNY_CHROMIUM";

/// Usual paths of the browser.
const PLACES: [&str; 4] =
    ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome", "/snap/bin/chromium"];

/// Checks for Node with the packages of `web/`, and a Chromium; installs a missing Chromium if this needs no confirmation.
pub fn readiness(here: &Surroundings) -> Readiness {
    let ready_or_not = gltf::readiness(here);
    if ready_or_not != Readiness::Ready || chromium().is_some() {
        return ready_or_not;
    }
    match here.install(&["chromium"]) {
        Ok(()) if chromium().is_some() => Readiness::Ready,
        Ok(()) => Readiness::Missing("no Chromium, though apt-get says that it has installed one".to_owned()),
        Err(reason) => {
            Readiness::Missing(format!("no Chromium: install one, or name it in {CHROMIUM} ({reason})"))
        }
    }
}

/// Builds the program, with the page in it, and runs both in a browser, after the page's types and unit tests.
///
/// # Errors
/// If any of these fails.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let program = here.built_program()?;
    let mut test = here.command("npm", &["test"]);
    test.current_dir(here.root.join("web"));
    test.env(step::PROGRAM, program);
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
