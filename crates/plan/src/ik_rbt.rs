use serde::{Deserialize, Serialize};

use crate::growth::Growth;
use crate::ik_pipeline::{PipelineSettings, plan_goal_by_goal};
use crate::{Budget, IkRrt, Observer, PlanError, PlanReport, Planner, Problem, RbtConnect};

/// IK-RBT, as in the programs that were released with the paper: [`IkRrt`] whose trees grow by burs ([`RbtConnect`]) in the
/// place of steps, where the world is farther away than the critical distance.
///
/// One iteration is one random configuration, or one turn of a grasp in inverse kinematics. Differs from the released
/// program, which takes given configurations one after the other, in its inverse kinematics, and in that both trees grow
/// towards the random configuration until they are there or blocked, as those of [`IkRrt`] do, where [`RbtConnect`] makes one
/// bur: with one a gate is found ten times later.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IkRbt {
    /// [`IkRrt::p_goal`].
    pub p_goal: f64,
    /// [`RbtConnect::spines`].
    pub spines: usize,
    /// [`RbtConnect::critical_m`].
    pub critical_m: f64,
    /// [`RbtConnect::step_m`].
    pub step_m: f64,
    /// [`IkRrt::goal_iterations`]. Default 2000: burs go farther in one.
    pub goal_iterations: u64,
    /// [`IkRrt::ik_attempts`].
    pub ik_attempts: usize,
}

impl Default for IkRbt {
    fn default() -> Self {
        let RbtConnect { spines, critical_m, step_m, .. } = RbtConnect::default();
        let IkRrt { p_goal, ik_attempts, .. } = IkRrt::default();
        Self { p_goal, spines, critical_m, step_m, goal_iterations: 2000, ik_attempts }
    }
}

impl Planner for IkRbt {
    fn name(&self) -> &'static str {
        "ik-rbt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        problem.exact_cell(self.name())?;
        let Self { p_goal, spines, critical_m, step_m, goal_iterations, ik_attempts } = *self;
        let growth = Growth::Bur { spines, critical_m, step_m };
        let settings = PipelineSettings { growth, p_goal, goal_iterations, ik_attempts };
        plan_goal_by_goal(settings, problem, (budget, seed), observer)
    }
}
