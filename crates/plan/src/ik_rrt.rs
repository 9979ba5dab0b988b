use std::time::Instant;

use cranny_grasp::GraspSet;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::{Pose, Stream};
use serde::{Deserialize, Serialize};

use crate::baseline_check::BaselineCheck;
use crate::planner::Clock;
use crate::search_tree::SearchTree;
use crate::step::{RELEASED_STEP_M, Stepper};
use crate::{Budget, Goal, Observer, Outcome, PlanError, PlanReport, Planner, Problem, Statistics};

/// IK-RRT (the paper's §V.B): first a configuration for a grasp by inverse kinematics, then a bidirectional
/// RRT to it; if that fails, the next grasp, from the highest score down.
///
/// 1. Grasps at which the hand alone collides are left out (`exact`); if none is left, no grasp can be
///    reached.
/// 2. The next grasp in order, or its twin, round after round: a configuration that is not known yet, free
///    under `exact`, unchecked under `paper`, as released; first from the start with a pull towards it, then
///    from random configurations.
/// 3. A tree from the start and a tree from that goal both grow towards the same random configuration (with
///    probability `p_goal` towards the goal) until each reaches it or is blocked. Where both reach it they
///    make a path.
/// 4. After `goal_iterations` without a path, on to 2.
///
/// A problem with goal configurations instead of grasps starts at 3. One iteration is one random
/// configuration of 3, or one turn of a grasp in 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IkRrt {
    /// Probability of growing towards the goal itself, in [0, 1]. Default 0.01, the paper's.
    pub p_goal: f64,
    /// How far the origin of any link frame moves in a step, in metres. Default 0.1, the released value.
    pub step_m: f64,
    /// At most so many iterations for one goal. Default 20 000.
    pub goal_iterations: u64,
    /// At most so many attempts of inverse kinematics for one grasp in one round. Default 100: a second
    /// round is cheaper than a grasp that has no solution.
    pub ik_attempts: usize,
}

impl Default for IkRrt {
    fn default() -> Self {
        Self { p_goal: 0.01, step_m: RELEASED_STEP_M, goal_iterations: 20_000, ik_attempts: 100 }
    }
}

impl Planner for IkRrt {
    fn name(&self) -> &'static str {
        "ik-rrt"
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
        let mut search = Search {
            settings: self,
            problem,
            random: Stream::new(seed, 0),
            stepper: Stepper::new(problem.robot()),
            check: BaselineCheck::of(problem),
            clock,
            observer,
            statistics: Statistics::default(),
        };
        let ended = search.run(problem.some_goal()?);
        let mut statistics = search.statistics;
        statistics.planning_time_s = clock.elapsed_s();
        Ok(PlanReport::of(ended, statistics))
    }
}

type Path = Vec<Vec<f64>>;

/// How the search for a way to one goal ended.
enum Connection {
    Path(Path),
    /// Its iterations are spent.
    Spent,
    GoalInvalid,
}

struct Search<'a> {
    settings: &'a IkRrt,
    problem: &'a Problem,
    random: Stream,
    stepper: Stepper,
    check: BaselineCheck<'a>,
    clock: Clock,
    observer: &'a mut dyn Observer,
    statistics: Statistics,
}

