//! `cranny scenario` from the command line.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = cranny(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", said(&output));
    said(&output)
}

fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = cranny(folder, arguments);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    for word in words {
        assert!(said.contains(word), "no '{word}' in {said}");
    }
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn every_built_in_scenario_is_planned() {
    let folder = folder();
    for id in (1..=4).flat_map(|environment| (1..=5).map(move |level| format!("0{environment}{level}"))) {
        let answer = done(folder.path(), &["plan", &id, "--json"]);
        let plan: Value = serde_json::from_str(&answer).expect("one JSON document");
        assert_eq!((&plan["outcome"], &plan["valid"]), (&"solved".into(), &true.into()), "{id}");
    }
    assert!(done(folder.path(), &["list"]).contains("045"));
}

#[test]
fn a_scenario_is_begun_checked_planned_packed_and_planned_from_the_archive() {
    let folder = folder();
    let path = folder.path();
    done(path, &["scenario", "new", "mine"]);
    assert!(done(path, &["scenario", "check", "mine"]).contains("sound"));
    done(path, &["plan", "mine"]);
    done(path, &["scenario", "pack", "mine", "--author", "A. Nother", "--licence", "CC0-1.0"]);
    done(path, &["plan", "mine.zip", "-o", "packed.plan.json"]);
    done(path, &["verify", "mine", "packed.plan.json"]);
    done(path, &["scenario", "unpack", "mine.zip", "-o", "again"]);
    assert!(done(path, &["info", "again"]).contains("3 scored"));
    refused(path, &["scenario", "unpack", "mine.zip", "-o", "again"], &["again", "exists already"]);
    refused(path, &["scenario", "new", "mine"], &["mine", "exists already"]);
    let bytes = std::fs::read(path.join("mine.zip")).expect("an archive");
    std::fs::write(path.join("cut.zip"), &bytes[..bytes.len() / 2]).expect("written");
    refused(path, &["plan", "cut.zip"], &["cut.zip", "not a complete zip archive"]);
    refused(path, &["plan", "nowhere.zip"], &["nowhere.zip"]);
}

