use cranny_path::CostKind;
use cranny_plan::Improvement;
use cranny_solve::{Optimisation, Shortening};
use serde::{Deserialize, Serialize};

/// How a path was shortened after the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanShortening {
    /// Random changes of the path that were tried, drawn from the plan's seed.
    pub attempts: usize,
    /// Further searches for a better path.
    #[serde(default)]
    pub searches: u64,
}

impl PlanShortening {
    pub(crate) fn of(shortening: &Shortening) -> Self {
        Self { attempts: shortening.attempts, searches: shortening.searches }
    }
}

/// How a path was bettered after the first search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanOptimisation {
    /// How long it was to go on after the first path, in seconds.
    pub time_limit_s: f64,
    /// What was measured of a path.
    #[serde(default)]
    pub cost: CostKind,
    /// What a grasp of score 1 is worth, in the unit of the cost.
    pub score_weight: f64,
    /// How long it went on, in seconds.
    pub time_s: f64,
    /// Iterations of all searches together.
    pub iterations: u64,
    /// The cost over time: of the first path, and of every better one.
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
