use cranny_grasp::Course;
use cranny_shape::Roundness;
use cranny_spatial::Pose;
use serde::Serialize;

use crate::grasping::grasp_test::STILL_S;
use crate::grasping::grasp_trial::{BLOCKED_M, CLOSED_SHARE, CLOSING_GRACE_S, LOST_M};
use crate::object_model::STILL_M_PER_S;
use crate::{GraspTest, grasping::mjcf};

/// A test and its grasps as one document: what another engine needs to repeat it (`cranny.mujoco_grasps` in Python
/// does). Every figure that a run is judged by stands in it.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// What the object is called.
    pub object: String,
    /// The model, [`GraspTest::mjcf`].
    pub mjcf: String,
    /// A step of the drive of the fingers, in seconds.
    pub step_s: f64,
    /// How many steps of the model make one of the drive.
    pub model_steps: usize,
    /// Downwards, in m/s².
    pub gravity: f64,
    /// Whether anything carries the object. Where nothing does, there is no gravity until the hand has closed.
    pub is_carried: bool,
    /// Where the object rests, in the planning frame.
    pub world_from_object: ExperimentPose,
    /// The object's centre of mass, in its frame, in metres.
    pub center_in_object: [f64; 3],
    /// Turns that leave the surface of the object where it is: they do not count.
    pub unseen_turns: UnseenTurns,
    /// What each finger presses with, in newtons.
    pub closing_force_n: f64,
    /// With what the drive follows, in N/m.
    pub drive_stiffness: f64,
    /// How far each finger closes, in metres.
    pub strokes_m: Vec<f64>,
    /// What the hand does, and what counts as slipped.
    pub course: Course,
    /// An open hand that is deeper than this in the object, or with a finger in what stands around, begins no grasp, in
    /// metres.
    pub blocked_m: f64,
    /// What the fingers get beyond the time that their stroke takes, in seconds.
    pub closing_grace_s: f64,
    /// The share of its stroke before the end from which on a hand counts as closed on nothing.
    pub closed_share: f64,
    /// What is slower is still, in m/s.
    pub still_speed: f64,
    /// For how long, in seconds.
    pub still_s: f64,
    /// An object this far from where it was in the hand is dropped, in metres.
    pub lost_m: f64,
    /// The gripper at each grasp, in the planning frame.
    pub grasps: Vec<ExperimentPose>,
}

/// Turns that leave the surface of an object where it is.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum UnseenTurns {
    /// None.
    None,
    /// Those about an axis, a unit vector in the frame of the object.
    About([f64; 3]),
    /// All.
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

/// A pose in an [`Experiment`].
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ExperimentPose {
    /// In metres.
    pub position: [f64; 3],
    /// Of unit length.
    pub quaternion_xyzw: [f64; 4],
}

impl From<&Pose> for ExperimentPose {
    fn from(pose: &Pose) -> Self {
        Self { position: pose.translation.vector.into(), quaternion_xyzw: pose.rotation.coords.into() }
    }
}

impl GraspTest {
    /// The test as a document for another engine, with these grasps: poses of the gripper in the planning frame.
    pub fn experiment(&self, grasps: &[Pose]) -> Experiment {
        Experiment {
            object: self.object.name.clone(),
            mjcf: self.mjcf(),
            step_s: self.physics.step_s,
            model_steps: mjcf::mujoco_steps(&self.physics),
            gravity: self.physics.gravity,
            is_carried: self.is_carried(),
            world_from_object: self.world_from_object().into(),
            center_in_object: self.object.center.coords.into(),
            unseen_turns: self.object.roundness.into(),
            closing_force_n: self.hand.closing_force_n,
            drive_stiffness: self.physics.drive_stiffness,
            strokes_m: self.hand.fingers.iter().map(|finger| finger.stroke_m).collect(),
            course: self.course,
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