#[test]
fn check_names_every_problem_and_says_no() {
    let folder = folder();
    let path = folder.path();
    done(path, &["scenario", "new", "mine"]);
    let file = path.join("mine/scenario.yaml");
    let yaml = std::fs::read_to_string(&file).expect("a template");
    let broken = yaml
        .replace("radius: 0.03, length: 0.12", "radius: -0.03, length: 0.12")
        .replace("size: [0.4, 0.8, 0.02]", "size: [0.4, 0.8]");
    std::fs::write(&file, broken).expect("written");
    let output = cranny(path, &["scenario", "check", "mine", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let answer: Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
    assert_eq!(answer["sound"], false);
    assert_eq!(answer["problems"].as_array().map(Vec::len), Some(3), "{answer}");
    let blocked = yaml.replace("position: [0.9, 0, 0.6]", "position: [0.3, 0, 0.6]");
    std::fs::write(&file, blocked).expect("written");
    let output = cranny(path, &["scenario", "check", "mine"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("the start is not free"), "{}", said(&output));
    std::fs::write(&file, yaml).expect("written");
    done(path, &["grasps", "filter", "mine", "-o", "loaded.csv"]);
    let loaded = std::fs::read_to_string(path.join("loaded.csv")).expect("grasps");
    std::fs::write(path.join("mine/grasps.csv"), &loaded).expect("written");
    assert!(done(path, &["scenario", "check", "mine"]).contains("sound"));
    let (before_load, _) = loaded.trim_end().rsplit_once(',').expect("a load in the last row");
    std::fs::write(path.join("mine/grasps.csv"), format!("{before_load},77\n")).expect("written");
    let output = cranny(path, &["scenario", "check", "mine"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("1 grasp with a false load"), "{}", said(&output));
}

#[test]
fn scenarios_go_to_the_released_layout_and_back() {
    let folder = folder();
    let path = folder.path();
    done(path, &["scenario", "export", "034", "-o", "134"]);
    done(path, &["plan", "134"]);
    done(path, &["scenario", "import", "134", "-o", "back"]);
    done(path, &["plan", "back"]);
    refused(path, &["scenario", "import", "back", "-o", "again"], &["scene.yaml"]);
    refused(path, &["scenario", "export", "034", "-o", "134"], &["exists already"]);
}

#[test]
fn families_are_swept_and_drawn() {
    let folder = folder();
    let path = folder.path();
    let sweep = ["scenario", "sweep", "gap", "--from", "0.64", "--to", "0.30", "--steps", "3"];
    assert!(done(path, &sweep).contains("3 scenarios in gap-sweep"));
    done(path, &["plan", "gap-sweep/gap-0.4700"]);
    let draw = ["scenario", "generate", "--family", "table", "--count", "4", "--seed", "7", "--json"];
    let answer: Value = serde_json::from_str(&done(path, &draw)).expect("one JSON document");
    assert_eq!(answer["written"], 4);
    assert!(answer["rejected"]["things_overlap"].is_u64());
    assert!(done(path, &["scenario", "check", "table-7/table-00003"]).contains("sound"));
    refused(
        path,
        &["scenario", "sweep", "cave", "--from", "1", "--to", "2", "--steps", "2"],
        &["cave", "gate"],
    );
    refused(
        path,
        &["scenario", "sweep", "gate", "--from", "1", "--to", "7", "--steps", "2"],
        &["opening", "7"],
    );
    refused(path, &["scenario", "generate", "--family", "gap", "--count", "2", "--from=-1"], &["gap", "-1"]);
    refused(path, &["scenario", "generate", "--family", "table", "--count", "4", "--seed", "7"], &["exists"]);
}

/// Guards against a silent grasp 25 cm beside the object, after its pose was changed and its grasps were not.
#[test]
fn grasps_of_another_place_than_the_target_are_told() {
    let folder = folder();
    let run = |words: &[&str]| cranny(folder.path(), words);
    assert_eq!(run(&["scenario", "new", "moved"]).status.code(), Some(0));
    let file = folder.path().join("moved/scenario.yaml");
    let text = std::fs::read_to_string(&file).expect("read");
    std::fs::write(&file, text.replace("[0.8, 0, 0.67]", "[0.95, 0.2, 0.67]")).expect("written");
    let checked = run(&["scenario", "check", "moved"]);
    assert_eq!(checked.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&checked.stdout).contains("none of the 3 grasps is at can"));
    for (height, odd) in
        [("0.60", "can reaches into board"), ("0.80", "can rests on nothing: the nearest body is")]
    {
        std::fs::write(&file, text.replace("[0.8, 0, 0.67]", &format!("[0.8, 0, {height}]")))
            .expect("written");
        assert!(
            String::from_utf8_lossy(&run(&["scenario", "check", "moved"]).stdout).contains(odd),
            "{height}"
        );
    }
    std::fs::write(&file, text.replace("[0.8, 0, 0.67]", "[0.95, 0.2, 0.67]")).expect("written");
    let planned = run(&["plan", "moved"]);
    assert!(String::from_utf8_lossy(&planned.stderr).contains("note: none of the 3 grasps is at can"));
    assert_eq!(
        run(&["grasps", "sample", "moved", "-o", "moved/grasps.csv", "--count", "5"]).status.code(),
        Some(0)
    );
    assert_eq!(run(&["scenario", "check", "moved"]).status.code(), Some(0));
    std::fs::remove_file(folder.path().join("moved/grasps.csv")).expect("removed");
    assert_eq!(
        run(&["scenario", "check", "moved"]).status.code(),
        Some(0),
        "planners make grasps of their own"
    );
}

/// A place must be on its support, and an export states its losses.
#[test]
fn a_place_that_hovers_is_a_fault_and_an_export_states_what_it_loses() {
    let folder = folder();
    let scene = |z: f64| {
        format!(
            "robot: panda_mobile\nfloor: -0.05\nobstacles:\n  - name: t\n    pose: {{position: [1, 1, 0.1]}}\n    shapes: [{{box: \
             {{size: [0.6, 0.6, 0.2]}}}}]\ntarget:\n  name: crate\n  pose: {{position: [1, 1, 0.23]}}\n  shapes: [{{box: {{size: \
             [0.04, 0.04, 0.06]}}}}]\n  mass_kg: 0.2\nplaces:\n  - {{name: p, on: t, pose: {{position: [1.1, 1.1, {z}]}}, size: \
             [0.2, 0.2]}}\n"
        )
    };
    std::fs::create_dir(folder.path().join("cell")).expect("a folder");
    for (z, code) in [(0.2, 0), (0.21, 1)] {
        std::fs::write(folder.path().join("cell/scenario.yaml"), scene(z)).expect("written");
        let output = cranny(folder.path(), &["scenario", "check", "cell"]);
        assert_eq!(output.status.code(), Some(code), "{}", said(&output));
        assert_eq!(
            said(&output).contains("place 'p' is 10.0 mm away from 't'"),
            code == 1,
            "{}",
            said(&output)
        );
    }
    let page = done(folder.path(), &["scenario", "export", "025", "-o", "released"]);
    for words in ["up to 0.15 mm inside it", "places (1)", "scores of grasps (200)", "widths of grasps (200)"]
    {
        assert!(page.contains(words), "no '{words}' in {page}");
    }
}
