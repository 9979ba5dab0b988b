use cranny_spatial::Pose;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::Recording;

/// How a grasp ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum GraspOutcome {
    /// At the end the object is in the hand where it was when the hand had closed.
    Held,
    /// It is in the hand, but elsewhere in it.
    Slipped,
    /// No finger touches it any more.
    Dropped,
    /// The fingers found nothing to press on, and the object is where it was; or one stood in what is around from the
    /// beginning.
    NeverClosed,
    /// They found nothing, and have pushed the object away; or the open hand stood in it from the beginning.
    KnockedAway,
}

impl GraspOutcome {
    /// What files call it.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// What came of a grasp.
#[derive(Clone, Debug)]
pub struct GraspRun {
    /// How it ended.
    pub outcome: GraspOutcome,
    /// How far the object's centre of mass is from where it was in the hand when that had closed, in metres; where it
    /// never closed, from where it was in the world.
    pub translation_error_m: f64,
    /// How far it is turned against that, in radians.
    pub rotation_error_rad: f64,
    /// From the closing to the first moment when the object was elsewhere in the hand; to the end if there is none.
    pub held_s: f64,
    /// With what a finger pressed when the hand had closed, in newtons: the mean of the fingers.
    pub contact_force_n: f64,
    /// Where the object ended, in the planning frame.
    pub world_from_object: Pose,
    /// True if a finger touches it there.
    pub is_in_hand: bool,
    /// Pose of the object when the hand opened again to release it, in the planning frame; `None` if it did not.
    pub world_from_released: Option<Pose>,
    /// What was simulated, in seconds.
    pub simulated_s: f64,
    /// What moved where, if that was asked for.
    pub recording: Option<Recording>,
}
