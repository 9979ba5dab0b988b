use std::collections::VecDeque;

use cranny_collision::{Cell, Scratch};
use cranny_path::JointMetric;
use cranny_robot::between;
use cranny_spatial::{LANES, Stream};
use cranny_task::Problem;

use crate::planners::even_sequence::EvenSequence;
use crate::planners::laps::Laps;
use crate::search::clock::Clock;
use crate::search::connector::Path;
use crate::search::forest::Forest;
use crate::search::goal_pool::GoalPool;
use crate::wall_clock::now;
use crate::{Observer, Outcome, PathSearch, PlanError, PlanReport, Reach, Statistics};

mod below;
mod guess;
mod within_bounds;

/// Number of iterations after which the sampling box grows by another [`Reach::detour`]: most problems are solved before.
const ITERATIONS_PER_DETOUR: u64 = 100;

/// Maximum number of intervals in a proof at first, and its increase per iteration.
const FIRST_EFFORT: u64 = 200;
const EFFORT_PER_ITERATION: u64 = 2;

/// Maximum cost of an unshortened path, as a multiple of the bound: shortening may bring it below, and a new route is worth
/// more than the last per cent of a known one.
const SLACK: f64 = 3.0;

/// Number of iterations after which there may be one goal more than [`Reach::goals`].
const ITERATIONS_PER_GOAL: u64 = 100;

/// Search by lanes: a tree from the start and a forest from the goals that grow towards each other ([`Reach`]).
pub(crate) struct LaneSearch<'a> {
    settings: Reach,
    problem: &'a Problem,
    cell: &'a Cell,
    random: Stream,
    /// Forest from the start (with one root), and forest from the goals.
    sides: [Forest; 2],
    /// Radius of the domain of each node on either side.
    domains: [Vec<f64>; 2],
    /// Roots of the forest from the goals.
    goals: Vec<usize>,
    /// All goals ever found, with the cost of each.
    known: Vec<(Vec<f64>, f64)>,
    /// Goals for the next search.
    drawn: Vec<(Vec<f64>, f64)>,
    /// Cost bound: paths must cost less than [`SLACK`] times it, straight lines to goals less than itself.
    bound: f64,
    /// Iterations at which this search began, and at which it ends.
    began: u64,
    last: u64,
    /// Cost of a goal of each grasp; empty if there is none.
    grasp_costs: Vec<f64>,
    scratch: Scratch,
    /// Configuration to grow towards, beginning of a growth, and configuration to add.
    sample: Vec<f64>,
    from: Vec<f64>,
    q: Vec<f64>,
    /// Positions of the samples within the sampled box.
    shares: EvenSequence,
    clock: Clock,
    laps: Laps,
    statistics: Statistics,
    /// Pool of the goals of [`PathSearch::next`], if they are grasps.
    pool: Option<GoalPool<'a>>,
    /// Free goals that are not yet added, with the cost of each.
    waiting: VecDeque<(Vec<f64>, f64)>,
    stage: SearchState,
    /// Nodes of both sides at which the last path was joined.
    joined: Option<[usize; 2]>,
    is_rejected: bool,
}

/// Point at which a search continues.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SearchState {
    /// Before its first iteration.
    New,
    /// Between two iterations.
    Between,
    /// In an iteration, before either side has grown.
    Growing,
}

/// Relation of a growth to the edge before it: a turn, or its prolongation.
#[derive(Clone, Copy)]
enum EdgeRelation {
    Turns,
    GoesOn,
}

/// End of a growth.
struct Growth {
    /// Last node that was reached; the first one if the growth is blocked.
    node: usize,
    /// True if that node is the target.
    is_target: bool,
    /// True if nothing has blocked the growth.
    is_open: bool,
}

