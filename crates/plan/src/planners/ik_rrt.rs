use cranny_path::RELEASED_STEP_M;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::growth::Growth;
use crate::search::ik_pipeline::{PipelineSettings, Shares, plan_goal_by_goal};
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// IK-RRT (the paper's §V.B): finds a configuration for a grasp by inverse kinematics, then a path to it by a bidirectional
/// RRT; if that fails, continues with the next grasp, from the highest score down.
///
/// 1. Grasps at which the hand alone collides are discarded (`exact`); if none is left, no grasp can be reached.
/// 2. Inverse kinematics finds a new configuration for the next grasp in order, or its twin, in rounds: first from the start
///    with a pull towards it, then from random configurations. It is free under `exact`, unchecked under `paper`, as released.
/// 3. A tree from the start and a tree from that goal both grow towards the same random configuration (with probability
///    `p_goal` towards the goal) until each reaches it or is blocked. If both reach it, they form a path.
/// 4. After `goal_iterations` without a path, the search continues with 2.
///
/// A problem with goal configurations instead of grasps starts at 3. One iteration is one random configuration of 3, or one
/// turn of a grasp in 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IkRrt {
    /// Probability of growing towards the goal itself, in [0, 1]. Default 0.01, the paper's.
    pub p_goal: f64,
    /// Maximum motion of the origin of any link frame in a step, in metres. Default 0.1, the released value.
    pub step_m: f64,
    /// Maximum number of iterations per goal. Default 20 000.
    pub goal_iterations: u64,
    /// Maximum number of attempts of inverse kinematics per grasp and round. Default 100: a second round costs less than a
    /// grasp without a solution.
    pub ik_attempts: usize,
}

impl Default for IkRrt {
    fn default() -> Self {
        Self { p_goal: 0.01, step_m: RELEASED_STEP_M, goal_iterations: 20_000, ik_attempts: 100 }
    }
}

impl Planner for IkRrt {
    fn name(&self) -> &'static str {
        "ik-rrt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .share("p_goal", self.p_goal)?
            .positive("step_m", self.step_m)?
            .positive("goal_iterations", self.goal_iterations as f64)?
            .count("ik_attempts", self.ik_attempts, usize::MAX)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let Self { p_goal, step_m, goal_iterations, ik_attempts } = *self;
        let settings = PipelineSettings {
            growth: Growth::Step { step_m },
            p_goal,
            goal_iterations,
            shares: Shares::Equal,
            ik_attempts,
        };
        plan_goal_by_goal(settings, problem, (budget, seed), observer)
    }
}
