//! Built-in scenarios, which need no file.

use std::collections::BTreeSet;

use cranny_collision::{Body, Collider, Margins};
use cranny_scenario::{Family, OpenOptions, Scenario, ScenarioError, catalogue};
use cranny_shape::Aabb;
use cranny_spatial::Vector;
use cranny_task::Criterion;

#[test]
fn every_built_in_scenario_opens_with_a_free_start() {
    for entry in catalogue() {
        for criterion in [Criterion::Exact, Criterion::Paper] {
            let options = OpenOptions { criterion: Some(criterion), ..OpenOptions::default() };
            let scenario = Scenario::open(entry.id, &options).unwrap();
            assert_eq!(scenario.id, entry.id);
            let problem = scenario.problem(Margins::default()).unwrap();
            let is_free = problem.start_is_free();
            // The boxes around the built-in robot's links are larger than the released ones: under `paper` they touch the two
            // lowest gates.
            let is_low = criterion == Criterion::Paper && ["044", "045"].contains(&entry.id);
            assert_eq!(is_free, !is_low, "{} {criterion:?}", entry.id);
        }
    }
}

/// Names of obstacles with their number of cuboids, the centre of the target's bounds in the scene as in the paper's release,
/// along x and y, and the height of its support.
fn expected(family: Family, level: f64) -> (Vec<(&'static str, usize)>, [f64; 2], f64) {
    match family {
        Family::Shelf => (vec![("table", 3), ("shelf", 3)], [0.993, 0.713 + 0.1 * level], 0.5),
        Family::Table => (vec![("table", 3)], [1.0, 0.8 + 0.1 * level], 0.0),
        Family::Gap => (vec![("left wall", 1), ("right wall", 1)], [0.912, 0.744], 0.0),
        Family::Gate => (vec![("gate", 3), ("pedestal", 1)], [1.002, 1.242], 0.5),
    }
}

fn open(id: &str) -> Scenario {
    Scenario::open(id, &OpenOptions::default()).unwrap()
}

/// Low and high corner of a body, in the scene.
fn bounds_in_scene(body: &Body) -> (Vector, Vector) {
    // The robot's root is at (1, 0, 0.05) m, rotated by a quarter turn.
    let to_scene = |v: Vector| Vector::new(1.0 - v.y, v.x, v.z + 0.05);
    let boxes = body.parts.iter().map(|part| match part.solid.bounding_points() {
        Some((points, radius_m)) => Aabb::around(
            points.iter().map(|p| part.world_from_solid * p).collect::<Vec<_>>().iter(),
            radius_m,
        ),
        None => panic!("{} is bounded", body.name),
    });
    let infinity = Vector::repeat(f64::INFINITY);
    boxes.fold((infinity, -infinity), |(low, high), aabb| {
        let (a, b) = (to_scene(aabb.low().coords), to_scene(aabb.high().coords));
        (low.inf(&a.inf(&b)), high.sup(&a.sup(&b)))
    })
}

#[test]
fn the_twenty_are_the_papers_in_size_and_place() {
    assert_eq!(catalogue().len(), 20);
    for (index, entry) in catalogue().iter().enumerate() {
        assert_eq!(entry.id, format!("0{}{}", index / 5 + 1, index % 5 + 1));
        let scenario = open(entry.id);
        let (obstacles, middle, support_m) = expected(entry.family, (index % 5) as f64);
        let target = scenario.target.unwrap();
        let bodies = scenario.world.bodies();
        let found: Vec<_> = bodies[..target].iter().map(|b| (b.name.as_str(), b.parts.len())).collect();
        assert_eq!(found, obstacles, "{}", entry.id);
        let (low, high) = bounds_in_scene(&bodies[target]);
        let off = (low + high) * 0.5 - Vector::new(middle[0], middle[1], 0.0);
        assert!(off.x.abs() < 1e-6 && off.y.abs() < 1e-6, "{}: {off}", entry.id);
        assert!((low.z - support_m).abs() < 1e-6, "{}: rests at {}", entry.id, low.z);
        assert_eq!(bodies[target + 1].name, "floor");
        let (first, second) = (bounds_in_scene(&bodies[0]), bounds_in_scene(&bodies[1]));
        let dial_m = match entry.family {
            Family::Shelf | Family::Table => (low + high).y * 0.5 - first.0.y,
            Family::Gap => second.0.x - first.1.x,
            Family::Gate => 2.0 * bodies[0].parts[0].world_from_solid.translation.z + 0.1,
        };
        assert!((dial_m - entry.parameter_m).abs() < 1e-6, "{}: {dial_m}", entry.id);
    }
}

#[test]
fn every_grasp_is_scored_and_free_for_the_hand() {
    for entry in catalogue() {
        let scenario = open(entry.id);
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().expect("exact is the default");
        let mut scratch = cell.scratch();
        let wrist = scenario.robot.link_index("panda_link7").unwrap();
        assert_eq!(scenario.grasps.len(), 200);
        for grasp in scenario.grasps.grasps() {
            assert!(grasp.score.is_some_and(|score| (0.0..=1.0).contains(&score)));
            assert!(grasp.width_m.is_some_and(|width_m| width_m > 0.0 && width_m <= 0.08));
            // The link that carries the hand may collide: the sets are those of a hand alone.
            let is_free = [grasp.world_from_gripper, grasp.twin().world_from_gripper].iter().any(|pose| {
                let contact = cell.hand_contact(pose, &mut scratch);
                contact.is_none_or(|contact| contact.first == Collider::Link(wrist))
            });
            assert!(is_free, "{}", entry.id);
        }
        let scores: BTreeSet<u64> =
            scenario.grasps.grasps().iter().filter_map(|g| g.score).map(f64::to_bits).collect();
        assert!(scores.len() > 10, "{}: {} different scores", entry.id, scores.len());
    }
}

#[test]
fn a_name_that_means_nothing_is_answered_with_what_there_is() {
    let fault = Scenario::open("0x1", &OpenOptions::default()).unwrap_err();
    assert!(matches!(fault, ScenarioError::Unknown { .. }));
    let text = fault.to_string();
    assert!(text.contains("no built-in scenario '0x1' (there are 011, 012,"), "{text}");
    let empty = tempfile::tempdir().unwrap();
    let fault = Scenario::open(empty.path().to_str().unwrap(), &OpenOptions::default()).unwrap_err();
    assert!(fault.to_string().contains("neither scenario.yaml"), "{fault}");
}
