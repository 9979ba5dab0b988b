use std::time::{Duration, Instant};

use cranny_path::{AuditSettings, Clearances, CostKind, PathCost, STOP, Shortener, audit_with};
use cranny_spatial::other_seed;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::planners::lane_search::LaneSearch;
use crate::search::clock::Clock;
use crate::search::goal_pool::GoalPool;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Reach, search};

/// Settings for the improvement of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptimiseSettings {
    /// Time limit after the first path, which is shortened in any case. It may only cut short the sequence that the seed and
    /// the iterations determine. In a task of several stages, half of it is for new paths through all of them. Default: 10 s.
    pub time: Duration,
    /// Maximum number of iterations of all searches together, including the first. Default: unlimited.
    pub iterations: u64,
    /// Number of consecutive searches with a gain below 1 % each after which the improvement ends. Default: unlimited.
    pub idle_searches: u64,
    /// Value of a grasp of score 1 relative to one of score 0, in the unit of the cost. Default 1: by length this equals one
    /// metre of base motion, a fifth to a half of a usual path, so that a better grasp is worth a limited detour.
    pub score_weight: f64,
    /// Cost of a path. Default: its length.
    pub cost: CostKind,
    /// Minimum saving of an additional way point, as a share of the cost of the path, in [0, 1]: the motion stops there.
    /// Default 0: only the cost counts.
    pub stop: f64,
}

impl OptimiseSettings {
    /// Returns the default settings for delivered paths: shortening by plain L2 length, and further searches until three in a
    /// row gain hardly anything (a few milliseconds). A stop of 0.01 makes paths 0.2 % longer and trajectories 4 % shorter.
    pub fn delivery() -> Self {
        Self { time: Duration::MAX, idle_searches: 3, cost: CostKind::L2, stop: STOP, ..Self::default() }
    }
}

impl Default for OptimiseSettings {
    fn default() -> Self {
        Self {
            time: Duration::from_secs(10),
            iterations: u64::MAX,
            idle_searches: u64::MAX,
            score_weight: 1.0,
            cost: CostKind::default(),
            stop: 0.0,
        }
    }
}

/// Record of a path that was better than all before it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Improvement {
    /// Time since the planner was called, in seconds.
    pub time_s: f64,
    /// Number of iterations up to then, of all searches together; the shortening of one path counts as one.
    pub iterations: u64,
    /// Cost of the path (see [`PathCost`]).
    pub cost: f64,
}

/// Best path, and its history.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimised {
    /// Outcome and statistics of the first search, with the best path of all.
    pub report: PlanReport,
    /// Records of the first path, shortened, and of every better one; costs decrease strictly. Empty unless solved.
    pub improvements: Vec<Improvement>,
    /// Time spent after the first search, in seconds.
    pub time_s: f64,
    /// Number of iterations of all searches together.
    pub iterations: u64,
    /// Number of searches after the first.
    pub searches: u64,
}

