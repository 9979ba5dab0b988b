use cranny_path::{CurvedPath, EdgePace, TimingMethod, Trajectory, TrajectorySample, sample_times};
use cranny_plan::PlanError;
use cranny_robot::{PadDistance, Robot};
use cranny_task::{Segment, joined, joined_corners};

use crate::Timing;

/// Least standstill of the robot while its hand closes or opens, in seconds. Fingers of common hands need about twice that for
/// their whole stroke. The standstill is longer if the joints of the hand require it ([`PadDistance::least_time_s`]).
pub const CLOSING_S: f64 = 0.4;

/// Trajectory of a task, in legs. Between two legs the robot stands still while its hand closes or opens. The first leg leads
/// to the grasp; the second, if there is one, carries the object; the third, if there is one, starts after its release.
#[derive(Clone, Debug)]
pub struct TaskTrajectory {
    legs: Vec<Trajectory>,
    /// Distance between the fingers on each leg, in metres.
    openings_m: Vec<f64>,
    /// Pad distance of the robot's hand, if it has one.
    pads: Option<PadDistance>,
    torque_up: Option<[f64; 3]>,
}

/// Motion of the fingers between two legs of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandMotion {
    /// Start time, in seconds.
    pub from_s: f64,
    /// End time, in seconds.
    pub until_s: f64,
    /// Distance between the fingers before and after, in metres.
    pub openings_m: [f64; 2],
}

impl TaskTrajectory {
    /// Creates a trajectory of one leg, without finger motion.
    pub fn of_reach(reach: Trajectory) -> Self {
        Self { legs: vec![reach], openings_m: vec![0.0], pads: None, torque_up: None }
    }

    /// Returns this trajectory with another leg, after the fingers have moved between two openings, in metres.
    #[must_use]
    pub fn then(mut self, [before_m, after_m]: [f64; 2], leg: Trajectory) -> Self {
        if let Some(last_m) = self.openings_m.last_mut() {
            *last_m = before_m;
        }
        self.openings_m.push(after_m);
        self.legs.push(leg);
        self
    }

    /// Computes the trajectory of consecutive segments along their rounded corners, with the stops that the changes of mode
    /// need. `None` for a robot without the required limits, or for an empty path.
    ///
    /// # Errors
    /// [`PlanError`] for a path that cannot be timed.
    pub fn of(timing: Timing, robot: &Robot, segments: &[Segment]) -> Result<Option<Self>, PlanError> {
        let Ok(limits) = timing.limits(robot) else { return Ok(None) };
        let hand_opens_m = robot.hand().map(|hand| hand.description.opening_m);
        let (mut legs, mut openings_m) = (Vec::new(), Vec::new());
        for leg in cranny_task::legs(segments) {
            let way = joined(leg);
            if way.is_empty() {
                continue;
            }
            let (corners, paces) = (joined_corners(leg), edge_paces(leg));
            let drives = timing.drives(robot, leg[0].payload.as_ref())?;
            let curved = CurvedPath {
                waypoints: &way,
                corners: &corners,
                paces: &paces,
                robot: Some(robot),
                drives: drives.as_ref(),
            };
            legs.push(Trajectory::along_curve(&curved, &limits)?);
            openings_m.push(leg[0].opening_m.or(hand_opens_m).unwrap_or(0.0));
        }
        let pads = robot.hand().map(|hand| hand.pads.clone());
        let torque_up = timing.torque_up;
        Ok((!legs.is_empty()).then_some(Self { legs, openings_m, pads, torque_up }))
    }

    /// Direction against gravity in the planning frame for the effort limits of the drives; `None` if efforts are not limited.
    pub fn torque_up(&self) -> Option<[f64; 3]> {
        self.torque_up
    }

    /// Leg that leads to the grasp.
    pub fn reach(&self) -> &Trajectory {
        &self.legs[0]
    }

    /// All legs, each with its own time origin.
    pub fn legs(&self) -> &[Trajectory] {
        &self.legs
    }

    /// Timing method of the path.
    pub fn method(&self) -> TimingMethod {
        self.reach().method()
    }

    /// Returns true if a corner is rounded.
    pub fn is_rounded(&self) -> bool {
        self.legs.iter().any(Trajectory::is_rounded)
    }

    /// Names of the joints, in the order of every sample.
    pub fn joint_names(&self) -> &[String] {
        self.reach().joint_names()
    }

