//! Python package: built as a wheel, installed and tested.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::step::{self, Readiness, Surroundings};

/// Folder of its crate, relative to the root.
const PACKAGE: &str = "python";

/// Folder of its wheel, relative to the root.
const WHEELS: &str = "target/wheels";

/// Maximum size of a wheel, in bytes.
const MOST_BYTES: u64 = 15_000_000;

/// Checks for a Python to build and test the package with.
pub fn readiness(here: &Surroundings) -> Readiness {
    let Some(python) = &here.python else {
        return Readiness::Missing("no Python with the packages of xtask/python-requirements.txt".to_owned());
    };
    for module in ["maturin", "pytest"] {
        let answers = |command: &mut Command| command.output().is_ok_and(|output| output.status.success());
        if !answers(&mut here.command(python, &["-m", module, "--version"])) {
            return Readiness::Missing(format!(
                "{} has no {module}: install xtask/python-requirements.txt",
                python.display()
            ));
        }
    }
    Readiness::Ready
}

/// Builds the wheel into the shared `target` (1), checks its size (2), installs it (3) and tests it (4).
pub fn check(here: &Surroundings) -> Result<(), String> {
    let Some(python) = &here.python else { return Err("no Python".to_owned()) };
    let wheels = here.root.join(WHEELS);
    // Otherwise a wheel of another version could be installed instead.
    if wheels.is_dir() {
        fs::remove_dir_all(&wheels).map_err(|fault| format!("{}: {fault}", wheels.display()))?;
    }
    // 1.
    let manifest = format!("{PACKAGE}/Cargo.toml");
    let words = ["-m", "maturin", "build", "--release", "--quiet", "-m", &manifest, "--out", WHEELS];
    step::succeed(here.command(python, &words))?;
    // 2.
    let wheel = wheel_in(&wheels)?;
    let bytes = fs::metadata(&wheel).map_err(|fault| format!("{}: {fault}", wheel.display()))?.len();
    println!("{}: {:.1} MB", wheel.display(), bytes as f64 / 1e6);
    weighed(bytes)?;
    // 3.
    let wheel = wheel.to_string_lossy().into_owned();
    let words =
        ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--force-reinstall"];
    step::succeed(here.command(python, &[&words[..], &[&wheel]].concat()))?;
    // 4. From the root: in its own folder, Python would import the sources instead of the package.
    let mut tests = here.command(python, &["-m", "pytest", "-c", "python/pyproject.toml", "python/tests"]);
    tests.env(step::PROGRAM, here.program());
    step::succeed(tests)
}

fn wheel_in(folder: &Path) -> Result<PathBuf, String> {
    let entries = fs::read_dir(folder).map_err(|fault| format!("{}: {fault}", folder.display()))?;
    let is_wheel = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "whl");
    let mut wheels = entries.filter_map(Result::ok).map(|entry| entry.path()).filter(is_wheel);
    wheels.next().ok_or_else(|| format!("{}: maturin left no wheel", folder.display()))
}

fn weighed(bytes: u64) -> Result<(), String> {
    if bytes <= MOST_BYTES {
        return Ok(());
    }
    let (megabytes, most) = (bytes as f64 / 1e6, MOST_BYTES as f64 / 1e6);
    Err(format!("the wheel weighs {megabytes:.1} MB, more than {most:.0} MB"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_that_is_too_heavy_fails() {
        assert_eq!(weighed(MOST_BYTES), Ok(()));
        assert!(weighed(MOST_BYTES + 1).is_err());
    }

    #[test]
    fn only_a_wheel_is_one() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("cranny.tar.gz"), "x").expect("written");
        assert!(wheel_in(folder.path()).is_err());
        fs::write(folder.path().join("cranny.whl"), "x").expect("written");
        assert_eq!(wheel_in(folder.path()), Ok(folder.path().join("cranny.whl")));
    }

    #[test]
    fn without_a_python_the_step_is_missing_something() {
        let here =
            Surroundings { root: ".".into(), data: None, python: None, all_required: false, is_long: false };
        assert!(matches!(readiness(&here), Readiness::Missing(_)));
        let here = Surroundings { python: Some("no such program".into()), ..here };
        assert!(matches!(readiness(&here), Readiness::Missing(reason) if reason.contains("maturin")));
    }
}
