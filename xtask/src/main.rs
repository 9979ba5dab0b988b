//! Commands for contributors: `cargo xtask test`, `tidy`, `site`, `wheel` and `release`.
//!
//! Exit codes: 0 success, 1 a check failed, 2 not runnable (unknown word, no git, wrong `CRANNY_DATA`).

mod c_api;
mod checked_arithmetic;
mod checkout;
mod comment_words;
mod contents;
mod hardship;
mod latex;
mod member;
mod own_planner;
mod problem;
mod public_functions;
mod python_package;
mod release;
mod released_data;
mod site;
mod step;
mod test;
mod tidy;
mod web;

use std::path::PathBuf;
use std::process::ExitCode;

const HELP: &str = "\
Tasks of a Cranny contributor

Usage: cargo xtask <TASK>

Tasks:
  test           everything a change must pass: format, lints, tidy, tests, doc tests, glTF, films,
                 web (the viewer's page in a browser), C and C++, Python, pages
  test --long    the same, with the tests that have a longer form in it, the site, a report's LaTeX
                 compiled by pdflatex, a planner from a crate outside, checked arithmetic,
                 interrupted commands, and a minute of damaged input for each reader
  test --step STEP…
                 these steps alone, of both; a name that is none lists them
  capi --prefix DIR
                 the C and C++ API, built and installed below DIR: library, headers, files for CMake's
                 find_package(cranny) and pkg-config; the folder may be moved
  site           the pages of docs/ and benchmarks/, commands, gallery and API as one folder,
                 target/site/book; builds mdBook where it is not installed
  wheel          the wheel of the Python package, with the program in it, in target/wheels; tried in
                 a bare virtual environment, with the seconds of each step
  release        what a release consists of, in target/release-files: the wheel, an archive with
                 program, manual pages and completions, licences, bill of materials, changes, and
                 checksums (docs/releasing.md)
  release --allow-dirty
                 the same in a checkout with changes that are not committed
  tidy           the shape of the house: floors, crate table, module names, file length, unsafe,
                 machine paths, files of others, structs that drop unknown keys
  tidy --write   the same, after writing what is generated (the crate table of ARCHITECTURE.md, the
                 licences of what the programs are made of)
  help           this text

Environment:
  CRANNY_DATA          folder of the paper's released data (it holds `jogramop`); unset: the tests
                       that need it are skipped, and one line says so
  CRANNY_PYTHON        a Python with the packages of xtask/python-requirements.txt, into which the
                       package cranny is installed; unset: one is made under target/, or the tests
                       that need it are skipped, and one line says so
  CRANNY_CHROMIUM      the browser of the viewer's tests; unset: /usr/bin/chromium and the like,
                       which apt-get installs where root runs this
  CRANNY_WEB_DIST      a built page of the viewer, for `cargo build` to put into the program; unset:
                       web/dist, or npm builds one where Node is
  CRANNY_REQUIRE_ALL   1: whatever lacks its data or its tool fails instead of being skipped

Examples:
  cargo xtask test
  CRANNY_DATA=../shared/data cargo xtask test
  CRANNY_DATA=../shared/data CRANNY_REQUIRE_ALL=1 cargo xtask test
  cargo xtask tidy --write

Exit codes: 0 done, 1 a check failed, 2 not runnable as asked";

/// Parsed command line.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Task {
    Help,
    Tidy { generated: tidy::Generated },
    Test { is_long: bool },
    Steps { names: Vec<String> },
    Capi { prefix: PathBuf },
    Wheel,
    Release { uncommitted: release::Uncommitted },
}

