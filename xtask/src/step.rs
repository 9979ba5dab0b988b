//! Checks of a test run, each with its name, requirements and action.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::python_package::python_tools::PYTHON;
use crate::released_data::{DATA, REQUIRE_ALL};

/// Environment of a run.
#[derive(Debug, Clone)]
pub struct Surroundings {
    /// Root of the checkout; checks run there.
    pub root: PathBuf,
    /// Absolute path of the released data, if available.
    pub data: Option<PathBuf>,
    /// Python for the tests, if available.
    pub python: Option<PathBuf>,
    /// True if a check that lacks its tool fails instead of being skipped.
    pub all_required: bool,
    /// True if tests that have a longer form run in it.
    pub is_long: bool,
}

/// Environment variable that selects the longer form of tests.
const LONG: &str = "CRANNY_LONG";

/// Environment variable with the path of the program for tests.
pub const PROGRAM: &str = "CRANNY_BIN";

impl Surroundings {
    /// Returns the path of the program that the tests build.
    pub fn program(&self) -> PathBuf {
        let target =
            std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| self.root.join("target"), PathBuf::from);
        self.root.join(target).join("release").join(format!("cranny{}", std::env::consts::EXE_SUFFIX))
    }

    /// Returns the path of the up-to-date program, built as by the tests, with all crates and their test dependencies, so that
    /// no dependency is rebuilt with other features.
    ///
    /// # Errors
    /// If it cannot be built.
    pub fn built_program(&self) -> Result<PathBuf, String> {
        succeed(self.cargo(&["build", "--release", "--quiet", "--workspace", "--bins", "--tests"]))?;
        Ok(self.program())
    }

    /// Returns a cargo command at the root, with data folder and Python in its environment.
    pub fn cargo(&self, words: &[&str]) -> Command {
        // Uses the cargo that runs this program, so that nested runs use the same toolchain.
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
        self.command(cargo, words)
    }

    /// Returns a command at the root, with data folder and Python in its environment.
    pub fn command(&self, program: impl Into<OsString>, words: &[&str]) -> Command {
        let mut command = Command::new(program.into());
        command
            .args(words)
            .current_dir(&self.root)
            .env_remove(DATA)
            .env_remove(PYTHON)
            .env_remove(REQUIRE_ALL)
            .env_remove(LONG);
        if self.is_long {
            command.env(LONG, "1");
        }
        if let Some(data) = &self.data {
            command.env(DATA, data);
        }
        if let Some(python) = &self.python {
            command.env(PYTHON, python);
        }
        if self.all_required {
            command.env(REQUIRE_ALL, "1");
        }
        command
    }

    /// Installs packages of Debian as root, for machines that only run tests; others install them themselves.
    ///
    /// # Errors
    /// If the user is not root, or apt-get fails.
    pub fn install(&self, packages: &[&str]) -> Result<(), String> {
        let user = self.command("id", &["-u"]).output();
        if !user.is_ok_and(|user| user.stdout.trim_ascii() == b"0") {
            return Err("only root can install it here".to_owned());
        }
        println!("==> {} by apt-get", packages.join(", "));
        succeed(self.command("apt-get", &["-qq", "update"]))?;
        let words = [&["-qq", "install", "--yes", "--no-install-recommends"], packages].concat();
        let mut command = self.command("apt-get", &words);
        command.env("DEBIAN_FRONTEND", "noninteractive");
        succeed(command)
    }

    /// Returns true if `cargo <words>` succeeds; its output is discarded.
    pub fn cargo_answers(&self, words: &[&str]) -> bool {
        self.cargo(words).output().is_ok_and(|output| output.status.success())
    }
}

/// Availability of the tools of a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Readiness {
    /// All tools are available.
    Ready,
    /// A tool is missing; the text names it and explains its installation.
    Missing(String),
}

/// Check of a run.
#[derive(Clone, Copy)]
pub struct Step {
    /// Name: a noun or two.
    pub name: &'static str,
    /// Checks the availability of its tools.
    pub needs: fn(&Surroundings) -> Readiness,
    /// Runs the check; the error describes the failure.
    pub action: fn(&Surroundings) -> Result<(), String>,
}

