use cranny_grasp::{Grasp, GraspSet};
use cranny_task::{FailureReason, IkStatus};
use serde::Serialize;

use crate::{PagePlan, viewer::number_row};

/// Grasp of a page with the known result of its inverse kinematics.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PageGrasp {
    index: usize,
    world_from_gripper: [f64; 7],
    score: Option<f64>,
    width_m: Option<f64>,
    load: Option<f64>,
    ik: &'static str,
}

/// Returns all grasps with the names of their statuses. A grasp also counts as "solved" if a valid plan ends there, or if a
/// failed search found a free configuration that reaches it.
pub(crate) fn all(grasps: &GraspSet, statuses: &[IkStatus], plans: &[PagePlan]) -> Vec<PageGrasp> {
    let mut names: Vec<&'static str> = statuses.iter().map(IkStatus::name).collect();
    for plan in plans {
        let is_held = |reason: &FailureReason| matches!(reason, FailureReason::NotConnected { .. });
        let held =
            plan.failures.iter().filter(|failure| is_held(&failure.reason)).map(|failure| failure.grasp);
        for grasp in held.chain(plan.grasp()) {
            if let Some(name) = names.get_mut(grasp) {
                *name = IkStatus::Solved.name();
            }
        }
    }
    let grasps = grasps.grasps().iter().zip(names).enumerate();
    let page_grasp = |(index, (grasp, ik)): (usize, (&Grasp, &'static str))| PageGrasp {
        index,
        world_from_gripper: number_row::pose(&grasp.world_from_gripper),
        score: grasp.score,
        width_m: grasp.width_m,
        load: grasp.load,
        ik,
    };
    grasps.map(page_grasp).collect()
}
