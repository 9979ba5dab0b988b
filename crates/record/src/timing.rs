use cranny_path::TimingMethod;
use cranny_solve::TaskTrajectory;
use serde::{Deserialize, Serialize};

/// Timing of a path. With the limits of the robot it determines the trajectory:
/// [`Trajectory::along_curve`](cranny_path::Trajectory::along_curve) the way points and rounded corners by the same method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanTiming {
    /// Timing method.
    pub method: TimingMethod,
    /// True if a corner is rounded, instead of a stop at each.
    pub blended: bool,
    /// Duration from the first way point to the last, in seconds.
    pub duration_s: f64,
    /// Times at which each way point, or the middle of its rounded corner, is passed, in seconds.
    pub waypoint_times_s: Vec<f64>,
    /// Direction against gravity in the planning frame for the effort limits of the drives; missing if efforts are not limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_up: Option<[f64; 3]>,
    /// Start and end of each closing or opening of the hand, in seconds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hand_s: Vec<[f64; 2]>,
}

impl PlanTiming {
    /// Creates the timing from a trajectory.
    pub(crate) fn of(trajectory: &TaskTrajectory) -> Self {
        Self {
            method: trajectory.method(),
            blended: trajectory.is_rounded(),
            duration_s: trajectory.duration_s(),
            torque_up: trajectory.torque_up(),
            waypoint_times_s: trajectory.waypoint_times_s(),
            hand_s: trajectory.hand_motions().iter().map(|motion| [motion.from_s, motion.until_s]).collect(),
        }
    }
}
