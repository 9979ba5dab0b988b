//! Checks of a test run, each with its name, requirements and action.

use std::cell::RefCell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use std::{fs, io};

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
    /// First check that failed; none began after it.
    pub failed: Option<&'static str>,
}

impl Record {
    /// Adds the result of a check and prints it if the check did not pass.
    fn add(&mut self, name: &'static str, outcome: Result<(), String>) {
        match outcome {
            Ok(()) => self.passed.push(name),
            Err(reason) => {
                eprintln!("FAILED: {name} ({reason})");
                self.failed.get_or_insert(name);
            }
        }
    }

    /// Returns true if a check can run. One that lacks its tool is recorded: as failed where all is required, else as skipped.
    fn admits(&mut self, step: &Step, surroundings: &Surroundings) -> bool {
        match (step.needs)(surroundings) {
            Readiness::Ready => return true,
            Readiness::Missing(missing) if surroundings.all_required => self.add(step.name, Err(missing)),
            Readiness::Missing(missing) => {
                eprintln!("SKIPPED: {} ({missing})", step.name);
                self.skipped.push(Skipped { name: step.name, missing });
            }
        }
        false
    }

    /// Runs `steps` in order and stops at the first that fails, printing name and time of each.
    pub fn run(&mut self, steps: &[Step], surroundings: &Surroundings) {
        for step in steps {
            if self.failed.is_none() && self.admits(step, surroundings) {
                println!("==> {}", step.name);
                let start = Instant::now();
                let outcome = (step.action)(surroundings);
                println!("<== {}: {:.1} s", step.name, start.elapsed().as_secs_f64());
                self.add(step.name, outcome);
            }
        }
    }

    /// Runs `steps` beside each other, each of which leaves processors idle. The output of each is printed when it has ended.
    pub fn run_beside(&mut self, steps: &[Step], surroundings: &Surroundings) {
        if self.failed.is_some() {
            return;
        }
        let ready: Vec<&Step> = steps.iter().filter(|step| self.admits(step, surroundings)).collect();
        if self.failed.is_some() {
            return;
        }
        println!(
            "==> {} beside each other",
            ready.iter().map(|step| step.name).collect::<Vec<_>>().join(", ")
        );
        let record = Mutex::new(self);
        std::thread::scope(|scope| {
            for step in ready {
                scope.spawn(|| {
                    let start = Instant::now();
                    let log = surroundings.root.join("target").join(format!("{}.log", step.name));
                    let outcome = logged(&log, || (step.action)(surroundings));
                    let mut record = record.lock().unwrap_or_else(PoisonError::into_inner);
                    println!("==> {}", step.name);
                    print!("{}", fs::read_to_string(&log).unwrap_or_default());
                    println!("<== {}: {:.1} s", step.name, start.elapsed().as_secs_f64());
                    record.add(step.name, outcome);
                });
            }
        });
    }
}

thread_local! {
    /// File for the output of the commands of this thread, if it is not to be shown at once.
    static LOG: RefCell<Option<fs::File>> = const { RefCell::new(None) };
}

/// Runs an action, with the output of its commands in a file.
fn logged(path: &Path, action: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    let file = fs::File::create(path).map_err(|fault| format!("{}: {fault}", path.display()))?;
    LOG.set(Some(file));
    action()
}

/// Runs `command` with its output shown, or in the log of its thread.
///
/// # Errors
/// If it does not start or does not succeed.
pub fn succeed(mut command: Command) -> Result<(), String> {
    let program = Path::new(command.get_program()).file_name().unwrap_or(command.get_program());
    let words: Vec<_> =
        std::iter::once(program).chain(command.get_args()).map(|word| word.to_string_lossy()).collect();
    let line = words.join(" ");
    let log = LOG.with_borrow(|log| log.as_ref().map(|file| Ok([file.try_clone()?, file.try_clone()?])));
    if let Some(copies) = log {
        let [out, err] = copies.map_err(|fault: io::Error| format!("its log: {fault}"))?;
        command.stdout(out).stderr(err);
    }
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

    fn run_all(steps: &[Step], surroundings: &Surroundings) -> Record {
        let mut record = Record::default();
        record.run(steps, surroundings);
        record
    }

    #[test]
    fn of_checks_beside_each_other_each_is_recorded_and_its_output_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("target")).expect("a folder");
        let here = Surroundings { root: folder.path().to_owned(), ..surroundings(false) };
        let speaks =
            Step { name: "speaks", action: |here| succeed(here.command("cargo", &["--version"])), ..PASSES };
        let mut record = Record::default();
        record.run_beside(&[FAILS, speaks, LACKS, PASSES], &here);
        record.passed.sort_unstable();
        assert_eq!((record.failed, &record.passed[..]), (Some("fails"), &["passes", "speaks"][..]));
        assert_eq!(record.skipped.len(), 1);
        let log = fs::read_to_string(folder.path().join("target/speaks.log")).expect("a log");
        assert!(log.starts_with("cargo "), "{log}");
        record.run_beside(&[PASSES], &here);
        assert_eq!(record.passed.len(), 2, "none begins after a failure");
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