/// Check that could not run, with the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// Name of the check.
    pub name: &'static str,
    /// Description of the missing tool.
    pub missing: String,
}

/// Results of a run of checks.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Record {
    /// Checks that passed, in order.
    pub passed: Vec<&'static str>,
    /// Checks that were skipped.
    pub skipped: Vec<Skipped>,
    /// Check that failed; none ran after it.
    pub failed: Option<&'static str>,
}

/// Runs `steps` in order and stops at the first that fails, printing name and time of each.
pub fn run_all(steps: &[Step], surroundings: &Surroundings) -> Record {
    let mut record = Record::default();
    for step in steps {
        let outcome = match (step.needs)(surroundings) {
            Readiness::Missing(missing) if !surroundings.all_required => {
                eprintln!("SKIPPED: {} ({missing})", step.name);
                record.skipped.push(Skipped { name: step.name, missing });
                continue;
            }
            Readiness::Missing(missing) => Err(missing),
            Readiness::Ready => {
                println!("==> {}", step.name);
                let start = Instant::now();
                let outcome = (step.action)(surroundings);
                println!("<== {}: {:.1} s", step.name, start.elapsed().as_secs_f64());
                outcome
            }
        };
        match outcome {
            Ok(()) => record.passed.push(step.name),
            Err(reason) => {
                eprintln!("FAILED: {} ({reason})", step.name);
                record.failed = Some(step.name);
                break;
            }
        }
    }
    record
}

/// Runs `command` with its output shown.
///
/// # Errors
/// If it does not start or does not succeed.
pub fn succeed(mut command: Command) -> Result<(), String> {
    let program = Path::new(command.get_program()).file_name().unwrap_or(command.get_program());
    let words: Vec<_> =
        std::iter::once(program).chain(command.get_args()).map(|word| word.to_string_lossy()).collect();
    let line = words.join(" ");
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{line}`: {status}")),
        Err(error) => Err(format!("`{line}` does not start: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PASSES: Step = Step { name: "passes", needs: |_| Readiness::Ready, action: |_| Ok(()) };
    const FAILS: Step =
        Step { name: "fails", needs: |_| Readiness::Ready, action: |_| Err("as it should".to_owned()) };
    const LACKS: Step = Step {
        name: "lacks",
        needs: |_| Readiness::Missing("its tool".to_owned()),
        action: |_| unreachable!("a step without its tool must not run"),
    };

    fn surroundings(all_required: bool) -> Surroundings {
        Surroundings { root: PathBuf::from("."), data: None, python: None, all_required, is_long: false }
    }

    #[test]
    fn the_first_failure_ends_the_run() {
        let record = run_all(&[PASSES, FAILS, PASSES], &surroundings(false));
        assert_eq!(record.passed, ["passes"]);
        assert_eq!(record.failed, Some("fails"));
    }

    #[test]
    fn a_step_without_its_tool_is_skipped() {
        let record = run_all(&[LACKS, PASSES], &surroundings(false));
        assert_eq!(record.passed, ["passes"]);
        assert_eq!(record.skipped, [Skipped { name: "lacks", missing: "its tool".to_owned() }]);
        assert_eq!(record.failed, None);
    }

    #[test]
    fn a_step_without_its_tool_fails_where_all_is_required() {
        let record = run_all(&[LACKS, PASSES], &surroundings(true));
        assert_eq!(record, Record { failed: Some("lacks"), ..Record::default() });
    }

    #[test]
    fn commands_see_the_data_folder_only_if_there_is_one() {
        let value_of = |surroundings: &Surroundings, name: &str| {
            let command = surroundings.cargo(&["--version"]);
            let found = command.get_envs().find(|(key, _)| *key == name);
            found.and_then(|(_, value)| value.map(OsString::from))
        };
        let with = Surroundings { data: Some("data".into()), ..surroundings(true) };
        assert_eq!(value_of(&with, "CRANNY_DATA"), Some("data".into()));
        assert_eq!(value_of(&with, "CRANNY_REQUIRE_ALL"), Some("1".into()));
        assert_eq!(value_of(&surroundings(false), "CRANNY_DATA"), None);
        assert_eq!(value_of(&surroundings(false), "CRANNY_REQUIRE_ALL"), None);
    }
}
