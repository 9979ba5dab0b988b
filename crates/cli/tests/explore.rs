//! Explores true scenarios view by view, and judges the plans in the folder that is written and in the true scene.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

/// Runs a command, and returns its code, its page and its messages.
fn run(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output = command.current_dir(folder).args(line.split(' ')).output().expect("it runs");
    let [page, notes] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    (output.status.code(), page, notes)
}

#[test]
fn a_built_in_scenario_is_explored_and_the_plan_is_valid_in_the_folder_and_in_truth() {
    // About half a minute; the crate's own test explores a wall in seconds.
    if std::env::var_os("CRANNY_LONG").is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (code, page, notes) = run(folder, "plan 031 --explore --noise-seed 0 --views 12 -o seen");
    assert_eq!(code, Some(0), "{page}{notes}");
    for words in ["view 1: from (", "blocked by", "next view", "true scene  free"] {
        assert!(page.contains(words), "no '{words}' in {page}");
    }
    assert_eq!(run(folder, "verify seen seen/plan.json").0, Some(0));
    assert_eq!(run(folder, "verify 031 seen/plan.json").0, Some(0));
}

#[test]
fn a_plan_that_unseen_space_blocks_names_it_and_the_next_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (code, page, notes) = run(folder, "sense 031 --default-cameras 1 --noise-seed 1 --scenario -o seen");
    assert_eq!(code, Some(0), "{page}{notes}");
    let (code, document, notes) = run(folder, "plan seen --time-limit 2 --json");
    assert_eq!(code, Some(1), "{notes}");
    let document: Value = serde_json::from_str(&document).expect("JSON");
    let (cells, sees) = (&document["blocked_by"]["cells"], &document["next_view"]["sees"]);
    assert!(cells.as_u64() >= sees.as_u64() && sees.as_u64() > Some(0), "{cells} {sees}");
    // A seen scenario is not explored, and a folder is kept.
    let (code, _, fault) = run(folder, "plan seen --explore -o other");
    assert!(code == Some(2) && fault.contains("has `seen` space already"), "{fault}");
    let (code, _, fault) = run(folder, "plan 031 --explore -o seen");
    assert!(code == Some(2) && fault.contains("seen"), "{fault}");
}
