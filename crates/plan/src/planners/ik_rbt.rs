use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::growth::Growth;
use crate::search::ik_pipeline::{PipelineSettings, Shares, plan_goal_by_goal};
use crate::{Budget, IkRrt, Observer, PlanError, PlanReport, Planner, Ranges, RbtConnect};

/// IK-RBT, as in the programs released with the paper: [`IkRrt`] whose trees grow by burs ([`RbtConnect`]) instead of steps
/// where the world is farther away than the critical distance.
///
/// One iteration is one random configuration, or one turn of a grasp in inverse kinematics. Differs from the released program,
/// which takes given configurations one after the other, in these points:
///
/// - its inverse kinematics;
/// - the tree from the start keeps growing from goal to goal, and goals have their turns by the sequence of Luby, Sinclair &
///   Zuckerman (1993, "Optimal speedup of Las Vegas algorithms", whole: the strategy `S^univ`), short and long, because some
///   goals behind a wall are unreachable, and others behind a narrow passage take long;
/// - both trees grow towards the random configuration until they reach it or are blocked, as those of [`IkRrt`] do, whereas
///   [`RbtConnect`] makes one bur, and thus finds a narrow passage ten times later;
/// - its critical distance is four times the released one, because spines near obstacles are short, and cost more than steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IkRbt {
    /// [`IkRrt::p_goal`].
    pub p_goal: f64,
    /// [`RbtConnect::spines`].
    pub spines: usize,
    /// [`RbtConnect::critical_m`]. Default 0.4.
    pub critical_m: f64,
    /// [`RbtConnect::step_m`].
    pub step_m: f64,
    /// Maximum number of iterations per goal, times the share of its turn: 1, 1, 2, 1, 1, 2, 4, … Default 1000.
    pub goal_iterations: u64,
    /// [`IkRrt::ik_attempts`].
    pub ik_attempts: usize,
}

impl Default for IkRbt {
    fn default() -> Self {
        let RbtConnect { spines, step_m, .. } = RbtConnect::default();
        let IkRrt { p_goal, ik_attempts, .. } = IkRrt::default();
        Self { p_goal, spines, critical_m: 0.4, step_m, goal_iterations: 1000, ik_attempts }
    }
}

impl Planner for IkRbt {
    fn name(&self) -> &'static str {
        "ik-rbt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .share("p_goal", self.p_goal)?
            .count("spines", self.spines, usize::MAX)?
            .positive("critical_m", self.critical_m)?
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
        let Self { p_goal, spines, critical_m, step_m, goal_iterations, ik_attempts } = *self;
        let growth = Growth::Bur { spines, critical_m, step_m };
        let settings =
            PipelineSettings { growth, p_goal, goal_iterations, shares: Shares::Luby, ik_attempts };
        plan_goal_by_goal(settings, problem, (budget, seed), observer)
    }
}
