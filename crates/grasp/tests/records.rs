//! Unknown keys of JSON and YAML are rejected by name or noted, and grasps keep the order of the file.

use cranny_grasp::{ClosingAxis, ImportSettings};

use crate::imports::{Files, QUARTER, json};

const GIVEN: ImportSettings = ImportSettings {
    format: None,
    closing: Some(ClosingAxis::Y),
    offset_m: Some(0.0),
    min_score: None,
    object: None,
};

fn isaac(head: &str, grasps: &str) -> Vec<u8> {
    format!("format: isaac_grasp\nformat_version: 1.0\n{head}grasps:\n{grasps}").into_bytes()
}

fn grasp(place: usize, more: &str) -> String {
    format!(
        "  grasp_{place}:\n    position: [{place}, 0, 0]\n    orientation: {{w: 1, xyz: [0, 0, 0]}}\n{more}"
    )
}

/// Guards against sorting by name, `grasp_10` before `grasp_2`.
#[test]
fn isaacs_grasps_are_in_the_order_of_the_file() {
    let grasps: String = [11, 2, 10, 0, 1].map(|place| grasp(place, "")).concat();
    let read = Files::new().read(&isaac("", &grasps), &GIVEN).expect("grasps");
    let places: Vec<f64> =
        read.grasps.grasps().iter().map(|grasp| grasp.world_from_gripper.translation.x).collect();
    assert_eq!(places, [11.0, 2.0, 10.0, 0.0, 1.0]);
}

#[test]
fn an_unknown_key_of_isaac_is_refused_with_the_nearest_known() {
    let files = Files::new();
    for (head, more, words) in [
        ("", "    confidense: 0.5\n", "line 7: as YAML of Isaac: unknown field `confidense`"),
        ("", "    confidense: 0.5\n", "did you mean 'confidence'?"),
        ("", "    scale: 0.01\n", "`scale`"),
        ("", "    units: cm\n", "`units`"),
        ("", "    width: 3\n", "`width`"),
        ("object_scal: 2\n", "", "did you mean 'object_scale'?"),
        ("approach_axis: 0\n", "", "approach_axis is 0"),
        ("object_scale: 0\n", "", "the scale of its object is 0"),
    ] {
        let fault = files.read(&isaac(head, &grasp(0, more)), &GIVEN).expect_err(words);
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
    let twice = isaac("", &[grasp(1, ""), grasp(1, "")].concat());
    let twice = files.read(&twice, &GIVEN).expect_err("two of one name");
    assert!(twice.contains("'grasp_1' is given twice"), "{twice}");
}

#[test]
fn known_keys_of_isaac_without_bearing_are_noted_where_they_are() {
    let files = Files::new();
    let note = |head: &str, more: &str, words: &str| {
        let grasps = [grasp(0, more), grasp(1, "")].concat();
        let read = files.read(&isaac(head, &grasps), &GIVEN).expect("grasps");
        assert!(read.notes.iter().any(|note| note == words), "no '{words}' in {:?}", read.notes);
        read
    };
    note("", "", "there is no confidence: the grasps have no score");
    note("", "    confidence: 0.5\n", "the score is the confidence; 1 grasp has none");
    let bare = note("", "", "object frame not named, gripper frame not named");
    assert!(!bare.notes.iter().any(|note| note.contains("not read")), "{:?}", bare.notes);
    note("", "    cspace_position: {finger: 0.02}\n", "not read: cspace_position");
    note("gripper_frame_link: /hand\n", "", "object frame not named, gripper frame /hand");
    let generated =
        note("object_scale: 0.5\nopen_limit: lower\napproach_axis: 2\n", "", "not read: open_limit");
    assert_eq!(generated.object_scale, Some(0.5));
}

#[test]
fn graspgens_keys_and_gripper_are_not_believed() {
    let files = Files::new();
    let text = String::from_utf8(json(&[QUARTER], ", \"object_in_gripper\": [1]")).expect("text");
    let settings = ImportSettings::default();
    for (from, to, words) in [
        ("\"scale\": 0.5", "\"scale\": 0.5, \"unit\": \"cm\"", "unknown field `unit`"),
        ("\"object_in_gripper\"", "\"object_in_grippr\"", "did you mean 'object_in_gripper'?"),
        ("{\"object\"", "{\"units\": \"mm\", \"object\"", "unknown field `units`"),
        ("{\"object\"", "{\"gripper\": \"robotiq_2f_140\", \"object\"", "gripper is 'robotiq_2f_140'"),
        ("{\"object\"", "{\"gripper\": {\"name\": \"suction\"}, \"object\"", "gripper.name is 'suction'"),
        ("\"scale\": 0.5", "\"scale\": -1", "the scale of its object is -1"),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text);
        let fault = files.read(changed.as_bytes(), &settings).expect_err(words);
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
    let panda = text.replacen("{\"object\"", "{\"gripper\": {\"name\": \"Panda\"}, \"object\"", 1);
    assert!(files.read(panda.as_bytes(), &settings).is_ok());
    let unscored = files.read(&json(&[QUARTER], ""), &settings).expect("grasps");
    let words = "there is no object_in_gripper: the grasps have no score";
    assert!(unscored.notes.iter().any(|note| note == words), "{:?}", unscored.notes);
}
