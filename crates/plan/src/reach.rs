use std::time::Instant;

use cranny_collision::{Cell, Motion, Scratch};
use cranny_robot::between;
use cranny_spatial::{LANES, Stream};
use serde::{Deserialize, Serialize};

use crate::forest::Forest;
use crate::goal_pool::GoalPool;
use crate::joint_metric::JointMetric;
use crate::planner::Clock;
use crate::{
    Budget, Goal, GraspFailure, Observer, Outcome, PlanError, PlanReport, Planner, Problem, Statistics,
};

/// The flagship: one search for grasp and motion at exact tolerance.
///
/// 1. Batches of inverse kinematics between the iterations add goal configurations, for random grasps or
///    their twins, as further roots of one goal forest.
/// 2. A pose at which the hand alone collides is left out; if none is left, no grasp can be reached.
/// 3. Bidirectional growth (RRT-Connect: Kuffner and `LaValle` 2000): the smaller side grows towards a random
///    configuration, the other side then goes as far as it can towards the new node. Random configurations lie
///    about the box between the start and one of the goals, farther and farther beyond it as time goes on.
/// 4. Growth looks at a row of single configurations at once (Thomason, Kingston & Kavraki 2024) and ends
///    before the first that is not free; where both sides meet, every straight way of the path is proven as one
///    edge, and one that cannot be is cut off where it fails, with all that grew from there.
///
/// One iteration is one random configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// How far apart the nodes of a growth lie, in the metric weighted by reach. Default 0.25.
    pub step: f64,
    /// Configurations looked at between two nodes, the second included. One growth looks at [`LANES`].
    /// Default 4.
    pub looks: usize,
    /// Goals that are enough at first. Default 100: more do not help, unless all are cut off; one more for every 100
    /// iterations.
    pub goals: usize,
    /// How far beyond start and goal each joint of a random configuration may lie at first (m, rad); once more
    /// that far for every 100 iterations, up to the joint limits. Default 0.5.
    pub detour: f64,
    /// The smaller side grows unless it has been chosen so many times running. Default 4: a small side may
    /// be small because it is trapped.
    pub patience: u32,
}

/// After so many iterations the way may lead [`Reach::detour`] farther away: most problems are solved by then.
const ITERATIONS_PER_DETOUR: u64 = 100;

/// After so many iterations there is one goal more than [`Reach::goals`].
const ITERATIONS_PER_GOAL: u64 = 100;

impl Default for Reach {
    fn default() -> Self {
        Self { step: 0.25, looks: 4, goals: 100, detour: 0.5, patience: 4 }
    }
}

impl Planner for Reach {
    fn name(&self) -> &'static str {
        "reach"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
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
        let cell = problem.exact_cell(self.name())?;
        let forest = Forest::new(problem.robot().dof(), JointMetric::by_reach(problem.robot()));
        let mut search = Search {
            settings: self,
            problem,
            cell,
            random: Stream::new(seed, 0),
            sides: [forest.clone(), forest],
            goals: Vec::new(),
            scratch: cell.scratch(),
            sample: problem.start().to_vec(),
            from: Vec::new(),
            q: Vec::new(),
            clock,
            lap: Instant::now(),
            observer,
            statistics: Statistics::default(),
            failures: Vec::new(),
        };
        let ended = search.run(pool);
        let mut statistics = search.statistics;
        statistics.nodes = search.sides.iter().map(|side| side.len() as u64).sum();
        statistics.planning_time_s = clock.elapsed_s();
        Ok(PlanReport { failures: search.failures, ..PlanReport::of(ended, statistics) })
    }
}

struct Search<'a> {
    settings: &'a Reach,
    problem: &'a Problem,
    cell: &'a Cell,
    random: Stream,
    /// The forest from the start (of one root), and the one from the goals.
    sides: [Forest; 2],
    /// The roots of the latter.
    goals: Vec<usize>,
    scratch: Scratch,
    /// The configuration to grow towards, the one that a growth begins at, and the one that is added.
    sample: Vec<f64>,
    from: Vec<f64>,
    q: Vec<f64>,
    clock: Clock,
    /// When the last piece of work that is timed ended.
    lap: Instant,
    observer: &'a mut dyn Observer,
    statistics: Statistics,
    failures: Vec<GraspFailure>,
}

type Path = Vec<Vec<f64>>;

/// How a growth follows on the way that led to where it begins.
#[derive(Clone, Copy)]
enum Way {
    Turns,
    GoesOn,
}

/// Where a growth towards a target ended.
struct Growth {
    /// The last node that was reached; the one it began at if there was no way.
    node: usize,
    /// Whether that is the target.
    is_target: bool,
    /// Whether nothing was in the way so far.
    is_open: bool,
}

