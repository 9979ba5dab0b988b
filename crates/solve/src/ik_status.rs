use std::sync::atomic::AtomicBool;

use cranny_plan::PlanError;
use cranny_task::{IkAnnotationSettings, IkStatus, Problem, annotate_ik};

/// Number of attempts at each grasp. They find nine tenths of the solutions, in some tens of milliseconds for all grasps of a
/// released scenario.
const ATTEMPTS: usize = 200;

/// Returns a quick IK status of each grasp of an `exact` problem.
///
/// 1. [`IkStatus::Solved`] if one of the configurations `known` (m, rad; one value per joint) is a collision-free solution.
///    Configurations with another number of values are skipped.
/// 2. Otherwise the result of a few attempts of inverse kinematics: [`IkStatus::OutOfReach`] is certain,
///    [`IkStatus::HandCollides`] at the pose of the grasp itself, [`IkStatus::NoSolution`] is not.
///
/// # Errors
/// As [`annotate_ik`].
pub fn ik_statuses(problem: &Problem, known: &[Vec<f64>]) -> Result<Vec<IkStatus>, PlanError> {
    let settings = IkAnnotationSettings { attempts: ATTEMPTS, ..IkAnnotationSettings::default() };
    let annotations = annotate_ik(problem, &settings, &|| (), &AtomicBool::new(false))?;
    let mut statuses: Vec<IkStatus> = annotations.into_iter().map(|annotation| annotation.status).collect();
    let (Some(grasps), Some(cell)) = (problem.grasps(), problem.cell()) else {
        return Ok(statuses);
    };
    let mut scratch = cell.scratch();
    for q in known {
        if q.len() != problem.robot().dof() || !cell.is_free(q, &mut scratch) {
            continue;
        }
        let frames = problem.robot().frames_at(q);
        let gripper = frames.link(problem.robot().tip());
        for (status, grasp) in statuses.iter_mut().zip(grasps.grasps()) {
            if grasp.difference(gripper).is_exact() {
                *status = IkStatus::Solved;
            }
        }
    }
    Ok(statuses)
}
