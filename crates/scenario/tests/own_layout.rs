//! Scenarios in Cranny's layout.

use std::path::Path;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario, ScenarioError};
use cranny_task::Criterion;

fn corner() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/corner").display().to_string()
}

#[test]
fn everything_that_a_file_says_stands_in_the_planning_frame() {
    let scenario = Scenario::open(&corner(), &OpenOptions::default()).unwrap();
    assert_eq!(scenario.id, "corner");
    let bodies = scenario.world.bodies();
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["board", "pipe", "wedge", "block", "floor"]);
    assert_eq!(bodies.iter().map(|body| body.parts.len()).collect::<Vec<_>>(), [2, 2, 2, 1, 1]);
    assert_eq!(scenario.target, Some(3));
    let place = |body: usize, part: usize| bodies[body].parts[part].world_from_solid;
    let expect = |body: usize, part: usize, [x, y, z]: [f64; 3]| {
        let found = place(body, part).translation.vector;
        assert!((found - cranny_spatial::Vector::new(x, y, z)).norm() < 1e-12, "{found}");
    };
    // The root is at (1, 0, 0.05) m, rotated by a quarter turn: x of the scene is y here.
    expect(0, 0, [1.0, 0.0, 0.35]);
    expect(0, 1, [1.0, -0.3, 0.45]);
    expect(3, 0, [1.0, 0.0, 0.41]);
    assert!((place(4, 0).translation.z + 0.05).abs() < 1e-12);
    // The pipe lies along y of the scene, which is x of the planning frame.
    let axis = place(1, 0).rotation * cranny_spatial::Vector::z();
    assert!((axis.x.abs() - 1.0).abs() < 1e-6, "{axis}");
    assert_eq!(bodies[0].parts[0].solid.as_cuboid().unwrap(), cranny_spatial::Vector::new(0.3, 0.15, 0.01));
    // Mesh files are read in single precision.
    assert!((bodies[2].parts[0].solid.aabb().half_extents.x - 0.05).abs() < 1e-8);
    assert!((scenario.start[3] + 0.7601).abs() < 1e-15);
    let scores: Vec<_> = scenario.grasps.grasps().iter().map(|g| (g.score, g.width_m)).collect();
    assert_eq!(scores, [(Some(0.9), Some(0.04)), (None, None)]);
}

#[test]
fn without_a_start_the_robot_begins_at_that_of_its_own_files() {
    let folder = tempfile::tempdir().unwrap();
    let original = Scenario::open("021", &OpenOptions::default()).unwrap();
    original.write_folder(folder.path()).unwrap();
    let file = folder.path().join("scenario.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    let (before, after) = text.split_once("start:").unwrap();
    let end = after.find("\nfloor").unwrap();
    std::fs::write(&file, format!("{before}{}", &after[end + 1..])).unwrap();
    let scenario = Scenario::open(folder.path().to_str().unwrap(), &OpenOptions::default()).unwrap();
    assert_eq!(Some(&scenario.start[..]), scenario.robot.default_start());
}

#[test]
fn exempt_pairs_are_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let original = Scenario::open("021", &OpenOptions::default()).unwrap();
    let [first, second] = [folder.path().join("first"), folder.path().join("second")];
    original.write_folder(&first).unwrap();
    let file = first.join("scenario.yaml");
    let pairs = "unchecked_pairs: [[\"panda_hand\",\"panda_link5\"]]\n";
    std::fs::write(&file, std::fs::read_to_string(&file).unwrap() + pairs).unwrap();
    let scenario = Scenario::open(first.to_str().unwrap(), &OpenOptions::default()).unwrap();
    scenario.write_folder(&second).unwrap();
    assert!(std::fs::read_to_string(second.join("scenario.yaml")).unwrap().contains(pairs));
    let again = Scenario::open(second.to_str().unwrap(), &OpenOptions::default()).unwrap();
    assert_eq!(again.robot_source, scenario.robot_source);
}

#[test]
fn the_files_criterion_holds_unless_another_is_asked_for() {
    let scenario = Scenario::open(&corner(), &OpenOptions::default()).unwrap();
    assert_eq!(scenario.problem(Margins::default()).unwrap().criterion(), Criterion::Paper);
    let demanding = Margins { margin_m: 0.005, grasp_margin_m: 0.0, ..Margins::default() };
    assert!(matches!(scenario.problem(demanding), Err(ScenarioError::MarginUnderPaper)));
    let options = OpenOptions { criterion: Some(Criterion::Exact), ..OpenOptions::default() };
    let scenario = Scenario::open(&corner(), &options).unwrap();
    let problem = scenario.problem(demanding).unwrap();
    assert_eq!((problem.criterion(), problem.target()), (Criterion::Exact, Some(3)));
    let negative = Margins { margin_m: -0.005, grasp_margin_m: 0.0, ..Margins::default() };
    assert!(scenario.problem(negative).unwrap_err().to_string().contains("-0.005"));
}
