use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::curves::curve_settings::CurveSettings;
use crate::curves::obstacle_cost::CostRange;
use crate::curves::starts::improve;
use crate::planners::optimisers::covariant_descent::{CovariantDescent, Descent};
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges, Reach};

/// CHOMP (Zucker et al. 2013, "CHOMP: Covariant Hamiltonian optimization for motion planning", §3 and §4, without its Hamiltonian
/// Monte Carlo): gradient descent of a curve in the metric of its smoothness.
///
/// 1. A start begins with a straight line to a goal (the starts are those of `curves/starts.rs`, which also proves the curves).
/// 2. A step is `ξ ← ξ − η·A⁻¹·(w_o·∇F_obs + w_s·∇F_smooth)`, with A the metric of velocities and `F_obs` the cost of certified
///    distances; its gradient is bounded by `most_slope`.
/// 3. Joint limits: while a way point violates them, `ξ ← ξ + s·A⁻¹v`, with `v` the violation and `s` such that the greatest one
///    vanishes, up to ten times (§4.1); the rest is clamped.
///
/// One iteration is one step, or one batch of inverse kinematics. The defaults are those of the code of OMG-Planner (`liruiw/OMG-Planner`
/// 53e899c, `omg/config.py`), which descends in the same way, except for the nearness of hand and links.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
// Unknown keys are refused when a planner is created.
pub struct Chomp {
    /// Way points, steps and starts.
    #[serde(flatten)]
    pub curve: CurveSettings,
    /// Distances that cost.
    #[serde(flatten)]
    pub range: CostRange,
    /// Covariant descent.
    #[serde(flatten)]
    pub descent: Descent,
}

impl Planner for Chomp {
    fn name(&self) -> &'static str {
        "chomp"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        let ranges = self.curve.check(Ranges::of(self.name()))?;
        self.descent.check(self.range.check(ranges)?)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        self.check()?;
        let cell = problem.exact_cell(self.name())?;
        let mut descent = CovariantDescent::new(cell, self.range, self.descent);
        let guide = Reach::default();
        improve(self.name(), self.curve, &mut descent, &guide, problem, (budget, seed), observer)
    }
}
