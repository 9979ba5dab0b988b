use cranny_spatial::Pose;
use serde::{Serialize, Serializer};

use crate::object_model::ObjectModel;
use crate::{GraspOutcome, GraspRun};

/// Result of a plan that an arm executed: reach, close, lift.
#[derive(Clone, Debug)]
pub struct PlanRun {
    /// Duration of the motion to the grasp, in seconds.
    pub reach_s: f64,
    /// Contacts of the arm or the hand with the surroundings, and with the object except while the hand holds or releases it;
    /// each pair once in each phase.
    pub contacts: Vec<PlanContact>,
    /// Displacement of the object before the closing, in metres.
    pub pushed_m: f64,
    /// Height of the vertical lift, in metres: as far as the arm can reach straight up, at most the requested one.
    pub lift_m: f64,
    /// Height of the origin of the object at the end above that at the beginning, in metres.
    pub rose_m: f64,
    /// Pose of the object before any motion, in the planning frame.
    pub world_from_resting: Pose,
    /// Error of the object at its release, relative to the planned set-down pose; `None` if it was not released.
    pub released: Option<PlacedError>,
    /// Error 2 s after the arm has stopped, relative to the planned set-down pose; `None` if the object was not released there.
    pub placed: Option<PlacedError>,
    /// Result of closing and lifting.
    pub grasp: GraspRun,
}

/// Error of the pose of an object relative to its planned set-down pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlacedError {
    /// Displacement of the centre of mass, in metres.
    pub translation_m: f64,
    /// Visible rotation, in radians.
    pub rotation_rad: f64,
    /// True if both are within [`Self::MOST_M`] and [`Self::MOST_RAD`].
    pub is_there: bool,
}

/// Outcome of an executed plan for its object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanOutcome {
    /// The hand did not release the object: the outcome of the grasp.
    Grasped(GraspOutcome),
    /// The hand released the object, and it stands at the planned set-down pose.
    Placed,
    /// The hand released the object, and it is elsewhere.
    Misplaced,
}

impl PlanOutcome {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grasped(outcome) => outcome.name(),
            Self::Placed => "placed",
            Self::Misplaced => "misplaced",
        }
    }
}

impl Serialize for PlanOutcome {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl PlacedError {
    /// Tolerance of the planned set-down pose, in metres.
    pub const MOST_M: f64 = 0.01;
    /// Tolerance of the planned set-down pose, in radians.
    pub const MOST_RAD: f64 = std::f64::consts::PI / 18.0;

    /// Computes the error between the planned and the actual pose. Rotations that leave the surface unchanged do not count.
    pub(crate) fn between(planned: &Pose, actual: &Pose, object: &ObjectModel) -> Self {
        let translation_m = (actual * object.center - planned * object.center).norm();
        let rotation_rad = object.roundness.angle(&planned.rotation, &actual.rotation);
        let is_there = translation_m <= Self::MOST_M && rotation_rad <= Self::MOST_RAD;
        Self { translation_m, rotation_rad, is_there }
    }
}

impl PlanRun {
    /// Outcome for the object.
    pub fn outcome(&self) -> PlanOutcome {
        match (self.released, self.placed) {
            (Some(_), Some(PlacedError { is_there: true, .. })) => PlanOutcome::Placed,
            (Some(_), _) => PlanOutcome::Misplaced,
            (None, _) => PlanOutcome::Grasped(self.grasp.outcome),
        }
    }
}

/// Contact of two bodies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanContact {
    /// Time of the first contact, in seconds from the beginning of the plan.
    pub time_s: f64,
    /// Link of the arm, or the hand.
    pub link: String,
    /// Object, or surrounding body.
    pub body: String,
    /// Maximum penetration depth, in metres.
    pub depth_m: f64,
    /// Phase of the plan in which the two touched.
    pub phase: ContactPhase,
}

/// Phase of an executed plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactPhase {
    /// From the start until the hand closes.
    Reach,
    /// From the closing until the hand is open again, or to the end.
    Hold,
    /// From the open hand at the set-down to the end.
    Release,
}
