use cranny_path::CostKind;
use cranny_plan::Improvement;
use cranny_solve::{Optimisation, Shortening};
use serde::{Deserialize, Serialize};

/// Statistics of the shortening of a path after the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanShortening {
    /// Number of random changes of the path that were tried, drawn from the plan's seed.
    pub attempts: usize,
    /// Number of further searches for a better path.
    #[serde(default)]
    pub searches: u64,
}

impl PlanShortening {
    pub(crate) fn of(shortening: &Shortening) -> Self {
        Self { attempts: shortening.attempts, searches: shortening.searches }
    }
}

/// Statistics of the optimisation of a path after the first search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanOptimisation {
    /// Time limit after the first path, in seconds.
    pub time_limit_s: f64,
    /// Cost of a path.
    #[serde(default)]
    pub cost: CostKind,
    /// Reward of a grasp of score 1, in the unit of the cost.
    pub score_weight: f64,
    /// Duration, in seconds.
    pub time_s: f64,
    /// Number of iterations of all searches together.
    pub iterations: u64,
    /// Cost over time: of the first path, and of each improvement.
    pub improvements: Vec<Improvement>,
}

impl PlanOptimisation {
    pub(crate) fn of(optimisation: &Optimisation) -> Self {
        Self {
            time_limit_s: optimisation.settings.time.as_secs_f64(),
            cost: optimisation.settings.cost,
            score_weight: optimisation.settings.score_weight,
            time_s: optimisation.time_s,
            iterations: optimisation.iterations,
            improvements: optimisation.improvements.clone(),
        }
    }
}
