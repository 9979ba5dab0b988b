//! Python package: a wheel with the program in it, tried in a bare environment, installed and tested.

pub mod python_tools;
mod trial;

use std::fs;
use std::path::{Path, PathBuf};

use crate::checkout;
use crate::contents;
use crate::member;
use crate::step::{self, Readiness, Surroundings};

/// Folder of its crate, relative to the root.
const PACKAGE: &str = "./python";

/// Folder of its wheel, relative to the root.
const WHEELS: &str = "target/wheels";

/// Maximum size of a wheel, in bytes.
const MOST_BYTES: u64 = 35_000_000;

/// Prefix of the versions of symbols of the GNU C library 2, whose minor version follows.
const GLIBC: &[u8] = b"GLIBC_2.";

/// Checks for a Python to build and test the package with.
pub fn readiness(here: &Surroundings) -> Readiness {
    let Some(python) = &here.python else {
        return Readiness::Missing("no Python with the packages of xtask/python-requirements.txt".to_owned());
    };
    for module in ["maturin", "pytest"] {
        let mut command = here.command(python, &["-m", module, "--version"]);
        if !command.output().is_ok_and(|output| output.status.success()) {
            return Readiness::Missing(format!(
                "{} has no {module}: install xtask/python-requirements.txt",
                python.display()
            ));
        }
    }
    Readiness::Ready
}

/// Builds the wheel and tries it (1), installs it (2) and tests it (3).
pub fn check(here: &Surroundings) -> Result<(), String> {
    // 1.
    let wheel = built_and_tried(here)?.display().to_string();
    // 2.
    let python = python_of(here)?;
    let words =
        ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--force-reinstall"];
    step::succeed(here.command(python, &[&words[..], &[&wheel]].concat()))?;
    // 3. From the root: in its own folder, Python would import the sources instead of the package. In several processes: the
    // other checks beside this one end long before it.
    let words = ["-m", "pytest", "-c", "python/pyproject.toml", "python/tests", "--durations=10"];
    let mut tests =
        here.command(python, &[&words[..], &["--numprocesses=auto", "--maxprocesses=4"]].concat());
    tests.env(step::PROGRAM, here.program());
    step::succeed(tests)
}

/// Returns an environment with a Python that can build the wheel.
///
/// # Errors
/// As [`python_tools::prepare_build`].
pub fn build_surroundings(root: PathBuf) -> Result<Surroundings, String> {
    let python = Some(python_tools::prepare_build(&root)?);
    Ok(Surroundings { root, data: None, python, all_required: true, is_long: false })
}

/// Builds the wheel and tries it; returns true.
///
/// # Errors
/// As [`built_and_tried`].
pub fn run() -> Result<bool, String> {
    let (root, _) = member::read_workspace()?;
    built_and_tried(&build_surroundings(root)?)?;
    Ok(true)
}

/// Builds the wheel, checks its size, and tries it in a bare environment; returns its path.
///
/// # Errors
/// If it does not build, is too large, or anything of it fails there.
pub fn built_and_tried(here: &Surroundings) -> Result<PathBuf, String> {
    let wheel = built(here)?;
    let bytes = fs::metadata(&wheel).map_err(|fault| format!("{}: {fault}", wheel.display()))?.len();
    println!("{}: {:.1} MB", wheel.display(), bytes as f64 / 1e6);
    weighed(bytes)?;
    trial::run(here, python_of(here)?, &wheel)?;
    Ok(wheel)
}

fn python_of(here: &Surroundings) -> Result<&Path, String> {
    here.python.as_deref().ok_or_else(|| "no Python".to_owned())
}

/// Builds program and module (1), and packs them into a wheel (2) whose tag names the C library that they need.
fn built(here: &Surroundings) -> Result<PathBuf, String> {
    let python = python_of(here)?;
    let wheels = here.root.join(WHEELS);
    // Otherwise a wheel of another version could be installed instead.
    if wheels.is_dir() {
        fs::remove_dir_all(&wheels).map_err(|fault| format!("{}: {fault}", wheels.display()))?;
    }
    // 1.
    let words = ["build", "--release", "--quiet", "--package", "cranny-cli", "--package", "cranny-python"];
    step::succeed(here.cargo(&words))?;
    // 2.
    let bill = here.root.join("target").join(contents::BILL);
    contents::write_bill(&here.root, &bill)?;
    let settings =
        format!("build-args=--auditwheel check --sbom-include '{}' {}", bill.display(), tag(here)?);
    let words = ["-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-deps"];
    let options = ["--no-build-isolation", "--wheel-dir", WHEELS, "--config-settings", &settings, PACKAGE];
    let mut build = here.command(python, &[&words[..], &options].concat());
    // The backend calls the maturin of the same environment.
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders = python.parent().map(Path::to_owned).into_iter().chain(std::env::split_paths(&folders));
    build.env("PATH", std::env::join_paths(folders).map_err(|fault| fault.to_string())?);
    build.env("SOURCE_DATE_EPOCH", checkout::commit_time(&here.root)?);
    step::succeed(build)?;
    wheel_in(&wheels)
}

/// Returns the option of maturin for the oldest GNU C library on which program and module run; none on other systems.
fn tag(here: &Surroundings) -> Result<String, String> {
    let program = here.program();
    let module = program.with_file_name("lib_cranny.so");
    if std::env::consts::OS != "linux" {
        return Ok(String::new());
    }
    let mut newest = None;
    for file in [program, module] {
        let bytes = fs::read(&file).map_err(|fault| format!("{}: {fault}", file.display()))?;
        newest = newest.max(newest_glibc(&bytes));
    }
    Ok(newest.map_or_else(String::new, |minor| format!("--compatibility manylinux_2_{minor}")))
}

/// Returns the greatest minor version of glibc among the symbol versions that a program contains.
fn newest_glibc(program: &[u8]) -> Option<u32> {
    let beginnings = program.windows(GLIBC.len()).enumerate().filter(|(_, bytes)| *bytes == GLIBC);
    let minor = |(at, _): (usize, &[u8])| {
        let digits = program[at + GLIBC.len()..].iter().take_while(|byte| byte.is_ascii_digit());
        String::from_utf8(digits.copied().collect()).ok()?.parse().ok()
    };
    beginnings.filter_map(minor).max()
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
    fn the_newest_c_library_is_found_by_number() {
        assert_eq!(
            newest_glibc(b"\0GLIBC_2.2.5\0GLIBC_2.35\0GLIBC_2.9\0GLIBC_2.\0GLIBC_PRIVATE\0"),
            Some(35)
        );
        assert_eq!(newest_glibc(b"\0GCC_3.0\0GLIBC_2"), None);
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