/// Searches for a path, and then for better ones: [`search`] and [`better`].
///
/// # Errors
/// Those of the planner and of [`better`].
pub fn optimise(
    planner: &dyn Planner,
    problem: &Problem,
    budget: &Budget,
    settings: OptimiseSettings,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Optimised, PlanError> {
    problem.exact_cell("optimise")?;
    PathCost::new(problem, settings.cost, settings.score_weight)?;
    let report = search(planner, problem, budget, seed, observer)?;
    let settings = OptimiseSettings { iterations: settings.iterations.min(budget.iterations), ..settings };
    better(problem, report, settings, seed, observer)
}

/// Searches for better paths than `first` until time, iterations or searches are used up (anytime planning by restarts: Luna,
/// Şucan, Moll & Kavraki 2013, "Anytime solution optimization for sampling-based motion planning", whole, without their
/// hybridisation). Each search is bounded by the best cost as in AORRTC (Wilson, Thomason, Kingston & Gammell 2025, Algorithm
/// 1, lines 5 to 8), but without its cost dimension: a node is dropped if its cost-to-come plus the straight line to the goal
/// exceeds three times the bound, because shortening comes later.
///
/// 1. The first path, shortened, is the initial best path.
/// 2. Whichever planner found it, [`Reach`] with default settings searches repeatedly from the start and from all known goals,
///    each with the cost of its grasp. Goals to which the straight line costs more than the best path are left out. Every
///    second search begins with the best path in its tree, as does a search after an unsuccessful one. A new path is shortened,
///    block by block, as long as its cost is close to the best.
/// 3. After each search the best path is shortened again with another seed, until several attempts in a row gain nothing.
/// 4. A path that costs less than the best path replaces it.
/// 5. The best path is audited like any other; if it is rejected, its predecessor takes over.
///
/// Laws: costs decrease. The result is no worse than the first path shortened. Equal iterations give equal paths, and time only
/// cuts the same sequence short (tests in `tests/optimise.rs`).
///
/// # Errors
/// [`TaskError::Goal`](cranny_task::TaskError::Goal) for a problem under a criterion other than `exact`, where nothing is
/// proven; [`PathError::ScoreWeight`](cranny_path::PathError::ScoreWeight), and those of [`PathCost::new`].
pub fn better(
    problem: &Problem,
    first: PlanReport,
    settings: OptimiseSettings,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Optimised, PlanError> {
    let begin = now();
    let cost = PathCost::new(problem, settings.cost, settings.score_weight)?;
    let mut best = Best {
        problem,
        cost: &cost,
        shortener: Shortener::new(problem, &cost, settings.stop)?,
        begin,
        first_time_s: first.statistics.planning_time_s,
        end: begin.checked_add(settings.time),
        steps: Vec::new(),
        iterations: first.statistics.iterations,
        searches: 0,
    };
    let mut report = first;
    if report.outcome == Outcome::Solved {
        best.challenge(&report.path, seed)?;
        let rest = Budget { iterations: u64::MAX, time: settings.time.saturating_sub(begin.elapsed()) };
        let mut offset = Offset { observer, before: best.iterations };
        let mut pool = GoalPool::of(problem)?;
        let mut lanes = LaneSearch::new(
            Reach::default(),
            problem,
            cost.metric().clone(),
            (Clock::new(&rest), other_seed(seed, 1)),
        )?;
        lanes.know_goals();
        lanes.set_grasp_costs(cost.of_grasps(problem));
        best.improve((&mut lanes, &mut offset), pool.as_mut(), settings, seed)?;
        report.path = best.judged()?;
    }
    let Best { steps, iterations, searches, .. } = best;
    let improvements = steps.into_iter().map(|step| step.improvement).collect();
    Ok(Optimised { report, improvements, time_s: begin.elapsed().as_secs_f64(), iterations, searches })
}

/// Best path, and its predecessors.
struct Best<'a> {
    problem: &'a Problem,
    cost: &'a PathCost,
    shortener: Shortener<'a>,
    begin: Instant,
    /// Planning time of the first path, in seconds.
    first_time_s: f64,
    /// Instant at which the search ends; `None` for a time beyond the range of the clock.
    end: Option<Instant>,
    steps: Vec<BestPath>,
    iterations: u64,
    searches: u64,
}

/// Path that was once the best.
struct BestPath {
    improvement: Improvement,
    path: Vec<Vec<f64>>,
    score: Option<f64>,
}

/// Number of iterations after which a search is abandoned: later paths are seldom shorter.
const PATIENCE: u64 = 300;

/// Number of shortening attempts per block. After each block a path is shortened further only while its cost exceeds the best
/// by at most the share `WORSE` of its measure.
const ATTEMPTS_PER_BLOCK: usize = 20;
const WORSE: [f64; 5] = [0.1, 0.075, 0.05, 0.025, 0.0];

/// Number of goal batches drawn before each search: the nearest grasp is seldom among the first few.
const BATCHES: usize = 16;

/// Saving of a block, as a share, below which a path is converged for this seed.
const STILL: f64 = 2e-4;

/// Saving by a search, as a share of the measure of the best path, above which it was worthwhile.
const WORTH: f64 = 0.01;

/// Number of consecutive shortenings without a gain after which the best path is converged.
const IDLE_SHORTENINGS: u32 = 3;

impl Best<'_> {
    /// Shortens a path, and returns true if it replaced the best one (2 and 4 of [`better`]).
    fn challenge(&mut self, path: &[Vec<f64>], seed: u64) -> Result<bool, PlanError> {
        self.iterations += 1;
        let Some(goal) = path.last() else { return Ok(false) };
        // Shortening keeps the grasp at the end.
        let score = self.cost.score_at(self.problem, goal);
        let mut has_won = false;
        self.shortener.take(path, seed);
        let mut before = self.cost.measure(self.shortener.path())?;
        for worse in WORSE {
            let end = self.end.filter(|_| !self.steps.is_empty());
            let is_over = || end.is_some_and(|end| now() >= end);
            if !self.shortener.shorten(ATTEMPTS_PER_BLOCK, &is_over) {
                break;
            }
            let path = self.shortener.path();
            let measured = self.cost.measure(path)?;
            let cost = measured - self.cost.reward(score);
            let least = self.steps.last().map_or(f64::INFINITY, |best| best.improvement.cost);
            if cost < least {
                let time_s = self.first_time_s + self.begin.elapsed().as_secs_f64();
                let improvement = Improvement { time_s, iterations: self.iterations, cost };
                self.steps.push(BestPath { improvement, path: path.to_vec(), score });
                has_won = true;
            }
            if cost - least > worse * measured || before - measured < STILL * measured {
                break;
            }
            before = measured;
        }
        Ok(has_won)
    }

    /// Runs 2 and 3 of [`better`] until the time of the search or the iterations are used up.
    fn improve(
        &mut self,
        (lanes, observer): (&mut LaneSearch, &mut dyn Observer),
        mut pool: Option<&mut GoalPool>,
        settings: OptimiseSettings,
        seed: u64,
    ) -> Result<(), PlanError> {
        let OptimiseSettings { idle_searches, iterations: most_iterations, .. } = settings;
        let (mut idle, mut has_found, mut last_worth) = (0, true, 0);
        while self.searches < idle_searches.saturating_add(last_worth) {
            let Some(best) = self.steps.last() else { break };
            let before = best.improvement.cost;
            self.searches += 1;
            let seed = other_seed(seed, self.searches);
            let bound = self.cost.search_bound(&best.path, best.score);
            if let Some(pool) = &mut pool {
                (0..BATCHES).for_each(|_| lanes.draw_goals(pool, &best.path, bound));
            }
            let iterations = lanes.iterations();
            let patience = PATIENCE.min(most_iterations.saturating_sub(self.iterations));
            let along = self.searches.is_multiple_of(2) || !has_found;
            let found = lanes.run_below(bound, patience, along.then_some(&best.path), observer);
            self.iterations += 1 + lanes.iterations() - iterations;
            if self.is_over() || observer.should_stop() || self.iterations >= most_iterations {
                break;
            }
            has_found = found.is_ok();
            match found {
                Ok(path) => {
                    if self.challenge(&path, seed)? {
                        idle = 0;
                    }
                }
                Err(Outcome::GaveUp) => {}
                // Other grasps may offer better goals than those that are known.
                Err(Outcome::GoalsInvalid) if pool.is_some() => {}
                Err(_) => break,
            }
            if idle < IDLE_SHORTENINGS && self.iterations < most_iterations {
                let path = self.steps.last().map(|best| best.path.clone()).unwrap_or_default();
                idle = if self.challenge(&path, seed)? { 0 } else { idle + 1 };
            }
            let Some(best) = self.steps.last() else { break };
            let measured = best.improvement.cost + self.cost.reward(best.score);
            if before - best.improvement.cost > WORTH * measured {
                last_worth = self.searches;
            }
        }
        Ok(())
    }

    /// Returns true if time is over; the first path is shortened in any case.
    fn is_over(&self) -> bool {
        !self.steps.is_empty() && self.end.is_some_and(|end| now() >= end)
    }

    /// Returns the best path that passes the audit (5 of [`better`]).
    fn judged(&mut self) -> Result<Vec<Vec<f64>>, PlanError> {
        let settings = AuditSettings { clearances: Clearances::None, ..AuditSettings::default() };
        while let Some(best) = self.steps.last() {
            if self.steps.len() == 1 || audit_with(self.problem, &best.path, settings)?.valid {
                return Ok(best.path.clone());
            }
            self.steps.pop();
        }
        Ok(Vec::new())
    }
}

/// Observer that adds the iterations of earlier searches.
struct Offset<'a> {
    observer: &'a mut dyn Observer,
    before: u64,
}

impl Observer for Offset<'_> {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        self.observer.node_added(tree, q, parent);
    }

    fn node_cut(&mut self, tree: usize, node: usize) {
        self.observer.node_cut(tree, node);
    }

    fn progress(&mut self, iterations: u64) {
        self.observer.progress(self.before + iterations);
    }

    fn should_stop(&self) -> bool {
        self.observer.should_stop()
    }
}
