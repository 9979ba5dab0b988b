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
    let filtered = cranny(folder.path(), &["grasps", "filter", "021", "--grasps", "grasps.csv"]);
    let page = String::from_utf8_lossy(&filtered.stdout);
    assert!(
        page.contains("take 0 of 200") && page.contains("200  of a width that the hand cannot"),
        "{page}"
    );
    let found = cranny(folder.path(), &["ik", "021", "--grasps", "grasps.csv", "--single-shot"]);
    let note = String::from_utf8_lossy(&found.stderr);
    assert!(note.contains("200 grasps of a width that the hand cannot take"), "{note}");
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

/// A table with a box on it or above it, without grasps, and a place without a support.
fn write_box(folder: &Path, height_m: f64) {
    std::fs::create_dir_all(folder.join("box")).expect("a folder");
    let scenario = format!(
        "robot: panda_mobile
start: [0, 0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, 1.5412, 0.7534]
floor: 0
frame: {{position: [0, 0, 0.05]}}
obstacles:
  - {{name: table, pose: {{position: [0.9, 0, 0.25]}}, shapes: [{{box: {{size: [0.4, 1.2, 0.5]}}}}]}}
target:
  name: cube
  mass_kg: 0.1
  pose: {{position: [0.85, -0.2, {height_m}]}}
  shapes: [{{box: {{size: [0.05, 0.05, 0.05]}}}}]
places: [{{name: hover, target_pose: {{position: [0.85, 0, 0.5275]}}}}]
"
    );
    std::fs::write(folder.join("box/scenario.yaml"), scenario).expect("written");
}

/// Before, such a search used its whole time, and gave a cause of grasps that had nothing to do with the place.
#[test]
fn a_place_without_a_support_ends_a_search_for_own_grasps_at_once() {
    let folder = folder();
    write_box(folder.path(), 0.5251);
    let output = cranny(folder.path(), &["plan", "box", "--place", "hover", "--time-limit", "60"]);
    let page = text(&output);
    assert_eq!(output.status.code(), Some(1), "{page}");
    let cause = "own grasps: with this grasp no placement of the object is feasible";
    assert!(page.contains("no-reachable-grasp") && page.contains(cause), "{page}");
}

#[test]
fn a_target_that_rests_on_nothing_is_named() {
    let folder = folder();
    for (height_m, floats) in [(0.5251, false), (0.565, true)] {
        write_box(folder.path(), height_m);
        let page = text(&cranny(folder.path(), &["plan", "box", "--carry", "home"]));
        assert_eq!(page.contains("'cube' rests on nothing"), floats, "{page}");
    }
}

#[test]
fn options_without_an_effect_are_refused() {
    let folder = folder();
    for (arguments, expected) in [
        (&["--speed", "carry=0.5"][..], "--speed: there is no motion 'carry'"),
        (&["--tool-speed", "approach=0.5"], "--tool-speed: there is no motion 'approach'"),
        (&["--carry", "home", "--speed", "retreat=0.5"], "--speed: there is no motion 'retreat'"),
        (&["--hold", "3"], "--hold: nothing is carried"),
        (&["--upright", "5"], "--upright: nothing is carried"),
    ] {
        let output = cranny(folder.path(), &[&["plan", "021"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output).contains(expected), "{}", text(&output));
    }
}

#[test]
fn a_fault_of_a_plan_file_names_the_file_and_only_what_is_as_stated_is_listed_so() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "021", "-o", "p.json"]);
    assert_eq!(planned.status.code(), Some(0), "{}", text(&planned));
    let plan: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("p.json")).expect("a plan")).expect("JSON");
    let verify = |pointer: &str, value: &str| {
        let mut other = plan.clone();
        *other.pointer_mut(pointer).expect("a value") = "@".into();
        let other = other.to_string().replace("\"@\"", value);
        std::fs::write(folder.path().join("other.json"), other).expect("written");
        let output = cranny(folder.path(), &["verify", "021", "other.json"]);
        (output.status.code(), text(&output))
    };
    let (code, page) = verify("/margins/margin_m", "-0.01");
    assert!(code == Some(2) && page.contains("other.json: its 'margins': a margin must be"), "{page}");
    let (code, page) = verify("/seed", "1000000000000000000000000000000");
    assert!(code == Some(2) && page.contains("other.json") && page.contains("1e30 is too large"), "{page}");
    let (code, page) = verify("/least_length", "2.8");
    let as_stated = page.lines().find(|line| line.starts_with("  as stated")).expect("a line");
    assert!(code == Some(1) && page.contains("least_length: the file states 2.80"), "{page}");
    assert!(as_stated.contains("outcome") && !as_stated.contains("least_length"), "{as_stated}");
}

/// A scenario whose only goals are regions has no grasps.
#[test]
fn a_scenario_of_regions_is_sound_without_grasps() {
    let folder = folder();
    let hover = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/tutorial/hover");
    let output = cranny(folder.path(), &["scenario", "check", &hover.to_string_lossy()]);
    assert!(output.status.code() == Some(0) && text(&output).contains("sound"), "{}", text(&output));
}
