//! Explores true scenarios view by view, and judges the plans in the folder that is written and in the true scene.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

const URDF: &str = r#"<robot name="gantry">
<link name="world"/><link name="bridge"/><link name="trolley"/>
<link name="body"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="world"/><child link="bridge"/><axis xyz="1 0 0"/>
  <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="y" type="prismatic"><parent link="bridge"/><child link="trolley"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="z" type="prismatic"><parent link="trolley"/><child link="body"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"#;

const SCENARIO: &str = "robot: robot.urdf
tip: body
floor: -0.4
start: [-0.45, 0, 0]
obstacles:
  - name: wall
    pose: {position: [0, 0, -0.1]}
    shapes: [{box: {size: [0.04, 0.6, 0.6]}}]
target:
  name: target
  pose: {position: [0.45, 0, 0]}
  shapes: [{sphere: {radius: 0.04}}]
";

const CAMERAS: &str = "cameras:
  - {name: bad, width: 160, height: 120, field_of_view_deg: 75, position_m: [-1.1, 0.1, 0.2], look_at_m: [0.4, 0, -0.1]}
";

/// Writes a ball before a wall, and a target behind it.
fn write_wall(folder: &Path) {
    let wall = folder.join("wall");
    fs::create_dir(&wall).expect("a folder");
    fs::write(wall.join("robot.urdf"), URDF).expect("written");
    fs::write(wall.join("scenario.yaml"), SCENARIO).expect("written");
    fs::write(wall.join("grasps.csv"), "1,0,0,0.3,0,1,0,0,0,0,1,0,0,0,0,1\n").expect("written");
    fs::write(folder.join("cameras.yaml"), CAMERAS).expect("written");
}

/// Runs a command, and returns its code, its page and its messages.
fn run(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    let output = command.current_dir(folder).args(line.split(' ')).output().expect("it runs");
    let [page, notes] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    (output.status.code(), page, notes)
}

#[test]
fn a_wall_is_explored_and_the_plan_is_valid_in_the_folder_and_in_truth() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_wall(folder);
    let (code, page, notes) =
        run(folder, "plan wall --explore --cameras cameras.yaml --noise-seed 1 -o seen");
    assert_eq!(code, Some(0), "{page}{notes}");
    for words in ["view 1: from (-1.100", "blocked by", "body meets them", "next view", "true scene  free"] {
        assert!(page.contains(words), "no '{words}' in {page}");
    }
    let (code, verdict, notes) = run(folder, "verify seen seen/plan.json");
    assert_eq!(code, Some(0), "{verdict}{notes}");
    assert_eq!(run(folder, "verify wall seen/plan.json").0, Some(0));
    // The folder is kept, and a seen scenario is not explored.
    let again = run(folder, "plan wall --explore --cameras cameras.yaml -o seen");
    assert!(again.0 == Some(2) && again.2.contains("seen"), "{}", again.2);
    let (code, _, fault) = run(folder, "plan seen --explore --cameras cameras.yaml -o other");
    assert!(code == Some(2) && fault.contains("has `seen` space already"), "{fault}");
    // One view alone is too little; nothing is written, and the next view is proposed.
    let (code, document, notes) =
        run(folder, "plan wall --explore --cameras cameras.yaml --noise-seed 1 --views 1 --json");
    assert_eq!(code, Some(1), "{notes}");
    let document: Value = serde_json::from_str(&document).expect("JSON");
    assert_eq!((&document["solved"], &document["folder"]), (&Value::Bool(false), &Value::Null));
    let blocked = &document["views"][0]["blocked_by"];
    assert!(blocked["unseen_cells"].as_u64().is_some_and(|count| count > 50), "{blocked}");
    assert_eq!((&blocked["candidate"], &blocked["first_link"]), (&"path".into(), &"body".into()));
    assert!(!folder.join("wall.explored").exists());
}

#[test]
fn a_plan_that_unseen_space_blocks_names_it_and_the_next_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_wall(folder);
    let (code, page, notes) =
        run(folder, "sense wall --cameras cameras.yaml --noise-seed 1 --scenario -o seen");
    assert_eq!(code, Some(0), "{page}{notes}");
    let (code, page, notes) = run(folder, "plan seen --time-limit 1");
    assert_eq!(code, Some(1), "{page}{notes}");
    assert!(page.contains("  blocked by") && page.contains("  next view   at ("), "{page}");
    let (_, document, _) = run(folder, "plan seen --time-limit 1 --json");
    let document: Value = serde_json::from_str(&document).expect("JSON");
    let (cells, sees) = (&document["blocked_by"]["cells"], &document["next_view"]["sees"]);
    assert!(cells.as_u64() >= sees.as_u64() && sees.as_u64() > Some(0), "{cells} {sees}");
}
