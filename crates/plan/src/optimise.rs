use std::time::{Duration, Instant};

use cranny_grasp::GraspSet;
use serde::{Deserialize, Serialize};

use crate::{
    Budget, Goal, Observer, Outcome, PathCost, PlanError, PlanReport, Planner, Problem, ShortcutSettings,
    audit, search, shortcut,
};

/// How to go on once there is a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptimiseSettings {
    /// How long after the first path. It may only cut short what the seed and the iterations determine.
    /// Default: 10 s.
    pub time: Duration,
    /// What a grasp of score 1 is worth against one of score 0, in units of the path's length. Default 1:
    /// as much as one metre of the base, a fifth to a half of a usual path, so that a better grasp is worth
    /// a detour but not any detour.
    pub score_weight: f64,
}

impl Default for OptimiseSettings {
    fn default() -> Self {
        Self { time: Duration::from_secs(10), score_weight: 1.0 }
    }
}

/// A path that was better than all before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Improvement {
    /// Seconds since the planner was asked.
    pub time_s: f64,
    /// Iterations until then, of all searches together; the shortening of one path counts as one.
    pub iterations: u64,
    /// What the path costs (see [`PathCost`]).
    pub cost: f64,
}

/// The best path, and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimised {
    /// Outcome and cost of the first search, with the best path of all.
    pub report: PlanReport,
    /// The first path, shortened, and every better one; costs fall strictly. Empty unless solved.
    pub improvements: Vec<Improvement>,
    /// Seconds spent after the first search.
    pub time_s: f64,
    /// Iterations of all searches together.
    pub iterations: u64,
}

/// Looks for a path, and then for better ones until time or iterations are over (anytime planning by
/// restarts: Luna, Şucan, Moll & Kavraki 2013, without their hybridisation).
///
/// 1. The planner's first path, shortened, is the best so far.
/// 2. Again and again the planner searches with another seed, every other time for grasps of a higher score
///    alone where there are any. A path that it finds is shortened.
/// 3. After each search the best path is shortened once more with another seed, until that gained nothing a
///    few times running.
/// 4. Whatever costs less than the best so far and is proven takes its place.
///
/// Laws: costs fall; the end is no worse than the first path shortened; with the same iterations the same
/// path comes out, and time only cuts the same sequence short (tests in `tests/optimise.rs`).
///
/// # Errors
/// Those of the planner, and [`PlanError::Goal`] for a problem under another criterion than `exact`, where
/// nothing is proven; [`PlanError::ScoreWeight`].
pub fn optimise(
    planner: &dyn Planner,
    problem: &mut Problem,
    budget: &Budget,
    settings: OptimiseSettings,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Optimised, PlanError> {
    let begin = Instant::now();
    problem.exact_cell("optimise")?;
    let cost = PathCost::new(problem.robot(), settings.score_weight)?;
    // 1.
    let mut report = search(planner, problem, budget, seed, observer)?;
    let first_iterations = report.statistics.iterations;
    let found = Instant::now();
    let mut best = Best {
        problem: &*problem,
        cost,
        begin,
        path: Vec::new(),
        score: None,
        iterations: first_iterations,
        improvements: Vec::new(),
    };
    if report.outcome == Outcome::Solved {
        best.challenge_shortened(&report.path, seed)?;
    }
    if !best.path.is_empty() {
        let deadline = found.checked_add(settings.time);
        let mut rounds = Rounds { planner, budget, seed, deadline, first_iterations, round: 0 };
        rounds.run(&mut best, observer)?;
        report.path = best.path;
    }
    let Best { improvements, iterations, .. } = best;
    Ok(Optimised { report, improvements, time_s: found.elapsed().as_secs_f64(), iterations })
}

/// The best path so far.
struct Best<'a> {
    problem: &'a Problem,
    cost: PathCost,
    begin: Instant,
    path: Vec<Vec<f64>>,
    score: Option<f64>,
    iterations: u64,
    improvements: Vec<Improvement>,
}

