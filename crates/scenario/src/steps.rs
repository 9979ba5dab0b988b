use cranny_collision::World;
use cranny_plan::{AfterPlacing, PlanError, Problem};

use crate::{PlanFile, Scenario, ScenarioError, TargetPhysics};

/// A step of a task: something is picked, and put down elsewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// What is picked: the target, or an obstacle.
    pub pick: String,
    /// Where it is put down: a place of the scenario.
    pub place: String,
    /// Where the robot goes then.
    pub then: AfterPlacing,
}

impl Scenario {
    /// The scenario in which what a step picks is the target. The scenario's own target has its own grasps; of anything else
    /// none are given, and whoever plans makes one.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for a step that picks what there is not.
    pub fn at_step(&self, step: &Step) -> Result<Self, ScenarioError> {
        let target = self.world.body_index(&step.pick).map_err(PlanError::from)?;
        if self.target == Some(target) {
            return Ok(self.clone());
        }
        let (target, physics) = (Some(target), TargetPhysics::default());
        Ok(Self { target, target_source: None, given_physics: physics, ..self.without_grasps() })
    }

    /// The scenario as it is once a plan has been carried out that put the target of its problem down: this has moved, and
    /// the robot stands where the plan ends. The scenario's own grasps move with its target.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for a plan that puts nothing down.
    pub fn after(&self, plan: &PlanFile, problem: &Problem) -> Result<Self, ScenarioError> {
        let placed = plan.task_cells(problem)?.and_then(|cells| cells.placed().copied());
        let (Some(target), Some(placed), Some(end)) = (problem.target(), placed, plan.waypoints.last())
        else {
            return Err(PlanError::Segments.into());
        };
        let mut bodies = self.world.bodies().to_vec();
        let first = bodies[target].parts.first().map(|part| part.world_from_solid);
        let motion = placed * first.unwrap_or_default().inverse();
        for part in &mut bodies[target].parts {
            part.world_from_solid = motion * part.world_from_solid;
        }
        let is_own = self.target == Some(target);
        let grasps = if is_own { self.grasps.moved(&motion) } else { self.grasps.clone() };
        let world = World::new(bodies)?;
        Ok(Self { world, grasps, start: end.clone(), ik: Vec::new(), export: None, ..self.clone() })
    }
}
