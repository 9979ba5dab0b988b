use cranny_spatial::Pose;
use serde::{Serialize, Serializer};

use crate::object_model::ObjectModel;
use crate::{GraspOutcome, GraspRun};

/// What came of a plan that an arm executed: reach, close, lift.
#[derive(Clone, Debug)]
pub struct PlanRun {
    /// How long the motion to the grasp takes, in seconds.
    pub reach_s: f64,
    /// What the arm or the hand touched before the hand closed, and what stood around after: each pair once.
    pub contacts: Vec<PlanContact>,
    /// How far the object had been moved before the hand closed, in metres.
    pub pushed_m: f64,
    /// How far up the arm went with what it had, in metres: as far as it can go straight up, at most as far as asked.
    pub lift_m: f64,
    /// Where the object was before anything moved, in the planning frame.
    pub world_from_resting: Pose,
    /// Error of the object, when the hand released it, against the pose at which it was to be put down; `None` if it
    /// did not.
    pub released: Option<PlacedError>,
    /// Error of the object, 2 s after the arm has stopped, against the pose at which it was to be put down; `None` if it
    /// was not released there.
    pub placed: Option<PlacedError>,
    /// Closing and lifting.
    pub grasp: GraspRun,
}

/// How far an object stands from where it was to be put down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlacedError {
    /// Of its centre of mass, in metres.
    pub translation_m: f64,
    /// How far it is seen to be turned, in radians.
    pub rotation_rad: f64,
    /// True if both are within [`Self::MOST_M`] and [`Self::MOST_RAD`].
    pub is_there: bool,
}

/// Fate of the object of an executed plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanOutcome {
    /// The hand did not let it go: as for a grasp.
    Grasped(GraspOutcome),
    /// The hand let it go, and it stands where it was to be put down.
    Placed,
    /// The hand let it go, and it is elsewhere.
    Misplaced,
}

impl PlanOutcome {
    /// Its name in files.
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
    /// What counts as standing where it was to be, in metres and radians.
    pub const MOST_M: f64 = 0.01;
    /// See [`Self::MOST_M`].
    pub const MOST_RAD: f64 = std::f64::consts::PI / 18.0;

    /// Error of an object that is at a pose instead of the planned one; turns that leave its surface where it is do not count.
    pub(crate) fn between(planned: &Pose, actual: &Pose, object: &ObjectModel) -> Self {
        let translation_m = (actual * object.center - planned * object.center).norm();
        let rotation_rad = object.roundness.angle(&planned.rotation, &actual.rotation);
        let is_there = translation_m <= Self::MOST_M && rotation_rad <= Self::MOST_RAD;
        Self { translation_m, rotation_rad, is_there }
    }
}

impl PlanRun {
    /// Fate of the object.
    pub fn outcome(&self) -> PlanOutcome {
        match (self.released, self.placed) {
            (Some(_), Some(PlacedError { is_there: true, .. })) => PlanOutcome::Placed,
            (Some(_), _) => PlanOutcome::Misplaced,
            (None, _) => PlanOutcome::Grasped(self.grasp.outcome),
        }
    }

    /// How far the object's origin rose, in metres.
    pub fn rose_m(&self) -> f64 {
        self.grasp.world_from_object.translation.z - self.world_from_resting.translation.z
    }
}

/// What touched what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanContact {
    /// When first, in seconds from the beginning of the plan.
    pub time_s: f64,
    /// A part of the arm or the hand.
    pub link: String,
    /// The object, or what stands around.
    pub body: String,
    /// How deep they were in each other at most, in metres.
    pub depth_m: f64,
    /// Whether the hand had closed.
    pub is_lifting: bool,
}
