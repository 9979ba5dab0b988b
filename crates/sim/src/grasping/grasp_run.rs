use cranny_spatial::Pose;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::Recording;

/// Outcome of a grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum GraspOutcome {
    /// The object stays in the hand at the pose of the closing.
    Held,
    /// The object is in the hand, but has slipped beyond the limits.
    Slipped,
    /// No finger touches the object any more.
    Dropped,
    /// The fingers closed on nothing and the object has not moved, or a finger was in the surroundings from the beginning.
    NeverClosed,
    /// The fingers closed on nothing and pushed the object away, or the open hand was in the object from the beginning.
    KnockedAway,
}

impl GraspOutcome {
    /// Name in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Result of a grasp.
#[derive(Clone, Debug)]
pub struct GraspRun {
    /// Outcome.
    pub outcome: GraspOutcome,
    /// Displacement of the object's centre of mass in the hand since the closing, in metres; if the hand never closed, its
    /// displacement in the world.
    pub translation_error_m: f64,
    /// Rotation of the object relative to the same reference, in radians.
    pub rotation_error_rad: f64,
    /// Time from the closing to the first slip beyond the limits, or to the end, in seconds.
    pub held_s: f64,
    /// Mean force of the fingers on the object after the closing, in newtons.
    pub contact_force_n: f64,
    /// Final pose of the object, in the planning frame.
    pub world_from_object: Pose,
    /// True if a finger touches the object at the end.
    pub is_in_hand: bool,
    /// Pose of the object when the hand opened again to release it, in the planning frame; `None` if it did not.
    pub world_from_released: Option<Pose>,
    /// Simulated time, in seconds.
    pub simulated_s: f64,
    /// Recorded motions, if requested.
    pub recording: Option<Recording>,
}