impl Best<'_> {
    /// Whether the path, shortened, took the place of the best. Step 4.
    fn challenge_shortened(&mut self, path: &[Vec<f64>], seed: u64) -> Result<bool, PlanError> {
        self.iterations += 1;
        let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
        let path = shortcut(self.problem, path, settings)?.path;
        let bar = self.improvements.last().map_or(f64::INFINITY, |best| best.cost);
        // No grasp scores more than 1, so that longer paths need no proof.
        if self.cost.of(&path, Some(1.0)) >= bar {
            return Ok(false);
        }
        let verification = audit(self.problem, &path)?;
        let score = verification.grasp_score(self.problem);
        let cost = self.cost.of(&path, score);
        if !verification.valid || cost >= bar {
            return Ok(false);
        }
        let time_s = self.begin.elapsed().as_secs_f64();
        self.improvements.push(Improvement { time_s, iterations: self.iterations, cost });
        (self.path, self.score) = (path, score);
        Ok(true)
    }

    /// The problem with those grasps alone that are worth more than the best path's; `None` if there are none.
    fn with_better_grasps(&self) -> Option<Problem> {
        let set = self.problem.grasps()?;
        let reward = self.cost.reward(self.score);
        let better: Vec<_> =
            set.grasps().iter().filter(|grasp| self.cost.reward(grasp.score) > reward).copied().collect();
        let goal = Goal::Grasps(GraspSet::new(better).ok().filter(|set| !set.is_empty())?);
        self.problem.with_goal(goal).ok()
    }
}

/// The searches after the first.
struct Rounds<'a> {
    planner: &'a dyn Planner,
    budget: &'a Budget,
    seed: u64,
    deadline: Option<Instant>,
    first_iterations: u64,
    round: u64,
}

/// A search is given up after so many times the iterations of the first: another seed is likelier to be
/// quick.
const PATIENCE: u64 = 4;

/// A search gets at least so many iterations, for a first path may be found by luck.
const LEAST_ITERATIONS: u64 = 1000;

/// So many shortenings running without a gain, and the best path is taken for as short as it gets.
const IDLE_SHORTENINGS: u32 = 3;

impl Rounds<'_> {
    fn run(&mut self, best: &mut Best, observer: &mut dyn Observer) -> Result<(), PlanError> {
        let mut idle = 0;
        let mut better_are_hopeless = false;
        while self.left(best).is_some() && !observer.should_stop() {
            self.round += 1;
            let seed = other_seed(self.seed, self.round);
            // 2.
            let narrowed =
                if self.round % 2 == 1 && !better_are_hopeless { best.with_better_grasps() } else { None };
            let Some(budget) = self.left(best) else { break };
            let mut offset = Offset { observer, before: best.iterations };
            let problem = narrowed.as_ref().unwrap_or(best.problem);
            let report = self.planner.plan(problem, &budget, seed, &mut offset)?;
            // A search that ends at once counts too, so that every budget of iterations ends.
            best.iterations += report.statistics.iterations.max(1);
            better_are_hopeless |= narrowed.is_some() && report.outcome == Outcome::NoReachableGrasp;
            if report.outcome == Outcome::Solved
                && self.left(best).is_some()
                && best.challenge_shortened(&report.path, seed)?
            {
                (idle, better_are_hopeless) = (0, false);
            }
            // 3.
            if idle < IDLE_SHORTENINGS && self.left(best).is_some() {
                let path = best.path.clone();
                idle = if best.challenge_shortened(&path, seed)? { 0 } else { idle + 1 };
            }
        }
        Ok(())
    }

    /// What the next search may spend, if anything is left.
    fn left(&self, best: &Best) -> Option<Budget> {
        let time = match self.deadline {
            Some(deadline) => deadline.checked_duration_since(Instant::now()).filter(|t| !t.is_zero())?,
            None => Duration::MAX,
        };
        let left = self.budget.iterations.checked_sub(best.iterations).filter(|left| *left > 0)?;
        let most = PATIENCE.saturating_mul(self.first_iterations).max(LEAST_ITERATIONS);
        Some(Budget { iterations: left.min(most), time })
    }
}

/// Another seed for every round, far from those that people choose (Steele, Lea & Flood 2014).
pub fn other_seed(seed: u64, round: u64) -> u64 {
    const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
    seed.wrapping_add(round.wrapping_mul(GOLDEN))
}

/// Counts on from the searches before.
struct Offset<'a> {
    observer: &'a mut dyn Observer,
    before: u64,
}

impl Observer for Offset<'_> {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        self.observer.node_added(tree, q, parent);
    }

    fn progress(&mut self, iterations: u64) {
        self.observer.progress(self.before + iterations);
    }

    fn should_stop(&self) -> bool {
        self.observer.should_stop()
    }
}
