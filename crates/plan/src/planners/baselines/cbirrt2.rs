use cranny_collision::{Cell, Scratch};
use cranny_path::JointMetric;
use cranny_robot::{between, distance};
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::connector::Path;
use crate::search::forest::Forest;
use crate::search::goal_pool::GoalPool;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Ranges};

/// `CBiRRT2` (Berenson, Srinivasa & Kuffner 2011, "Task space regions: a framework for pose-constrained manipulation planning",
/// §5): a tree from the start and a tree from goals, every step of which is projected onto the bounds of the tool.
///
/// 1. With probability `p_sample`, and until there is a goal, goals from regions or grasps become roots of the second tree.
/// 2. Otherwise one tree is extended from its node nearest to a uniform random configuration towards it, and the other from its
///    node nearest to the end of that extension towards that end. If the second extension arrives, there is a path. The trees
///    then swap.
/// 3. An extension takes steps of length `step` (L2 in joint space) and projects each onto the bounds of the tool, by Newton's
///    method in the least joint motion. It ends where a step comes no nearer to its target, where the projection fails or moves
///    a configuration farther than two steps, or where the motion is not proven free and within the bounds.
/// 4. A path is shortened by `shortcuts` projected extensions between random nodes of it.
///
/// One iteration is one turn of 1 or 2. The bounds of the tool are task space regions: a box is one for a point of the tool, a
/// cone for its direction. Differs from the publication in that the projection ends within the bounds with a reserve, instead of
/// within ε of their surface (an edge between two configurations on that surface is rarely within them), in that every edge is
/// proven, and in that a target within one step is joined by a straight proven edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cbirrt2 {
    /// Probability of adding goals in a turn, in [0, 1]. Default 0.1, the published one.
    pub p_sample: f64,
    /// Length of a step in joint space (m, rad), above 0. Default 0.1, that of `sscbirrt`.
    pub step: f64,
    /// Number of attempts to shorten a path, from 0 to 100 000. Default 50, that of `sscbirrt`.
    pub shortcuts: usize,
}

impl Default for Cbirrt2 {
    fn default() -> Self {
        Self { p_sample: 0.1, step: 0.1, shortcuts: 50 }
    }
}

impl Planner for Cbirrt2 {
    fn name(&self) -> &'static str {
        "cbirrt2"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        const MOST_SHORTCUTS: usize = 100_000;
        Ranges::of(self.name())
            .share("p_sample", self.p_sample)?
            .positive("step", self.step)?
            .count_between("shortcuts", self.shortcuts, [0, MOST_SHORTCUTS])?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let mut search = Search::new(problem, budget, seed, observer);
        let cell = problem.exact_cell(self.name())?;
        problem.some_goal()?;
        let mut pool = GoalPool::of(problem)?;
        let dof = problem.robot().dof();
        let forest = Forest::new(dof, JointMetric::plain(dof));
        let extender = Extender { step: self.step, cell, scratch: cell.scratch() };
        let mut trees = Trees { settings: self, extender, sides: [forest.clone(), forest] };
        let ended = trees.run(pool.as_mut(), &mut search);
        search.statistics.nodes = trees.sides.iter().map(|side| side.len() as u64).sum();
        let failures = match &pool {
            Some(pool) if ended.is_err() => pool.failures(&mut trees.extender.scratch),
            _ => Vec::new(),
        };
        Ok(PlanReport { failures, ..search.report(ended) })
    }
}

struct Trees<'a> {
    settings: &'a Cbirrt2,
    extender: Extender<'a>,
    /// Tree from the start, and trees from the goals.
    sides: [Forest; 2],
}

