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

/// Returns the Python that `CRANNY_PYTHON` names, or one in an environment below `target`, recreated for new requirements.
///
/// # Errors
/// Name of the missing component: Python itself, its module `venv`, or a package.
pub fn prepare(root: &Path) -> Result<PathBuf, String> {
    if let Some(python) = std::env::var_os(PYTHON).filter(|python| !python.is_empty()) {
        return Ok(python.into());
    }
    let requirements = root.join(REQUIREMENTS);
    let wanted = fs::read_to_string(&requirements).map_err(|fault| format!("{REQUIREMENTS}: {fault}"))?;
    let environment = root.join("target").join("python-tests");
    let python = python_of(&environment);
    let installed = environment.join("installed-requirements.txt");
    if python.is_file() && fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    println!("==> Python packages of {REQUIREMENTS}");
    let system = if cfg!(windows) { "python" } else { "python3" };
    answer(Command::new(system).args(["-m", "venv", "--clear"]).arg(&environment))?;
    let words = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
    answer(Command::new(&python).args(words).arg(&requirements))?;
    fs::write(&installed, wanted).map_err(|fault| format!("{}: {fault}", installed.display()))?;
    Ok(python)
}

fn python_of(environment: &Path) -> PathBuf {
    if cfg!(windows) { environment.join("Scripts/python.exe") } else { environment.join("bin/python") }
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
        for file in
            [&python, &root.path().join(REQUIREMENTS), &environment.join("installed-requirements.txt")]
        {
            fs::write(file, "ompl==2.0.1\n").expect("written");
        }
        // An installation would fail here, because a placeholder file stands for Python.
        if std::env::var_os(PYTHON).is_none() {
            assert_eq!(prepare(root.path()), Ok(python));
        }
    }

    #[test]
    fn a_command_that_fails_is_named_with_its_last_words() {
        let message = answer(Command::new("no such program").arg("word")).expect_err("there is none");
        assert!(message.starts_with("`no such program word` does not start: "), "{message}");
    }
}
