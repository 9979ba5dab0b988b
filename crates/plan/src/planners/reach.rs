use cranny_path::JointMetric;
use cranny_task::{Goal, Problem};

use crate::planners::lane_search::LaneSearch;
use crate::search::clock::Clock;
use crate::search::goal_pool::GoalPool;
use crate::{Budget, Observer, PathSearch, PlanError, PlanReport, Planner, Ranges, Reach};

impl Planner for Reach {
    fn name(&self) -> &'static str {
        "reach"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        self.search_ranges(Ranges::of(self.name()))?;
        Ok(())
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

impl Reach {
    fn search<'a>(
        &self,
        problem: &'a Problem,
        budget: &Budget,
        seed: u64,
    ) -> Result<LaneSearch<'a>, PlanError> {
        let clock = Clock::new(budget);
        let cell = problem.exact_cell(self.name())?;
        let pool = match problem.some_goal()? {
            Goal::Grasps(grasps) => Some(GoalPool::new(problem, cell, grasps)),
            Goal::Regions(regions) => Some(GoalPool::of_regions(problem, cell, regions)),
            Goal::Configurations(_) => None,
        };
        self.search_in(problem, pool, clock, seed)
    }

    /// Creates the search for a path to the goals of a pool, or to those of the problem.
    pub(crate) fn search_in<'a>(
        &self,
        problem: &'a Problem,
        pool: Option<GoalPool<'a>>,
        clock: Clock,
        seed: u64,
    ) -> Result<LaneSearch<'a>, PlanError> {
        let metric = JointMetric::by_reach(problem.robot());
        Ok(LaneSearch::new(self.clone(), problem, metric, (clock, seed))?.with_pool(pool))
    }
}
