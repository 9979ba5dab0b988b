use cranny_collision::Cell;
use cranny_grasp::Grasp;
use cranny_plan::{FailureReason, GraspFailure};
use cranny_scenario::Scenario;
use cranny_spatial::{Point, PoseDifference};
use serde::Serialize;

use crate::{PagePlan, number_row};

/// A grasp of a page, and what is known of inverse kinematics there.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PageGrasp {
    index: usize,
    world_from_gripper: [f64; 7],
    score: Option<f64>,
    width_m: Option<f64>,
    ik: &'static str,
}

/// All grasps of the scenario.
///
/// 1. "solved" where a valid plan ends, or a free configuration of the scenario's files or of a failed search
///    holds the grasp.
/// 2. "hand-collides" and "out-of-reach" where that is certain, whatever the arm does.
/// 3. "not-found" where a failed search tried and came to no free configuration; else "unknown".
pub(crate) fn all(scenario: &Scenario, cell: &Cell, plans: &[PagePlan]) -> Vec<PageGrasp> {
    let mut scratch = cell.scratch();
    let held = held_by_files(scenario, cell);
    let reach = scenario.robot.reach_bound();
    let failures: Vec<&GraspFailure> = plans.iter().flat_map(|plan| &plan.failures).collect();
    let mut status = |index: usize, grasp: &Grasp| {
        let of_failures = || failures.iter().filter(|failure| failure.grasp == index);
        let is_connected_to = |f: &&&GraspFailure| matches!(f.reason, FailureReason::NotConnected { .. });
        if held[index]
            || plans.iter().any(|plan| plan.grasp() == Some(index))
            || of_failures().any(|failure| is_connected_to(&failure))
        {
            return "solved";
        }
        let hand_is_free =
            |grasp: &Grasp, scratch: &mut _| cell.hand_is_free(&grasp.world_from_gripper, scratch);
        if !hand_is_free(grasp, &mut scratch) && !hand_is_free(&grasp.twin(), &mut scratch) {
            return "hand-collides";
        }
        if reach.beyond_m(&Point::from(grasp.world_from_gripper.translation.vector)) > 0.0 {
            return "out-of-reach";
        }
        if of_failures().any(|failure| failure.attempts > 0) { "not-found" } else { "unknown" }
    };
    let grasps = scenario.grasps.grasps().iter().enumerate();
    grasps
        .map(|(index, grasp)| PageGrasp {
            index,
            world_from_gripper: number_row::pose(&grasp.world_from_gripper),
            score: grasp.score,
            width_m: grasp.width_m,
            ik: status(index, grasp),
        })
        .collect()
}

/// Whether a configuration of the scenario's files holds each grasp freely.
fn held_by_files(scenario: &Scenario, cell: &Cell) -> Vec<bool> {
    let mut scratch = cell.scratch();
    let mut held = vec![false; scenario.grasps.len()];
    for q in &scenario.ik {
        if q.len() != scenario.robot.dof() || !cell.is_free(q, &mut scratch) {
            continue;
        }
        let gripper = scratch.frames().link(scenario.robot.tip());
        for (held, grasp) in held.iter_mut().zip(scenario.grasps.grasps()) {
            let difference: PoseDifference = grasp.difference(gripper);
            *held |= difference.is_exact();
        }
    }
    held
}
