//! Python with the packages that tests run, in a virtual environment of the checkout.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Environment variable that names the Python for the tests.
pub const PYTHON: &str = "CRANNY_PYTHON";
/// Message of a run without it; the reason follows.
pub const SKIPPED: &str = "SKIPPED: tests that run Python packages";

/// Requirements file, relative to the root of the checkout.
const REQUIREMENTS: &str = "xtask/python-requirements.txt";

/// Environment of the tests, relative to the root of the checkout.
const TESTS: &str = "target/python-tests";

/// File of an environment that holds its requirements.
const INSTALLED: &str = "installed-requirements.txt";

/// Returns the Python that `CRANNY_PYTHON` names, or one in an environment below `target`, recreated for new requirements.
///
/// # Errors
/// Name of the missing component: Python itself, its module `venv`, or a package.
pub fn prepare(root: &Path) -> Result<PathBuf, String> {
    environment(&root.join(TESTS), &requirements(root)?)
}

/// Returns a Python that can build the wheel: that of the tests if it is installed, or one with maturin alone.
///
/// # Errors
/// As [`prepare`].
pub fn prepare_build(root: &Path) -> Result<PathBuf, String> {
    let all = requirements(root)?;
    if is_installed(&root.join(TESTS), &all) {
        return prepare(root);
    }
    let maturin: String = all.lines().filter(|line| line.starts_with("maturin==")).collect();
    environment(&root.join("target/python-build"), &maturin)
}

fn requirements(root: &Path) -> Result<String, String> {
    fs::read_to_string(root.join(REQUIREMENTS)).map_err(|fault| format!("{REQUIREMENTS}: {fault}"))
}

/// Returns the Python of an environment with the wanted requirements, which is created anew if it has others.
fn environment(environment: &Path, wanted: &str) -> Result<PathBuf, String> {
    if let Some(python) = std::env::var_os(PYTHON).filter(|python| !python.is_empty()) {
        return Ok(python.into());
    }
    let python = python_of(environment);
    if is_installed(environment, wanted) {
        return Ok(python);
    }
    println!("==> Python packages of {REQUIREMENTS}");
    let system = if cfg!(windows) { "python" } else { "python3" };
    answer(Command::new(system).args(["-m", "venv", "--clear"]).arg(environment))?;
    let list = environment.join("requirements.txt");
    let fault = |fault: std::io::Error| format!("{}: {fault}", environment.display());
    fs::write(&list, wanted).map_err(fault)?;
    let words = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
    answer(Command::new(&python).args(words).arg(&list))?;
    // Its presence shows that the installation was completed.
    fs::rename(list, environment.join(INSTALLED)).map_err(fault)?;
    Ok(python)
}

fn is_installed(environment: &Path, wanted: &str) -> bool {
    let installed = fs::read_to_string(environment.join(INSTALLED));
    python_of(environment).is_file() && installed.is_ok_and(|text| text == wanted)
}

/// Returns the folder of the programs of an environment.
pub fn programs_of(environment: &Path) -> PathBuf {
    environment.join(if cfg!(windows) { "Scripts" } else { "bin" })
}

fn python_of(environment: &Path) -> PathBuf {
    programs_of(environment).join(format!("python{}", std::env::consts::EXE_SUFFIX))
}

/// Runs a command that must succeed; the error is the last line of its output.
fn answer(command: &mut Command) -> Result<(), String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let words: Vec<_> = command.get_args().map(|word| word.to_string_lossy().into_owned()).collect();
    let line = format!("`{program} {}`", words.join(" "));
    let output = command.output().map_err(|fault| format!("{line} does not start: {fault}"))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(format!("{line}: {}", said.trim().lines().last().unwrap_or("it says nothing")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_environment_of_the_wanted_requirements_is_taken_as_it_is() {
        let root = tempfile::tempdir().expect("a folder");
        let environment = root.path().join("target/python-tests");
        let python = python_of(&environment);
        fs::create_dir_all(python.parent().expect("a folder")).expect("made");
        fs::create_dir_all(root.path().join("xtask")).expect("made");
        for file in [&python, &root.path().join(REQUIREMENTS), &environment.join(INSTALLED)] {
            fs::write(file, "ompl==2.0.1\n").expect("written");
        }
        // An installation would fail here, because a placeholder file stands for Python.
        if std::env::var_os(PYTHON).is_none() {
            assert_eq!(prepare(root.path()), Ok(python.clone()));
            assert_eq!(prepare_build(root.path()), Ok(python));
        }
    }

    #[test]
    fn a_command_that_fails_is_named_with_its_last_words() {
        let message = answer(Command::new("no such program").arg("word")).expect_err("there is none");
        assert!(message.starts_with("`no such program word` does not start: "), "{message}");
    }
}
