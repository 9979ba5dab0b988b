use std::time::Instant;

use cranny_grasp::GraspSet;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::Pose;

use crate::baseline_check::BaselineCheck;
use crate::connector::Path;
use crate::forest::Forest;
use crate::growth::{Grower, Growth};
use crate::joint_metric::JointMetric;
use crate::search::Search;
use crate::{Budget, Goal, Observer, Outcome, PlanError, PlanReport, Problem};

/// What goes by [`IkRrt`](crate::IkRrt) and its kin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PipelineSettings {
    /// How trees grow.
    pub growth: Growth,
    /// Probability of growing towards the goal itself.
    pub p_goal: f64,
    /// At most so many iterations for one goal.
    pub goal_iterations: u64,
    /// At most so many attempts of inverse kinematics for one grasp in one round.
    pub ik_attempts: usize,
}

/// One goal after the other, each with a tree from the start and one from it ([`IkRrt`](crate::IkRrt)).
///
/// # Errors
/// [`PlanError::NoGoal`].
pub(crate) fn plan_goal_by_goal(
    settings: PipelineSettings,
    problem: &Problem,
    (budget, seed): (&Budget, u64),
    observer: &mut dyn Observer,
) -> Result<PlanReport, PlanError> {
    let mut search = Search::new(problem, budget, seed, observer);
    let mut pipeline = Pipeline {
        settings,
        check: BaselineCheck::of(problem),
        grower: Grower::new(problem, settings.growth),
    };
    let ended = pipeline.run(problem.some_goal()?, &mut search);
    Ok(search.report(ended))
}

struct Pipeline<'a> {
    settings: PipelineSettings,
    check: BaselineCheck<'a>,
    grower: Grower<'a>,
}

impl Pipeline<'_> {
    fn run(&mut self, goal: &Goal, search: &mut Search) -> Result<Path, Outcome> {
        if !self.check.is_free(search.problem.start()) {
            return Err(Outcome::StartInvalid);
        }
        match goal {
            Goal::Configurations(goals) => {
                let mut outcome = Outcome::GoalsInvalid;
                for goal in goals {
                    search.statistics.goals_tried += 1;
                    if self.check.checks_goals() && !self.check.is_free(goal) {
                        continue;
                    }
                    if let Some(path) = self.accepted_path(goal, search)? {
                        return Ok(path);
                    }
                    outcome = Outcome::GaveUp;
                }
                Err(outcome)
            }
            Goal::Grasps(grasps) => self.all_grasps(grasps, search),
        }
    }

    fn all_grasps(&mut self, grasps: &GraspSet, search: &mut Search) -> Result<Path, Outcome> {
        let open = self.check.open_poses(grasps);
        if open.is_empty() {
            return Err(Outcome::NoReachableGrasp);
        }
        let robot = search.problem.robot();
        let new_search = |(_, pose): &(usize, Pose)| IkSearch::new(robot, pose, IkSearchSettings::default());
        let mut solutions: Vec<IkSearch> = open.iter().map(new_search).collect();
        loop {
            for solutions in &mut solutions {
                search.begin_iteration()?;
                let Some(goal) = self.next_goal(solutions, search) else { continue };
                search.statistics.goals_tried += 1;
                if let Some(path) = self.accepted_path(&goal, search)? {
                    return Ok(path);
                }
            }
        }
    }

    /// A path to the goal, if there is one and its end will do.
    fn accepted_path(&mut self, goal: &[f64], search: &mut Search) -> Result<Option<Path>, Outcome> {
        let path = self.connect(goal, search)?;
        Ok(path.filter(|path| search.observer.accepts_goal(path)))
    }

    /// The next configuration for the grasp of `solutions` that is free.
    fn next_goal(&mut self, solutions: &mut IkSearch, search: &mut Search) -> Option<Vec<f64>> {
        let begin = Instant::now();
        let attempts_before = solutions.attempts();
        let (robot, start) = (search.problem.robot(), search.problem.start());
        let Self { check, settings, .. } = self;
        let Search { random, statistics, .. } = search;
        let mut is_free = |q: &[f64]| {
            statistics.collision_checks += u64::from(check.checks_goals());
            !check.checks_goals() || check.is_free(q)
        };
        // The paper's way first: from the start, pulled towards it; then from random configurations.
        let from_start = match attempts_before {
            0 => solutions.next_from(start, &mut is_free).map(|solution| solution.q.clone()),
            _ => None,
        };
        let found = from_start.or_else(|| {
            let drawn = solutions.next_solution(random, settings.ik_attempts, &mut is_free);
            drawn.map(|solution| solution.q.clone())
        });
        statistics.ik_attempts += (solutions.attempts() - attempts_before) as u64;
        statistics.ik_time_s += begin.elapsed().as_secs_f64();
        found.map(|mut q| {
            robot.turn_towards(start, &mut q);
            q
        })
    }

    /// Steps 3 and 4 of [`IkRrt`](crate::IkRrt).
    fn connect(&mut self, goal: &[f64], search: &mut Search) -> Result<Option<Path>, Outcome> {
        let start = search.problem.start();
        let mut trees = [start, goal].map(|root| {
            let mut tree = Forest::new(root.len(), JointMetric::plain(root.len()));
            tree.add(root, None);
            tree
        });
        search.observer.node_added(0, start, None);
        search.observer.node_added(1, goal, None);
        let mut found = Ok(None);
        for _ in 0..self.settings.goal_iterations {
            if let Err(outcome) = search.begin_iteration() {
                found = Err(outcome);
                break;
            }
            let is_goal = search.random.uniform() < self.settings.p_goal;
            let sample = if is_goal { goal.to_vec() } else { search.sample() };
            let ends = [0, 1].map(|index| self.reach(&mut trees[index], index, &sample, search));
            if let [Some(from_start), Some(from_goal)] = ends {
                let mut path = trees[0].path_to(from_start);
                // Both trees end at the sample: it stands in the path once.
                let back = trees[1].nodes_to_root(from_goal).into_iter().skip(1);
                path.extend(back.map(|node| trees[1].q(node).to_vec()));
                found = Ok(Some(path));
                break;
            }
        }
        search.statistics.nodes += trees.iter().map(|tree| tree.len() as u64).sum::<u64>();
        found
    }

    /// Extends a tree towards `target` until it is reached, which gives the node there, or the way is blocked.
    fn reach(
        &mut self,
        tree: &mut Forest,
        index: usize,
        target: &[f64],
        search: &mut Search,
    ) -> Option<usize> {
        let begin = Instant::now();
        let mut node = tree.nearest(target)?;
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let mut is_there = tree.q(node) == target;
        let mut explores = true;
        while !is_there {
            let from = tree.q(node).to_vec();
            let grown = self.grower.grow(&from, target, explores, search);
            for end in &grown.aside {
                search.observer.node_added(index, end, Some(node));
                tree.add(end, Some(node));
            }
            let end;
            (end, is_there) = grown.ahead?;
            search.observer.node_added(index, &end, Some(node));
            node = tree.add(&end, Some(node));
            explores = false;
        }
        Some(node)
    }
}
