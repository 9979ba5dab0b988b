//! Quick IK status of each grasp: from attempts, and from known configurations.

use std::sync::atomic::AtomicBool;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::ik_statuses;
use cranny_spatial::nalgebra::Unit;
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Pose, Rotation, Stream, Vector};
use cranny_task::{IkAnnotationSettings, IkStatus, annotate_ik};

#[test]
fn a_known_configuration_solves_the_grasps_that_it_holds() {
    let scenario = Scenario::open("015", &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let few = ik_statuses(&problem, &[]).unwrap();
    let many =
        annotate_ik(&problem, &IkAnnotationSettings::default(), &|| (), &AtomicBool::new(false)).unwrap();
    let hard = many.iter().find(|grasp| !grasp.solutions.is_empty() && few[grasp.grasp] != IkStatus::Solved);
    let hard = hard.expect("a grasp that few attempts do not solve");
    // Configurations of another robot are skipped.
    let known = [vec![0.0], hard.solutions[0].q.clone()];
    let told = ik_statuses(&problem, &known).unwrap();
    assert_eq!(told[hard.grasp], IkStatus::Solved);
    let others = told.iter().zip(&few).filter(|(told, few)| told != few);
    assert!(others.clone().all(|(told, _)| *told == IkStatus::Solved) && others.count() > 0);
}

#[test]
fn where_a_hand_is_proven_blocked_it_touches_at_every_pose_within_the_tolerance() {
    let mut random = Stream::new(5, 0);
    let (mut proven, mut by_boxes, mut open) = (0, 0, 0);
    for id in ["014", "023", "034", "044"] {
        let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().unwrap();
        let mut scratch = cell.scratch();
        for grasp in problem.grasps().unwrap().grasps() {
            // Moved towards the support, in steps of a few millimetres, so that it touches shallowly and deeply.
            for step in 0..8 {
                let sunk = Pose::translation(0.0, 0.0, -4e-3 * f64::from(step)) * grasp.world_from_gripper;
                let tolerance = (EXACT_TRANSLATION_M, EXACT_ROTATION_RAD);
                let at_once = cell.hand_is_blocked_near(&sunk, tolerance, 1, &mut scratch);
                if !cell.hand_is_blocked_near(&sunk, tolerance, 200, &mut scratch) {
                    assert!(!at_once, "{id}");
                    open += 1;
                    continue;
                }
                proven += 1;
                by_boxes += usize::from(!at_once);
                for _ in 0..4 {
                    let way = Vector::from_fn(|_, _| random.normal()).normalize() * EXACT_TRANSLATION_M;
                    let axis = Unit::new_normalize(Vector::from_fn(|_, _| random.normal()));
                    let turn = Rotation::from_axis_angle(&axis, EXACT_ROTATION_RAD);
                    let near = Pose::from_parts((sunk.translation.vector + way).into(), turn * sunk.rotation);
                    assert!(!cell.hand_is_free(&near, &mut scratch), "{id}");
                }
            }
        }
    }
    assert!(proven > 500 && by_boxes > 50 && open > 300, "{proven} proven, {by_boxes} by boxes, {open} open");
}
