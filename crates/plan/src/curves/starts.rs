use cranny_collision::{Cell, Scratch};
use cranny_path::{ShortcutSettings, shortcut};
use cranny_robot::distance;
use cranny_spatial::other_seed;
use cranny_task::{Goal, GraspFailure, Problem};

use crate::curves::curve::{add_detour, clamp, resampled, straight};
use crate::curves::curve_settings::{CurveSettings, FirstCurve};
use crate::curves::refused_claim::RefusedClaim;
use crate::search::connector::Path;
use crate::search::goal_pool::GoalPool;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Statistics};

/// Optimiser of a curve.
pub(crate) trait Improver {
    /// Begins with a curve from the start to `goals[goal]` (m, rad; one value per joint each).
    fn begin(&mut self, path: Path, goals: &[Vec<f64>], goal: usize, search: &mut Search);

    /// Takes one step; returns false if there is nothing left to improve.
    fn step(&mut self, search: &mut Search) -> bool;

    /// Returns the current curve, from the start to a goal.
    fn path(&self) -> &Path;
}

/// Searches for a path to any goal of a problem by an optimiser, from one first curve after the other.
///
/// 1. Inverse kinematics finds goals, one batch per iteration, until there are `goals`, or as many batches were run and there is
///    one.
/// 2. A start begins with a first curve ([`FirstCurve`]): straight to the goals in order of distance, then to random goals by
///    random detours. Each further start is preceded by another batch.
/// 3. The optimiser takes up to `steps` steps, each an iteration. A curve whose way points are all free is a claim. Each edge of
///    it is then proven. If the proof refuses it, the optimiser continues.
/// 4. After the first proven curve of a start the optimiser takes `settle` further steps. The last proven curve is the path.
///
/// # Errors
/// [`PlanError`] for a criterion other than `exact`, or a problem without a goal.
pub(crate) fn improve(
    planner: &'static str,
    settings: CurveSettings,
    improver: &mut dyn Improver,
    guide: &dyn Planner,
    problem: &Problem,
    (budget, seed): (&Budget, u64),
    observer: &mut dyn Observer,
) -> Result<PlanReport, PlanError> {
    let search = Search::new(problem, budget, seed, observer);
    let (cell, goal) = (problem.exact_cell(planner)?, problem.some_goal()?);
    let mut starts = Starts {
        settings,
        problem,
        cell,
        guide,
        seed,
        search,
        scratch: cell.scratch(),
        goals: Vec::new(),
        order: Vec::new(),
        round: 0,
        verdicts: Vec::new(),
        claim: None,
        proven: None,
        failures: Vec::new(),
    };
    let ended = starts.run(goal, improver)?;
    let Starts { search, claim, failures, .. } = starts;
    let (ended, refused) = match (ended, claim) {
        (Err(Outcome::BudgetExhausted), Some(claim)) => (Err(Outcome::ClaimedNotProven), Some(claim)),
        (ended, _) => (ended, None),
    };
    Ok(PlanReport { failures, refused, ..search.report(ended) })
}

struct Starts<'a> {
    settings: CurveSettings,
    problem: &'a Problem,
    cell: &'a Cell,
    /// Planner of the first curve of a warm start.
    guide: &'a dyn Planner,
    seed: u64,
    search: Search<'a>,
    scratch: Scratch,
    goals: Vec<Vec<f64>>,
    /// Goals without a turn yet, the nearest last.
    order: Vec<usize>,
    /// Number of starts that were begun.
    round: u64,
    verdicts: Vec<bool>,
    /// The refused claim of least depth.
    claim: Option<RefusedClaim>,
    proven: Option<Path>,
    failures: Vec<GraspFailure>,
}

type Ended = Result<Path, Outcome>;

