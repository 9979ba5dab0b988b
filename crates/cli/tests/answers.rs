//! Answers that state their limiting factors, and error messages that lead to the fault.

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

    // With one margin for all, no margin limits another.
    let arguments = ["plan", "023", "--margin", "1", "--grasp-margin", "1", "--json"];
    let planned = cranny(folder.path(), &arguments);
    assert!(!text(&planned).contains("limited by") && json(&planned)["clearance_limit"].is_object());
}

/// Writes the grasps of scenario 021 to a file, with `change` applied to each line.
fn grasps_of_021(folder: &Path, change: impl Fn(&mut [f64])) {
    let entry = cranny_scenario::catalogue().iter().find(|entry| entry.id == "021").expect("built in");
    let (_, grasps) = entry.files();
    let lines = grasps.lines().enumerate().map(|(line, text)| {
        if line == 0 {
            return text.to_owned();
        }
        let mut values: Vec<f64> = text.split(',').map(|value| value.parse().expect("a number")).collect();
        change(&mut values);
        values.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
    });
    let text = lines.collect::<Vec<_>>().join("\n") + "\n";
    std::fs::write(folder.join("grasps.csv"), text).expect("written");
}

#[test]
fn grasps_that_are_too_wide_end_a_search_at_once_with_digits_that_differ() {
    let folder = folder();
    grasps_of_021(folder.path(), |grasp| grasp[17] = 0.080_000_4);
    let planned = cranny(folder.path(), &["plan", "021", "--grasps", "grasps.csv"]);
    assert_eq!(planned.status.code(), Some(1));
    let text = text(&planned);
    assert!(text.contains("no-reachable-grasp") && text.contains("0 iterations"), "{text}");
    assert!(text.contains("the object is 80.0004 mm wide there, and the hand opens 80.0000 mm"), "{text}");
}

#[test]
fn grasps_beyond_reach_are_told_with_distance_joints_and_a_base_that_reaches_them() {
    let folder = folder();
    grasps_of_021(folder.path(), |grasp| grasp[3] += 9.0);
    let planned = cranny(folder.path(), &["plan", "021", "--grasps", "grasps.csv"]);
    assert_eq!(planned.status.code(), Some(1));
    let text = text(&planned);
    for words in ["or more beyond reach", "joints at their limits: base_joint_x", "with the base moved by +"]
    {
        assert!(text.contains(words), "{text}");
    }
    assert!(!text.contains("--time-limit"), "{text}");
    let told = json(&cranny(folder.path(), &["plan", "021", "--grasps", "grasps.csv", "--json"]));
    let miss = &told["no_grasp"];
    assert!(miss["beyond_m"].as_f64() <= miss["missed_by_m"].as_f64(), "{miss}");
    assert!(miss["grasp"].is_u64() && miss["base_shift_m"].is_array(), "{miss}");
}

#[test]
fn a_slip_of_the_pen_gets_a_suggestion_wherever_a_name_is_looked_up() {
    let folder = folder();
    let made = cranny(folder.path(), &["scenario", "new", "kitchen"]);
    assert!(made.status.success());
    std::fs::write(folder.path().join("ball.plan.json"), "{}").expect("written");
    for (words, meant) in [
        ("plan kichen", "kitchen"),
        ("info 21", "021"),
        ("plan 021 --robot ur55", "ur5e"),
        ("robot check ur55", "ur5e"),
        ("plan 021 --planner reech", "reach"),
        ("plan 021 --set lokks=3", "looks"),
        ("plan 012 --place outsid", "outside"),
        ("object show bananna", "banana"),
        ("simulate settle bananna", "banana"),
        ("scenario sweep gapp --from 0.6 --to 0.3 --steps 2", "gap"),
        ("bench run --scenarios kichen --planners reach -o x.db", "kitchen"),
        ("bench run --preset papr -o x.db", "paper"),
        ("verify 021 bal.plan.json", "ball.plan.json"),
    ] {
        let told = cranny(folder.path(), &words.split_whitespace().collect::<Vec<_>>());
        let error = String::from_utf8_lossy(&told.stderr);
        let hint = error.rsplit_once("did you mean").or(error.rsplit_once("similar value"));
        assert_eq!(told.status.code(), Some(2), "{words}: {error}");
        assert!(hint.is_some_and(|(_, hint)| hint.contains(meant)), "{words}: {error}");
    }
}