impl Search<'_> {
    fn run(&mut self, pool: Option<GoalPool>) -> Result<Path, Outcome> {
        // Start and goals in one look.
        let start = self.problem.start();
        let mut free = Vec::new();
        let ends = [start, &self.problem.goal_configurations().concat()].concat();
        self.cell.are_free(&ends, &mut self.scratch, &mut free);
        if !free[0] {
            return Err(Outcome::StartInvalid);
        }
        self.add_root(0, start);
        let goals = self.problem.goal_configurations();
        for (goal, _) in goals.iter().zip(&free[1..]).filter(|(_, is_free)| **is_free) {
            if let Some(path) = self.add_goal(goal) {
                return Ok(path);
            }
        }
        let Some(mut pool) = pool else { return self.search(None) };
        let ended = self.search(Some(&mut pool));
        if ended.is_err() {
            self.failures = pool.failures(&mut self.scratch);
        }
        ended
    }

    fn search(&mut self, mut pool: Option<&mut GoalPool>) -> Result<Path, Outcome> {
        let (mut side, mut times_running) = (0, 0);
        loop {
            // With no goal that is free, or will do, there is nothing to search for.
            if self.goals.is_empty() && pool.is_none() {
                return Err(Outcome::GoalsInvalid);
            }
            if let Some(outcome) = self.clock.verdict(self.statistics.iterations, self.observer) {
                return Err(outcome);
            }
            self.statistics.iterations += 1;
            // 1. and 2.
            // Goals that the search does not come to may all be cut off from the start: later there are more.
            let most = self.settings.goals + (self.statistics.iterations / ITERATIONS_PER_GOAL) as usize;
            if let Some(pool) = pool.as_mut().filter(|_| self.goals.len() < most) {
                if pool.is_hopeless() {
                    return Err(Outcome::NoReachableGrasp);
                }
                let found =
                    pool.draw(&mut self.random, &mut self.scratch, &mut self.statistics, self.observer);
                if let Some(path) = found.iter().find_map(|goal| self.add_goal(goal)) {
                    return Ok(path);
                }
            }
            if self.goals.is_empty() {
                continue;
            }
            // 3.
            let smaller = usize::from(self.sides[1].len() < self.sides[0].len());
            let chosen = if times_running < self.settings.patience { smaller } else { 1 - side };
            times_running = if chosen == side { times_running + 1 } else { 0 };
            side = chosen;
            if let Some(path) = self.grow_both(side) {
                return Ok(path);
            }
        }
    }

    /// Adds a root to the goal forest, and looks whether the way to it lies open.
    fn add_goal(&mut self, goal: &[f64]) -> Option<Path> {
        let root = self.add_root(1, goal);
        self.goals.push(root);
        self.lap = Instant::now();
        self.meet(1, root)
    }

    /// Growth of one side towards a random configuration, and the other side's way to where it ended.
    fn grow_both(&mut self, side: usize) -> Option<Path> {
        let mut sample = std::mem::take(&mut self.sample);
        self.draw(&mut sample);
        self.lap = Instant::now();
        let nearest = self.nearest(side, &sample);
        let Growth { node, .. } = self.grow(side, nearest, Way::Turns, &sample);
        self.sample = sample;
        if node == nearest {
            return None;
        }
        self.meet(side, node)
    }

    /// A random configuration about the box between the start and a random goal.
    fn draw(&mut self, sample: &mut [f64]) {
        let goal = self.sides[1].q(self.goals[self.random.index(self.goals.len())]);
        let beyond =
            self.settings.detour * (1.0 + self.statistics.iterations as f64 / ITERATIONS_PER_DETOUR as f64);
        let joints = self.problem.start().iter().zip(goal).zip(self.problem.robot().limits());
        for (value, ((start, goal), limits)) in sample.iter_mut().zip(joints) {
            let lower = limits.lower.max(start.min(*goal) - beyond);
            let upper = limits.upper.min(start.max(*goal) + beyond);
            *value = self.random.uniform_between(lower, upper);
        }
    }

    /// The other side's way to a node, as far as it goes; a path if it gets there.
    fn meet(&mut self, side: usize, node: usize) -> Option<Path> {
        let meeting = self.sides[side].q(node).to_vec();
        let from = self.nearest(1 - side, &meeting);
        let mut other = self.grow(1 - side, from, Way::Turns, &meeting);
        while other.is_open && !other.is_target {
            other = self.grow(1 - side, other.node, Way::GoesOn, &meeting);
        }
        if !other.is_target {
            return None;
        }
        self.proven_path(if side == 0 { [node, other.node] } else { [other.node, node] })
    }

    fn nearest(&mut self, side: usize, q: &[f64]) -> usize {
        let nearest = self.sides[side].nearest(q).unwrap_or(0);
        self.statistics.nearest_time_s += self.lap_s();
        nearest
    }

    /// Seconds since the last lap: one look at the clock between two pieces of work, not two.
    fn lap_s(&mut self) -> f64 {
        let begin = std::mem::replace(&mut self.lap, Instant::now());
        self.lap.duration_since(begin).as_secs_f64()
    }

    /// Grows from a node towards `target` as far as one pass of looks goes, or to the first that is not free;
    /// adds a node for each whole step, and at the target.
    fn grow(&mut self, side: usize, from: usize, mut way: Way, target: &[f64]) -> Growth {
        let Reach { step, looks, .. } = *self.settings;
        let forest = &self.sides[side];
        self.from.clear();
        self.from.extend_from_slice(forest.q(from));
        let spacing = step / looks as f64;
        // Looks all the way to the target, and how many of them one pass takes.
        let all = (forest.distance(&self.from, target) / spacing).ceil().max(1.0);
        let count = LANES.min(as_count(all));
        let is_last = count >= as_count(all);
        let place = |look: usize| if is_last && look == count { 1.0 } else { look as f64 / all };
        let places: [f64; LANES] = std::array::from_fn(|look| place(look + 1));
        let free = self.cell.free_ahead(&self.from, target, &places[..count], &mut self.scratch);
        self.statistics.collision_checks += count as u64;
        self.statistics.collision_time_s += self.lap_s();
        let forest = &mut self.sides[side];
        let (is_open, is_target) = (free == count, free == count && is_last);
        let mut node = from;
        let ends = (1..=free).filter(|look| look % looks == 0 || (is_target && *look == free));
        for end in ends {
            self.q.clear();
            self.q.extend(between(&self.from, target, place(end)));
            self.observer.node_added(side, &self.q, Some(node));
            node = match way {
                Way::Turns => forest.add(&self.q, Some(node)),
                Way::GoesOn => forest.prolong(&self.q, node),
            };
            way = Way::GoesOn;
        }
        Growth { node, is_target, is_open }
    }

    /// Step 4: the path through two nodes at the same configuration, or nothing if an edge cannot be proven.
    fn proven_path(&mut self, ends: [usize; 2]) -> Option<Path> {
        let begin = Instant::now();
        let mut refuted = None;
        'sides: for (side, end) in ends.into_iter().enumerate() {
            for node in self.sides[side].way_to_root(end) {
                let forest = &mut self.sides[side];
                let Some(from) = forest.open_way(node) else { continue };
                self.statistics.collision_checks += 1;
                match self.cell.motion_is_free(forest.q(from), forest.q(node), &mut self.scratch) {
                    Motion::Proven => forest.set_proven(node),
                    Motion::Contact { at, .. } | Motion::Unresolved { at, .. } => {
                        refuted = Some((side, forest.first_beyond(node, at)));
                        break 'sides;
                    }
                    Motion::OutOfLimits { .. } => {
                        refuted = Some((side, node));
                        break 'sides;
                    }
                }
            }
        }
        self.statistics.proof_time_s += begin.elapsed().as_secs_f64();
        if let Some((side, node)) = refuted {
            self.sides[side].cut(node);
            return None;
        }
        let way = |side: usize| {
            let forest = &self.sides[side];
            forest.way_to_root(ends[side]).into_iter().map(|node| forest.q(node).to_vec())
        };
        let mut path: Path = way(0).collect();
        path.reverse();
        // Both ways end where they meet: it stands in the path once.
        path.extend(way(1).skip(1));
        if self.observer.accepts_goal(&path) {
            return Some(path);
        }
        self.refuse(ends);
        None
    }

    /// Cuts off a goal that will not do, where both sides have met. What led to it is of use for its neighbours: it grows
    /// on from the start.
    fn refuse(&mut self, ends: [usize; 2]) {
        let [start, goals] = &mut self.sides;
        let (way, turns) = (goals.nodes_to_root(ends[1]), goals.way_to_root(ends[1]));
        let mut last = ends[0];
        for nodes in way.windows(2) {
            let q = goals.q(nodes[1]);
            self.observer.node_added(0, q, Some(last));
            last = if turns.contains(&nodes[0]) { start.add(q, Some(last)) } else { start.prolong(q, last) };
        }
        if let Some(root) = way.last() {
            self.goals.retain(|goal| goal != root);
            goals.cut(*root);
        }
    }

    fn add_root(&mut self, side: usize, q: &[f64]) -> usize {
        self.observer.node_added(side, q, None);
        self.sides[side].add(q, None)
    }
}

/// Looks that would take longer than this are not taken at once anyway.
const MOST_LOOKS: f64 = 1e9;

// The value lies within what a count can hold.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn as_count(looks: f64) -> usize {
    looks.min(MOST_LOOKS) as usize
}
