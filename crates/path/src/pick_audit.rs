use cranny_task::FoundGrasp;
use serde::Serialize;

use crate::GoalError;

/// Grasp at which the path of a pick ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PickAudit {
    /// Index of the stage.
    pub stage: usize,
    /// Error relative to the nearest of the given grasps.
    pub goal: Option<GoalError>,
    /// Grasp that the hand takes, if no set of grasps is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_grasp: Option<FoundGrasp>,
    /// Index of the way point.
    pub way_point: usize,
}
