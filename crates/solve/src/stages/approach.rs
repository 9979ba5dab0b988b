use std::sync::Arc;

use cranny_collision::Cell;
use cranny_plan::Observer;
use cranny_spatial::Pose;
use cranny_task::{FailureReason, Goal, Mode, Problem, Segment, State};

use crate::stages::effort::Effort;
use crate::stages::onward::{Piece, Towards, onward};

/// Shares of the approach at which the hand alone is checked, before any IK.
const CHECKED_AT: [f64; 3] = [1.0, 2.0 / 3.0, 1.0 / 3.0];

/// Returns a check of the hand alone on its straight approach to a pose of the gripper frame in the planning frame, along its z
/// axis over `length_m` (m), at the shares [`CHECKED_AT`].
pub(crate) fn blocked_approach(
    cell: &Arc<Cell>,
    length_m: f64,
) -> impl Fn(&Pose) -> Option<FailureReason> + Send + Sync + use<> {
    let cell = cell.clone();
    move |world_from_tip| {
        let mut scratch = cell.scratch();
        let before =
            CHECKED_AT.iter().map(|share| world_from_tip * Pose::translation(0.0, 0.0, -share * length_m));
        let contact =
            before.map(|pose| cell.hand_contact(&pose, &mut scratch)).find_map(|contact| contact)?;
        let [first, second] = contact.names(&cell);
        Some(FailureReason::ApproachBlocked { first, second })
    }
}

/// A path to a grasp, as pieces, and its way points (m, rad; one value per joint).
pub(crate) struct Approach {
    pub pieces: Vec<Piece>,
    pub led: Vec<Vec<f64>>,
}

/// Returns pieces of a stage that lead to the grasp at the end of `path`. If `length_m` (m) is above 0, the last piece is a
/// straight approach of that length. The path to the start of this line follows `path` as far as it can.
/// # Errors
/// Reason why no such path was found.
pub(crate) fn approach(
    effort: &mut Effort,
    (stage, picking): (usize, &Problem),
    (before, path): (&State, Vec<Vec<f64>>),
    length_m: f64,
    observer: &dyn Observer,
) -> Result<Approach, FailureReason> {
    let towards = |end: &[f64]| {
        let problem = picking.with_goal(Goal::Configurations(vec![end.to_vec()]));
        problem.map_err(|_| FailureReason::ApproachNotReached)
    };
    let end = path.last().cloned().unwrap_or_default();
    if length_m <= 0.0 {
        let reach = (Segment::empty(stage, Mode::REACH, path.clone()), Some(towards(&end)?));
        return Ok(Approach { pieces: vec![reach], led: path });
    }
    let line = before.at(&end).approach(length_m)?;
    let begin = line.first().ok_or(FailureReason::ApproachOutOfReach)?;
    let (mut way, _) = onward(effort, &before.at(begin), &path, &Towards::Begin, observer)
        .map_err(|_| FailureReason::ApproachNotReached)?;
    way.reverse();
    let led = way.iter().chain(&line[1..]).cloned().collect();
    let reach = (Segment::empty(stage, Mode::REACH, way), Some(towards(begin)?));
    let straight = (Segment::empty(stage, Mode::APPROACH, line), None);
    Ok(Approach { pieces: vec![reach, straight], led })
}
