use std::borrow::Cow;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::goal_pool::GoalPool;
use crate::lane_search::LaneSearch;
use crate::planner::Clock;
use crate::shortcut::shortcut_unless;
use crate::{
    AuditSettings, Budget, Clearances, CostKind, Observer, Outcome, PathCost, PlanError, PlanReport, Planner,
    Problem, Reach, ShortcutSettings, audit_with, search,
};

/// How to go on once there is a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptimiseSettings {
    /// How long after the first path, which is shortened and proven in any case. It may only cut short what the seed and
    /// the iterations determine.
    /// Default: 10 s.
    pub time: Duration,
    /// What a grasp of score 1 is worth against one of score 0, in the unit of the cost. Default 1: by length as
    /// much as one metre of the base, a fifth to a half of a usual path, so that a better grasp is worth a detour
    /// but not any detour.
    pub score_weight: f64,
    /// What a path costs. Default: its length.
    pub cost: CostKind,
}

impl Default for OptimiseSettings {
    fn default() -> Self {
        Self { time: Duration::from_secs(10), score_weight: 1.0, cost: CostKind::default() }
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
/// restarts: Luna, Şucan, Moll & Kavraki 2013, without their hybridisation; bounded as in AORRTC: Wilson, Thomason,
/// Kingston & Gammell 2025).
///
/// 1. The planner's first path, shortened, is the best so far.
/// 2. Whichever planner found that, again and again [`Reach`], by its default settings, searches anew from the start
///    and from all goals that were ever found, each with what its grasp costs, for a path whose cost stays below a
///    little more than the best so far: it draws nothing by which that cannot be (informed sampling: Gammell, Srinivasa
///    & Barfoot 2014). A path that it finds is shortened.
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
    let cost = PathCost::new(problem.robot(), settings.cost, settings.score_weight)?;
    // 1.
    let mut report = search(planner, problem, budget, seed, observer)?;
    let first_iterations = report.statistics.iterations;
    let found = Instant::now();
    let mut best = Best {
        problem: &*problem,
        cost,
        begin,
        end: found.checked_add(settings.time),
        path: Vec::new(),
        score: None,
        iterations: first_iterations,
        improvements: Vec::new(),
    };
    if report.outcome == Outcome::Solved {
        best.challenge_shortened(&report.path, seed)?;
    }
    if !best.path.is_empty() {
        let rest = Budget { iterations: u64::MAX, time: settings.time.saturating_sub(found.elapsed()) };
        let mut offset = Offset { observer, before: best.iterations };
        let mut pool = GoalPool::of(problem)?;
        let metric = best.cost.metric().clone();
        let mut lanes = LaneSearch::new(
            Reach::default(),
            problem,
            metric,
            (Clock::new(&rest), other_seed(seed, 1)),
            &mut offset,
        )?;
        lanes.know_goals();
        lanes.set_grasp_costs(best.cost.of_grasps(problem));
        best.improve(&mut lanes, pool.as_mut(), budget.iterations, seed)?;
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
    /// When to stop looking for better ones; nothing for a time that no clock tells.
    end: Option<Instant>,
    path: Vec<Vec<f64>>,
    score: Option<f64>,
    iterations: u64,
    improvements: Vec<Improvement>,
}

impl Best<'_> {
    /// Whether the path, shortened, took the place of the best. Step 4.
    fn challenge_shortened(&mut self, path: &[Vec<f64>], seed: u64) -> Result<bool, PlanError> {
        self.iterations += 1;
        let end = self.end.filter(|_| !self.path.is_empty());
        let is_over = || end.is_some_and(|end| Instant::now() >= end);
        let shortened = |path: &[Vec<f64>], attempts| {
            shortcut_unless(&is_over, self.problem, path, ShortcutSettings { attempts, seed })
        };
        let ShortcutSettings { attempts, .. } = ShortcutSettings::default();
        let mut path = Cow::Borrowed(path);
        // Costs are counted from those of the best grasp that there can be: what is measured is the least.
        let mut bar = f64::INFINITY;
        if let Some(best) = self.improvements.last() {
            bar = best.cost + self.cost.score_weight();
            let Some(shorter) = shortened(&path, FEW_SHORTCUTS)? else { return Ok(false) };
            path = Cow::Owned(shorter);
        }
        // What costs far more than the best after a few shortcuts seldom beats it after many.
        if self.cost.measure(&path)? >= bar * PROMISING {
            return Ok(false);
        }
        let Some(path) = shortened(&path, attempts)? else { return Ok(false) };
        // What cannot win needs no proof.
        if self.cost.measure(&path)? >= bar {
            return Ok(false);
        }
        let settings = AuditSettings { clearances: Clearances::None, ..AuditSettings::default() };
        let verification = audit_with(self.problem, &path, settings)?;
        let score = verification.grasp_score(self.problem);
        let cost = self.cost.of(&path, score)?;
        if !verification.valid || self.improvements.last().is_some_and(|best| cost >= best.cost) {
            return Ok(false);
        }
        let time_s = self.begin.elapsed().as_secs_f64();
        self.improvements.push(Improvement { time_s, iterations: self.iterations, cost });
        (self.path, self.score) = (path, score);
        Ok(true)
    }

    /// Steps 2 and 3, until the time of the search is spent, or so many iterations are.
    fn improve(
        &mut self,
        lanes: &mut LaneSearch,
        mut pool: Option<&mut GoalPool>,
        most_iterations: u64,
        seed: u64,
    ) -> Result<(), PlanError> {
        let mut idle = 0;
        for round in 1.. {
            let seed = other_seed(seed, round);
            let bound = self.cost.search_bound(&self.path, self.score) * SLACK;
            let before = lanes.iterations();
            let patience = PATIENCE.min(most_iterations.saturating_sub(self.iterations));
            let found = lanes.run_below(bound, patience, pool.as_deref_mut());
            self.iterations += lanes.iterations() - before;
            if self.iterations >= most_iterations {
                break;
            }
            match found {
                Ok(path) => {
                    if self.challenge_shortened(&path, seed)? {
                        idle = 0;
                    }
                }
                Err(Outcome::GaveUp) => {}
                Err(_) => break,
            }
            if idle < IDLE_SHORTENINGS && self.iterations < most_iterations {
                let path = self.path.clone();
                idle = if self.challenge_shortened(&path, seed)? { 0 } else { idle + 1 };
            }
        }
        Ok(())
    }
}

/// A search is given up after so many iterations.
const PATIENCE: u64 = 300;

/// A raw path may be so many times as long as the best shortened one: another way round is worth more than the last per cent
/// of this one.
const SLACK: f64 = 1.8;

/// A path that was found is shortened so hard at first, and harder if it then costs less than so many times the best.
const FEW_SHORTCUTS: usize = 20;
const PROMISING: f64 = 1.05;

/// So many shortenings running without a gain, and the best path is taken for as short as it gets.
const IDLE_SHORTENINGS: u32 = 3;

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
