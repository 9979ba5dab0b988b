use cranny_plan::TimingMethod;
use cranny_solve::TaskTrajectory;
use serde::{Deserialize, Serialize};

/// When a path is run through. With the limits of the robot it determines the trajectory:
/// [`Trajectory::along`](cranny_plan::Trajectory::along) the way points by the same method, or [`Trajectory::blended`](cranny_plan::Trajectory::blended).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanTiming {
    /// How the path was given its time.
    pub method: TimingMethod,
    /// Whether corners are cut where that is proven, instead of a stop at each.
    pub blended: bool,
    /// From the first way point to the last, in seconds.
    pub duration_s: f64,
    /// When each way point is passed, or its cut corner half passed, in seconds.
    pub waypoint_times_s: Vec<f64>,
    /// From when to when the hand closes at the grasp, in seconds, where the target is carried on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub closing_s: Option<[f64; 2]>,
    /// From when to when it opens again where the target is put down, in seconds, where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opening_s: Option<[f64; 2]>,
}

impl PlanTiming {
    /// What a plan says of its trajectory.
    pub(crate) fn of(trajectory: &TaskTrajectory) -> Self {
        Self {
            method: trajectory.method(),
            blended: trajectory.is_blended(),
            duration_s: trajectory.duration_s(),
            waypoint_times_s: trajectory.waypoint_times_s(),
            closing_s: trajectory.closing_s(),
            opening_s: trajectory.opening_s(),
        }
    }
}
