use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::planners::lane_search::LaneSearch;
use crate::search::clock::Clock;
use crate::search::goal_pool::GoalPool;
use crate::search::grasp_source::GraspSource;
use crate::{Budget, Observer, PathSearch, PlanError, PlanReport, Planner, Ranges, Reach};

/// [`Reach`] without a set of grasps: it samples them on the target during the search.
///
/// 1. Antipodal grasps are sampled on the surface of the target (Eppner et al. 2019, §III), with random rotation of the hand
///    about the line between the contacts, in proportion to the attempts of inverse kinematics made. A grasp is discarded if
///    its score is too low or the hand alone collides. The required score decreases to the minimum
///    ([`GraspMeasure::LEAST_SCORE`](cranny_task::GraspMeasure::LEAST_SCORE)) with every batch without a goal.
/// 2. Batches of inverse kinematics go to the remaining grasps. A free configuration is a goal if the hand holds the target
///    there, by the same judge as in the audit of the path.
/// 3. Everything else is as in [`Reach`]. The supply of grasps never ends, so only the budget ends an unsuccessful search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraspReach {
    /// Settings of the search.
    #[serde(flatten)]
    pub search: Reach,
    /// Minimum score of the first grasps, in [0, 1]. Default 0.5: half of the friction then remains as a reserve for
    /// measurement errors, and most objects have many such grasps.
    pub first_score: f64,
}

impl Default for GraspReach {
    fn default() -> Self {
        Self { search: Reach::default(), first_score: 0.5 }
    }
}

impl Planner for GraspReach {
    fn name(&self) -> &'static str {
        "grasp-reach"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        self.search.search_ranges(Ranges::of(self.name()))?.share("first_score", self.first_score)?;
        Ok(())
    }

    fn makes_grasps(&self) -> bool {
        true
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        self.search(problem, budget, seed)?.next(observer)
    }

    fn begin<'a>(
        &self,
        problem: &'a Problem,
        budget: &Budget,
        seed: u64,
    ) -> Result<Option<Box<dyn PathSearch + 'a>>, PlanError> {
        Ok(Some(Box::new(self.search(problem, budget, seed)?)))
    }
}

impl GraspReach {
    fn search<'a>(
        &self,
        problem: &'a Problem,
        budget: &Budget,
        seed: u64,
    ) -> Result<LaneSearch<'a>, PlanError> {
        let clock = Clock::new(budget);
        let measure = problem.own_grasp_measure(self.name())?;
        let source = GraspSource::new(measure, self.first_score)?;
        let pool = GoalPool::sampling(problem, problem.exact_cell(self.name())?, source);
        self.search.search_in(problem, Some(pool), clock, seed)
    }
}
