use cranny_spatial::{Point, Pose};
use serde::Serialize;

use crate::GraspRun;

/// What came of a plan that an arm executed: reach, close, lift.
#[derive(Clone, Debug)]
pub struct PlanRun {
    /// How long the motion to the grasp takes, in seconds.
    pub reach_s: f64,
    /// How far the arm is from where the plan has it, at worst on the way.
    pub on_the_way: TrackingError,
    /// The same at the end of the way, before the hand closes.
    pub at_the_end: TrackingError,
    /// What the arm or the hand touched before the hand closed, and what stood around after: each pair once.
    pub contacts: Vec<PlanContact>,
    /// How far the object had been moved before the hand closed, in metres.
    pub pushed_m: f64,
    /// How far up the arm went with what it had, in metres: as far as it can go straight up, at most as far as asked.
    pub lift_m: f64,
    /// Where the object was before anything moved, in the planning frame.
    pub world_from_resting: Pose,
    /// How far the object is in the end from where it was to be put down, of a plan that puts it down.
    pub placed: Option<PlacedError>,
    /// Closing and lifting.
    pub grasp: GraspRun,
}

/// How far an object stands from where it was to be put down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlacedError {
    /// Of its centre of mass, in metres.
    pub translation_m: f64,
    /// How far it is turned, in radians.
    pub rotation_rad: f64,
}

impl PlacedError {
    /// What counts as standing where it was to be, in metres and radians.
    pub const MOST_M: f64 = 0.01;
    /// See [`Self::MOST_M`].
    pub const MOST_RAD: f64 = std::f64::consts::PI / 18.0;

    pub(crate) fn between(planned: &Pose, actual: &Pose, center: &Point) -> Self {
        Self {
            translation_m: (actual * center - planned * center).norm(),
            rotation_rad: planned.rotation.angle_to(&actual.rotation),
        }
    }

    /// Whether it stands where it was to be.
    pub fn is_there(&self) -> bool {
        self.translation_m <= Self::MOST_M && self.rotation_rad <= Self::MOST_RAD
    }
}

impl PlanRun {
    /// How far the object's origin rose, in metres.
    pub fn rose_m(&self) -> f64 {
        self.grasp.world_from_object.translation.z - self.world_from_resting.translation.z
    }
}

/// How far an arm is from where it should be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TrackingError {
    /// Of the gripper frame, in metres.
    pub translation_m: f64,
    /// Of the gripper frame, in radians.
    pub rotation_rad: f64,
    /// Of the joint that is farthest off, in its unit (m, rad).
    pub joint: f64,
}

impl TrackingError {
    /// The worse of two, figure by figure.
    pub(crate) fn worst(self, other: Self) -> Self {
        Self {
            translation_m: self.translation_m.max(other.translation_m),
            rotation_rad: self.rotation_rad.max(other.rotation_rad),
            joint: self.joint.max(other.joint),
        }
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
