//! `cranny plan --moveit SCENE REQUEST` and `verify`: MoveIt problems are planned and verified like scenarios.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

const URDF: &str = "<robot name='crane'>
<link name='base'/>
<link name='boom'><collision><origin xyz='0.5 0 0'/><geometry><box size='1 0.1 0.1'/></geometry></collision></link>
<link name='hook'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>
<joint name='turn' type='revolute'><parent link='base'/><child link='boom'/><axis xyz='0 0 1'/>
<limit lower='-3' upper='3' velocity='1' effort='1'/></joint>
<joint name='lift' type='revolute'><origin xyz='1 0 0'/><parent link='boom'/><child link='hook'/>
<axis xyz='0 1 0'/><limit lower='-1' upper='1' velocity='1' effort='1'/></joint>
<joint name='grip' type='prismatic'><parent link='hook'/><child link='claw'/><axis xyz='0 0 1'/>
<limit lower='0' upper='0.1' velocity='1' effort='1'/></joint>
<link name='claw'/>
</robot>";

const SRDF: &str =
    "<robot name='crane'><group name='both'><chain base_link='base' tip_link='hook'/></group></robot>";

const SCENE: &str = "robot_model_name: crane
world:
  collision_objects:
    - id: post
      primitives: [{type: cylinder, dimensions: [2, 0.05]}]
      primitive_poses: [{position: [-0.8, 0.5, 0], orientation: [0, 0, 0, 1]}]
";

const REQUEST: &str = "group_name: both
start_state: {joint_state: {name: [turn, lift, grip], position: [-1, 0, 0.2]}}
goal_constraints:
  - joint_constraints: [{joint_name: turn, position: 1}, {joint_name: lift, position: 0.5}]
";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files =
        [("crane.urdf", URDF), ("crane.srdf", SRDF), ("crate1.yaml", SCENE), ("request1.yaml", REQUEST)];
    for (file, text) in files {
        std::fs::write(folder.path().join(file), text).expect("written");
    }
    folder
}

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

#[test]
fn a_moveit_problem_is_planned_and_written() {
    let folder = folder();
    let planned = cranny(folder.path(), &["plan", "--moveit", "crate1.yaml", "request1.yaml", "--json"]);
    let notes = String::from_utf8_lossy(&planned.stderr);
    assert_eq!(planned.status.code(), Some(0), "{notes}");
    assert!(notes.contains("note: joint 'grip' is held at its limit 0.1 instead of 0.2"), "{notes}");
    let answer: Value = serde_json::from_slice(&planned.stdout).expect("one JSON document");
    assert_eq!(
        (&answer["scenario"], &answer["outcome"], &answer["criterion"]),
        (&"crate1".into(), &"solved".into(), &"exact".into())
    );
    assert_eq!((&answer["grasp"], &answer["valid"]), (&Value::Null, &true.into()));
    assert_eq!(answer["deviations"][0], "joint 'grip' is held at its limit 0.1 instead of 0.2");
    let way_points = answer["waypoints"].as_array().expect("way points");
    assert_eq!(way_points.first(), Some(&serde_json::json!([-1.0, 0.0])));
    assert_eq!(way_points.last(), Some(&serde_json::json!([1.0, 0.5])));
    assert!(folder.path().join("crate1.plan.json").is_file());

    let summary =
        cranny(folder.path(), &["plan", "--moveit", "crate1.yaml", "request1.yaml", "--margin", "5"]);
    let text = String::from_utf8_lossy(&summary.stdout);
    assert_eq!(summary.status.code(), Some(0), "{text}");
    for word in ["crate1: solved", "clearance", "way points", "crate1.plan.json", "held at its limit 0.1"] {
        assert!(text.contains(word), "no '{word}' in {text}");
    }
}

#[test]
fn a_start_in_contact_is_an_honest_no() {
    let folder = folder();
    std::fs::write(folder.path().join("crate1.yaml"), SCENE.replace("-0.8, 0.5", "0.54, -0.84"))
        .expect("written");
    let refused = cranny(folder.path(), &["plan", "--moveit", "crate1.yaml", "request1.yaml"]);
    let text = String::from_utf8_lossy(&refused.stdout);
    assert_eq!(refused.status.code(), Some(1), "{text}");
    assert!(text.contains("start-invalid") && text.contains("hook touches post"), "{text}");
    assert!(!folder.path().join("crate1.plan.json").exists());
}

