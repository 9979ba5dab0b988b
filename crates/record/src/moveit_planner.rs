use std::path::Path;
use std::time::Duration;

use cranny_collision::Margins;
use cranny_path::sample_times;
use cranny_plan::Observer;
use cranny_scenario::{MoveItProblem, MoveItRobot};
use cranny_solve::{Request, solve};
use serde_json::Value;

use crate::moveit_response::response;
use crate::{PlanOptions, RecordError};

/// Planner of `MoveIt`'s requests for one robot, from message to message.
#[derive(Clone, Debug)]
pub struct MoveItPlanner {
    robot: MoveItRobot,
    settings: MoveItSettings,
}

/// Settings of a [`MoveItPlanner`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveItSettings {
    /// Maximum time of a search; a request may allow less (`allowed_planning_time`). Default: 30 s, six times what `MoveIt`
    /// usually allows.
    pub most_time: Duration,
    /// Sample rate of trajectories, in Hz. Default: 100, the rate of common controllers.
    pub rate_hz: f64,
    /// Clearance, in metres, that every check and proof requires. Default: 0.
    pub margin_m: f64,
}

impl Default for MoveItSettings {
    fn default() -> Self {
        Self { most_time: Duration::from_secs(30), rate_hz: 100.0, margin_m: 0.0 }
    }
}

impl MoveItPlanner {
    /// Reads the files of a robot, as [`MoveItRobot::open`].
    ///
    /// # Errors
    /// Those of [`MoveItRobot::open`], and [`RecordError::Path`] for an invalid sample rate.
    pub fn open(robot: &Path, srdf: Option<&Path>, settings: MoveItSettings) -> Result<Self, RecordError> {
        sample_times(0.0, settings.rate_hz).map(drop)?;
        Ok(Self { robot: MoveItRobot::open(robot, srdf)?, settings })
    }

    /// Name of the robot.
    pub fn robot_name(&self) -> &str {
        self.robot.name()
    }

    /// Names of the groups of the SRDF.
    pub fn groups(&self) -> Vec<&str> {
        self.robot.srdf().groups.iter().map(|group| group.name.as_str()).collect()
    }

    /// Plans a document `{"planning_scene": …, "motion_plan_request": …}` of `MoveIt`'s messages, and returns
    /// `{"motion_plan_response": …, "cranny": …}`: the response of `MoveIt`, and what was proven.
    ///
    /// The same document gives the same path, unless the time limit stops the search.
    ///
    /// # Errors
    /// [`RecordError`] for a malformed document, as [`MoveItProblem::of_document`]. A search without a path is a response.
    pub fn plan(&mut self, document: Value, observer: &mut dyn Observer) -> Result<Value, RecordError> {
        let MoveItSettings { most_time, rate_hz, margin_m } = self.settings;
        let asked = MoveItProblem::of_document(document, &mut self.robot)?;
        let problem = asked.problem(Margins { margin_m, grasp_margin_m: 0.0, ..Margins::default() })?;
        let options = PlanOptions {
            time_limit: asked.allowed_time.map_or(most_time, |time| time.min(most_time)),
            tool_m_s: asked.tool_speed_m_s,
            ..PlanOptions::default()
        };
        let (request, _) = options.request(&problem, None)?;
        // They take longer than the search, and a response has no field for them.
        let request = Request { robustness: false, least_length: false, ..request };
        let answer = solve(&problem, &request, observer)?;
        response(&asked, &problem, &answer, rate_hz)
    }
}
