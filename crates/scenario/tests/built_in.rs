//! The built-in scenarios, which need no file.

use cranny_collision::{Body, Cell, Margins, World};
use cranny_plan::{Criterion, Validity};
use cranny_scenario::{Demands, OpenOptions, Scenario, ScenarioError, catalogue};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Vector};

#[test]
fn every_built_in_scenario_opens_with_a_free_start_under_both_criteria() {
    for entry in catalogue() {
        for criterion in [Criterion::Exact, Criterion::Paper] {
            let options = OpenOptions { criterion: Some(criterion), ..OpenOptions::default() };
            let scenario = Scenario::open(entry.id, &options).unwrap();
            assert_eq!(scenario.id, entry.id);
            let problem = scenario.problem(&Demands::default()).unwrap();
            let mut scratch = problem.validity.scratch();
            assert!(problem.validity.is_free(&problem.start, &mut scratch), "{} {criterion:?}", entry.id);
        }
    }
}

#[test]
fn the_ball_moves_back_under_a_table_of_three_boxes() {
    let ids = ["021", "022", "023", "024", "025"];
    assert!(catalogue().iter().map(|entry| entry.id).eq(ids));
    for (level, id) in ids.into_iter().enumerate() {
        let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
        let [table, ball, floor] = scenario.world.bodies() else { panic!("three bodies") };
        let sizes: Vec<Vector> =
            table.parts.iter().map(|part| part.solid.as_cuboid().unwrap() * 2.0).collect();
        let leg = Vector::new(0.1, 0.8, 0.4);
        for (size, expected) in sizes.iter().zip([leg, leg, Vector::new(2.0, 0.8, 0.1)]) {
            assert!((size - expected).norm() < 1e-12, "{size}");
        }
        let boxes = table.parts.iter().map(|part| part.solid.aabb().transformed(&part.world_from_solid));
        let (low, high) = boxes.fold((Vector::repeat(9.0), Vector::repeat(-9.0)), |(low, high), aabb| {
            (low.inf(&aabb.low().coords), high.sup(&aabb.high().coords))
        });
        assert!((low - Vector::new(0.6, -1.0, -0.05)).norm() < 1e-12, "{low}");
        assert!((high - Vector::new(1.4, 1.0, 0.45)).norm() < 1e-12, "{high}");
        let center = ball.parts[0].world_from_solid.translation.vector;
        assert!((center - Vector::new(0.8 + 0.1 * level as f64, 0.0, -0.016)).norm() < 1e-12, "{center}");
        assert!((floor.parts[0].world_from_solid.translation.z + 0.05).abs() < 1e-12);
        assert_eq!(scenario.world.supports_of(1), [2]);
        assert_eq!(scenario.target, Some(1));
    }
}

#[test]
fn grasps_hold_the_ball_from_all_sides_and_are_the_same_at_every_level() {
    let open = |id: &str| Scenario::open(id, &OpenOptions::default()).unwrap();
    let (first, last) = (open("021"), open("025"));
    assert_eq!(first.grasps.len(), 200);
    let mut mean_axis = Vector::zeros();
    for (near, far) in first.grasps.grasps().iter().zip(last.grasps.grasps()) {
        let (near, far) = (near.world_from_gripper, far.world_from_gripper);
        assert_eq!(near.rotation, far.rotation);
        assert!(
            (far.translation.vector - near.translation.vector - Vector::new(0.4, 0.0, 0.0)).norm() < 1e-12
        );
        mean_axis += near.rotation * Vector::y() / 200.0;
    }
    assert!(mean_axis.norm() < 0.15, "{mean_axis}");
    assert!(first.grasps.grasps().iter().all(|g| g.score.is_none() && g.width_m == Some(0.0647)));
}

#[test]
fn the_open_hand_holds_the_ball_without_touching_it() {
    let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
    let grasps = scenario.grasps.grasps();
    let ball = Body::new(
        "ball",
        Pose::from(grasps[0].world_from_gripper.translation),
        Solid::sphere(0.03235).unwrap(),
    );
    let world = World::new(vec![ball]).unwrap();
    let margins = Margins { hand_links: scenario.hand_links.clone(), ..Margins::default() };
    let cell = Cell::new(scenario.robot.clone(), world, margins).unwrap();
    let mut scratch = cell.scratch();
    for grasp in grasps {
        assert!(cell.hand_is_free(&grasp.world_from_gripper, &mut scratch));
    }
}

#[test]
fn many_grasps_leave_room_for_the_hand_between_floor_and_table() {
    for entry in catalogue() {
        let scenario = Scenario::open(entry.id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(&Demands::default()).unwrap();
        let Validity::Exact(cell) = &problem.validity else { panic!("exact is the default") };
        let mut scratch = cell.scratch();
        let free = |g: &&cranny_grasp::Grasp| cell.hand_is_free(&g.world_from_gripper, &mut scratch);
        let free = scenario.grasps.grasps().iter().filter(free).count();
        assert!(free >= 40, "{}: {free} of 200", entry.id);
    }
}

#[test]
fn a_name_that_means_nothing_is_answered_with_what_there_is() {
    let fault = Scenario::open("0x1", &OpenOptions::default()).unwrap_err();
    assert!(matches!(fault, ScenarioError::Unknown { .. }));
    let text = fault.to_string();
    assert!(text.contains("no built-in scenario '0x1' (there are 021, 022, 023, 024, 025)"), "{text}");
    let empty = tempfile::tempdir().unwrap();
    let fault = Scenario::open(empty.path().to_str().unwrap(), &OpenOptions::default()).unwrap_err();
    assert!(fault.to_string().contains("neither scenario.yaml"), "{fault}");
}
