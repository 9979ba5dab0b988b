use cranny_path::{Audit, PickAudit};
use cranny_task::FoundGrasp;
use serde::{Deserialize, Serialize};

/// Grasp of a later pick, in the same form as that of the first in a plan file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanPick {
    /// Index of the stage.
    pub stage: usize,
    /// Index of the grasp.
    #[serde(default)]
    pub grasp: Option<usize>,
    /// Distance of the gripper from it, in metres.
    #[serde(default)]
    pub translation_error_m: Option<f64>,
    /// Angle between gripper and grasp, in radians.
    #[serde(default)]
    pub rotation_error_rad: Option<f64>,
    /// The grasp, if the planner generated it.
    #[serde(default)]
    pub own_grasp: Option<FoundGrasp>,
}

impl PlanPick {
    fn of(pick: &PickAudit) -> Self {
        Self {
            stage: pick.stage,
            grasp: pick.goal.map(|goal| goal.grasp),
            translation_error_m: pick.goal.map(|goal| goal.translation_error_m),
            rotation_error_rad: pick.goal.map(|goal| goal.rotation_error_rad),
            own_grasp: pick.own_grasp,
        }
    }

    /// Returns the grasps of the picks that follow the first.
    pub(crate) fn all_of(audit: &Audit) -> Vec<Self> {
        audit.picks.iter().skip(1).map(Self::of).collect()
    }
}
