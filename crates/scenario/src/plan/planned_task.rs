use cranny_collision::World;
use cranny_plan::{PlanError, Problem, StatesAlong, are_complete};

use crate::{PlanFile, PlanSource, Scenario, ScenarioError};

impl Scenario {
    /// The source of a plan's problem, with the task whose name the plan states if the scenario has it.
    pub fn source_of(&self, plan: &PlanFile, source: &PlanSource) -> PlanSource {
        let task = plan.task_name.as_ref().and_then(|name| self.task(name).ok());
        PlanSource { task: task.cloned(), ..source.clone() }
    }

    /// Checks that the stages of a plan are those of the task that it names, and that its path comes to their end.
    ///
    /// # Errors
    /// [`ScenarioError::UnknownTask`]; [`ScenarioError::Plan`] for other stages, or a path that ends before.
    pub fn check_task(&self, plan: &PlanFile) -> Result<(), ScenarioError> {
        let refuse = |problem: String| Err(PlanError::Segments { problem }.into());
        if let Some(name) = &plan.task_name {
            let own = &self.task(name)?.stages;
            if own.len() != plan.task.len() || own.iter().zip(&plan.task).any(|(a, b)| !a.is_like(b)) {
                return refuse(format!(
                    "the stages of the plan are not those of task '{name}' of '{}'",
                    self.id
                ));
            }
        }
        let has_path = !plan.task.is_empty() && !plan.segments.is_empty();
        if has_path && !are_complete(&plan.task, &plan.segments) {
            return refuse(format!(
                "the path of the plan ends before its {} stages are done",
                plan.task.len()
            ));
        }
        Ok(())
    }

    /// The scenario once a plan has been carried out: bodies stand where it has put them, and the robot where it ends. The
    /// scenario's own grasps move with its target.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for a plan without a path, whose hand cannot do what it demands, or that holds an object at its
    /// end.
    pub fn after(&self, plan: &PlanFile, problem: &Problem) -> Result<Self, ScenarioError> {
        let refuse = |problem: &str| PlanError::Segments { problem: problem.to_owned() };
        let along =
            plan.states(problem)?.ok_or_else(|| refuse("under the paper criterion nothing is put down"))?;
        let StatesAlong { end, stopped: None, states, .. } = along else {
            return Err(refuse("the hand cannot do what the plan demands").into());
        };
        if states.is_empty() || end.held().is_some() {
            return Err(refuse("at its end the plan has put nothing down").into());
        }
        self.with_bodies_of(end.empty_cell().world(), &end.q)
    }

    /// The scenario with each body where a world has the one of its name, and the robot at a configuration.
    fn with_bodies_of(&self, world: &World, q: &[f64]) -> Result<Self, ScenarioError> {
        let mut now = self.clone();
        for body in world.bodies() {
            let own = self.world.body_index(&body.name).map_err(PlanError::from)?;
            let first = |world: &World, index: usize| {
                world.bodies()[index].parts.first().map(|part| part.world_from_solid)
            };
            let moved = body.parts.first().map(|part| part.world_from_solid).zip(first(&self.world, own));
            if let Some((to, from)) = moved.filter(|(to, from)| to != from) {
                now = now.with_moved(own, &(to * from.inverse()), q)?;
            }
        }
        Ok(Self { start: q.to_vec(), ..now })
    }
}