impl Starts<'_> {
    fn run(&mut self, goal: &Goal, improver: &mut dyn Improver) -> Result<Ended, PlanError> {
        let start = self.problem.start();
        if !self.cell.is_free(start, &mut self.scratch) {
            return Ok(Err(Outcome::StartInvalid));
        }
        self.search.observer.node_added(0, start, None);
        self.search.statistics.nodes += 1;
        match goal {
            Goal::Configurations(goals) => {
                self.search.statistics.collision_checks += goals.len() as u64;
                let free = goals.iter().filter(|goal| self.cell.is_free(goal, &mut self.scratch));
                self.goals = free.cloned().collect();
                if self.goals.is_empty() {
                    return Ok(Err(Outcome::GoalsInvalid));
                }
                self.order_goals(0);
                self.run_starts(improver, &mut |_| Ok(()))
            }
            Goal::Grasps(grasps) => {
                self.run_with_pool(GoalPool::new(self.problem, self.cell, grasps), improver)
            }
            Goal::Regions(regions) => {
                self.run_with_pool(GoalPool::of_regions(self.problem, self.cell, regions), improver)
            }
        }
    }

    fn run_with_pool(&mut self, mut pool: GoalPool, improver: &mut dyn Improver) -> Result<Ended, PlanError> {
        let ended = self.run_starts(improver, &mut |starts| starts.draw(&mut pool))?;
        if ended.is_err() {
            self.failures = pool.failures(&mut self.scratch);
        }
        Ok(ended)
    }

    /// Runs one start after the other, with `more_goals` before each.
    fn run_starts(
        &mut self,
        improver: &mut dyn Improver,
        more_goals: &mut dyn FnMut(&mut Self) -> Result<(), Outcome>,
    ) -> Result<Ended, PlanError> {
        // 1.
        if self.settings.first == FirstCurve::Straight {
            let mut batches = 0;
            while self.goals.is_empty()
                || (self.goals.len() < self.settings.goals && batches < self.settings.goals)
            {
                if matches!(self.problem.goal(), Goal::Configurations(_)) {
                    break;
                }
                batches += 1;
                if let Err(outcome) = more_goals(self) {
                    return Ok(Err(outcome));
                }
            }
        }
        loop {
            // 2.
            let first = match self.settings.first {
                FirstCurve::Straight => Ok(self.straight_curve()),
                FirstCurve::Reach => self.guided_curve()?,
            };
            let (path, goal) = match first {
                Ok(first) => first,
                Err(outcome) => return Ok(Err(outcome)),
            };
            self.round += 1;
            improver.begin(path, &self.goals, goal, &mut self.search);
            // 3. and 4.
            let ended = self.run_start(improver);
            if let Some(path) = self.proven.take() {
                return Ok(Ok(path));
            }
            let more = ended.and_then(|()| match self.settings.first {
                FirstCurve::Straight => more_goals(self),
                FirstCurve::Reach => Ok(()),
            });
            if let Err(outcome) = more {
                return Ok(Err(outcome));
            }
        }
    }

    /// Runs the steps of one start.
    fn run_start(&mut self, improver: &mut dyn Improver) -> Result<(), Outcome> {
        let mut settled = 0;
        for _ in 0..self.settings.steps {
            self.search.begin_long_iteration()?;
            let goes_on = improver.step(&mut self.search);
            self.judge(improver.path());
            if self.proven.is_some() {
                settled += 1;
                if settled > self.settings.settle {
                    break;
                }
            }
            if !goes_on {
                break;
            }
        }
        Ok(())
    }

    /// Keeps a curve if it is proven, or the fault of a claim.
    fn judge(&mut self, path: &Path) {
        let begin = now();
        let rows: Vec<f64> = path.iter().flatten().copied().collect();
        self.cell.are_free(&rows, &mut self.scratch, &mut self.verdicts);
        self.search.statistics.collision_checks += path.len() as u64;
        self.search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        if !self.verdicts.iter().all(|is_free| *is_free) {
            return;
        }
        let begin = now();
        self.search.statistics.collision_checks += path.len() as u64 - 1;
        let refused = RefusedClaim::of(self.cell, path, &mut self.scratch);
        self.search.statistics.proof_time_s += begin.elapsed().as_secs_f64();
        match refused {
            None => {
                for (index, q) in path.iter().enumerate().skip(1) {
                    let parent = if index == 1 { 0 } else { self.search.statistics.nodes - 1 };
                    self.search.observer.node_added(0, q, usize::try_from(parent).ok());
                    self.search.statistics.nodes += 1;
                }
                self.proven = Some(path.clone());
            }
            Some(refused) => {
                if self.claim.as_ref().is_none_or(|known| refused.depth_m < known.depth_m) {
                    self.claim = Some(refused);
                }
            }
        }
    }

    /// Adds the goals of one more batch of inverse kinematics.
    fn draw(&mut self, pool: &mut GoalPool) -> Result<(), Outcome> {
        self.search.begin_long_iteration()?;
        let Search { random, statistics, .. } = &mut self.search;
        let goals = pool.draw_batch(&[], random, &mut self.scratch, statistics);
        if pool.is_hopeless() {
            return Err(Outcome::NoReachableGrasp);
        }
        let known = self.goals.len();
        self.goals.extend(goals.into_iter().map(|(_, q)| q));
        self.order_goals(known);
        Ok(())
    }

    /// Gives the goals from index `known` on a turn.
    fn order_goals(&mut self, known: usize) {
        self.order.extend(known..self.goals.len());
        let (goals, start) = (&self.goals, self.problem.start());
        let from_start = |goal: &usize| distance(start, &goals[*goal]);
        self.order.sort_by(|a, b| from_start(b).total_cmp(&from_start(a)).then(b.cmp(a)));
    }

    fn straight_curve(&mut self) -> (Path, usize) {
        let start = self.problem.start();
        let next = self.order.pop();
        let goal = next.unwrap_or_else(|| self.search.random.index(self.goals.len()));
        let end = &self.goals[goal];
        let mut path = straight(start, end, self.settings.way_points);
        if next.is_none() {
            let sample = self.search.sample();
            let middle = start.iter().zip(end).map(|(a, b)| 0.5 * (a + b));
            let aside: Vec<f64> = sample.iter().zip(middle).map(|(sample, middle)| sample - middle).collect();
            add_detour(&mut path, &aside);
            let inner = path.len() - 1;
            clamp(&mut path[1..inner], self.problem.robot().limits());
        }
        (path, goal)
    }

    /// Returns the resampled path of the guide.
    fn guided_curve(&mut self) -> Result<Result<(Path, usize), Outcome>, PlanError> {
        if let Err(outcome) = self.search.begin_long_iteration() {
            return Ok(Err(outcome));
        }
        let seed = other_seed(self.seed, self.round);
        let left = self.search.left();
        let mut observer = Unseen { observer: &mut *self.search.observer };
        let report = self.guide.plan(self.problem, &left, seed, &mut observer)?;
        let statistics = Statistics { nodes: 0, planning_time_s: 0.0, ..report.statistics };
        self.search.statistics = self.search.statistics.with(&statistics);
        if report.outcome != Outcome::Solved {
            return Ok(Err(report.outcome));
        }
        let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
        let path = shortcut(self.problem, &report.path, settings)?.path;
        let Some(end) = path.last() else { return Ok(Err(Outcome::GaveUp)) };
        self.goals.push(end.clone());
        Ok(Ok((resampled(&path, self.settings.way_points), self.goals.len() - 1)))
    }
}

/// Observer that can stop the search for a first curve, but does not see its nodes.
struct Unseen<'a> {
    observer: &'a mut dyn Observer,
}

impl Observer for Unseen<'_> {
    fn progress(&mut self, iterations: u64) {
        self.observer.progress(iterations);
    }

    fn should_stop(&self) -> bool {
        self.observer.should_stop()
    }
}
