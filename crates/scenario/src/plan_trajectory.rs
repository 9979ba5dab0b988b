use std::path::Path;

use cranny_plan::{PlanError, Problem, Trajectory};
use cranny_robot::Robot;
use cranny_solve::Timing;

use crate::{PlanFile, ScenarioError};

impl PlanFile {
    /// When to be where on the path, computed anew from the limits of the robot: as the plan's timing says; where it
    /// has none, as fast as those of velocity and acceleration allow. `None` for a plan without a path, and for a
    /// robot without the limits that this needs.
    ///
    /// # Errors
    /// [`PlanError`] for what is no path of the robot.
    pub fn trajectory(&self, problem: &Problem) -> Result<Option<Trajectory>, PlanError> {
        if self.waypoints.is_empty() {
            return Ok(None);
        }
        let timing = self.timing.as_ref().map_or_else(Timing::default, |timing| Timing {
            method: timing.method,
            blend: timing.blended,
            ..Timing::default()
        });
        timing.of(problem, &self.waypoints)
    }

    /// Whether the plan, which was read from `path`, moves the joints of a robot.
    ///
    /// # Errors
    /// [`ScenarioError::Content`] names the first that differs.
    pub fn check_joints(&self, path: &Path, robot: &Robot) -> Result<(), ScenarioError> {
        let mut pairs = self.joint_names.iter().zip(robot.joint_names());
        let Some((found, expected)) = pairs.find(|(found, expected)| found != expected) else {
            return Ok(());
        };
        let problem = format!("the plan moves joint '{found}' where this scenario's robot has '{expected}'");
        Err(ScenarioError::Content { path: path.to_owned(), problem })
    }
}