impl Trees<'_> {
    fn run(&mut self, mut pool: Option<&mut GoalPool>, search: &mut Search) -> Result<Path, Outcome> {
        let start = search.problem.start();
        if !self.extender.is_free(start, search) {
            return Err(Outcome::StartInvalid);
        }
        self.add(0, start, None, search);
        for goal in search.problem.goal_configurations() {
            if self.extender.is_free(goal, search) {
                self.add(1, goal, None, search);
            }
        }
        if pool.is_none() && self.sides[1].is_empty() {
            return Err(Outcome::GoalsInvalid);
        }
        let mut side = 0;
        loop {
            search.begin_long_iteration()?;
            // 1.
            if let Some(pool) = &mut pool
                && (self.sides[1].is_empty() || search.random.uniform() < self.settings.p_sample)
            {
                self.add_goals(pool, search)?;
                continue;
            }
            // 2.
            let sample = search.sample();
            let node = self.extend(side, &sample, search).0;
            let end = self.sides[side].q(node).to_vec();
            let (met, is_met) = self.extend(1 - side, &end, search);
            if is_met {
                let path = self.path_through(if side == 0 { [node, met] } else { [met, node] });
                return Ok(self.extender.shortened(path, self.settings.shortcuts, search));
            }
            side = 1 - side;
        }
    }

    /// Adds the goals of one batch of inverse kinematics.
    fn add_goals(&mut self, pool: &mut GoalPool, search: &mut Search) -> Result<(), Outcome> {
        let Search { random, statistics, .. } = search;
        let goals = pool.draw_batch(&[], random, &mut self.extender.scratch, statistics);
        if self.sides[1].is_empty() && goals.is_empty() && pool.is_hopeless() {
            return Err(Outcome::NoReachableGrasp);
        }
        for (_, goal) in goals {
            self.add(1, &goal, None, search);
        }
        Ok(())
    }

    /// Extends a tree towards a configuration; returns its node at the end of the extension, and true if that is the target.
    fn extend(&mut self, side: usize, target: &[f64], search: &mut Search) -> (usize, bool) {
        let begin = now();
        let mut node = self.sides[side].nearest(target).unwrap_or(0);
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let from = self.sides[side].q(node).to_vec();
        let (way, is_target) = self.extender.extend(&from, target, search);
        for q in &way {
            node = self.add(side, q, Some(node), search);
        }
        (node, is_target)
    }

    fn add(&mut self, side: usize, q: &[f64], parent: Option<usize>, search: &mut Search) -> usize {
        search.observer.node_added(side, q, parent);
        self.sides[side].add(q, parent)
    }

    /// Returns the path through two nodes at the same configuration.
    fn path_through(&self, [from_start, from_goal]: [usize; 2]) -> Path {
        let mut path = self.sides[0].path_to(from_start);
        let back = self.sides[1].nodes_to_root(from_goal).into_iter().skip(1);
        path.extend(back.map(|node| self.sides[1].q(node).to_vec()));
        path
    }
}

/// Projected extension.
struct Extender<'a> {
    step: f64,
    cell: &'a Cell,
    scratch: Scratch,
}

impl Extender<'_> {
    /// Performs 3 of [`Cbirrt2`] from a configuration: returns the configurations after it (m, rad; one value per joint), and
    /// true if the last of all is the target. Every motion between them is proven.
    fn extend(&mut self, from: &[f64], target: &[f64], search: &mut Search) -> (Path, bool) {
        /// Least progress of a step, as a share of it: sliding along a bound might else never end.
        const LEAST_PROGRESS: f64 = 1e-3;
        let mut way: Path = Vec::new();
        loop {
            let last = way.last().map_or(from, |q| &q[..]);
            let left = distance(last, target);
            if left <= 0.0 {
                return (way, true);
            }
            if left <= self.step {
                let is_target = self.edge(last, target, search);
                if is_target {
                    way.push(target.to_vec());
                }
                return (way, is_target);
            }
            let mut next: Vec<f64> = between(last, target, self.step / left).collect();
            let is_within = self.cell.project_to_bounds(&mut next, &mut self.scratch);
            let is_near = distance(last, &next) <= 2.0 * self.step;
            let is_nearer = distance(&next, target) < left - LEAST_PROGRESS * self.step;
            if !(is_within && is_near && is_nearer && self.edge(last, &next, search)) {
                return (way, false);
            }
            way.push(next);
        }
    }

    /// Performs 4 of [`Cbirrt2`].
    fn shortened(&mut self, mut path: Path, attempts: usize, search: &mut Search) -> Path {
        for _ in 0..attempts {
            if path.len() < 3 || search.observer.should_stop() {
                break;
            }
            let [a, b] = [0, 1].map(|_| search.random.index(path.len()));
            let (first, last) = (a.min(b), a.max(b));
            if last - first < 2 {
                continue;
            }
            let length =
                |way: &[Vec<f64>]| way.windows(2).map(|edge| distance(&edge[0], &edge[1])).sum::<f64>();
            let (way, is_target) = self.extend(&path[first], &path[last], search);
            let mut whole = vec![path[first].clone()];
            whole.extend(way);
            if is_target && length(&whole) < length(&path[first..=last]) {
                path.splice(first..=last, whole);
            }
        }
        path
    }

    fn is_free(&mut self, q: &[f64], search: &mut Search) -> bool {
        search.statistics.collision_checks += 1;
        self.cell.is_free(q, &mut self.scratch)
    }

    /// Returns true if the whole motion between two configurations is proven free and within the bounds.
    fn edge(&mut self, from: &[f64], to: &[f64], search: &mut Search) -> bool {
        let begin = now();
        // A blocked end is the most frequent reason, and cheaper to find than the whole proof.
        let is_proven =
            self.is_free(to, search) && self.cell.motion_is_free(from, to, &mut self.scratch).is_proven();
        search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        is_proven
    }
}
