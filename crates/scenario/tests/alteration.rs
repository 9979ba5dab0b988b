//! Scenarios derived from others, and written in Cranny's and other formats.

use cranny_collision::{Body, Margins};
use cranny_scenario::{
    MoveItProblem, OpenOptions, Scenario, ScenarioError, moveit_scene_text, read_moveit_scene,
    write_moveit_scene,
};
use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::{Pose, Vector};
use cranny_task::Criterion;

fn opened(id: &str) -> Scenario {
    Scenario::open(id, &OpenOptions::default()).unwrap()
}

fn crate_body() -> Body {
    let pose = Pose::new(Vector::new(0.3, -0.5, 0.2), Vector::new(0.1, 0.2, 0.3));
    Body::new("crate", pose, Solid::cuboid(Vector::new(0.1, 0.2, 0.3)).unwrap())
}

fn names(scenario: &Scenario) -> Vec<&str> {
    scenario.world.bodies().iter().map(|body| body.name.as_str()).collect()
}

#[test]
fn an_obstacle_comes_before_the_target_and_goes_again() {
    let scenario = opened("021");
    let more = scenario.with_body(crate_body()).unwrap();
    assert_eq!(names(&more), ["table", "crate", "ball", "floor"]);
    assert_eq!(more.target.map(|target| more.world.bodies()[target].name.as_str()), Some("ball"));
    assert!(matches!(more.with_body(crate_body()), Err(ScenarioError::BodyName { .. })));
    let again = more.without_body("crate").unwrap();
    assert_eq!((names(&again), again.target), (names(&scenario), scenario.target));
    let bare = again.without_body("ball").unwrap();
    assert!(bare.target.is_none() && bare.without_body("ball").is_err());
    assert!(matches!(bare.with_target_moved(&Pose::identity()), Err(ScenarioError::NoTarget { .. })));
    let without_target = bare.with_body(crate_body()).unwrap();
    assert_eq!(names(&without_target), ["table", "crate", "floor"]);
}

#[test]
fn a_target_takes_its_grasps_along_and_leaves_the_export_behind() {
    let scenario = opened("021");
    let motion = Pose::new(Vector::new(0.0, 0.1, 0.0), Vector::new(0.0, 0.0, 0.5));
    let moved = scenario.with_target_moved(&motion).unwrap();
    let place = |scenario: &Scenario| {
        let body = &scenario.world.bodies()[scenario.target.unwrap()];
        body.parts[0].world_from_solid.inverse() * scenario.grasps.grasps()[7].world_from_gripper
    };
    assert!((place(&scenario).to_homogeneous() - place(&moved).to_homogeneous()).amax() < 1e-12);
    assert!(moved.export.is_none() && moved.ik.is_empty());
    assert!(scenario.with_target_moved(&Pose::translation(1e9, 0.0, 0.0)).is_err());
    assert!(matches!(scenario.with_start(vec![0.0]), Err(ScenarioError::StartCount { .. })));
}

#[test]
fn what_was_altered_is_written_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("altered");
    let altered = Scenario { criterion: Criterion::Paper, ..opened("043").with_body(crate_body()).unwrap() };
    altered.write_folder(&path).unwrap();
    let read = Scenario::open(path.to_str().unwrap(), &OpenOptions::default()).unwrap();
    assert_eq!(names(&read), names(&altered));
    assert_eq!(
        (read.criterion, &read.start, read.target),
        (Criterion::Paper, &altered.start, altered.target)
    );
    assert_eq!(read.grasps.len(), altered.grasps.len());
    assert!(matches!(altered.write_folder(&path), Err(ScenarioError::Exists { .. })));
    let floorless = altered.without_body("floor").unwrap();
    let nowhere = folder.path().join("floorless");
    assert!(matches!(floorless.write_folder(&nowhere), Err(ScenarioError::OtherFloor { .. })));
    assert!(!nowhere.exists());
}

/// Round shapes, a hull and a mesh keep their clearances in a round trip.
#[test]
fn a_world_survives_a_planning_scene() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenario = opened("044").with_body(crate_body()).unwrap();
    let at = |x: f64| Pose::new(Vector::new(x, 0.6, 0.4), Vector::new(0.4, 0.1, 0.2));
    let cube = TriangleSoup::convex_hull(
        &[-0.1, 0.1].map(|x| [-0.1, 0.1].map(|y| [-0.1, 0.1].map(|z| [x, y, z].into()))).concat().concat(),
    )
    .unwrap();
    for (name, x, solid) in [
        ("ball", 0.2, Solid::sphere(0.1)),
        ("post", 0.4, Solid::cylinder(0.3, 0.05)),
        ("rail", 0.6, Solid::capsule(0.2, 0.05)),
        ("hull", 0.8, Solid::hull(&cube.vertices)),
        ("mesh", 1.0, Solid::mesh(&cube)),
    ] {
        scenario = scenario.with_body(Body::new(name, at(x), solid.unwrap())).unwrap();
    }
    let path = folder.path().join("scene.yaml");
    write_moveit_scene(&path, "044", &scenario.robot, &scenario.world, &scenario.start).unwrap();
    let world = read_moveit_scene(&path, &scenario.robot).unwrap();
    let read = Scenario { world, ..scenario.clone() };
    assert_eq!(names(&read), names(&scenario));
    let clearances = [&scenario, &read].map(|scenario| {
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().expect("the exact criterion is the default");
        let mut scratch = cell.scratch();
        let mut clearance = |scale: f64| {
            let q: Vec<f64> = scenario.start.iter().map(|value| value * scale).collect();
            cell.clearance(&q, &mut scratch)
        };
        [1.0, 0.9, 0.5, 0.2, 0.0].map(&mut clearance)
    });
    for (here, there) in clearances[0].iter().zip(&clearances[1]) {
        // Distances are certified to less than this for all kinds of solids.
        assert!((here - there).abs() < 1e-6, "{clearances:?}");
    }
}

#[test]
fn a_planning_scene_is_one_that_a_request_can_stand_beside() {
    let scenario = opened("031");
    let text =
        moveit_scene_text("a \"quoted\" name", &scenario.robot, &scenario.world, &scenario.start).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (scene, request) = (folder.path().join("scene.yaml"), folder.path().join("request.yaml"));
    std::fs::write(&scene, text).unwrap();
    std::fs::write(&request, "group_name: none\n").unwrap();
    // The scene is read; only the robot's files beside it are missing.
    let fault =
        MoveItProblem::open(&scene, &request, &cranny_scenario::MoveItOptions::default()).unwrap_err();
    assert!(fault.to_string().contains("urdf"), "{fault}");
}
