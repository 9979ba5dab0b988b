use cranny_scenario::Scenario;
use cranny_task::{Problem, StateSequence, TaskError, are_complete};

use crate::{PlanFile, PlanSource, RecordError};

impl PlanFile {
    /// Returns the source of the problem, with the scenario's task of the stated name if there is one.
    pub fn source_in(&self, scenario: &Scenario, source: &PlanSource) -> PlanSource {
        let task = self.task_name.as_ref().and_then(|name| scenario.task(name).ok());
        PlanSource { task: task.cloned(), ..source.clone() }
    }

    /// Checks that the stages are those of the named task of the scenario, and that the path reaches the end of the last one.
    ///
    /// # Errors
    /// [`ScenarioError::UnknownTask`](cranny_scenario::ScenarioError::UnknownTask); [`TaskError::Segments`] for other stages,
    /// or a path that ends early.
    pub fn check_task(&self, scenario: &Scenario) -> Result<(), RecordError> {
        let refuse = |problem: String| Err(TaskError::Segments { problem }.into());
        if let Some(name) = &self.task_name {
            let own = &scenario.task(name)?.stages;
            if own.len() != self.task.len() || own.iter().zip(&self.task).any(|(a, b)| !a.is_like(b)) {
                let id = &scenario.id;
                return refuse(format!("the stages of the plan are not those of task '{name}' of '{id}'"));
            }
        }
        let has_path = !self.task.is_empty() && !self.segments.is_empty();
        if has_path && !are_complete(&self.task, &self.segments) {
            let stages = self.task.len();
            return refuse(format!("the path of the plan ends before its {stages} stages are done"));
        }
        Ok(())
    }

    /// Returns the scenario after the plan: bodies stand where the robot has put them, and the robot where the path ends.
    ///
    /// # Errors
    /// [`TaskError::Segments`] for a plan without a path, with an impossible motion of the hand, or with an object in the hand
    /// at its end.
    pub fn scenario_after(&self, scenario: &Scenario, problem: &Problem) -> Result<Scenario, RecordError> {
        let refuse = |problem: &str| TaskError::Segments { problem: problem.to_owned() };
        let along =
            self.states(problem)?.ok_or_else(|| refuse("under the paper criterion nothing is put down"))?;
        let StateSequence { end, stopped: None, states, .. } = along else {
            return Err(refuse("the plan contains an impossible motion of the hand").into());
        };
        if states.is_empty() || end.held().is_some() {
            return Err(refuse("at its end the plan has put nothing down").into());
        }
        Ok(scenario.with_bodies_of(end.empty_cell().world(), &end.q)?)
    }
}
