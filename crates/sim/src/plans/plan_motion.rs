use cranny_path::Trajectory;
use cranny_robot::Robot;
use cranny_solve::{CLOSING_S, TaskTrajectory};
use cranny_spatial::Pose;

use crate::plans::lift::Lift;
use crate::{GraspTest, SimError};

/// Motion of an arm that executes a plan: to the grasp, on with the object, and off it.
pub(crate) struct PlanMotion<'a> {
    pub reach: &'a Trajectory,
    onward: Option<&'a Trajectory>,
    pub lift: Lift,
    /// Duration of the motion with the object, in seconds.
    moving_s: f64,
    off: Option<&'a Trajectory>,
    /// Duration of the opening of the hand at the set-down before the retreat, in seconds.
    opening_s: f64,
    /// Poses of the tip at the grasp and at the set-down, if there is one.
    world_from_grasp: Pose,
    world_from_down: Option<Pose>,
}

/// Duration of the pause of the arm after the motion with the object, in seconds.
const RESTING_S: f64 = 0.5;
/// Duration of the observation of a set-down object after the arm has stopped, in seconds.
const WATCHED_S: f64 = 2.0;

impl<'a> PlanMotion<'a> {
    /// Creates the motion along a timed path; a vertical lift by `lift_m` metres follows a path that ends at the grasp.
    ///
    /// # Errors
    /// [`SimError::Figure`] for a lift out of range or a path that takes too long.
    pub fn new(
        path: &'a TaskTrajectory,
        lift_m: f64,
        (test, robot): (&GraspTest, &Robot),
    ) -> Result<Self, SimError> {
        let (reach, onward, off) = (path.reach(), path.legs().get(1), path.legs().get(2));
        let lift_m = if onward.is_some() { 0.0 } else { lift_m };
        for (figure, value, range, most) in [
            ("lift", lift_m, "from 0 to 1 m", 1.0),
            ("time of the motion", path.duration_s(), "from 0 to 600 s", 600.0),
        ] {
            if !(0.0..=most).contains(&value) {
                return Err(SimError::Figure { figure, value, range });
            }
        }
        let end = |leg: &Trajectory| leg.sample(leg.duration_s()).position;
        let world_from_tip = |q: &[f64]| *robot.frames_at(q).link(robot.tip());
        Ok(Self {
            reach,
            onward,
            lift: Lift::new(robot, &end(reach), &test.physics.up, lift_m),
            moving_s: onward.map_or(test.shake_test.lift_s, Trajectory::duration_s),
            off,
            opening_s: path.hand_times_s().get(1).copied().unwrap_or(CLOSING_S),
            world_from_grasp: world_from_tip(&end(reach)),
            world_from_down: onward.filter(|_| off.is_some()).map(|onward| world_from_tip(&end(onward))),
        })
    }

    /// Duration for which the hand holds the object, in seconds.
    pub fn held_s(&self) -> f64 {
        self.moving_s + RESTING_S
    }

    /// Returns the configuration (m, rad; one per joint) at a time after the closing of the hand, in seconds.
    pub fn held(&self, time_s: f64) -> Vec<f64> {
        match self.onward {
            Some(onward) => onward.sample(time_s).position,
            None => self.lift.at(time_s, self.moving_s),
        }
    }

    /// Duration after the hand begins to open, in seconds; `None` for a plan without a release.
    pub fn left_s(&self) -> Option<f64> {
        self.off.map(|off| self.opening_s + off.duration_s() + WATCHED_S)
    }

    /// Returns true if the hand is open at a time after it begins to open, in seconds.
    pub fn has_opened(&self, time_s: f64) -> bool {
        time_s >= self.opening_s
    }

    /// Returns the configuration (m, rad; one per joint) at a time after the hand begins to open, in seconds.
    pub fn left(&self, time_s: f64) -> Vec<f64> {
        match self.off {
            Some(off) => off.sample((time_s - self.opening_s).max(0.0)).position,
            None => self.held(self.held_s()),
        }
    }

    /// Returns the planned set-down pose, in the planning frame, of an object at a resting pose; `None` without a set-down.
    pub fn planned(&self, world_from_resting: &Pose) -> Option<Pose> {
        Some(self.world_from_down? * self.world_from_grasp.inverse() * world_from_resting)
    }
}