impl<'a> LaneSearch<'a> {
    /// Creates a search that has not begun.
    ///
    /// # Errors
    /// [`TaskError::Goal`] for a criterion other than `exact`; [`PlanError::Setting`] for a guess of another robot.
    pub fn new(
        settings: Reach,
        problem: &'a Problem,
        metric: JointMetric,
        (clock, seed): (Clock, u64),
    ) -> Result<Self, PlanError> {
        let cell = problem.exact_cell("reach")?;
        let settings = settings.within_limits(problem)?;
        let forest = Forest::new(problem.robot().dof(), metric);
        let mut random = Stream::new(seed, 0);
        let shares = EvenSequence::new(problem.robot().dof(), &mut random);
        Ok(Self {
            settings,
            problem,
            cell,
            random,
            sides: [forest.clone(), forest],
            domains: [Vec::new(), Vec::new()],
            goals: Vec::new(),
            known: Vec::new(),
            drawn: Vec::new(),
            bound: f64::INFINITY,
            began: 0,
            last: u64::MAX,
            grasp_costs: Vec::new(),
            scratch: cell.scratch(),
            sample: problem.start().to_vec(),
            from: Vec::new(),
            q: Vec::new(),
            shares,
            clock,
            laps: Laps::default(),
            statistics: Statistics::default(),
            pool: None,
            waiting: VecDeque::new(),
            stage: SearchState::New,
            joined: None,
            is_rejected: false,
        })
    }

    /// Returns this search with a pool of grasps.
    pub fn with_pool(self, pool: Option<GoalPool<'a>>) -> Self {
        Self { pool, ..self }
    }

    fn report(&mut self, ended: Result<Path, Outcome>) -> PlanReport {
        let failures = match &self.pool {
            Some(pool) if ended.is_err() && self.stage != SearchState::New => {
                pool.failures(&mut self.scratch)
            }
            _ => Vec::new(),
        };
        let mut statistics = self.statistics;
        statistics.nodes = self.sides.iter().map(|side| side.added() as u64).sum();
        statistics.planning_time_s = self.clock.elapsed_s();
        let share = self.laps.share_of(statistics.iterations);
        statistics.collision_time_s *= share;
        statistics.nearest_time_s *= share;
        PlanReport { failures, ..PlanReport::of(ended, statistics) }
    }

    /// Adds the start, and queues the goal configurations that are free.
    fn begin(&mut self, observer: &mut dyn Observer) -> Result<(), Outcome> {
        // One check covers start and goals.
        let start = self.problem.start();
        let mut free = Vec::new();
        let goals = self.problem.goal_configurations();
        let ends = [start, &goals.concat()].concat();
        self.cell.are_free(&ends, &mut self.scratch, &mut free);
        if !free[0] {
            return Err(Outcome::StartInvalid);
        }
        self.add_root(0, start, 0.0, observer);
        let goals = goals.iter().zip(&free[1..]).filter(|(_, is_free)| **is_free);
        self.waiting.extend(goals.map(|(goal, _)| (goal.clone(), 0.0)));
        self.follow_guess(observer);
        self.stage = SearchState::Between;
        Ok(())
    }