    /// Returns the finger motions between the legs.
    pub fn hand_motions(&self) -> Vec<HandMotion> {
        let openings_m = self.openings_m.windows(2).map(|openings_m| [openings_m[0], openings_m[1]]);
        let until_s = self.begins_s().into_iter().skip(1);
        let times = until_s.zip(self.hand_times_s()).map(|(until_s, time_s)| [until_s - time_s, until_s]);
        let motions = times.zip(openings_m);
        motions.map(|([from_s, until_s], openings_m)| HandMotion { from_s, until_s, openings_m }).collect()
    }

    /// Returns the standstills between the legs, one per pause, in seconds, while the hand closes or opens: [`CLOSING_S`], or
    /// longer if the limits of the joints of the hand require it.
    pub fn hand_times_s(&self) -> Vec<f64> {
        let least_s = |openings_m: &[f64]| {
            self.pads.as_ref().map_or(0.0, |pads| pads.least_time_s([openings_m[0], openings_m[1]]))
        };
        self.openings_m.windows(2).map(|openings_m| CLOSING_S.max(least_s(openings_m))).collect()
    }

    /// Openings of the fingers, one per leg, in metres; `None` without finger motion.
    pub fn openings_m(&self) -> Option<&[f64]> {
        (self.legs.len() > 1).then_some(&self.openings_m)
    }

    /// Total duration, in seconds.
    pub fn duration_s(&self) -> f64 {
        let last = self.legs.len() - 1;
        self.begins_s()[last] + self.legs[last].duration_s()
    }

    /// Returns the start time of each leg, in seconds.
    fn begins_s(&self) -> Vec<f64> {
        let mut begins_s = vec![0.0];
        for (index, (leg, hand_s)) in self.legs.iter().zip(self.hand_times_s()).enumerate() {
            // The first leg starts at zero; its end must be exact, without rounding from an addition.
            let ends_s = if index == 0 { leg.duration_s() } else { begins_s[index] + leg.duration_s() };
            begins_s.push(ends_s + hand_s);
        }
        begins_s
    }

    /// Returns the times at which the way points of the path are passed, one per way point, in seconds, as
    /// [`Trajectory::waypoint_times_s`]; for a way point between two legs, the end of the first.
    pub fn waypoint_times_s(&self) -> Vec<f64> {
        let mut times_s = self.reach().waypoint_times_s().to_vec();
        for (begin_s, leg) in self.begins_s().iter().zip(&self.legs).skip(1) {
            times_s.extend(leg.waypoint_times_s()[1..].iter().map(|time_s| begin_s + time_s));
        }
        times_s
    }

    /// Returns the state of the robot at `time_s`, as [`Trajectory::sample`].
    pub fn sample(&self, time_s: f64) -> TrajectorySample {
        let begins_s = self.begins_s();
        let leg = begins_s.iter().rposition(|begin_s| time_s >= *begin_s).unwrap_or(0);
        if leg == 0 {
            return self.reach().sample(time_s);
        }
        TrajectorySample { time_s, ..self.legs[leg].sample(time_s - begins_s[leg]) }
    }

    /// Returns the distance between the fingers at `time_s`, in metres; `None` without finger motion.
    pub fn opening_m(&self, time_s: f64) -> Option<f64> {
        let motions = self.hand_motions();
        let begun = motions.iter().rfind(|motion| time_s >= motion.from_s).or(motions.first())?;
        let HandMotion { from_s, until_s, openings_m: [before_m, after_m] } = *begun;
        let share = ((time_s - from_s) / (until_s - from_s)).clamp(0.0, 1.0);
        let evenly_m = before_m + share * (after_m - before_m);
        Some(self.pads.as_ref().map_or(evenly_m, |pads| pads.between_m([before_m, after_m], share)))
    }

    /// Returns samples at 0, 1/`rate_hz`, 2/`rate_hz`, … and at the end.
    ///
    /// # Errors
    /// As [`sample_times`].
    pub fn samples(
        &self,
        rate_hz: f64,
    ) -> Result<impl Iterator<Item = TrajectorySample> + use<'_>, PlanError> {
        Ok(sample_times(self.duration_s(), rate_hz)?.map(|time_s| self.sample(time_s)))
    }
}

/// Returns the pace of each edge of a leg: one motion, so the lowest speed share of its segments applies to all edges.
pub(crate) fn edge_paces(leg: &[Segment]) -> Vec<EdgePace> {
    let share = leg.iter().filter_map(|segment| segment.speed).fold(1.0, f64::min);
    let of_segment = |segment: &Segment| {
        let edges = segment.waypoints.len().saturating_sub(1);
        std::iter::repeat_n(EdgePace { pace: segment.pace, share }, edges)
    };
    leg.iter().flat_map(of_segment).collect()
}
