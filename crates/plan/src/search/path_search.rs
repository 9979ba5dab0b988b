use std::time::Duration;

use cranny_spatial::{EXACT_TRANSLATION_M, other_seed};
use cranny_task::{Goal, Problem, Region};

use crate::search::no_grasp::all_excluded;
use crate::{Budget, Observer, Outcome, PathSearch, PlanError, PlanReport, Planner, Statistics};

/// Runs a planner with valid settings ([`Planner::check`]). If every grasp is excluded beforehand, by its width or because it
/// is beyond reach, or every region, no search begins.
///
/// # Errors
/// Those of the planner.
pub fn search(
    planner: &dyn Planner,
    problem: &Problem,
    budget: &Budget,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<PlanReport, PlanError> {
    planner.check()?;
    match excluded(problem) {
        Some(report) => Ok(report),
        None => planner.plan(problem, budget, seed, observer),
    }
}

/// Begins the search of a planner for one path after another, as [`search`] does for one.
///
/// # Errors
/// Those of the planner.
pub fn begin_search<'a>(
    planner: &'a dyn Planner,
    problem: &'a Problem,
    budget: &Budget,
    seed: u64,
) -> Result<Box<dyn PathSearch + 'a>, PlanError> {
    planner.check()?;
    if let Some(report) = excluded(problem) {
        return Ok(Box::new(Ended(report)));
    }
    let own = planner.begin(problem, budget, seed)?;
    Ok(own.unwrap_or_else(|| {
        Box::new(Restarts { planner, problem, budget: *budget, seed, count: 0, spent: Statistics::default() })
    }))
}

/// Returns the report on a problem whose grasps are all excluded, or whose regions are all beyond reach.
fn excluded(problem: &Problem) -> Option<PlanReport> {
    if let Goal::Regions(regions) = problem.goal()
        && are_out_of_reach(problem, regions)
        && problem.start_is_free()
    {
        return Some(PlanReport::of(Err(Outcome::RegionOutOfReach), Statistics::default()));
    }
    let failures = all_excluded(problem).filter(|_| problem.start_is_free())?;
    let report = PlanReport::of(Err(Outcome::NoReachableGrasp), Statistics::default());
    Some(PlanReport { failures, ..report })
}

/// Returns true if the positions of all regions are provably beyond the reach of the arm.
fn are_out_of_reach(problem: &Problem, regions: &[Region]) -> bool {
    let reach = problem.robot().reach_bound();
    let is_beyond = |region: &Region| {
        let (center, radius_m) = region.ball();
        reach.beyond_m(&center) - radius_m - EXACT_TRANSLATION_M > 0.0
    };
    !regions.is_empty() && regions.iter().all(is_beyond)
}

/// Search of a planner that finds one path: each further path is a new search with another seed.
struct Restarts<'a> {
    planner: &'a dyn Planner,
    problem: &'a Problem,
    budget: Budget,
    seed: u64,
    /// Number of completed searches.
    count: u64,
    /// Statistics of all of them.
    spent: Statistics,
}

impl PathSearch for Restarts<'_> {
    fn next(&mut self, observer: &mut dyn Observer) -> Result<PlanReport, PlanError> {
        let seed = other_seed(self.seed, self.count);
        let report = self.planner.plan(self.problem, &self.budget, seed, observer)?;
        self.count += 1;
        let Statistics { iterations, planning_time_s, .. } = report.statistics;
        self.budget.iterations = self.budget.iterations.saturating_sub(iterations.max(1));
        self.budget.time = self.budget.time.saturating_sub(Duration::from_secs_f64(planning_time_s));
        self.spent = self.spent.with(&report.statistics);
        Ok(PlanReport { statistics: self.spent, ..report })
    }

    fn reject(&mut self) {}
}

/// Search that ended before it began.
struct Ended(PlanReport);

impl PathSearch for Ended {
    fn next(&mut self, _: &mut dyn Observer) -> Result<PlanReport, PlanError> {
        Ok(self.0.clone())
    }

    fn reject(&mut self) {
        self.0.outcome = Outcome::GaveUp;
    }
}