    fn search(&mut self, observer: &mut dyn Observer) -> Result<Path, Outcome> {
        loop {
            while let Some((goal, cost)) = self.waiting.pop_front() {
                if let Some(path) = self.add_goal(&goal, cost, observer) {
                    return Ok(path);
                }
            }
            // 3.
            if self.stage == SearchState::Growing {
                self.stage = SearchState::Between;
                let smaller = usize::from(self.sides[1].len() < self.sides[0].len());
                if !self.goals.is_empty()
                    && let Some(path) = self.grow_both(smaller, observer)
                {
                    return Ok(path);
                }
            }
            // Without a goal that is free and accepted, there is nothing to search for.
            if self.goals.is_empty() && self.pool.is_none() {
                return Err(Outcome::GoalsInvalid);
            }
            if let Some(outcome) = self.clock.verdict(self.statistics.iterations, observer) {
                return Err(outcome);
            }
            if self.statistics.iterations >= self.last {
                return Err(Outcome::GaveUp);
            }
            self.laps.choose(self.statistics.iterations);
            self.statistics.iterations += 1;
            self.stage = SearchState::Growing;
            // 1. and 2.
            // Unreached goals may all be cut off from the start, so more goals are added later.
            let most = self.settings.goals + (self.statistics.iterations / ITERATIONS_PER_GOAL) as usize;
            if let Some(pool) = self.pool.as_mut().filter(|_| self.goals.len() < most) {
                if pool.is_hopeless() {
                    return Err(Outcome::NoReachableGrasp);
                }
                let end = self.settings.guess.last().filter(|_| self.statistics.iterations == 1);
                let found = match end {
                    Some(end) => pool.draw_near(end, &mut self.scratch, &mut self.statistics),
                    None => pool.draw(&mut self.random, &mut self.scratch, &mut self.statistics),
                };
                let cost = |grasp: usize| self.grasp_costs.get(grasp).copied().unwrap_or(0.0);
                self.waiting.extend(found.into_iter().map(|(grasp, goal)| (goal, cost(grasp))));
            }
        }
    }

    /// Adds a goal to the known goals, and as a root, unless every path to it costs too much.
    fn remember_goal(&mut self, goal: &[f64], cost: f64, observer: &mut dyn Observer) -> Option<usize> {
        let least = self.sides[0].distance(self.problem.start(), goal) + cost;
        (least < self.bound).then(|| {
            self.known.push((goal.to_vec(), cost));
            let root = self.add_root(1, goal, cost, observer);
            self.goals.push(root);
            root
        })
    }

    /// Adds a goal as a root, and grows the tree from the start towards it; returns a path if they meet.
    fn add_goal(&mut self, goal: &[f64], cost: f64, observer: &mut dyn Observer) -> Option<Path> {
        let root = self.remember_goal(goal, cost, observer)?;
        self.laps.begin();
        let met = self.meet(1, root, observer);
        if met.is_some() || self.goals.len() > 1 { met } else { self.follow_back(root, observer) }
    }

    /// Grows one side towards a random configuration, and the other side to the end of that growth.
    fn grow_both(&mut self, side: usize, observer: &mut dyn Observer) -> Option<Path> {
        let mut sample = std::mem::take(&mut self.sample);
        self.draw(&mut sample);
        self.laps.begin();
        let nearest = self.nearest(side, &sample);
        let forest = &self.sides[side];
        let sees = self.domains[side].get(nearest).copied().unwrap_or(f64::INFINITY);
        if sees < f64::INFINITY && forest.distance(forest.q(nearest), &sample) > sees {
            self.sample = sample;
            return None;
        }
        let Growth { node, .. } = self.grow(side, (nearest, EdgeRelation::Turns), &sample, observer);
        self.sample = sample;
        if node == nearest {
            let domains = &mut self.domains[side];
            if domains.len() <= nearest {
                domains.resize(nearest + 1, f64::INFINITY);
            }
            domains[nearest] = self.settings.domain;
            return None;
        }
        self.meet(side, node, observer)
    }

    /// Draws a random configuration about the box between the start and a random goal.
    fn draw(&mut self, sample: &mut [f64]) {
        let root = self.goals[self.random.index(self.goals.len())];
        let goal = self.sides[1].q(root);
        let beyond = self.settings.detour
            * (1.0 + (self.statistics.iterations - self.began) as f64 / ITERATIONS_PER_DETOUR as f64);
        let joints = self.problem.start().iter().zip(goal).zip(self.problem.robot().limits());
        for ((value, share), ((start, goal), limits)) in sample.iter_mut().zip(self.shares.next()).zip(joints)
        {
            let lower = limits.lower.max(start.min(*goal) - beyond);
            let upper = limits.upper.min(start.max(*goal) + beyond);
            *value = lower + (upper - lower) * share;
        }
    }

