use cranny_collision::Collider;
use cranny_file::counted;
use serde::{Deserialize, Serialize};

use crate::course::clearance_profile::PairNames;
use crate::{PageCells, viewer::number_row};

/// Request of a page for the check of a configuration.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VerdictQuestion {
    /// Configuration, one value per joint (m, rad).
    pub q: Vec<f64>,
    /// Segment of a plan; absent before any motion and for a manually set configuration.
    #[serde(default)]
    pub during: Option<DuringQuestion>,
}

/// Segment of a plan whose state (held object and other bodies) applies.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DuringQuestion {
    /// Index of the plan.
    pub plan: usize,
    /// Index of the segment.
    pub segment: usize,
}

/// Result of the exact check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Verdict {
    is_free: bool,
    clearance_m: Option<f64>,
    contacts: Vec<PairNames>,
    world_from_gripper: [f64; 7],
}

/// Errors of a request.
#[derive(Debug, thiserror::Error)]
pub(crate) enum QuestionError {
    #[error("the question is no JSON of the form {{\"q\": [numbers]}}: {0}")]
    Malformed(#[from] serde_json::Error),
    #[error("'q' has {}, but the robot has {}: {joints}", counted(*actual, "value"), counted(*expected, "joint"))]
    JointCount { expected: usize, actual: usize, joints: String },
    #[error("value {index} of 'q' is not finite")]
    NotFinite { index: usize },
    #[error("plan {plan} has no segment {segment}")]
    NotDone { plan: usize, segment: usize },
}

/// Answers a request with the content `body`.
pub(crate) fn answer(cells: &PageCells, body: &[u8]) -> Result<Verdict, QuestionError> {
    let VerdictQuestion { q, during } = serde_json::from_slice(body)?;
    let cell = match during {
        None => cells.empty(),
        Some(DuringQuestion { plan, segment }) => {
            cells.during(plan, segment).ok_or(QuestionError::NotDone { plan, segment })?
        }
    };
    let robot = cell.robot();
    if q.len() != robot.dof() {
        let joints = robot.joint_names().join(", ");
        return Err(QuestionError::JointCount { expected: robot.dof(), actual: q.len(), joints });
    }
    if let Some(index) = q.iter().position(|value| !value.is_finite()) {
        return Err(QuestionError::NotFinite { index });
    }
    let mut scratch = cell.scratch();
    let name = |collider: Collider| cell.name(collider).to_owned();
    let touching = cell.contacts(&q, &mut scratch);
    let mut contacts: Vec<PairNames> =
        touching.iter().map(|c| PairNames { first: name(c.first), second: name(c.second) }).collect();
    let beyond = robot.limits().iter().zip(&q).zip(robot.joint_names());
    contacts.extend(
        beyond
            .filter(|((limits, value), _)| !limits.contain(**value))
            .map(|(_, joint)| PairNames { first: joint.clone(), second: "joint limit".to_owned() }),
    );
    let closest = cell.closest(&q, &mut scratch);
    Ok(Verdict {
        is_free: cell.is_free(&q, &mut scratch),
        clearance_m: closest.map(|closest| closest.distance_m),
        contacts,
        world_from_gripper: {
            let frames = robot.frames_at(&q);
            number_row::pose(frames.link(robot.tip()))
        },
    })
}
