use cranny_grasp::{pose_of_rows, rows_of_pose};
use cranny_spatial::Pose;
use serde::{Deserialize, Serialize};

/// A plan that was tried in simulation: one before the plan of a file, or that plan itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanAttempt {
    /// Seed of the search.
    pub seed: u64,
    /// Fate of the object, or of the object of the first failed pick: `held`, `placed`, `misplaced`, `slipped`, …
    pub outcome: String,
    /// True if each object stayed in the hand until it was released, or to the end.
    pub kept: bool,
    /// True if the whole run went as planned.
    pub as_planned: bool,
    /// The failed grasp, which is excluded from then on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<LeftOut>,
}

/// A grasp that is excluded from a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Index of the stage.
    pub stage: usize,
    /// Pose of the gripper frame in the planning frame, as a homogeneous matrix, row by row (m).
    pub world_from_gripper: [[f64; 4]; 4],
}

impl LeftOut {
    /// Creates the excluded grasp of a stage at a pose of the gripper frame in the planning frame.
    pub fn new(stage: usize, world_from_gripper: &Pose) -> Self {
        let rows = rows_of_pose(world_from_gripper);
        let world_from_gripper = [0, 1, 2, 3].map(|row| std::array::from_fn(|column| rows[4 * row + column]));
        Self { stage, world_from_gripper }
    }

    /// Returns the grasps that the tries before the last one excluded: the stage of each, and the pose of its gripper frame in
    /// the planning frame (`world_from_gripper`).
    pub fn before_last(tries: &[PlanAttempt]) -> Vec<(usize, Pose)> {
        let before = tries.split_last().map_or(&[][..], |(_, before)| before);
        let left_out = before.iter().filter_map(|tried| tried.left_out.as_ref());
        left_out.filter_map(|grasp| Some((grasp.stage, grasp.pose()?))).collect()
    }

    /// Returns the pose of the gripper frame in the planning frame (`world_from_gripper`); `None` for an invalid matrix.
    pub fn pose(&self) -> Option<Pose> {
        let [a, b, c, d] = self.world_from_gripper;
        let rows: [f64; 16] = [a, b, c, d].concat().try_into().ok()?;
        pose_of_rows(&rows).ok()
    }
}