    /// Returns true if a path through a node at `q`, which is grown from `from`, may cost less than the bound.
    fn is_below_bound(&self, side: usize, from: usize, q: &[f64]) -> bool {
        if self.bound.is_infinite() {
            return true;
        }
        let forest = &self.sides[side];
        let to_come = forest.cost(from) + forest.distance(forest.q(from), q);
        let to_go = if side == 0 {
            let to_goal =
                |root: &usize| self.sides[1].distance(self.sides[1].q(*root), q) + self.sides[1].cost(*root);
            self.goals.iter().map(to_goal).fold(f64::INFINITY, f64::min)
        } else {
            forest.distance(self.problem.start(), q)
        };
        to_come + to_go < SLACK * self.bound
    }

    /// Grows the other side towards a node as far as possible; returns a path if the sides meet.
    fn meet(&mut self, side: usize, node: usize, observer: &mut dyn Observer) -> Option<Path> {
        let meeting = self.sides[side].q(node).to_vec();
        let from = self.nearest(1 - side, &meeting);
        let mut other = self.grow(1 - side, (from, EdgeRelation::Turns), &meeting, observer);
        while other.is_open && !other.is_target {
            other = self.grow(1 - side, (other.node, EdgeRelation::GoesOn), &meeting, observer);
        }
        let cost = self.sides[side].cost(node) + self.sides[1 - side].cost(other.node);
        if !other.is_target || cost >= SLACK * self.bound {
            return None;
        }
        self.proven_path(if side == 0 { [node, other.node] } else { [other.node, node] }, observer)
    }

    fn nearest(&mut self, side: usize, q: &[f64]) -> usize {
        let nearest = self.sides[side].nearest(q).unwrap_or(0);
        self.statistics.nearest_time_s += self.laps.lap_s();
        nearest
    }

    /// Grows from a node towards `target` as far as one pass of checks extends, or to the first configuration that is not free.
    /// Adds a node for each whole step, and at the target.
    fn grow(
        &mut self,
        side: usize,
        (from, mut way): (usize, EdgeRelation),
        target: &[f64],
        observer: &mut dyn Observer,
    ) -> Growth {
        if self.cell.tool_bounds().len() > 0 {
            return self.grow_within_bounds(side, (from, way), target, observer);
        }
        let Reach { step, looks, .. } = self.settings;
        let forest = &self.sides[side];
        self.from.clear();
        self.from.extend_from_slice(forest.q(from));
        let spacing = step / looks as f64;
        // Number of checks up to the target, and number of checks in this pass.
        let all = (forest.distance(&self.from, target) / spacing).ceil().max(1.0);
        let count = LANES.min(as_count(all));
        let is_last = count >= as_count(all);
        let place = |check: usize| if is_last && check == count { 1.0 } else { check as f64 / all };
        let places: [f64; LANES] = std::array::from_fn(|check| place(check + 1));
        let free = self.cell.free_ahead(&self.from, target, &places[..count], &mut self.scratch);
        self.statistics.collision_checks += count as u64;
        self.statistics.collision_time_s += self.laps.lap_s();
        let (is_open, is_target) = (free == count, free == count && is_last);
        let mut node = from;
        let ends = (1..=free).filter(|check| check % looks == 0 || (is_target && *check == free));
        for end in ends {
            self.q.clear();
            self.q.extend(between(&self.from, target, place(end)));
            if !self.is_below_bound(side, node, &self.q) {
                return Growth { node, is_target: false, is_open: false };
            }
            let q = std::mem::take(&mut self.q);
            node = self.add_node(side, &q, (node, way), observer);
            self.q = q;
            way = EdgeRelation::GoesOn;
        }
        Growth { node, is_target, is_open }
    }

