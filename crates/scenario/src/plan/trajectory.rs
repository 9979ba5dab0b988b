use std::path::Path;
use std::str::FromStr as _;

use cranny_collision::Cell;
use cranny_plan::{
    Audit, AuditSettings, Carrier, LiftOffSettings, PlanError, Problem, audit_cut_corners, audit_with,
};
use cranny_robot::Robot;
use cranny_solve::{Mode, Segment, TaskCells, TaskTrajectory, Timing, audit_segments};

use crate::{PlanFile, PlanSegment, ScenarioError};

impl PlanFile {
    /// When to be where on the path, computed anew from the limits of the robot: as the plan's timing says; where it
    /// has none, as fast as those of velocity and acceleration allow. `None` for a plan without a path, and for a
    /// robot without the limits that this needs. `cell` is asked only where corners are to be cut ([`Self::is_blended`]).
    ///
    /// # Errors
    /// [`PlanError`] for what is no path of the robot.
    pub fn trajectory(
        &self,
        robot: &Robot,
        cell: Option<&Cell>,
    ) -> Result<Option<TaskTrajectory>, PlanError> {
        // What the plan's own margins allow is what was executed, whatever others are demanded of it now.
        let cell = cell.map(|cell| cell.with_margins(self.margins)).transpose()?;
        TaskTrajectory::of(self.timing_asked(), robot, cell.as_ref(), &self.solved_segments()?)
    }

    /// The segments as [`solve`](cranny_solve::solve) has them.
    pub(crate) fn solved_segments(&self) -> Result<Vec<Segment>, PlanError> {
        let segments: Result<Vec<Segment>, String> = self.segments.iter().map(PlanSegment::segment).collect();
        segments.map_err(|_| PlanError::Segments)
    }

    /// The legs of the path, between which the hand closes or opens: the way to the grasp; the way on with the object, if it
    /// is carried away; the way off the object, if it is put down.
    pub fn legs(&self) -> Vec<Vec<Vec<f64>>> {
        let holds = |segment: &PlanSegment| Mode::from_str(&segment.mode).is_ok_and(Mode::holds);
        let legs = self.segments.chunk_by(|a, b| holds(a) == holds(b));
        let joined = legs.map(|leg| {
            let mut way: Vec<Vec<f64>> = Vec::new();
            for segment in leg {
                way.pop();
                way.extend_from_slice(&segment.waypoints);
            }
            way
        });
        joined.collect()
    }

    /// The way to the grasp.
    pub(crate) fn reach(&self) -> Vec<Vec<f64>> {
        self.legs().into_iter().next().unwrap_or_default()
    }

    /// Whether the target was to be carried on, or is.
    pub fn is_task(&self) -> bool {
        let is_asked = self.carry_to.is_some() || self.carry_clear_m.is_some() || self.place.is_some();
        is_asked || self.segments.len() > 1
    }

    /// Whether its time is that of cut corners.
    pub fn is_blended(&self) -> bool {
        self.timing_asked().blend
    }

    /// In what the object is in the hand, as it closes where the way to the grasp ends, and what follows; `None` for a plan
    /// that does not carry it, or where the hand does not close on it.
    ///
    /// # Errors
    /// As [`Carrier::new`] and [`Self::carry_end`].
    pub fn task_cells(&self, problem: &Problem) -> Result<Option<TaskCells>, PlanError> {
        let carrier = if self.segments.len() > 1 { self.carrier(problem)? } else { None };
        self.task_cells_by(carrier.as_ref(), problem)
    }

    pub(crate) fn task_cells_by(
        &self,
        carrier: Option<&Carrier>,
        problem: &Problem,
    ) -> Result<Option<TaskCells>, PlanError> {
        let segments: Result<Vec<Segment>, String> = self.segments.iter().map(PlanSegment::segment).collect();
        match segments.ok().filter(|segments| segments.len() > 1).zip(carrier) {
            Some((segments, carrier)) => TaskCells::of(carrier, &segments, self.carry_end(problem)?.as_ref()),
            None => Ok(None),
        }
    }

    /// The target in the closing hand, where it is carried: some 20 ms for a mesh.
    pub(crate) fn carrier(&self, problem: &Problem) -> Result<Option<Carrier>, PlanError> {
        self.is_task().then(|| Carrier::new(problem, LiftOffSettings::default())).transpose()
    }

    fn timing_asked(&self) -> Timing {
        self.timing.as_ref().map_or_else(Timing::default, |timing| Timing {
            method: timing.method,
            blend: timing.blended,
            ..Timing::default()
        })
    }

    /// The verdict on the path alone, on all that it does, and on the grasp that it is stated to end at where no set is
    /// given; `None` for a plan without a path. [`Self::judge`] compares everything else that the file states.
    ///
    /// # Errors
    /// As [`audit_segments`].
    pub fn audit(&self, problem: &Problem, settings: AuditSettings) -> Result<Option<Audit>, PlanError> {
        self.audit_by(self.carrier(problem)?.as_ref(), problem, settings)
    }

    pub(crate) fn audit_by(
        &self,
        carrier: Option<&Carrier>,
        problem: &Problem,
        settings: AuditSettings,
    ) -> Result<Option<Audit>, PlanError> {
        let carries = carrier.is_some();
        let segments: Result<Vec<Segment>, String> = self.segments.iter().map(PlanSegment::segment).collect();
        let audit = match (self.waypoints.is_empty(), segments) {
            (true, _) => return Ok(None),
            // Whoever says that the target is carried on must carry it on.
            (false, Ok(segments)) if carries && segments.len() == 1 => return Err(PlanError::Segments),
            (false, Ok(segments)) if carries => {
                let end = self.carry_end(problem)?;
                audit_segments(problem, carrier, &segments, end.as_ref(), settings)?
            }
            _ => audit_with(problem, &self.waypoints, settings)?,
        };
        let audit = if self.is_blended() { self.with_cut_corners(problem, audit, settings)? } else { audit };
        Ok(Some(match self.own_grasp {
            Some(said) => audit.with_said_grasp(said, self.reach().len().saturating_sub(1)),
            None => audit,
        }))
    }

