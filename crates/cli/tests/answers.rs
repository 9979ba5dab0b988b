//! Answers that state what limits them, and reasons that lead to what is wrong.

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

fn text(output: &Output) -> String {
    let streams = [&output.stdout, &output.stderr].map(|stream| String::from_utf8_lossy(stream));
    streams.concat()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("one JSON document on standard output")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn a_clearance_below_the_margin_names_the_margin_that_limits_it() {
    let folder = folder();
    let planned = text(&cranny(folder.path(), &["plan", "023", "--margin", "5"]));
    let limited = "limited by panda_leftfinger and ball, to which the grasp margin of 0.00 mm applies, not the \
                   margin of 5.00 mm";
    assert!(planned.contains(limited), "{planned}");
    let verified = json(&cranny(folder.path(), &["verify", "023", "023.plan.json", "--json"]));
    let limit = &verified["clearance_limit"];
    assert!(verified["clearance_m"].as_f64().is_some_and(|clearance_m| clearance_m < 5e-3));
    assert_eq!((&limit["second"], &limit["margin"]), (&"ball".into(), &"grasp-margin".into()), "{limit}");

    // With one margin for all, none is limited by another.
    let arguments = ["plan", "023", "--margin", "1", "--grasp-margin", "1", "--json"];
    let planned = cranny(folder.path(), &arguments);
    assert!(!text(&planned).contains("limited by") && json(&planned)["clearance_limit"].is_object());
}