    /// Returns the path through two nodes at the same configuration, or `None` if an edge cannot be proven (4 of [`Reach`]).
    fn proven_path(&mut self, ends: [usize; 2], observer: &mut dyn Observer) -> Option<Path> {
        let begin = now();
        let mut refuted = None;
        'sides: for (side, end) in ends.into_iter().enumerate() {
            for node in self.sides[side].turns_to_root(end) {
                let forest = &mut self.sides[side];
                let Some(from) = forest.unproven_edge(node) else { continue };
                self.statistics.collision_checks += 1;
                // Proofs of motions that pass obstacles very closely are left to searches that find nothing else.
                let effort = FIRST_EFFORT
                    .saturating_add(EFFORT_PER_ITERATION.saturating_mul(self.statistics.iterations));
                let (a, b) = (forest.q(from), forest.q(node));
                if let Some(at) = self.cell.unproven_at(effort, a, b, &mut self.scratch) {
                    refuted = Some((side, forest.first_beyond(node, at)));
                    break 'sides;
                }
                forest.set_proven(node);
            }
        }
        self.statistics.proof_time_s += begin.elapsed().as_secs_f64();
        if let Some((side, node)) = refuted {
            observer.node_cut(side, node);
            self.sides[side].cut(node);
            return None;
        }
        let way = |side: usize| {
            let forest = &self.sides[side];
            forest.turns_to_root(ends[side]).into_iter().map(|node| forest.q(node).to_vec())
        };
        let mut path: Path = way(0).collect();
        path.reverse();
        // Both paths end at the meeting configuration, which is added once.
        path.extend(way(1).skip(1));
        if !self.settings.guess.is_empty() {
            path.dedup();
        }
        self.joined = Some(ends);
        Some(path)
    }

    /// Cuts off a rejected goal where both sides met. Its branch moves to the tree from the start, where it helps its
    /// neighbours.
    fn refuse(&mut self, ends: [usize; 2], observer: &mut dyn Observer) {
        let goals = &self.sides[1];
        let (nodes, turns) = (goals.nodes_to_root(ends[1]), goals.turns_to_root(ends[1]));
        let mut last = ends[0];
        for pair in nodes.windows(2) {
            let q = self.sides[1].q(pair[1]).to_vec();
            let way = if turns.contains(&pair[0]) { EdgeRelation::Turns } else { EdgeRelation::GoesOn };
            last = self.add_node(0, &q, (last, way), observer);
        }
        if let Some(root) = nodes.last() {
            let goals = &mut self.sides[1];
            self.goals.retain(|goal| goal != root);
            self.known.retain(|(goal, _)| goal != goals.q(*root));
            goals.cut(*root);
            observer.node_cut(1, *root);
        }
    }

    fn add_node(
        &mut self,
        side: usize,
        q: &[f64],
        (parent, way): (usize, EdgeRelation),
        observer: &mut dyn Observer,
    ) -> usize {
        observer.node_added(side, q, Some(parent));
        match way {
            EdgeRelation::Turns => self.sides[side].add(q, Some(parent)),
            EdgeRelation::GoesOn => self.sides[side].prolong(q, parent),
        }
    }

    fn add_root(&mut self, side: usize, q: &[f64], cost: f64, observer: &mut dyn Observer) -> usize {
        observer.node_added(side, q, None);
        self.sides[side].add_root(q, cost)
    }
}

impl PathSearch for LaneSearch<'_> {
    fn next(&mut self, observer: &mut dyn Observer) -> Result<PlanReport, PlanError> {
        if self.is_rejected
            && let Some(ends) = self.joined.take()
        {
            self.refuse(ends, observer);
        }
        self.is_rejected = false;
        let ended = match self.stage {
            SearchState::New => self.begin(observer),
            SearchState::Between | SearchState::Growing => Ok(()),
        };
        let ended = ended.and_then(|()| self.search(observer));
        Ok(self.report(ended))
    }

    fn reject(&mut self) {
        self.is_rejected = true;
    }
}

/// Upper limit of a count of checks, far above a single pass.
const MOST_CHECKS: f64 = 1e9;

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the value lies within what a count can hold"
)]
fn as_count(count: f64) -> usize {
    count.min(MOST_CHECKS) as usize
}
