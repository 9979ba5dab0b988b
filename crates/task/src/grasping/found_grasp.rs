use cranny_grasp::pose_of_rows;
use cranny_spatial::{Pose, PoseDifference};
use serde::{Deserialize, Serialize};

/// Grasp at the end of a path for a problem without a set of grasps: measured, or stated in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FoundGrasp {
    /// Pose of the gripper frame in the planning frame, as a homogeneous matrix, row by row (m), as in files, so that it is
    /// read back bit by bit. A stated matrix need not be a pose.
    pub world_from_gripper: [[f64; 4]; 4],
    /// Distance between the fingers once they have closed on the target, in metres.
    pub opening_m: f64,
    /// Score in [0, 1] from the friction that its contacts need ([`friction_score`](cranny_grasp::friction_score)).
    pub score: f64,
    /// Travel of the finger that touches last, after the first one touches, in metres; `None` in older files, which lack this
    /// key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uneven_m: Option<f64>,
}

/// Tolerances of a stated grasp: pose (metres and radians), finger opening and uneven travel (metres), and score.
const STATED_TRANSLATION_M: f64 = 1e-4;
const STATED_ROTATION_RAD: f64 = 1e-3;
const STATED_OPENING_M: f64 = 1e-4;
const STATED_SCORE: f64 = 1e-3;

impl FoundGrasp {
    fn pose(&self) -> Option<Pose> {
        let rows = &self.world_from_gripper;
        pose_of_rows(&std::array::from_fn(|index| rows[index / 4][index % 4])).ok()
    }

    /// Returns the difference between the measured and the stated pose; `None` if the stated matrix is not a pose.
    pub(crate) fn off(&self, stated: &Self) -> Option<PoseDifference> {
        Some(PoseDifference::between(&self.pose()?, &stated.pose()?))
    }

    /// Compares the measured grasp with a stated one, in words.
    pub fn against(&self, stated: &Self) -> String {
        let pose = self.off(stated).map_or_else(
            || "the stated grasp is not a pose".to_owned(),
            |PoseDifference { translation_m, rotation_rad, .. }| {
                let (off, turned) = (translation_m * 1e3, rotation_rad.to_degrees());
                format!("the grasp is {off:.2} mm and {turned:.2}° from the stated one")
            },
        );
        let [(opening, score), (stated_opening, stated_score)] =
            [self, stated].map(|grasp| (grasp.opening_m * 1e3, grasp.score));
        let uneven = self.uneven_m.zip(stated.uneven_m).map_or_else(String::new, |(measured_m, stated_m)| {
            let (measured, stated) = (measured_m * 1e3, stated_m * 1e3);
            format!("; one touches {measured:.2} mm before the other, stated {stated:.2}")
        });
        format!(
            "{pose}; score {score:.3}, stated {stated_score:.3}; fingers {opening:.2} mm apart, stated \
             {stated_opening:.2}{uneven}"
        )
    }

    /// Returns true if the stated grasp agrees with the measured one within tolerance; false for a value that is not a number.
    pub fn agrees_with(&self, stated: &Self) -> bool {
        let Some(off) = self.off(stated) else { return false };
        let opening_off_m = (self.opening_m - stated.opening_m).abs();
        let score_off = (self.score - stated.score).abs();
        let uneven_off_m = self
            .uneven_m
            .zip(stated.uneven_m)
            .map_or(0.0, |(measured_m, stated_m)| (measured_m - stated_m).abs());
        off.translation_m <= STATED_TRANSLATION_M
            && off.rotation_rad <= STATED_ROTATION_RAD
            && opening_off_m <= STATED_OPENING_M
            && uneven_off_m <= STATED_OPENING_M
            && score_off <= STATED_SCORE
    }
}
