use cranny_task::OwnGrasp;
use serde::Serialize;

use crate::GoalError;

/// Grasp at which the path of a pick ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PickAudit {
    /// Index of the stage.
    pub stage: usize,
    /// The nearest of the given grasps.
    pub goal: Option<GoalError>,
    /// The grasp that the hand takes, where no set of them is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_grasp: Option<OwnGrasp>,
    /// Number of the way point.
    pub way_point: usize,
}
