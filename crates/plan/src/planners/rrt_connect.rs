use cranny_path::RELEASED_STEP_M;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::bidirectional::Bidirectional;
use crate::search::connector::connect;
use crate::search::growth::Growth;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// RRT-Connect (Kuffner & `LaValle` 2000, §II) with the goals of all grasps at once.
///
/// 1. Inverse kinematics adds goal configurations, each the root of its own tree.
/// 2. The tree from the start and the forest from the goals grow in turn: one by a step from its nearest node (L2 in joint
///    space) towards a uniform random configuration, the other by steps towards the new node until it arrives or is blocked.
/// 3. Every step is proven when it is taken, so that a path needs no further proof.
///
/// One iteration is one random configuration, or one batch of inverse kinematics before there is a goal. Differs from the
/// publication in 1, and in that the length of a step is measured at the links.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RrtConnect {
    /// Maximum motion of the origin of any link frame in a step, in metres. Default 0.1, that of the released planners.
    pub step_m: f64,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
}

impl Default for RrtConnect {
    fn default() -> Self {
        Self { step_m: RELEASED_STEP_M, goals: 100 }
    }
}

impl Planner for RrtConnect {
    fn name(&self) -> &'static str {
        "rrt-connect"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name()).positive("step_m", self.step_m)?.count("goals", self.goals, usize::MAX)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let growth = Growth::Step { step_m: self.step_m };
        let mut trees = Bidirectional::new(problem, growth);
        connect(self.name(), &mut trees, self.goals, problem, (budget, seed), observer)
    }
}
