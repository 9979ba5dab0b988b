//! `check` reports all faults at once.

use std::fs;
use std::path::Path;

use cranny_scenario::check;

/// Returns the faults of a copy of a sound scenario with these replacements in its file.
fn said(replacements: &[(&str, &str)]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/corner");
    for file in ["scenario.yaml", "grasps.csv", "wedge.obj"] {
        fs::copy(original.join(file), folder.path().join(file)).unwrap();
    }
    let path = folder.path().join("scenario.yaml");
    let mut text = fs::read_to_string(&path).unwrap();
    for (from, to) in replacements {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    fs::write(path, text).unwrap();
    check(folder.path().to_str().unwrap()).unwrap().iter().map(ToString::to_string).collect()
}

fn expect(replacements: &[(&str, &str)], faults: &[&str]) {
    let said = said(replacements);
    assert_eq!(said.len(), faults.len(), "{said:#?}");
    for (said, expected) in said.iter().zip(faults) {
        assert!(said.contains(expected), "{said}\n  not: {expected}");
    }
}

#[test]
fn a_sound_scenario_has_no_faults() {
    expect(&[], &[]);
}

#[test]
fn faults_of_meaning_are_all_named_with_their_lines() {
    expect(
        &[
            ("panda_joint7: 0.7534", "panda_joint7: .nan"),
            ("[1.0, 1.0, 0.4]", "[1.0, .inf, 0.4]"),
            ("radius: 0.05", "radius: -0.05"),
            ("name: pipe", "name: board"),
            ("mesh: {file: wedge.obj", "mesh: {file: cone.obj"),
        ],
        &[
            "scenario.yaml:5: 'NaN'",
            "scenario.yaml:9: 'inf'",
            "scenario.yaml:12: 'board': the radius",
            "scenario.yaml:14: the name 'board'",
            "scenario.yaml:22: 'wedge': ",
        ],
    );
}

#[test]
fn faults_of_form_hide_only_the_entry_that_they_are_in() {
    expect(
        &[
            ("radius: 0.05}", "radius: 0.05, length: 1}"),
            ("criterion: paper", "criterium: paper"),
            ("name: pipe", "name: floor"),
            ("floor: 0.0\n", "\n"),
        ],
        &[
            "scenario.yaml:12: unknown field `length`",
            "scenario.yaml:29: unknown field `criterium`",
            "missing field `floor`",
            "scenario.yaml:14: the name 'floor'",
        ],
    );
}

#[test]
fn a_broken_start_is_said_once() {
    expect(&[("base_joint_y: 0,", "base_joint_y: [0],")], &["scenario.yaml:4"]);
}

#[test]
fn every_line_of_grasps_and_solutions_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/corner");
    for file in ["scenario.yaml", "wedge.obj"] {
        fs::copy(original.join(file), folder.path().join(file)).unwrap();
    }
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("grasps.csv", "1,2\n0,0,1,0.8,0,1,0,0,-1,0,0,0.6,0,0,0,1\n1,0,0,x,0,1,0,0,0,0,1,0,0,0,0,1\n");
    write("ik.csv", "0,0,0,0,0,-1,0,1\n0,0,0,0,0,-1,0,1,0\n0,0,nan,0,0,-1,0,1,0\n");
    let said: Vec<String> =
        check(folder.path().to_str().unwrap()).unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 4, "{said:#?}");
    for (said, expected) in said.iter().zip([
        "grasps.csv:1: 2 numbers",
        "grasps.csv:3: number 4",
        "ik.csv:1: 8",
        "ik.csv:3: 'nan'",
    ]) {
        assert!(said.contains(expected), "{said}");
    }
}

/// A fault within a named region removed another region before, so that it was reported once for each, at wrong lines.
#[test]
fn a_fault_in_a_region_is_named_once_at_its_line() {
    let regions = "criterion: exact
regions:
  above:
    frames:
      - {pose: {position: [0.9, 0, 0.6]}, x: [-1, 1]}
  bad:
    frames:
      - {pose: {position: [0.9, 0, 0.6]}}
      - {pose: {position: [0.9, 0, 0.6]}, x: [1, 0]}
  near:
    hand: {position: [0.4, 0, 0.6]}
    within_m: [0.1, 0.1, 0.1]
";
    expect(&[("criterion: paper\n", regions)], &["scenario.yaml:37: 'x' is [1, 0], which is empty"]);
    // A scenario without a target, whose only region is the unreadable one, needs no grasps.
    let folder = tempfile::tempdir().unwrap();
    let text = "robot: panda_mobile
start: [0, 0, 0, -0.7, 0, -2.3, 0, 1.5, 0.7]
floor: 0
regions:
  bad: {frames: [{x: [1, 0]}]}
";
    fs::write(folder.path().join("scenario.yaml"), text).unwrap();
    let found = check(folder.path().to_str().unwrap()).unwrap();
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].to_string().contains("scenario.yaml:5: 'x' is [1, 0]"), "{}", found[0]);
}

#[test]
fn each_bound_and_each_joint_of_the_start_is_checked() {
    let bounds = "criterion: exact
tool_bounds:
  - {name: a, size: [1, 1, -1]}
  - {name: b, axis: [0, 0, 0], toward: [0, 0, 1], within_deg: 400}
  - {name: a, radius: 1}
";
    expect(
        &[("criterion: paper\n", bounds), ("panda_joint7: 0.7534", "panda_joint7: 99")],
        &[
            "the start is not free: panda_joint7 is 99",
            "scenario.yaml:31: bound 'a'",
            "scenario.yaml:32: bound 'b'",
            "scenario.yaml:33: the name 'a'",
        ],
    );
}
