use cranny_path::{MAX_SAMPLE_RATE_HZ, Trajectory, path_length};
use cranny_record::PlanFile;
use cranny_robot::{Robot, between, distance};
use cranny_solve::{CLOSING_S, TaskTrajectory};
use cranny_task::{joined, legs};

use crate::{CarriedObjectMotion, ViewError};

/// Path shown in a scene: the configuration of the robot at each of a sequence of instants.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledPath {
    /// Instants in seconds, ascending from 0.
    pub times_s: Vec<f64>,
    /// Configuration at each instant (m, rad).
    pub configurations: Vec<Vec<f64>>,
    /// Time at each way point, in seconds.
    pub waypoint_times_s: Vec<f64>,
    /// Index of the grasp in the scenario at which the path ends, if known.
    pub grasp: Option<usize>,
    /// True if the path is timed within the limits of the robot; otherwise its speed is 1 (m and rad alike) per second.
    pub is_timed: bool,
    /// Carried objects in order.
    pub carries: Vec<CarriedObjectMotion>,
}

/// Speed of a path without timing, in the Euclidean norm of `q` (m and rad alike) per second: about half the maximum velocity
/// of a robot. At 1, the time equals the length.
const UNTIMED_SPEED: f64 = 1.0;

/// Maximum number of instants, an hour at 25 per second; a longer path gets a lower rate.
const MOST_INSTANTS: f64 = 1e5;

impl SampledPath {
    /// Samples a sequence of way points (m, rad; one value per joint) at `rate_hz` samples per second, in the time of its
    /// trajectory, or at constant speed without one. `None` if there are no way points.
    ///
    /// # Errors
    /// [`ViewError::Waypoint`] for a way point without one value per joint, [`ViewError::Path`] for an invalid rate.
    pub fn of(
        robot: &Robot,
        waypoints: &[Vec<f64>],
        trajectory: Option<&Trajectory>,
        rate_hz: f64,
    ) -> Result<Option<Self>, ViewError> {
        let expected = robot.dof();
        if let Some((waypoint, q)) = waypoints.iter().enumerate().find(|(_, q)| q.len() != expected) {
            return Err(ViewError::Waypoint { waypoint, expected, actual: q.len() });
        }
        match trajectory {
            _ if waypoints.is_empty() => Ok(None),
            Some(trajectory) => Self::sampled(trajectory, rate_hz).map(Some),
            None => Ok(Some(Self::even(waypoints, rate_hz))),
        }
    }

    /// Samples the path of a plan likewise, in the times of [`PlanFile::trajectory`] if it has any. The robot stands still
    /// while its hand closes or opens, for [`TaskTrajectory::hand_times_s`], or [`CLOSING_S`] without timing.
    ///
    /// # Errors
    /// See [`Self::of`].
    pub fn of_plan(
        robot: &Robot,
        plan: &PlanFile,
        timed: Option<&TaskTrajectory>,
        rate_hz: f64,
    ) -> Result<Option<Self>, ViewError> {
        // The hand does not move before the first leg.
        let mut stops_s =
            [0.0].into_iter().chain(timed.map(TaskTrajectory::hand_times_s).unwrap_or_default());
        let mut timed = timed.map(TaskTrajectory::legs).unwrap_or_default().iter();
        let mut shown: Option<Self> = None;
        let mut times_s = Vec::new();
        for leg in legs(&plan.segments) {
            let Some(leg) = Self::of(robot, &joined(leg), timed.next(), rate_hz)? else { break };
            let hand_s = stops_s.next().unwrap_or(CLOSING_S);
            let begin_s = shown.as_ref().map_or(0.0, |before| before.ends_s() + hand_s);
            times_s.push(leg.waypoint_times_s.iter().map(|time_s| begin_s + time_s).collect());
            shown = Some(match shown {
                Some(before) => before.then(leg, hand_s, rate_hz),
                None => leg,
            });
        }
        let carries = CarriedObjectMotion::all_of(robot, &plan.segments, &times_s);
        Ok(shown.map(|shown| Self { grasp: plan.grasp, carries, ..shown }))
    }

    /// Appends a stop of `hand_s` seconds in which the hand moves, then the next leg.
    fn then(mut self, leg: Self, hand_s: f64, rate_hz: f64) -> Self {
        let stops_s = self.ends_s();
        let goes_on_s = stops_s + hand_s;
        let steps = (hand_s * rate_hz).ceil().clamp(1.0, 1e5);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 1 and 10⁵; the last is the first of the way on"
        )]
        for step in 1..steps as u32 {
            self.times_s.push(stops_s + hand_s * f64::from(step) / steps);
            self.configurations.push(leg.configurations[0].clone());
        }
        self.times_s.extend(leg.times_s.iter().map(|time_s| goes_on_s + time_s));
        self.configurations.extend(leg.configurations);
        self.waypoint_times_s.extend(leg.waypoint_times_s[1..].iter().map(|time_s| goes_on_s + time_s));
        self
    }

    /// Returns the end time, in seconds.
    pub fn ends_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or_default()
    }

    fn sampled(trajectory: &Trajectory, rate_hz: f64) -> Result<Self, ViewError> {
        let rate_hz = within(rate_hz, trajectory.duration_s());
        let (times_s, configurations) =
            trajectory.samples(rate_hz)?.map(|sample| (sample.time_s, sample.position)).unzip();
        let waypoint_times_s = trajectory.waypoint_times_s().to_vec();
        Ok(Self {
            times_s,
            configurations,
            waypoint_times_s,
            grasp: None,
            is_timed: true,
            carries: Vec::new(),
        })
    }

    /// Samples the path at constant speed, each edge in a whole number of intervals.
    fn even(waypoints: &[Vec<f64>], rate_hz: f64) -> Self {
        let mut path = Self {
            times_s: vec![0.0],
            configurations: vec![waypoints[0].clone()],
            waypoint_times_s: vec![0.0],
            grasp: None,
            is_timed: false,
            carries: Vec::new(),
        };
        let rate_hz = within(rate_hz, path_length(waypoints) / UNTIMED_SPEED);
        let mut begin_s = 0.0;
        for edge in waypoints.windows(2) {
            let duration_s = distance(&edge[0], &edge[1]) / UNTIMED_SPEED;
            let steps = (duration_s * rate_hz).ceil().clamp(1.0, 1e5);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and 10⁵")]
            for step in 1..=steps as u32 {
                let share = f64::from(step) / steps;
                path.configurations.push(between(&edge[0], &edge[1], share).collect());
                path.times_s.push(begin_s + duration_s * share);
            }
            begin_s += duration_s;
            path.waypoint_times_s.push(begin_s);
        }
        path
    }
}

/// Returns the rate, lowered if it would exceed the maximum number of instants. An invalid rate stays unchanged.
pub(crate) fn within(rate_hz: f64, duration_s: f64) -> f64 {
    let is_too_many = rate_hz <= MAX_SAMPLE_RATE_HZ && rate_hz * duration_s > MOST_INSTANTS;
    if is_too_many { MOST_INSTANTS / duration_s } else { rate_hz }
}
