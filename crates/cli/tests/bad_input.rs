//! Bad input of every kind gives one clear error with its location, exit code 2, and leaves no files.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

const START: &str = "[0, 0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, 1.5412, 0.7534]";
const GRASP: &str = "1,0,0,0.5,0,-1,0,0,0,0,-1,0.4,0,0,0,1,0.5,0.05\n";

fn scenario(folder: &Path, yaml: &str, grasps: &str) {
    std::fs::write(folder.join("scenario.yaml"), yaml).expect("written");
    std::fs::write(folder.join("grasps.csv"), grasps).expect("written");
}

fn yaml(extra: &str) -> String {
    format!(
        "robot: panda_mobile\nstart: {START}\nfloor: -0.05\ntarget:\n  name: can\n  shapes:\n    \
         - cylinder: {{radius: 0.03, length: 0.1}}\n      pose: {{position: [0.5, 0, 0.3]}}\n{extra}"
    )
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command
        .current_dir(folder)
        .args(arguments)
        .args(["--time-limit", "2"].iter().filter(|_| arguments[0] == "plan"))
        .output()
        .expect("it runs")
}

/// Plans in `folder` and returns the error, which must contain every one of `words`.
fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let before = std::fs::read_dir(folder).expect("a folder").count();
    let output = run(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.stdout.is_empty());
    for word in words {
        assert!(error.contains(word), "no '{word}' in: {error}");
    }
    assert!(!error.contains("panicked"), "{error}");
    assert_eq!(std::fs::read_dir(folder).expect("a folder").count(), before, "something was written");
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn the_good_scenario_that_the_bad_ones_are_made_of_is_good() {
    let folder = folder();
    scenario(folder.path(), &yaml(""), GRASP);
    let output = run(folder.path(), &["plan", "."]);
    let code = output.status.code();
    assert!(code == Some(0) || code == Some(1), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_start_in_collision_is_an_outcome_not_an_error() {
    let folder = folder();
    let block = "obstacles:\n  - name: block\n    shapes:\n      - box: {size: [0.2, 0.2, 0.2]}\n        \
                 pose: {position: [0, 0, 0.1]}\n";
    scenario(folder.path(), &yaml(block), GRASP);
    let output = run(folder.path(), &["plan", "."]);
    let summary = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{summary}{}", String::from_utf8_lossy(&output.stderr));
    assert!(summary.contains("start-invalid") && summary.contains("touches block"), "{summary}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2, "nothing is written");
}

/// A name from a file could clear the screen, or forge output of the program.
#[test]
fn control_characters_of_names_are_made_visible() {
    let folder = folder();
    let two = "obstacles:\n  - {name: \"a\\e[2J\", shapes: [sphere: {radius: 1}]}\n  - {name: \"a\\e[2J\", shapes: [sphere: \
               {radius: 1}]}\n";
    scenario(folder.path(), &yaml(two), GRASP);
    refused(folder.path(), &["plan", "."], &["the name 'a\\u{1b}[2J' is taken"]);
    let one = "obstacles:\n  - {name: \"a\\e[2J\", shapes: [box: {size: [0.1, 0.1, 0.1]}]}\n";
    scenario(folder.path(), &yaml(one), GRASP);
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output = command.current_dir(folder.path()).args(["info", "."]).output().expect("it runs");
    let page = String::from_utf8_lossy(&output.stdout);
    assert!(page.contains("a\\u{1b}[2J") && !page.contains('\u{1b}'), "{page}");
}

/// A file beyond the limit of its kind is refused before it is read, and accepted with the flag that the message names.
#[test]
fn large_files_are_refused_unless_they_are_wanted() {
    let folder = folder();
    scenario(folder.path(), &yaml(""), GRASP);
    let large = format!("{}# {}\n", yaml(""), "a comment ".repeat(7_000_000));
    std::fs::write(folder.path().join("scenario.yaml"), large).expect("written");
    refused(folder.path(), &["info", "."], &["scenario.yaml", "64.0 MiB", "--large-files"]);
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output =
        command.current_dir(folder.path()).args(["info", ".", "--large-files"]).output().expect("it runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

/// An input file may be a pipe, which can be read only once.
#[cfg(unix)]
#[test]
fn a_plan_and_way_points_come_through_a_pipe() {
    let folder = folder();
    let cranny = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("cranny").expect("the program");
        command.current_dir(folder.path()).args(arguments).output().expect("it runs")
    };
    assert_eq!(cranny(&["plan", "021", "-o", "a.plan.json"]).status.code(), Some(0));
    let plan = std::fs::read_to_string(folder.path().join("a.plan.json")).expect("a plan");
    let pipe = folder.path().join("pipe.plan.json");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
    assert!(made.success());
    let writer = std::thread::spawn(move || std::fs::write(pipe, plan));
    let output = cranny(&["verify", "021", "pipe.plan.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    writer.join().expect("it ends").expect("written");
}

/// Some of these would exhaust the memory or overflow, or be parsed as an unknown flag `-1`.
#[test]
fn a_number_out_of_its_range_is_refused_with_the_range() {
    let folder = folder();
    let run = "bench run --scenarios 021 --planners reach";
    let sample = "grasps sample banana";
    let generate = "scenario generate --family gap";
    let cases = [
        (run, "--runs", "1 to 1000000", &["0", "100000000", "-1", "1e3", "99999999999999999999999"][..]),
        (run, "--memory-limit", "1 to 16777216", &["0", "17592186044416", "-5"]),
        (run, "--time-limit", "0 to 10000000", &["-1", "nan", "inf", "1e300"]),
        (run, "--iterations", "0 to 9223372036854775807", &["-1", "9223372036854775808"]),
        (run, "--first-seed", "0 to 9223372036854775807", &["-1", "18446744073709551615"]),
        (run, "--workers", "1 to 1024", &["0", "1000000000", "-1"]),
        (sample, "--count", "1 to 100000", &["0", "1000000000000", "-1", "1844674407370955162"]),
        (sample, "--candidates", "1 to 1000000", &["0", "1000000000000"]),
        (sample, "--approaches", "1 to 3600", &["0", "1000000000000"]),
        (sample, "--scale", "positive number", &["0", "-1", "nan", "inf"]),
        (sample, "--seed", "0 to 18446744073709551615", &["-1", "1.5"]),
        (generate, "--count", "1 to 1000000", &["0", "1000000000000", "-1"]),
        (generate, "--clutter", "0 to 50", &["51", "-1"]),
        ("scenario sweep gap --from 0.6 --to 0.5", "--steps", "1 to 100000", &["0", "4294967296"]),
        ("plan 021", "--time-limit", "0 to 10000000", &["-1", "nan", "inf", "1e20"]),
        ("plan 021", "--iterations", "0 to 9223372036854775807", &["-1"]),
        ("plan 021", "--rate", "samples per second", &["0", "-1", "nan", "inf"]),
        ("plan 021", "--seed", "0 to 18446744073709551615", &["-1", "18446744073709551616"]),
        ("ik 021", "--solutions", "1 to 1000", &["0", "1000000000000000000"]),
        ("ik 021", "--attempts", "1 to 1000000000", &["0", "-1"]),
        ("object add box.obj --mass 1", "--parts", "1 to 10000", &["0", "-1"]),
        ("object add box.obj --mass 1", "--resolution", "8 to 400", &["7", "401", "-8"]),
        ("bench replay results.db", "", "1 to 9223372036854775807", &["0", "18446744073709551615"]),
    ];
    for (command, flag, range, values) in cases {
        for value in values {
            let words = command.split(' ').chain((!flag.is_empty()).then_some(flag)).chain([*value]);
            let mut program = Command::cargo_bin("cranny").expect("the program");
            let output = program.current_dir(folder.path()).args(words).output().expect("it runs");
            let error = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{command} {flag} {value}: {error}");
            assert!(error.contains(range) && error.contains(value), "{command} {flag} {value}: {error}");
            let first = error.lines().next().unwrap_or_default();
            assert!(first.contains(range), "the range stands in another line: {error}");
            assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0, "{command} {flag}");
        }
    }
}
