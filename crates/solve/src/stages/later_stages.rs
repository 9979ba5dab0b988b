use std::sync::Arc;

use cranny_spatial::Pose;
use cranny_task::{Carrier, FailureReason, Problem, Stage};

use crate::stages::place_search::PlaceSearch;

/// Returns a check of grasps, by the pose of the tip in the planning frame, against `stages`, those after a pick: the reason why
/// the object cannot be at the ends of the next moves, or at its placements.
pub(crate) fn blocked_after(
    (problem, stages): (&Problem, &[Stage]),
    carrier: &Arc<Carrier>,
    places: Option<&Arc<PlaceSearch>>,
) -> impl Fn(&Pose) -> Option<FailureReason> + Send + Sync + use<> {
    let (carrier, places) = (carrier.clone(), places.cloned());
    let moves = stages.iter().map_while(|stage| match stage {
        Stage::Move(goal) => Some(goal.ends(problem)),
        Stage::Pick(_) | Stage::Place(_) => None,
    });
    let ends: Vec<Vec<Vec<f64>>> = moves.flatten().collect();
    move |world_from_tip| {
        places
            .as_ref()
            .and_then(|places| places.blocked_at(world_from_tip))
            .or_else(|| ends.iter().find_map(|ends| carrier.blocked_at(world_from_tip, ends)))
    }
}

/// Names the stage of a reason, from the third one on: the motions with the object of a first pick need no name.
pub(crate) fn of_stage(index: usize, because: FailureReason) -> FailureReason {
    match because {
        FailureReason::Later { .. } => because,
        because if index < 2 => because,
        because => FailureReason::Later { stage: index, because: Box::new(because) },
    }
}

/// Returns true if a pick after the stage `index` failed, or a stage after such a pick.
pub(crate) fn is_of_later_pick(stages: &[Stage], index: usize, reason: &FailureReason) -> bool {
    let FailureReason::Later { stage, .. } = reason else { return false };
    let mut later = stages.iter().take(stage + 1).skip(index + 1);
    later.any(|stage| matches!(stage, Stage::Pick(_)))
}
