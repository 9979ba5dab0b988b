//! Checks that every change must pass, the quickest to fail first.

use std::time::Instant;

use crate::c_api;
use crate::checked_arithmetic;
use crate::hardship;
use crate::latex;
use crate::member;
use crate::own_planner;
use crate::python_package::{self, python_tools};
use crate::released_data;
use crate::site;
use crate::step::{self, Readiness, Record, Step, Surroundings};
use crate::tidy;
use crate::web::{self, films, gltf};

/// Checks of every run. A check that needs a tool of its own declares it in `needs`.
const STEPS: [Step; 9] = [
    Step {
        name: "format",
        needs: |here| component(here, "fmt", "rustfmt"),
        action: |here| step::succeed(here.cargo(&["fmt", "--all", "--check"])),
    },
    Step {
        name: "lints",
        needs: |here| component(here, "clippy", "clippy"),
        action: |here| {
            let words = ["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"];
            step::succeed(here.cargo(&words))
        },
    },
    Step { name: "tidy", needs: |_| Readiness::Ready, action: |_| tidy_step() },
    Step {
        name: "pages",
        needs: |_| Readiness::Ready,
        action: |here| pages(here, &["--package", "cranny-collision"]),
    },
    Step { name: "tests", needs: |_| Readiness::Ready, action: tests },
    Step {
        name: "doc tests",
        needs: |_| Readiness::Ready,
        action: |here| step::succeed(here.cargo(&["test", "--release", "--doc", "--workspace"])),
    },
    // The checker of certificates is a workspace of its own, so that it depends on nothing.
    Step {
        name: "certificates",
        needs: |_| Readiness::Ready,
        action: |here| {
            let manifest = here.root.join("checker/Cargo.toml").display().to_string();
            let words = ["test", "--release", "--quiet", "--locked", "--manifest-path", &manifest];
            let mut command = here.cargo(&words);
            command.env("CARGO_TARGET_DIR", here.root.join("target/checker"));
            step::succeed(command)
        },
    },
    Step { name: "glTF", needs: gltf::readiness, action: gltf::check },
    Step { name: "films", needs: films::readiness, action: films::check },
];

/// Checks of every run that leave processors idle, and thus run beside each other.
const BESIDE: [Step; 3] = [
    Step { name: "web", needs: web::readiness, action: web::check },
    Step { name: "C and C++", needs: c_api::readiness, action: c_api::check },
    Step { name: "Python", needs: python_package::readiness, action: python_package::check },
];

/// Additional checks of a long run: those that rarely fail, or whose tools are rarely installed.
const LONG_STEPS: [Step; 8] = [
    Step { name: "all pages", needs: |_| Readiness::Ready, action: |here| pages(here, &["--workspace"]) },
    Step { name: "site", needs: site::readiness, action: site::check },
    Step { name: "LaTeX", needs: latex::readiness, action: latex::check },
    Step { name: "a planner from outside", needs: own_planner::readiness, action: own_planner::check },
    Step {
        name: "checked arithmetic",
        needs: checked_arithmetic::readiness,
        action: checked_arithmetic::check,
    },
    Step { name: "interruptions", needs: hardship::interruption_readiness, action: hardship::interrupt },
    Step { name: "sabotage", needs: hardship::sabotage_readiness, action: hardship::sabotage },
    Step { name: "fuzzing", needs: hardship::fuzzing_readiness, action: hardship::fuzz },
];

/// Runs the checks of these names, including those of a long run; returns true if they passed.
///
/// # Errors
/// For an unknown name, and as [`run`].
pub fn run_steps(names: &[&str]) -> Result<bool, String> {
    let all = [&STEPS[..], &BESIDE, &LONG_STEPS].concat();
    let find = |name: &&str| {
        let step = all.iter().find(|step| step.name == *name).copied();
        step.ok_or_else(|| {
            let known: Vec<&str> = all.iter().map(|step| step.name).collect();
            format!("there is no step `{name}` (there are: {})", listed(&known))
        })
    };
    let steps = names.iter().map(find).collect::<Result<Vec<_>, _>>()?;
    let here = here(true)?;
    let python = python_tools::prepare(&here.root).ok();
    let here = Surroundings { python, ..here };
    let mut record = Record::default();
    record.run(&steps, &here);
    Ok(record.failed.is_none())
}

/// Returns the environment of a command without Python.
///
/// # Errors
/// If there is no workspace here, or the named folder of the released data is not one.
pub fn here(all_required: bool) -> Result<Surroundings, String> {
    let (root, _) = member::read_workspace()?;
    Ok(Surroundings { root, data: released_data::folder()?, python: None, all_required, is_long: false })
}

