use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cranny_collision::{Cell, Margins};
use cranny_grasp::Grasp;
use cranny_plan::{FailureReason, IkAnnotationSettings, IkStatus, PlanError, annotate_ik};
use cranny_scenario::Scenario;
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
/// 2. Else what so many attempts at each show, by the names of [`IkStatus`]: "solved"; "hand-collides" and
///    "out-of-reach", which are certain; "no-solution", which is not.
///
/// # Errors
/// As [`annotate_ik`].
pub(crate) fn all(
    scenario: &Scenario,
    cell: &Arc<Cell>,
    plans: &[PagePlan],
    attempts: usize,
) -> Result<Vec<PageGrasp>, PlanError> {
    // 1.
    let mut solved = held_by_files(scenario, cell);
    for plan in plans {
        let is_held = |reason: &FailureReason| matches!(reason, FailureReason::NotConnected { .. });
        let held =
            plan.failures.iter().filter(|failure| is_held(&failure.reason)).map(|failure| failure.grasp);
        for grasp in held.chain(plan.grasp()) {
            if let Some(solved) = solved.get_mut(grasp) {
                *solved = true;
            }
        }
    }
    // 2.
    let exact = Scenario { criterion: cranny_plan::Criterion::Exact, ..scenario.clone() };
    let problem = exact.problem(Margins::default()).map_err(|_| PlanError::Annotation)?;
    let settings = IkAnnotationSettings { attempts, ..IkAnnotationSettings::default() };
    let annotations = annotate_ik(&problem, &settings, &|| (), &AtomicBool::new(false))?;
    let statuses = annotations
        .iter()
        .zip(solved)
        .map(|(annotation, solved)| if solved { IkStatus::Solved.name() } else { annotation.status.name() });
    let grasps = scenario.grasps.grasps().iter().zip(statuses).enumerate();
    let page_grasp = |(index, (grasp, ik)): (usize, (&Grasp, &'static str))| PageGrasp {
        index,
        world_from_gripper: number_row::pose(&grasp.world_from_gripper),
        score: grasp.score,
        width_m: grasp.width_m,
        ik,
    };
    Ok(grasps.map(page_grasp).collect())
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
            *held |= grasp.difference(gripper).is_exact();
        }
    }
    held
}