    /// The audit of the edges, extended by that of the corners that the trajectory cuts.
    fn with_cut_corners(
        &self,
        problem: &Problem,
        mut audit: Audit,
        settings: AuditSettings,
    ) -> Result<Audit, PlanError> {
        if let Some(trajectory) = self.trajectory(problem.robot(), problem.cell().map(AsRef::as_ref))? {
            audit_cut_corners(problem, trajectory.cut_corners(), settings, &mut audit);
        }
        Ok(audit)
    }

    /// Whether the plan, which was read from `path`, moves the joints of a robot.
    ///
    /// # Errors
    /// [`ScenarioError::Content`] names the first that differs.
    pub fn check_joints(&self, path: &Path, robot: &Robot) -> Result<(), ScenarioError> {
        let mut pairs = self.joint_names.iter().zip(robot.joint_names());
        pairs.find(|(found, expected)| found != expected).map_or(Ok(()), |(found, expected)| {
            let problem =
                format!("the plan moves joint '{found}' where this scenario's robot has '{expected}'");
            Err(ScenarioError::Content { path: path.to_owned(), problem })
        })
    }
}

#[cfg(test)]
mod tests {
    use cranny_collision::Margins;
    use cranny_plan::{TimingMethod, Trajectory};

    use super::*;
    use crate::plan::segment::segments_of;
    use crate::{OpenOptions, PlanTiming, Scenario};

    fn plan(scenario: &Scenario) -> PlanFile {
        let mut end = scenario.start.clone();
        end[0] += 0.1;
        let plan = serde_json::json!({
            "scenario": "021", "robot": null, "geometry": null, "planner": "x", "settings": {}, "criterion": "exact",
            "goal_threshold": null, "seed": 0, "version": "0", "outcome": "solved", "margins": Margins::default(),
            "budget": {"iterations": null, "time_limit_s": null}, "joint_names": scenario.robot.joint_names(),
            "grasp": null, "translation_error_m": null, "rotation_error_rad": null, "clearance_m": null,
            "clearances_per_edge_m": [], "path_length": 0.1, "waypoints": [scenario.start, end],
            "statistics": cranny_plan::Statistics::default(),
        });
        let plan: PlanFile = serde_json::from_value(plan).unwrap();
        PlanFile { segments: segments_of(&plan.waypoints, &[]), ..plan }
    }

    #[test]
    fn a_plan_has_the_trajectory_that_its_timing_says() {
        let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let (plan, robot) = (plan(&scenario), &scenario.robot);
        assert_eq!(plan.trajectory(robot, None).unwrap().unwrap().method(), TimingMethod::TimeOptimal);
        let method = TimingMethod::JerkLimited;
        let timing = PlanTiming {
            method,
            blended: false,
            duration_s: 1.0,
            waypoint_times_s: Vec::new(),
            closing_s: None,
            opening_s: None,
        };
        let smooth = PlanFile { timing: Some(timing), ..plan.clone() };
        assert_eq!(smooth.trajectory(robot, None).unwrap().unwrap().method(), method);
        let none = PlanFile { waypoints: Vec::new(), segments: Vec::new(), ..plan };
        assert!(
            none.trajectory(robot, None).unwrap().is_none()
                && none.audit(&problem, AuditSettings::default()).unwrap().is_none()
        );
    }

    /// A hand does not close between two pieces of the way to the grasp, and a cell is asked only for cut corners.
    #[test]
    fn what_follows_the_closing_of_the_hand_is_timed_by_itself() {
        let scenario = Scenario::open("021", &OpenOptions::default()).unwrap();
        let plan = plan(&scenario);
        let [start, end] = [plan.waypoints[0].clone(), plan.waypoints[1].clone()];
        let segment = |mode, ends: [&Vec<f64>; 2]| {
            let waypoints = ends.map(Clone::clone).to_vec();
            PlanSegment::of(&Segment { mode, ..Segment::reach(waypoints, Vec::new()) })
        };
        let there = [segment(Mode::Reach, [&start, &end]), segment(Mode::Reach, [&end, &start])];
        let back = [segment(Mode::LiftOff, [&start, &end]), segment(Mode::Carry, [&end, &start])];
        let reaching = PlanFile { segments: there.to_vec(), ..plan };
        assert_eq!(reaching.legs(), [[start.clone(), end.clone(), start.clone()]]);
        let carrying = PlanFile { segments: [there, back].concat(), ..reaching.clone() };
        assert_eq!(carrying.legs()[1], [start.clone(), end, start]);
        assert!(!carrying.is_blended());
        let durations = |plan: &PlanFile| {
            let timed = plan.trajectory(&scenario.robot, None).unwrap().unwrap();
            (timed.reach().duration_s(), timed.legs().get(1).map(Trajectory::duration_s))
        };
        let (reach_s, none) = durations(&reaching);
        assert_eq!((none, durations(&carrying)), (None, (reach_s, Some(reach_s))));
        let problem = scenario.problem(Margins::default()).unwrap();
        assert!(reaching.task_cells(&problem).unwrap().is_none());
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
