use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::growth::Growth;
use crate::search::jacobian_search::{GraspChoice, JacobianSettings, plan_by_jacobian};
use crate::{Budget, JPlusRrt, Observer, PlanError, PlanReport, Planner, Ranges, RbtConnect};

/// J⁺-RBT, as in the programs released with the paper: [`JPlusRrt`] whose tree grows towards random configurations by burs
/// ([`RbtConnect`]) instead of steps where the world is farther away than the critical distance.
///
/// One iteration is one bur, one step, or one series of pseudo-inverse steps towards a grasp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JPlusRbt {
    /// [`JPlusRrt::p_goal`].
    pub p_goal: f64,
    /// [`RbtConnect::spines`].
    pub spines: usize,
    /// [`RbtConnect::critical_m`].
    pub critical_m: f64,
    /// [`JPlusRrt::step_m`].
    pub step_m: f64,
    /// [`JPlusRrt::choice`].
    pub choice: GraspChoice,
    /// [`JPlusRrt::damping`].
    pub damping: f64,
}

impl Default for JPlusRbt {
    fn default() -> Self {
        let JPlusRrt { p_goal, step_m, choice, damping } = JPlusRrt::default();
        let RbtConnect { spines, critical_m, .. } = RbtConnect::default();
        Self { p_goal, spines, critical_m, step_m, choice, damping }
    }
}

impl Planner for JPlusRbt {
    fn name(&self) -> &'static str {
        "j-plus-rbt"
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
        let Self { p_goal, spines, critical_m, step_m, choice, damping } = *self;
        let growth = Growth::Bur { spines, critical_m, step_m };
        let settings = JacobianSettings { p_goal, growth, choice, damping };
        plan_by_jacobian(self.name(), settings, problem, (budget, seed), observer)
    }
}
