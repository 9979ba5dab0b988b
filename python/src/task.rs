//! What is planned, judged and shown: a scenario, or a problem in other people's files.

use std::path::PathBuf;
use std::sync::Arc;

use cranny_plan::Problem;
use cranny_scenario::{Demands, Scenario};
use pyo3::prelude::*;

use crate::fault::bad_type;
use crate::moveit_problem::PyMoveItProblem;
use crate::scenario::PyScenario;

/// A task as one of the classes gave it.
pub struct Task {
    pub id: String,
    pub problem: Problem,
    /// What pictures are made of; a problem of others has none.
    pub scenario: Option<Arc<Scenario>>,
    /// The URDF that was given instead of the scenario's robot.
    pub robot_file: Option<PathBuf>,
    /// The scenario or problem as it was given.
    pub given: Py<PyAny>,
}

impl Task {
    pub fn of(value: &Bound<'_, PyAny>, demands: &Demands) -> PyResult<Self> {
        if let Ok(scenario) = value.cast::<PyScenario>() {
            let scenario = scenario.get();
            return Ok(Self {
                id: scenario.scenario.id.clone(),
                problem: scenario.problem(demands)?,
                scenario: Some(scenario.scenario.clone()),
                robot_file: scenario.robot_file.clone(),
                given: value.clone().unbind(),
            });
        }
        if let Ok(problem) = value.cast::<PyMoveItProblem>() {
            let problem = problem.get();
            let id = problem.problem.id.clone();
            return Ok(Self {
                id,
                problem: problem.problem(demands)?,
                scenario: None,
                robot_file: None,
                given: value.clone().unbind(),
            });
        }
        Err(bad_type(format!(
            "scenario: a Scenario or a MoveItProblem is expected, not {}",
            value.get_type()
        )))
    }
}