impl Search<'_> {
    fn run(&mut self, goal: &Goal) -> Result<Path, Outcome> {
        if !self.check.is_free(self.problem.start()) {
            return Err(Outcome::StartInvalid);
        }
        match goal {
            Goal::Configurations(goals) => {
                let mut outcome = Outcome::GoalsInvalid;
                for goal in goals {
                    match self.connect(goal)? {
                        Connection::Path(path) => return Ok(path),
                        Connection::Spent => outcome = Outcome::GaveUp,
                        Connection::GoalInvalid => {}
                    }
                }
                Err(outcome)
            }
            Goal::Grasps(grasps) => self.pipeline(grasps),
        }
    }

    fn pipeline(&mut self, grasps: &GraspSet) -> Result<Path, Outcome> {
        // 1.
        let open = self.check.open_poses(grasps);
        if open.is_empty() {
            return Err(Outcome::NoReachableGrasp);
        }
        let robot = self.problem.robot();
        let new_search = |(_, pose): &(usize, Pose)| IkSearch::new(robot, pose, IkSearchSettings::default());
        let mut searches: Vec<IkSearch> = open.iter().map(new_search).collect();
        loop {
            for search in &mut searches {
                if let Some(outcome) = self.verdict() {
                    return Err(outcome);
                }
                self.statistics.iterations += 1;
                // 2.
                let Some(goal) = self.next_goal(search) else { continue };
                // 3. and 4.
                if let Connection::Path(path) = self.connect(&goal)? {
                    return Ok(path);
                }
            }
        }
    }

    /// The next configuration for the grasp of `search` that is free.
    fn next_goal(&mut self, search: &mut IkSearch) -> Option<Vec<f64>> {
        let begin = Instant::now();
        let attempts_before = search.attempts();
        let start = self.problem.start();
        let check = &mut self.check;
        let checks = &mut self.statistics.collision_checks;
        let mut is_free = |q: &[f64]| {
            *checks += u64::from(check.checks_goals());
            !check.checks_goals() || check.is_free(q)
        };
        // The paper's way first: from the start, pulled towards it; then from random configurations.
        let from_start = match attempts_before {
            0 => search.next_from(start, &mut is_free).map(|solution| solution.q.clone()),
            _ => None,
        };
        let found = from_start.or_else(|| {
            let drawn = search.next_solution(&mut self.random, self.settings.ik_attempts, &mut is_free);
            drawn.map(|solution| solution.q.clone())
        });
        self.statistics.ik_attempts += (search.attempts() - attempts_before) as u64;
        self.statistics.ik_time_s += begin.elapsed().as_secs_f64();
        found.map(|mut q| {
            self.problem.robot().turn_towards(start, &mut q);
            q
        })
    }

    /// Steps 3 and 4, or why all is over.
    fn connect(&mut self, goal: &[f64]) -> Result<Connection, Outcome> {
        self.statistics.goals_tried += 1;
        let problem = self.problem;
        if self.check.checks_goals() && !self.check.is_free(goal) {
            return Ok(Connection::GoalInvalid);
        }
        let mut trees = [SearchTree::new(problem.start()), SearchTree::new(goal)];
        for (index, root) in [problem.start(), goal].into_iter().enumerate() {
            self.observer.node_added(index, root, None);
        }
        let mut sample = goal.to_vec();
        let found = (|| {
            for _ in 0..self.settings.goal_iterations {
                if let Some(outcome) = self.verdict() {
                    return Err(outcome);
                }
                self.statistics.iterations += 1;
                if self.random.uniform() < self.settings.p_goal {
                    sample.copy_from_slice(goal);
                } else {
                    for (value, limits) in sample.iter_mut().zip(problem.robot().limits()) {
                        *value = self.random.uniform_between(limits.lower, limits.upper);
                    }
                }
                let reached = [0, 1].map(|tree| self.grow(&mut trees[tree], tree, &sample));
                if let [Some(from_start), Some(from_goal)] = reached {
                    let mut path = trees[0].path_to(from_start);
                    let mut back = trees[1].path_to(from_goal);
                    back.reverse();
                    // Both trees end at the sample: it stands in the path once.
                    path.extend(back.into_iter().skip(1));
                    return Ok(Connection::Path(path));
                }
            }
            Ok(Connection::Spent)
        })();
        self.statistics.nodes += (trees[0].len() + trees[1].len()) as u64;
        found
    }

    /// Extends a tree towards `target` step by step until it is reached, which returns the node there, or
    /// the way is blocked.
    fn grow(&mut self, tree: &mut SearchTree, index: usize, target: &[f64]) -> Option<usize> {
        let begin = Instant::now();
        let mut node = tree.nearest(target);
        self.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        loop {
            let from = tree.q(node);
            if from == target {
                return Some(node);
            }
            let (q, is_end) = self.stepper.towards(self.problem.robot(), from, target, self.settings.step_m);
            self.statistics.collision_checks += 1;
            let begin = Instant::now();
            let is_free = self.check.edge_is_free(from, q);
            self.statistics.collision_time_s += begin.elapsed().as_secs_f64();
            if !is_free {
                return None;
            }
            self.observer.node_added(index, q, Some(node));
            node = tree.add(q, node);
            if is_end {
                return Some(node);
            }
        }
    }

    fn verdict(&mut self) -> Option<Outcome> {
        self.clock.verdict(self.statistics.iterations, self.observer)
    }
}
