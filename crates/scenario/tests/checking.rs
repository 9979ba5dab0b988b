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
