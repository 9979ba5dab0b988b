use cranny_grasp::ShakeTest;
use cranny_shape::Roundness;
use cranny_spatial::Pose;
use serde::Serialize;

use crate::grasping::grasp_test::STILL_S;
use crate::grasping::grasp_trial::{BLOCKED_M, CLOSED_SHARE, CLOSING_GRACE_S, LOST_M};
use crate::object_model::STILL_M_PER_S;
use crate::{GraspTest, grasping::mjcf};

/// Test with its grasps as one document, complete for another engine to repeat it (`cranny.mujoco_grasps` in Python does). It
/// contains every parameter of the verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Name of the object.
    pub object: String,
    /// MJCF model, [`GraspTest::mjcf`].
    pub mjcf: String,
    /// Time step of the finger drive, in seconds.
    pub step_s: f64,
    /// Number of model steps per step of the drive.
    pub model_steps: usize,
    /// Gravitational acceleration, downwards, in m/s².
    pub gravity: f64,
    /// Direction against gravity in the planning frame, a unit vector.
    pub up: [f64; 3],
    /// True if anything supports the object. Otherwise there is no gravity until the hand has closed.
    pub is_carried: bool,
    /// Resting pose of the object, in the planning frame.
    pub world_from_object: ExperimentPose,
    /// Centre of mass in the frame of the object, in metres.
    pub center_in_object: [f64; 3],
    /// Symmetry rotations of the object, which do not count as slip.
    pub unseen_turns: UnseenTurns,
    /// Maximum force of each finger, in newtons.
    pub closing_force_n: f64,
    /// Stiffness of the drive, in N/m.
    pub drive_stiffness: f64,
    /// Stroke of each finger, in metres.
    pub strokes_m: Vec<f64>,
    /// Motion of the hand, and limits of slip.
    #[serde(rename = "course")]
    pub shake_test: ShakeTest,
    /// Penetration depth above which an open hand, in the object or with a finger in the surroundings, does not begin a grasp,
    /// in metres.
    pub blocked_m: f64,
    /// Additional time of the fingers beyond that of their stroke, in seconds.
    pub closing_grace_s: f64,
    /// Share of the stroke before its end from which a hand counts as closed on nothing.
    pub closed_share: f64,
    /// Speed below which the object counts as still, in m/s.
    pub still_speed: f64,
    /// Duration for which it must be still, in seconds.
    pub still_s: f64,
    /// Displacement in the hand above which an object is dropped, in metres.
    pub lost_m: f64,
    /// Pose of the gripper at each grasp, in the planning frame.
    pub grasps: Vec<ExperimentPose>,
}

/// Symmetry rotations that map the surface of an object onto itself.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum UnseenTurns {
    /// No rotation.
    None,
    /// Rotations about an axis, a unit vector in the frame of the object.
    About([f64; 3]),
    /// All rotations.
    All,
}

impl From<Roundness> for UnseenTurns {
    fn from(roundness: Roundness) -> Self {
        match roundness {
            Roundness::None => Self::None,
            Roundness::About(axis) => Self::About(axis.into_inner().into()),
            Roundness::Ball => Self::All,
        }
    }
}

/// Pose in an [`Experiment`].
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ExperimentPose {
    /// Position, in metres.
    pub position: [f64; 3],
    /// Unit quaternion (x, y, z, w).
    pub quaternion_xyzw: [f64; 4],
}

impl From<&Pose> for ExperimentPose {
    fn from(pose: &Pose) -> Self {
        Self { position: pose.translation.vector.into(), quaternion_xyzw: pose.rotation.coords.into() }
    }
}

impl GraspTest {
    /// Exports the test for another engine, with these grasps: poses of the gripper in the planning frame.
    pub fn experiment(&self, grasps: &[Pose]) -> Experiment {
        Experiment {
            object: self.object.name.clone(),
            mjcf: self.mjcf(),
            step_s: self.physics.step_s,
            model_steps: mjcf::mujoco_steps(&self.physics),
            gravity: self.physics.gravity,
            up: self.physics.up.into(),
            is_carried: self.is_carried(),
            world_from_object: self.world_from_object().into(),
            center_in_object: self.object.center.coords.into(),
            unseen_turns: self.object.roundness.into(),
            closing_force_n: self.hand.closing_force_n,
            drive_stiffness: self.physics.drive_stiffness,
            strokes_m: self.hand.fingers.iter().map(|finger| finger.stroke_m).collect(),
            shake_test: self.shake_test,
            blocked_m: BLOCKED_M,
            closing_grace_s: CLOSING_GRACE_S,
            closed_share: CLOSED_SHARE,
            still_speed: STILL_M_PER_S,
            still_s: STILL_S,
            lost_m: LOST_M,
            grasps: grasps.iter().map(Into::into).collect(),
        }
    }
}