/// Runs all checks and returns true if they passed.
///
/// # Errors
/// If the run cannot start: no workspace here, or the released data or Python are required but missing.
pub fn run(is_long: bool) -> Result<bool, String> {
    let start = Instant::now();
    let data = released_data::folder()?;
    let (root, _) = member::read_workspace()?;
    let all_required = released_data::all_required();
    let mut lacking = Vec::new();
    if data.is_none() {
        lacking.push(released_data::SKIPPED.to_owned());
    }
    let python = match python_tools::prepare(&root) {
        Ok(python) => Some(python),
        Err(reason) if all_required => return Err(format!("the Python of the tests: {reason}")),
        Err(reason) => {
            lacking.push(format!("{} ({reason})", python_tools::SKIPPED));
            None
        }
    };
    let here = Surroundings { root, data, python, all_required, is_long };

    // Printed before the checks, and again at the end of the output.
    warn(&lacking);
    let mut record = Record::default();
    record.run(&STEPS, &here);
    record.run_beside(&BESIDE, &here);
    if is_long {
        record.run(&LONG_STEPS, &here);
    }
    warn(&lacking);
    println!("{}", summary(&record, &here, start.elapsed().as_secs_f64()));
    Ok(record.failed.is_none())
}

fn warn(lines: &[String]) {
    for line in lines {
        eprintln!("{line}");
    }
}

/// Returns a summary in one line: passed, skipped and failed checks, and the time.
fn summary(record: &Record, here: &Surroundings, seconds: f64) -> String {
    let mut parts = vec![format!("passed: {}", listed(&record.passed))];
    let mut skipped: Vec<&str> = record.skipped.iter().map(|skipped| skipped.name).collect();
    if here.data.is_none() {
        skipped.push("tests on released data");
    }
    if here.python.is_none() {
        skipped.push("tests that run Python packages");
    }
    parts.push(format!("skipped: {}", listed(&skipped)));
    if let Some(failed) = record.failed {
        parts.push(format!("FAILED: {failed}"));
    }
    format!("xtask test: {} in {seconds:.1} s", parts.join("; "))
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn component(here: &Surroundings, command: &str, component: &str) -> Readiness {
    if here.cargo_answers(&[command, "--version"]) {
        Readiness::Ready
    } else {
        Readiness::Missing(format!("no `cargo {command}`: run `rustup component add {component}`"))
    }
}

fn tidy_step() -> Result<(), String> {
    if tidy::run(tidy::Generated::Compare)? { Ok(()) } else { Err("see above".to_owned()) }
}

fn tests(here: &Surroundings) -> Result<(), String> {
    // nextest runs each test in a process of its own and is faster; cargo's own runner runs the same tests.
    let words: &[&str] = if here.cargo_answers(&["nextest", "--version"]) {
        &["nextest", "run", "--release", "--workspace"]
    } else {
        &["test", "--release", "--workspace", "--lib", "--bins", "--tests"]
    };
    let mut command = here.cargo(words);
    if std::env::var_os(PROPTEST_SEED).is_none() {
        command.env(PROPTEST_SEED, "2024");
    }
    step::succeed(command)
}

/// Seed of property tests, so that a run can be repeated; set it to test other cases.
const PROPTEST_SEED: &str = "PROPTEST_RNG_SEED";

/// Builds the pages of the programming interface, of all crates only in a long run: that takes minutes.
fn pages(here: &Surroundings, packages: &[&str]) -> Result<(), String> {
    let mut command = here.cargo(&[&["doc", "--release", "--no-deps"], packages].concat());
    command.env("RUSTDOCFLAGS", "-D warnings");
    step::succeed(command)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::Skipped;

    #[test]
    fn the_summary_names_what_did_not_run() {
        let here =
            Surroundings { root: ".".into(), data: None, python: None, all_required: false, is_long: false };
        let record = Record {
            passed: vec!["format"],
            skipped: vec![Skipped { name: "lints", missing: "no clippy".to_owned() }],
            failed: Some("tidy"),
        };
        assert_eq!(
            summary(&record, &here, 1.25),
            "xtask test: passed: format; skipped: lints, tests on released data, tests that run Python packages; \
             FAILED: tidy in 1.2 s"
        );
    }

    #[test]
    fn a_full_run_skips_nothing() {
        let here = Surroundings {
            root: ".".into(),
            data: Some("data".into()),
            python: Some("python3".into()),
            all_required: true,
            is_long: false,
        };
        let record = Record { passed: vec!["format", "tests"], ..Record::default() };
        assert_eq!(summary(&record, &here, 2.0), "xtask test: passed: format, tests; skipped: none in 2.0 s");
    }
}
