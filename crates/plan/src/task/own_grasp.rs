use cranny_grasp::pose_of_rows;
use cranny_spatial::{Pose, PoseDifference};
use serde::{Deserialize, Serialize};

/// A grasp that a path ends at where no set of grasps is given: as it is measured, or as somebody says that it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnGrasp {
    /// Pose of the gripper frame in the planning frame, as a homogeneous matrix, row by row (m): as files have it, so that
    /// it is read back bit by bit. What somebody says need not be a pose.
    pub world_from_gripper: [[f64; 4]; 4],
    /// How far the fingers are apart once they have closed on the target, in metres.
    pub opening_m: f64,
    /// How good it is, in [0, 1]: how little friction its contacts need ([`friction_score`](cranny_grasp::friction_score)).
    pub score: f64,
}

/// What is said of a grasp is right to within these: a pose and an opening, in metres and radians, and a score.
const SAID_TRANSLATION_M: f64 = 1e-4;
const SAID_ROTATION_RAD: f64 = 1e-3;
const SAID_OPENING_M: f64 = 1e-4;
const SAID_SCORE: f64 = 1e-3;

impl OwnGrasp {
    fn pose(&self) -> Option<Pose> {
        let rows = &self.world_from_gripper;
        pose_of_rows(&std::array::from_fn(|index| rows[index / 4][index % 4])).ok()
    }

    /// How far the gripper is from where it is said to be; `None` where that is no pose.
    pub(crate) fn off(&self, said: &Self) -> Option<PoseDifference> {
        Some(PoseDifference::between(&self.pose()?, &said.pose()?))
    }

    /// Whether what is said is so, as far as it is measured; what is no number never is.
    pub(crate) fn is_as_said(&self, said: &Self) -> bool {
        let Some(off) = self.off(said) else { return false };
        let opening_off_m = (self.opening_m - said.opening_m).abs();
        let score_off = (self.score - said.score).abs();
        off.translation_m <= SAID_TRANSLATION_M
            && off.rotation_rad <= SAID_ROTATION_RAD
            && opening_off_m <= SAID_OPENING_M
            && score_off <= SAID_SCORE
    }
}
