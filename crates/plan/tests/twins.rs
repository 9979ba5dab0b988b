//! Grasps that are reached only at their twins.

use cranny_path::audit;
use cranny_plan::Outcome;
use cranny_task::Problem;

use crate::fixture::{OBJECT, START, arm, block, exact, finned_arm, grasp_at, grasps, off, plan, still_life};

/// Checks that a problem is solved only by the twin: the gripper ends rotated by about half a turn from the grasp itself.
fn assert_solved_at_the_twin(name: &str, problem: &Problem, grasp: cranny_grasp::Grasp) {
    let report = plan(name, problem, 1_000_000, 3);
    assert_eq!(report.outcome, Outcome::Solved, "{name}");
    assert!(audit(problem, &report.path).is_ok_and(|verification| verification.valid), "{name}");
    let end = report.path.last().expect("a path has way points");
    assert!(off(problem, end, &grasp.world_from_gripper).rotation_rad > 3.0, "{name}");
    assert!(off(problem, end, &grasp.twin().world_from_gripper).is_exact(), "{name}");
}

#[test]
fn a_grasp_that_only_its_twin_brings_into_reach_is_solved() {
    let grasp = grasp_at(OBJECT, 0.8).twin();
    let problem = exact(&arm(), still_life(), &START, grasps(vec![grasp]));
    for name in ["reach", "ik-rrt"] {
        assert_solved_at_the_twin(name, &problem, grasp);
    }
}

#[test]
fn a_grasp_at_which_only_the_twin_of_an_uneven_hand_is_free_is_solved() {
    let [x, y, z] = OBJECT;
    let mut bodies = still_life();
    bodies.push(block("lid", [x, y, z + 0.12], [0.2, 0.2, 0.05]));
    let grasp = grasp_at(OBJECT, 0.8);
    let problem = exact(&finned_arm(), bodies.clone(), &START, grasps(vec![grasp]));
    for name in ["reach", "ik-rrt"] {
        assert_solved_at_the_twin(name, &problem, grasp);
    }
    // Without the lid the fin may point upwards, so the lid alone decides.
    bodies.pop();
    let problem = exact(&finned_arm(), bodies, &START, grasps(vec![grasp]));
    let seen_upright = (0..10).any(|seed| {
        let report = plan("reach", &problem, 1_000_000, seed);
        report.path.last().is_some_and(|end| off(&problem, end, &grasp.world_from_gripper).is_exact())
    });
    assert!(seen_upright);
}
