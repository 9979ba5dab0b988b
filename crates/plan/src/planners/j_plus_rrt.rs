use cranny_path::RELEASED_STEP_M;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::growth::Growth;
use crate::search::jacobian_search::{GraspChoice, JacobianSettings, plan_by_jacobian};
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// J⁺-RRT (Vahrenkamp, Berenson, Asfour, Kuffner & Dillmann 2009, "Humanoid motion planning for dual-arm manipulation and
/// re-grasping tasks", whole, the planner of this name; such steps also in Shkolnik & Tedrake 2009, "Path planning in 1000+
/// dimensions using a task-space Voronoi bias", §III; the paper's §V.A): one tree from the start that grows towards random
/// configurations and, at times, towards a grasp by steps of the pseudo-inverse of the Jacobian.
///
/// 1. With probability `1 − p_goal`, takes one step from the nearest node towards a uniform random configuration.
/// 2. Otherwise chooses a grasp, and takes pseudo-inverse steps from its nearest node until the gripper arrives, the motion is
///    blocked, or the gripper comes no closer.
/// 3. Every new node is measured against all grasps; the first that has arrived ends the search.
///
/// One iteration is one pass through 1 or 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JPlusRrt {
    /// Probability of growing towards a grasp, in [0, 1]. Default 0.01, the paper's.
    pub p_goal: f64,
    /// Maximum motion of the origin of any link frame in a step, in metres. Default 0.1, the released value.
    pub step_m: f64,
    /// Choice of the grasp to grow towards. Default: uniform.
    pub choice: GraspChoice,
    /// Damping λ of the pseudo-inverse. Default 0.05: enough to bound steps near singularities without slowing them elsewhere.
    pub damping: f64,
}

impl Default for JPlusRrt {
    fn default() -> Self {
        Self { p_goal: 0.01, step_m: RELEASED_STEP_M, choice: GraspChoice::Uniform, damping: 0.05 }
    }
}

impl Planner for JPlusRrt {
    fn name(&self) -> &'static str {
        "j-plus-rrt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .share("p_goal", self.p_goal)?
            .positive("step_m", self.step_m)?
            .positive("damping", self.damping)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let Self { p_goal, step_m, choice, damping } = *self;
        let settings = JacobianSettings { p_goal, growth: Growth::Step { step_m }, choice, damping };
        plan_by_jacobian(self.name(), settings, problem, (budget, seed), observer)
    }
}
