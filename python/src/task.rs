//! Tasks of planning, verification and display: a scenario, or a problem from external files.

use cranny_collision::Margins;
use cranny_record::PlanSource;
use cranny_scenario::{GivenGrasps, Scenario};
use cranny_task::{Criterion, Goal, Problem};
use pyo3::prelude::*;

use crate::classes::{PyMoveItProblem, PyScenario, Task};
use crate::handover::fault::{bad_type, fault};

impl Task {
    pub fn of(value: &Bound<'_, PyAny>, margins: Margins) -> PyResult<Self> {
        if let Ok(scenario) = value.cast::<PyScenario>() {
            let scenario = scenario.get();
            return Ok(Self {
                source: PlanSource {
                    scenario: scenario.scenario.id.clone(),
                    robot: scenario.robot_file.clone(),
                    geometry: scenario.geometry,
                    grasps: scenario.given_grasps.clone(),
                    margins,
                    task: None,
                },
                problem: scenario.problem(margins)?,
                tool_m_s: None,
                scenario: Some(scenario.scenario.clone()),
                given: value.clone().unbind(),
            });
        }
        if let Ok(problem) = value.cast::<PyMoveItProblem>() {
            let problem = problem.get();
            return Ok(Self {
                source: PlanSource {
                    scenario: problem.problem.id.clone(),
                    robot: problem.robot_file.clone(),
                    geometry: None,
                    grasps: GivenGrasps::Own,
                    margins: Margins { grasp_margin_m: 0.0, ..margins },
                    task: None,
                },
                problem: problem.problem(margins)?,
                tool_m_s: problem.problem.tool_speed_m_s,
                scenario: None,
                given: value.clone().unbind(),
            });
        }
        Err(bad_type(format!(
            "scenario: a Scenario or a MoveItProblem is expected, not {}",
            value.get_type()
        )))
    }
}

impl PyScenario {
    /// Returns the planning problem.
    pub fn problem(&self, margins: Margins) -> PyResult<Problem> {
        self.with_its_goals(self.scenario.problem(margins).map_err(fault)?)
    }

    fn with_its_goals(&self, problem: Problem) -> PyResult<Problem> {
        let Some(goals) = &self.goals else { return Ok(problem) };
        problem.with_goal(Goal::Configurations(goals.clone())).map_err(fault)
    }

    /// Returns the problem under `exact`, regardless of the criterion of the scenario.
    pub fn exact_problem(&self, margins: Margins) -> PyResult<Problem> {
        let exact = Scenario { criterion: Criterion::Exact, ..(*self.scenario).clone() };
        exact.problem(margins).map_err(fault)
    }
}
