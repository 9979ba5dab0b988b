use cranny_path::JointMetric;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::Pose;
use cranny_task::{Goal, Problem};

use crate::search::baseline_check::BaselineCheck;
use crate::search::connector::Path;
use crate::search::forest::Forest;
use crate::search::growth::{Grower, Growth};
use crate::search::pose_source::open_region_poses;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport};

/// Settings of [`IkRrt`](crate::IkRrt) and related planners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PipelineSettings {
    /// Growth of the trees.
    pub growth: Growth,
    /// Probability of growing towards the goal itself.
    pub p_goal: f64,
    /// Maximum number of iterations per goal, multiplied by its share.
    pub goal_iterations: u64,
    pub shares: Shares,
    /// Maximum number of attempts of inverse kinematics per grasp and round.
    pub ik_attempts: usize,
}

/// Distribution of iterations among goals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shares {
    /// Equal shares, with two separate trees per goal; given configurations are tried once.
    Equal,
    /// One goal after the other, repeatedly, by the sequence 1, 1, 2, 1, 1, 2, 4, … of Luby, Sinclair & Zuckerman (1993,
    /// "Optimal speedup of Las Vegas algorithms", whole: the strategy `S^univ`), while the tree from the start keeps growing.
    Luby,
}

/// Returns the `index`-th share of [`Shares::Luby`], counted from 1.
fn luby_share(index: u64) -> u64 {
    // A run of 2ᵏ − 1 shares is the run of 2ᵏ⁻¹ − 1 shares twice, and then 2ᵏ⁻¹.
    let run = (index + 1).next_power_of_two();
    if run == index + 1 { run / 2 } else { luby_share(index + 1 - run / 2) }
}

/// Plans for one goal after the other, each with a tree from the start and one from the goal ([`IkRrt`](crate::IkRrt)).
///
/// # Errors
/// [`TaskError::NoGoal`].
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
        start_tree: None,
        turns: 0,
    };
    let ended = pipeline.run(problem.some_goal()?, &mut search);
    Ok(search.report(ended))
}

struct Pipeline<'a> {
    settings: PipelineSettings,
    check: BaselineCheck<'a>,
    grower: Grower<'a>,
    /// Tree from the start, if it is kept.
    start_tree: Option<Forest>,
    /// Number of goals that have had their turn.
    turns: u64,
}

impl Pipeline<'_> {
    fn run(&mut self, goal: &Goal, search: &mut Search) -> Result<Path, Outcome> {
        if !self.check.is_free(search.problem.start()) {
            return Err(Outcome::StartInvalid);
        }
        match goal {
            Goal::Configurations(goals) => {
                let is_free = |goal: &&Vec<f64>| !self.check.checks_goals() || self.check.is_free(goal);
                let free: Vec<&Vec<f64>> = goals.iter().filter(is_free).collect();
                if free.is_empty() {
                    return Err(Outcome::GoalsInvalid);
                }
                loop {
                    for goal in &free {
                        search.statistics.goals_tried += 1;
                        if let Some(path) = self.connect(goal, search)? {
                            return Ok(path);
                        }
                    }
                    if self.settings.shares == Shares::Equal {
                        return Err(Outcome::GaveUp);
                    }
                }
            }
            Goal::Grasps(grasps) => {
                let open = self.check.open_poses(grasps);
                self.all_poses(&open, search)
            }
            Goal::Regions(regions) => {
                let open = match &mut self.check {
                    BaselineCheck::Exact(cell, scratch) => {
                        open_region_poses(cell, regions, &mut search.random, scratch)
                    }
                    BaselineCheck::Paper { .. } => Vec::new(),
                };
                if open.is_empty() {
                    return Err(Outcome::GaveUp);
                }
                self.all_poses(&open, search)
            }
        }
    }

    fn all_poses(&mut self, open: &[(usize, Pose)], search: &mut Search) -> Result<Path, Outcome> {
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
                if let Some(path) = self.connect(&goal, search)? {
                    return Ok(path);
                }
            }
        }
    }

    /// Returns the next free configuration for the grasp of `solutions`.
    fn next_goal(&mut self, solutions: &mut IkSearch, search: &mut Search) -> Option<Vec<f64>> {
        let begin = now();
        let attempts_before = solutions.attempts();
        let (robot, start) = (search.problem.robot(), search.problem.start());
        let Self { check, settings, .. } = self;
        let Search { random, statistics, .. } = search;
        let mut is_free = |q: &[f64]| {
            statistics.collision_checks += u64::from(check.checks_goals());
            !check.checks_goals() || check.is_free(q)
        };
        // As in the paper, the first attempt is from the start, pulled towards it; the others are from random configurations.
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

    /// Runs 3 and 4 of [`IkRrt`](crate::IkRrt).
    fn connect(&mut self, goal: &[f64], search: &mut Search) -> Result<Option<Path>, Outcome> {
        let rooted = |index: usize, root: &[f64], search: &mut Search| {
            let mut tree = Forest::new(root.len(), JointMetric::plain(root.len()));
            search.observer.node_added(index, root, None);
            tree.add(root, None);
            tree
        };
        let kept = self.start_tree.take();
        let known = kept.as_ref().map_or(0, Forest::len);
        let from_start = kept.unwrap_or_else(|| rooted(0, search.problem.start(), search));
        let mut trees = [from_start, rooted(1, goal, search)];
        let mut found = Ok(None);
        self.turns += 1;
        let share = match self.settings.shares {
            Shares::Equal => 1,
            Shares::Luby => luby_share(self.turns),
        };
        for _ in 0..self.settings.goal_iterations.saturating_mul(share) {
            if let Err(outcome) = search.begin_iteration() {
                found = Err(outcome);
                break;
            }
            let is_goal = search.random.uniform() < self.settings.p_goal;
            let sample = if is_goal { goal.to_vec() } else { search.sample() };
            let ends = [0, 1].map(|index| self.reach(&mut trees[index], index, &sample, search));
            if let [Some(from_start), Some(from_goal)] = ends {
                let mut path = trees[0].path_to(from_start);
                // Both trees end at the sample, which is added once.
                let back = trees[1].nodes_to_root(from_goal).into_iter().skip(1);
                path.extend(back.map(|node| trees[1].q(node).to_vec()));
                found = Ok(Some(path));
                break;
            }
        }
        search.statistics.nodes += (trees[0].len() + trees[1].len() - known) as u64;
        let [from_start, _] = trees;
        self.start_tree = Some(from_start).filter(|_| self.settings.shares == Shares::Luby);
        found
    }

    /// Extends a tree towards `target` until it is reached, and returns the node there; `None` if it is blocked.
    fn reach(
        &mut self,
        tree: &mut Forest,
        index: usize,
        target: &[f64],
        search: &mut Search,
    ) -> Option<usize> {
        let begin = now();
        let mut node = tree.nearest(target)?;
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let mut is_there = tree.q(node) == target;
        let mut explores = true;
        while !is_there {
            let from = tree.q(node).to_vec();
            let grown = self.grower.grow(&from, target, explores, search);
            for branch in &grown.aside {
                branch.add_to(tree, index, node, search.observer);
            }
            node = grown.ahead.add_to(tree, index, node, search.observer)?;
            is_there = grown.ahead.is_target;
            explores = false;
        }
        Some(node)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_the_publication() {
        let shares: Vec<u64> = (1..=15).map(luby_share).collect();
        assert_eq!(shares, [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
    }
}
