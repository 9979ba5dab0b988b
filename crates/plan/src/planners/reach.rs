use crate::path::joint_metric::JointMetric;
use crate::planners::lane_search::LaneSearch;
use crate::search::clock::Clock;
use crate::search::goal_pool::GoalPool;
use crate::{Budget, Goal, Observer, PlanError, PlanReport, Planner, Problem, Ranges, Reach};

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

    fn asks_about_goals(&self) -> bool {
        true
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let clock = Clock::new(budget);
        let cell = problem.exact_cell(self.name())?;
        let pool = match problem.some_goal()? {
            Goal::Grasps(grasps) => Some(GoalPool::new(problem, cell, grasps)),
            Goal::Configurations(_) => None,
        };
        self.search(problem, pool, clock, seed, observer)
    }
}

impl Reach {
    /// The search for a way to the goals of a pool, or to those of the problem.
    pub(crate) fn search(
        &self,
        problem: &Problem,
        pool: Option<GoalPool>,
        clock: Clock,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let metric = JointMetric::by_reach(problem.robot());
        let mut search = LaneSearch::new(self.clone(), problem, metric, (clock, seed), observer)?;
        let ended = search.run(pool);
        Ok(search.report(ended))
    }
}
