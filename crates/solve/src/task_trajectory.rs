use cranny_collision::Cell;
use cranny_plan::{PlanError, TimingMethod, Trajectory, TrajectorySample, sample_times};
use cranny_robot::Robot;

use crate::segment::joined;
use crate::{Mode, Segment, Timing};

/// How long a robot stands at a grasp while its hand closes, in seconds, where the files of the robot do not say it: the
/// fingers of common hands go through their whole stroke in about twice that.
pub const CLOSING_S: f64 = 0.4;

/// A path in time, and what the hand does meanwhile: the way to the grasp, a stop in which the hand closes, and the way on
/// with what it holds; or the first alone.
#[derive(Clone, Debug)]
pub struct TaskTrajectory {
    reach: Trajectory,
    onward: Option<Onward>,
}

#[derive(Clone, Debug)]
struct Onward {
    trajectory: Trajectory,
    /// How far the fingers are apart before they close, and after that, in metres.
    openings_m: [f64; 2],
}

impl TaskTrajectory {
    /// The way to a grasp, and the way on from there, if there is one, with how far the fingers are apart before they close
    /// and after that, in metres.
    pub fn new(reach: Trajectory, onward: Option<(Trajectory, [f64; 2])>) -> Self {
        let onward = onward.map(|(trajectory, openings_m)| Onward { trajectory, openings_m });
        Self { reach, onward }
    }

    /// Of segments that follow each other, with the stops that the changes of mode need; corners are cut in `cell`.
    /// `None` for a robot without the limits that this needs, or no path.
    ///
    /// # Errors
    /// [`PlanError`] for a path that cannot be timed.
    pub fn of(
        timing: Timing,
        robot: &Robot,
        cell: Option<&Cell>,
        segments: &[Segment],
    ) -> Result<Option<Self>, PlanError> {
        let first_onward = segments.iter().position(|segment| segment.mode != Mode::Reach);
        let (reach, onward) = segments.split_at(first_onward.unwrap_or(segments.len()));
        let timed = |segments: &[Segment]| match &joined(segments)[..] {
            [] => Ok(None),
            way => timing.along(robot, cell, way),
        };
        let Some(reach) = timed(reach)? else { return Ok(None) };
        let open_m = robot.hand().map(|hand| hand.description.opening_m);
        let closed_m = onward.first().and_then(|segment| segment.opening_m);
        let open_m = open_m.or(closed_m).unwrap_or(0.0);
        let openings_m = [open_m, closed_m.unwrap_or(open_m)];
        Ok(Some(Self::new(reach, timed(onward)?.map(|onward| (onward, openings_m)))))
    }

    /// The way to the grasp.
    pub fn reach(&self) -> &Trajectory {
        &self.reach
    }

    /// The way on from there, once the hand has closed, from its own beginning on.
    pub fn onward(&self) -> Option<&Trajectory> {
        self.onward.as_ref().map(|onward| &onward.trajectory)
    }

    /// How the path was given its time.
    pub fn method(&self) -> TimingMethod {
        self.reach.method()
    }

    /// Whether a corner is cut.
    pub fn is_blended(&self) -> bool {
        self.reach.is_blended() || self.onward().is_some_and(Trajectory::is_blended)
    }

    /// The names of the joints, in the order of every sample.
    pub fn joint_names(&self) -> &[String] {
        self.reach.joint_names()
    }

    /// From when to when the hand closes, in seconds, if it does.
    pub fn closing_s(&self) -> Option<[f64; 2]> {
        let begin_s = self.reach.duration_s();
        self.onward.as_ref().map(|_| [begin_s, begin_s + CLOSING_S])
    }

    /// How far the fingers are apart before they close, and after that, in metres, if they do.
    pub fn openings_m(&self) -> Option<[f64; 2]> {
        self.onward.as_ref().map(|onward| onward.openings_m)
    }

    /// Seconds from the beginning to the end.
    pub fn duration_s(&self) -> f64 {
        match (&self.onward, self.closing_s()) {
            (Some(onward), Some([_, closed_s])) => closed_s + onward.trajectory.duration_s(),
            _ => self.reach.duration_s(),
        }
    }

    /// When each way point of the path is passed, in seconds, as [`Trajectory::waypoint_times_s`]; the grasp when it is
    /// reached.
    pub fn waypoint_times_s(&self) -> Vec<f64> {
        let mut times_s = self.reach.waypoint_times_s().to_vec();
        if let (Some(onward), Some([_, closed_s])) = (&self.onward, self.closing_s()) {
            times_s.extend(onward.trajectory.waypoint_times_s()[1..].iter().map(|time_s| closed_s + time_s));
        }
        times_s
    }

    /// The robot at `time_s`, as [`Trajectory::sample`].
    pub fn sample(&self, time_s: f64) -> TrajectorySample {
        match (&self.onward, self.closing_s()) {
            (Some(onward), Some([_, closed_s])) if time_s >= closed_s => {
                TrajectorySample { time_s, ..onward.trajectory.sample(time_s - closed_s) }
            }
            _ => self.reach.sample(time_s),
        }
    }

    /// How far the fingers are apart at `time_s`, in metres; `None` where the hand does nothing.
    pub fn opening_m(&self, time_s: f64) -> Option<f64> {
        let ([open_m, closed_m], [begin_s, closed_s]) = self.openings_m().zip(self.closing_s())?;
        let share = ((time_s - begin_s) / (closed_s - begin_s)).clamp(0.0, 1.0);
        Some(open_m + share * (closed_m - open_m))
    }

    /// Samples at 0, 1/`rate_hz`, 2/`rate_hz`, … and at the end.
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
