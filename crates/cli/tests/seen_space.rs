//! Plans in the space that cameras have seen, judged there and in the true scene.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

/// Runs a command, and returns its code and all that it prints.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output = command.current_dir(folder).args(arguments).output().expect("it runs");
    let [page, notes] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    (output.status.code(), page + &notes)
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let (code, text) = run(folder, arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {text}");
    text
}

#[test]
fn a_plan_in_seen_space_is_valid_in_the_true_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(
        folder,
        &["sense", "031", "--default-cameras", "8", "--noise-seed", "1", "--scenario", "-o", "seen"],
    );
    let page = done(folder, &["plan", "seen", "--time-limit", "60", "-o", "plan.json"]);
    assert!(
        page.contains("the obstacles are what 8 views show; all space that none of them shows"),
        "{page}"
    );
    assert!(done(folder, &["verify", "seen", "plan.json"]).contains("valid"));
    assert!(done(folder, &["verify", "031", "plan.json"]).contains("valid"));
    // A path through space that no camera has seen to be free is none.
    done(folder, &["plan", "031", "-o", "true.json"]);
    let (code, refused) = run(folder, &["verify", "seen", "true.json"]);
    assert_eq!(code, Some(1), "{refused}");
    assert!(refused.contains("unseen") || refused.contains("occupied"), "{refused}");
}

#[test]
fn faults_of_views_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let sense = ["sense", "021", "--default-cameras", "1", "--scenario", "-o", "seen"];
    done(folder, &sense);
    let (code, kept) = run(folder, &sense);
    assert_eq!(code, Some(2), "an existing folder is kept: {kept}");
    // Metres taken for millimetres, a frequent mistake, are beyond the range of the sensor.
    let views = folder.join("seen/views.yaml");
    let measured = fs::read_to_string(&views).expect("views");
    fs::write(&views, measured.replace("depth_unit_m: 0.001", "depth_unit_m: 1")).expect("written");
    assert!(run(folder, &["info", "seen"]).1.contains("the view 'camera1' shows nothing"));
    fs::write(&views, measured).expect("written");
    let file = folder.join("seen/scenario.yaml");
    let good = fs::read_to_string(&file).expect("a scenario");
    for (line, fault) in [
        ("  views: nowhere", "nowhere"),
        ("  views: .\n  cell_m: 0.00001", "0.001 to 0.2 m"),
        ("  views: .\n  robot_reach_m: 5", "robot_reach_m"),
        ("  views: .\n  colour: red", "colour"),
        ("  views: .\n  unseen: maybe", "maybe"),
        ("  views: .\n  region: {low: [0, 0, 0], high: [0, 1, 1]}", "positive size"),
    ] {
        fs::write(&file, good.replace("  views: .", line)).expect("written");
        let (code, message) = run(folder, &["plan", "seen"]);
        assert!(code == Some(2) && message.contains(fault), "{line}: {message}");
    }
}
