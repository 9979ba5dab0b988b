//! `cranny roadmap` and the settings of planners, from the command line.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("cranny")
        .expect("the program")
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("it runs")
}

fn complaint(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_roadmap_is_made_once_and_asked_with_another_seed_and_scenario() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let made = cranny(folder.path(), &["roadmap", "021", "--nodes", "200", "--json"]);
    assert_eq!(made.status.code(), Some(0));
    let made: Value = serde_json::from_slice(&made.stdout).expect("one JSON document");
    assert!(made["nodes"] == 200 && made["edges"].as_u64().is_some_and(|edges| edges > 200));
    for (id, seed) in [("021", "1"), ("022", "2")] {
        let plan = ["plan", id, "--planner", "prm", "--set", "roadmap=021.roadmap.json", "--seed", seed];
        assert_eq!(cranny(folder.path(), &plan).status.code(), Some(0), "{id}");
        let verify = ["verify", id, &format!("{id}.plan.json")];
        assert_eq!(cranny(folder.path(), &verify).status.code(), Some(0), "{id}");
    }
    std::fs::write(folder.path().join("notes.txt"), "mine").expect("a file");
    let refused = cranny(folder.path(), &["roadmap", "021", "--nodes", "9", "-o", "notes.txt"]);
    assert!(complaint(&refused).contains("notes.txt"));
    let other = ["plan", "021", "--planner", "prm", "--set", "roadmap=notes.txt"];
    assert!(complaint(&cranny(folder.path(), &other)).contains("notes.txt"));
    let paper = ["roadmap", "021", "--criterion", "paper"];
    assert!(complaint(&cranny(folder.path(), &paper)).contains("exact"));
}

#[test]
fn a_setting_is_taken_by_its_name_or_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plan = |settings: &[&str]| {
        cranny(folder.path(), &[&["plan", "021", "--planner", "ik-rbt", "--json"], settings].concat())
    };
    let planned = plan(&["--set", "critical_m=0.05", "--set", "spines=3"]);
    assert_eq!(planned.status.code(), Some(0));
    assert!(complaint(&plan(&["--set", "spikes=3"])).contains("spines"));
    assert!(complaint(&plan(&["--set", "critical_m=far"])).contains("must be a number"));
    assert!(complaint(&plan(&["--set", "critical_m=-1"])).contains("above 0"));
    assert!(complaint(&plan(&["--set", "spines"])).contains("name=value"));
}