#[test]
fn a_goal_that_is_refused_has_its_reasons() {
    let folder = folder();
    let goals =
        REQUEST.replace("position: 1}", "position: 3.00101}").replace("position: 0.5}", "position: 1.5}");
    let goals = goals
        + "  - joint_constraints: [{joint_name: turn, position: 2.5}, {joint_name: lift, position: 0}]\n";
    std::fs::write(folder.path().join("request1.yaml"), goals).expect("written");
    let plan = ["plan", "--moveit", "crate1.yaml", "request1.yaml"];
    let refused = cranny(folder.path(), &plan);
    let text = String::from_utf8_lossy(&refused.stdout);
    assert_eq!(refused.status.code(), Some(1), "{text}");
    for reason in [
        "goals-invalid",
        "0: turn is 3.0010, outside its limits [-3.0000, 3.0000]",
        "0: lift is 1.5000, outside its limits [-1.0000, 1.0000]",
        "1: boom touches post",
    ] {
        assert!(text.contains(reason), "no '{reason}' in {text}");
    }
    let answer = cranny(folder.path(), &[&plan[..], &["--json"]].concat());
    let answer: Value = serde_json::from_slice(&answer.stdout).expect("one JSON document");
    assert_eq!(answer["goal_faults"].as_array().map(Vec::len), Some(2), "{answer}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = folder();
    std::fs::write(folder.path().join("cone.yaml"), SCENE.replace("cylinder", "cone")).expect("written");
    let cases: [(&[&str], &str); 7] = [
        (&["plan"], "<ID>"),
        (&["plan", "--moveit", "crate1.yaml"], "2 values required"),
        (&["plan", "021", "--moveit", "crate1.yaml", "request1.yaml"], "cannot be used with"),
        (
            &["plan", "--moveit", "crate1.yaml", "request1.yaml", "--criterion", "paper"],
            "cannot be used with",
        ),
        (&["plan", "--moveit", "crate1.yaml", "request1.yaml", "--margin", "-1"], "--margin"),
        (&["plan", "--moveit", "crate1.yaml", "request2.yaml"], "request2.yaml: cannot be read"),
        (&["plan", "--moveit", "cone.yaml", "request1.yaml"], "cone.yaml:5: a cone is not supported"),
    ];
    for (arguments, expected) in cases {
        let output = cranny(folder.path(), arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(expected), "{arguments:?}\n  said: {error}\n  not:  {expected}");
    }
}

#[test]
fn a_plan_of_a_moveit_problem_is_judged_by_its_files() {
    let folder = folder();
    let problem = ["--moveit", "crate1.yaml", "request1.yaml"];
    let run = |arguments: &[&[&str]]| cranny(folder.path(), &arguments.concat());
    assert_eq!(run(&[&["plan"], &problem, &["--margin", "5"]]).status.code(), Some(0));

    let judged = run(&[&["verify"], &problem, &["crate1.plan.json", "--json"]]);
    let answer: Value = serde_json::from_slice(&judged.stdout).expect("one JSON document");
    assert_eq!((judged.status.code(), &answer["valid"]), (Some(0), &true.into()));
    assert!(answer["clearance_m"].as_f64().expect("a clearance") >= 0.005, "{answer}");
    let harder = run(&[&["verify"], &problem, &["crate1.plan.json", "--margin", "1000"]]);
    assert_eq!(harder.status.code(), Some(1), "the flag goes before the margin of the plan");

    // The short path from start to goal is free, the long one leads through the post.
    let way_points = |text: &str| std::fs::write(folder.path().join("way.csv"), text).expect("written");
    let verdict = || run(&[&["verify"], &problem, &["way.csv"]]);
    way_points("-1,0\n1,0.5\n");
    assert_eq!(verdict().status.code(), Some(0));
    way_points("-1,0\n2.6,0\n1,0.5\n");
    let through = verdict();
    let text = String::from_utf8_lossy(&through.stdout);
    assert!(through.status.code() == Some(1) && text.contains("deep in post"), "{text}");
    way_points("-1,0\n1,0.4\n");
    assert!(String::from_utf8_lossy(&verdict().stdout).contains("off the nearest goal"));
}

#[test]
fn a_verification_needs_a_scenario_or_a_moveit_problem_and_not_both() {
    let folder = folder();
    let refused = |arguments: &[&str]| {
        let output = cranny(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let problem = ["verify", "--moveit", "crate1.yaml", "request1.yaml"];
    assert!(refused(&[&problem[..], &["021", "x.plan.json"]].concat()).contains("cannot be used with"));
    assert!(refused(&problem).contains("--moveit <SCENE> <REQUEST> <PLAN>"));
    assert!(refused(&["verify", "x.plan.json"]).contains("<PLAN>"));
    assert!(
        refused(&["verify", "--moveit", "crate1.yaml", "x.plan.json"]).contains("<SCENE> <REQUEST> <PLAN>")
    );
    let missing = refused(&["verify", "--moveit", "crate1.yaml", "nowhere.yaml", "x.csv"]);
    assert!(missing.contains("nowhere.yaml"), "{missing}");
}
