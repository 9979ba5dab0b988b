use std::path::Path;

use cranny_path::{Audit, AuditSettings, audit_along, audit_task};
use cranny_plan::PlanError;
use cranny_robot::Robot;
use cranny_scenario::ScenarioError;
use cranny_solve::{TaskTrajectory, Timing};
use cranny_task::{Problem, Stage, StateSequence, TaskError, joined, legs};

use crate::PlanFile;

impl PlanFile {
    /// Recomputes the trajectory from the limits of the robot: with the plan's timing, or as fast as the limits allow if it has
    /// none. `None` for a plan without a path, and for a robot without the required limits.
    ///
    /// # Errors
    /// [`PlanError`] for an invalid path of the robot.
    pub fn trajectory(&self, robot: &Robot) -> Result<Option<TaskTrajectory>, PlanError> {
        TaskTrajectory::of(self.timing_asked(), robot, &self.segments)
    }

    /// Returns the stages of the task in a problem.
    pub fn stages(&self, problem: &Problem) -> Vec<Stage> {
        if self.task.is_empty() { Stage::of_goal(problem) } else { self.task.clone() }
    }

    /// Returns the path of the first pick, or the whole path without a pick.
    pub(crate) fn reach(&self) -> Vec<Vec<f64>> {
        legs(&self.segments).next().map(joined).unwrap_or_default()
    }

    /// Returns the state along each segment; `None` under `paper`.
    ///
    /// # Errors
    /// As [`StateSequence::of`].
    pub fn states(&self, problem: &Problem) -> Result<Option<StateSequence>, TaskError> {
        StateSequence::of(problem, &self.stages(problem), &self.segments)
    }

    /// Timing of the path.
    pub fn timing_asked(&self) -> Timing {
        self.timing.as_ref().map_or_else(Timing::default, |timing| Timing {
            method: Some(timing.method),
            torque_up: timing.torque_up,
            ..Timing::default()
        })
    }

    /// Audits the path alone, all motions of the hand, and the stated grasps if no set is given; `None` for a plan without a
    /// path. [`Self::judge`] compares all other statements of the file.
    ///
    /// # Errors
    /// As [`audit_task`].
    pub fn audit(&self, problem: &Problem, settings: AuditSettings) -> Result<Option<Audit>, PlanError> {
        self.audit_along(None, problem, settings)
    }

    /// Audits the path along known states; without them, they are computed.
    pub(crate) fn audit_along(
        &self,
        along: Option<&StateSequence>,
        problem: &Problem,
        settings: AuditSettings,
    ) -> Result<Option<Audit>, PlanError> {
        if self.waypoints.is_empty() {
            return Ok(None);
        }
        let stages = self.stages(problem);
        let audit = match along {
            Some(along) => audit_along(problem, &stages, (&self.segments, along), settings)?,
            None => audit_task(problem, &stages, &self.segments, settings)?,
        };
        let first = audit.picks.first().map(|pick| pick.stage).zip(self.own_grasp);
        let others = self.picks.iter().filter_map(|pick| Some((pick.stage, pick.own_grasp?)));
        let said: Vec<_> = first.into_iter().chain(others).collect();
        Ok(Some(audit.with_stated_grasps(&said)))
    }

    /// Checks that the plan, which was read from `path`, moves the joints of a robot.
    ///
    /// # Errors
    /// [`ScenarioError::Content`] names the first joint that differs.
    pub fn check_joints(&self, path: &Path, robot: &Robot) -> Result<(), crate::RecordError> {
        let mut pairs = self.joint_names.iter().zip(robot.joint_names());
        pairs.find(|(found, expected)| found != expected).map_or(Ok(()), |(found, expected)| {
            let problem =
                format!("the plan moves joint '{found}' where this scenario's robot has '{expected}'");
            Err(ScenarioError::Content { path: path.to_owned(), problem }.into())
        })
    }
}

#[cfg(test)]
mod tests {
    use cranny_collision::Margins;
    use cranny_path::{TimingMethod, Trajectory};
    use cranny_task::{Mode, Segment};

