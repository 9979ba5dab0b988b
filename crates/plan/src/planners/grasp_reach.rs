use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::planners::lane_search::LaneSearch;
use crate::search::clock::Clock;
use crate::search::goal_pool::GoalPool;
use crate::search::grasp_source::GraspSource;
use crate::{Budget, Observer, PathSearch, PlanError, PlanReport, Planner, Ranges, Reach};

/// [`Reach`] without a set of grasps: it samples them on the target while it searches.
///
/// 1. Antipodal grasps are sampled on the surface of the target (Eppner et al. 2019, §III), with the hand turned at random
///    about the line between the contacts, the more the more attempts of inverse kinematics were made. One below a score is
///    left out, and one at which the hand alone collides. The score that is asked falls to the least that is one
///    ([`GraspMeasure::LEAST_SCORE`](cranny_task::GraspMeasure::LEAST_SCORE)) with every batch that brings no goal.
/// 2. Batches of inverse kinematics go to those that are left. A configuration that is free is a goal if the hand holds
///    the target there, as whoever judges the path will find too.
/// 3. Everything else is as in [`Reach`]. There is always one more grasp to try, so that only the budget ends a search that
///    finds nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraspReach {
    /// How the search goes.
    #[serde(flatten)]
    pub search: Reach,
    /// The first grasps have at least this score, in [0, 1]. Default 0.5: half of the friction is then left for what is not
    /// as it was measured, and most objects have many such grasps.
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