/// Parses the words of the command line; the error describes invalid ones.
fn task_of(words: &[&str]) -> Result<Task, String> {
    match words {
        [] => Err("no task given".to_owned()),
        ["help" | "--help" | "-h", ..] => Ok(Task::Help),
        [_, rest @ ..] if rest.iter().any(|word| matches!(*word, "--help" | "-h")) => Ok(Task::Help),
        ["tidy"] => Ok(Task::Tidy { generated: tidy::Generated::Compare }),
        ["tidy", "--write"] => Ok(Task::Tidy { generated: tidy::Generated::Write }),
        ["test"] => Ok(Task::Test { is_long: false }),
        ["test", "--long"] => Ok(Task::Test { is_long: true }),
        ["test", "--step", names @ ..] if !names.is_empty() => {
            Ok(Task::Steps { names: names.iter().map(|name| (*name).to_owned()).collect() })
        }
        ["site"] => Ok(Task::Steps { names: vec!["site".to_owned()] }),
        ["capi", "--prefix", prefix] => Ok(Task::Capi { prefix: PathBuf::from(prefix) }),
        ["capi", ..] => Err("`capi` takes `--prefix DIR`, where it is installed".to_owned()),
        ["wheel"] => Ok(Task::Wheel),
        ["release"] => Ok(Task::Release { uncommitted: release::Uncommitted::Refuse }),
        ["release", "--allow-dirty"] => Ok(Task::Release { uncommitted: release::Uncommitted::Allow }),
        ["tidy" | "test" | "site" | "wheel" | "release", rest @ ..] => {
            Err(format!("`{}` does not take `{}`", words[0], rest.join(" ")))
        }
        [unknown, ..] => Err(format!("there is no task `{unknown}`")),
    }
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let outcome = match task_of(&words) {
        Ok(Task::Help) => {
            println!("{HELP}");
            Ok(true)
        }
        Ok(Task::Tidy { generated }) => tidy::run(generated),
        Ok(Task::Test { is_long }) => test::run(is_long),
        Ok(Task::Capi { prefix }) => {
            test::here(false).and_then(|here| c_api::install(&here, &prefix)).map(|()| true)
        }
        Ok(Task::Steps { names }) => test::run_steps(&names.iter().map(String::as_str).collect::<Vec<_>>()),
        Ok(Task::Wheel) => python_package::run(),
        Ok(Task::Release { uncommitted }) => release::run(uncommitted),
        Err(message) => Err(format!("{message}; `cargo xtask help` lists the tasks")),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::from(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_task_is_found_by_its_name() {
        assert_eq!(task_of(&["test"]), Ok(Task::Test { is_long: false }));
        assert_eq!(task_of(&["test", "--long"]), Ok(Task::Test { is_long: true }));
        assert_eq!(task_of(&["tidy"]), Ok(Task::Tidy { generated: tidy::Generated::Compare }));
        assert_eq!(task_of(&["tidy", "--write"]), Ok(Task::Tidy { generated: tidy::Generated::Write }));
        let site = Ok(Task::Steps { names: vec!["site".to_owned()] });
        assert_eq!((task_of(&["site"]), task_of(&["test", "--step", "site"])), (site.clone(), site));
        let prefix = PathBuf::from("/opt/cranny");
        assert_eq!(task_of(&["capi", "--prefix", "/opt/cranny"]), Ok(Task::Capi { prefix }));
        assert_eq!(task_of(&["wheel"]), Ok(Task::Wheel));
        let release = |uncommitted| Ok(Task::Release { uncommitted });
        assert_eq!(task_of(&["release"]), release(release::Uncommitted::Refuse));
        assert_eq!(task_of(&["release", "--allow-dirty"]), release(release::Uncommitted::Allow));
        assert_eq!(task_of(&["help"]), Ok(Task::Help));
        assert_eq!(task_of(&["tidy", "--help"]), Ok(Task::Help));
    }

    #[test]
    fn an_unknown_word_is_named_and_not_run() {
        for words in [&["tset"][..], &["test", "--fast"], &["tidy", "--wirte"], &["release", "--dirty"], &[]]
        {
            let message = task_of(words).expect_err("not a task");
            if let Some(word) = words.last() {
                assert!(message.contains(word), "{message}");
            }
        }
    }
}