    use super::*;
    use crate::PlanTiming;
    use cranny_scenario::{OpenOptions, Scenario};

    fn plan(scenario: &Scenario) -> PlanFile {
        let mut end = scenario.start.clone();
        end[0] += 0.1;
        let plan = serde_json::json!({
            "format": PlanFile::FORMAT, "scenario": "021", "robot": null, "geometry": null, "planner": "x", "settings": {}, "criterion": "exact",
            "goal_threshold": null, "seed": 0, "version": "0", "outcome": "solved", "margins": Margins::default(),
            "budget": {"iterations": null, "time_limit_s": null}, "joint_names": scenario.robot.joint_names(),
            "grasp": null, "translation_error_m": null, "rotation_error_rad": null, "clearance_m": null,
            "clearances_per_edge_m": [], "path_length": 0.1, "waypoints": [scenario.start, end],
            "statistics": cranny_plan::Statistics::default(),
        });
        let plan: PlanFile = serde_json::from_value(plan).unwrap();
        PlanFile { segments: vec![Segment::reach(plan.waypoints.clone(), Vec::new())], ..plan }
    }

    #[test]
    fn a_plan_has_the_trajectory_that_its_timing_says() {
        let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let (plan, robot) = (plan(&scenario), &scenario.robot);
        assert_eq!(plan.trajectory(robot).unwrap().unwrap().method(), TimingMethod::JerkLimited);
        let method = TimingMethod::TimeOptimal;
        let timing = PlanTiming {
            method,
            blended: false,
            torque_up: None,
            duration_s: 1.0,
            waypoint_times_s: Vec::new(),
            hand_s: Vec::new(),
        };
        let smooth = PlanFile { timing: Some(timing), ..plan.clone() };
        assert_eq!(smooth.trajectory(robot).unwrap().unwrap().method(), method);
        let none = PlanFile { waypoints: Vec::new(), segments: Vec::new(), ..plan };
        assert!(
            none.trajectory(robot).unwrap().is_none()
                && none.audit(&problem, AuditSettings::default()).unwrap().is_none()
        );
    }

    /// The hand does not close between two segments of the path to the grasp, and only rounded corners need a cell.
    #[test]
    fn what_follows_the_closing_of_the_hand_is_timed_by_itself() {
        let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
        let plan = plan(&scenario);
        let [start, end] = [plan.waypoints[0].clone(), plan.waypoints[1].clone()];
        let segment = |mode, ends: [&Vec<f64>; 2]| {
            let waypoints = ends.map(Clone::clone).to_vec();
            Segment::empty(0, mode, waypoints)
        };
        let there = [segment(Mode::REACH, [&start, &end]), segment(Mode::REACH, [&end, &start])];
        let back = [segment(Mode::LIFT_OFF, [&start, &end]), segment(Mode::CARRY, [&end, &start])];
        let reaching = PlanFile { segments: there.to_vec(), ..plan };
        assert_eq!(reaching.reach(), [start.clone(), end.clone(), start.clone()]);
        let carrying = PlanFile { segments: [there, back].concat(), ..reaching.clone() };
        assert_eq!(carrying.reach(), reaching.reach());
        let durations = |plan: &PlanFile| {
            let timed = plan.trajectory(&scenario.robot).unwrap().unwrap();
            (timed.reach().duration_s(), timed.legs().get(1).map(Trajectory::duration_s))
        };
        let (reach_s, none) = durations(&reaching);
        assert_eq!((none, durations(&carrying)), (None, (reach_s, Some(reach_s))));
    }

    #[test]
    fn a_plan_of_another_robot_is_refused_by_its_joint() {
        let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
        let mut plan = plan(&scenario);
        let path = Path::new("x.plan.json");
        assert!(plan.check_joints(path, &scenario.robot).is_ok());
        plan.joint_names[2] = "elbow".to_owned();
        let fault = plan.check_joints(path, &scenario.robot).unwrap_err().to_string();
        assert!(fault.starts_with("x.plan.json: the plan moves joint 'elbow' where"), "{fault}");
    }
}
