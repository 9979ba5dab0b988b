use cranny_path::RELEASED_STEP_M;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::bidirectional::Bidirectional;
use crate::search::connector::connect;
use crate::search::growth::Growth;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// RBT-Connect: trees of burs that grow towards each other (Lačević, Osmanković & Ademović 2016, "Burs of free C-space: a novel
/// structure for path planning", ICRA, whole), with the goals of all grasps at once.
///
/// 1. As in [`RrtConnect`](crate::RrtConnect) inverse kinematics adds goals, and both sides take turns.
/// 2. A node is extended by a bur: spines towards the random configuration and in random directions, each as far as no pair can
///    have come into contact. The distances at the node prove a spine without another check.
/// 3. If the first spine would be shorter than a step, the node is extended by a proven step instead. The other side follows by
///    spines towards the new node, or steps.
///
/// One iteration is one random configuration, or one batch of inverse kinematics before there is a goal. There are two
/// differences from the publication. Each pair has its own distance instead of their minimum. The pairs of the robot with
/// itself are included; since they are always closer than the critical distance, that distance and the length of the spine in 3
/// refer to the world alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RbtConnect {
    /// Number of spines of a bur, including the one towards the target. Default 7, that of the released planners.
    pub spines: usize,
    /// Distance of the world from a moving link below which trees grow by steps, in metres. Default 0.1, as released.
    pub critical_m: f64,
    /// Maximum motion of the origin of any link frame in a step, in metres. Default 0.1, as released.
    pub step_m: f64,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
}

impl Default for RbtConnect {
    fn default() -> Self {
        Self { spines: 7, critical_m: 0.1, step_m: RELEASED_STEP_M, goals: 100 }
    }
}

impl Planner for RbtConnect {
    fn name(&self) -> &'static str {
        "rbt-connect"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .count("spines", self.spines, usize::MAX)?
            .positive("critical_m", self.critical_m)?
            .positive("step_m", self.step_m)?
            .count("goals", self.goals, usize::MAX)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let growth = Growth::Bur { spines: self.spines, critical_m: self.critical_m, step_m: self.step_m };
        let mut trees = Bidirectional::new(problem, growth);
        connect(self.name(), &mut trees, self.goals, problem, (budget, seed), observer)
    }
}
