use cranny_collision::{Cell, Scratch};
use cranny_task::{Goal, GraspFailure, Problem};

use crate::search::goal_pool::GoalPool;
use crate::search::search_state::Search;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport};

/// Way points (m, rad; one value per joint each).
pub type Path = Vec<Vec<f64>>;

/// Trees or a graph to which a start and any number of goals are added, and that grow until they connect them.
pub trait Connector {
    /// Adds the start (m, rad; one per joint), once and first; it is free.
    fn add_start(&mut self, q: &[f64], search: &mut Search);

    /// Adds a goal (m, rad; one per joint), which is free; goals are numbered from 0.
    fn add_goal(&mut self, q: &[f64], search: &mut Search);

    /// Grows by one iteration, once there is a goal; returns a path with every edge proven, and the index of its goal.
    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)>;

    /// Returns the best known path, if [`Self::grow`] searches for better ones: it is the result when the budget is spent.
    fn best(&self) -> Option<(Path, usize)> {
        None
    }

    /// Removes an unsuitable goal.
    fn remove_goal(&mut self, goal: usize, search: &mut Search);

    /// Returns the number of nodes.
    fn nodes(&self) -> usize;
}

/// Searches for a path to any goal of a problem. For grasps, inverse kinematics finds goals between the iterations, up to
/// `most_goals`.
///
/// # Errors
/// [`PlanError`] for a criterion other than `exact`, or a problem without a goal.
pub fn connect(
    planner: &'static str,
    connector: &mut dyn Connector,
    most_goals: usize,
    problem: &Problem,
    (budget, seed): (&Budget, u64),
    observer: &mut dyn Observer,
) -> Result<PlanReport, PlanError> {
    let mut search = Search::new(problem, budget, seed, observer);
    let (cell, goal) = (problem.exact_cell(planner)?, problem.some_goal()?);
    let mut goals = Goals { connector, most: most_goals, added: 0, removed: 0 };
    let mut failures = Vec::new();
    let ended = goals.run(cell, goal, &mut search, &mut failures);
    search.statistics.nodes = goals.connector.nodes() as u64;
    Ok(PlanReport { failures, ..search.report(ended) })
}

struct Goals<'a> {
    connector: &'a mut dyn Connector,
    most: usize,
    added: usize,
    removed: usize,
}

impl Goals<'_> {
    fn run(
        &mut self,
        cell: &Cell,
        goal: &Goal,
        search: &mut Search,
        failures: &mut Vec<GraspFailure>,
    ) -> Result<Path, Outcome> {
        let mut scratch = cell.scratch();
        let start = search.problem.start();
        if !cell.is_free(start, &mut scratch) {
            return Err(Outcome::StartInvalid);
        }
        self.connector.add_start(start, search);
        match goal {
            Goal::Configurations(goals) => {
                search.statistics.collision_checks += goals.len() as u64;
                for goal in goals.iter().filter(|goal| cell.is_free(goal, &mut scratch)) {
                    self.add(goal, search);
                }
                self.grow_until_connected(search, &mut |_| Ok(Vec::new()))
            }
            Goal::Grasps(grasps) => {
                self.grow_from_pool(GoalPool::new(search.problem, cell, grasps), search, failures)
            }
            Goal::Regions(regions) => {
                self.grow_from_pool(GoalPool::of_regions(search.problem, cell, regions), search, failures)
            }
        }
    }

    fn grow_from_pool(
        &mut self,
        mut pool: GoalPool,
        search: &mut Search,
        failures: &mut Vec<GraspFailure>,
    ) -> Result<Path, Outcome> {
        let mut scratch = pool.scratch();
        let ended = self.grow_until_connected(search, &mut |search| draw(&mut pool, &mut scratch, search));
        if ended.is_err() {
            *failures = pool.failures(&mut scratch);
        }
        ended
    }

    fn grow_until_connected(
        &mut self,
        search: &mut Search,
        new_goals: &mut dyn FnMut(&mut Search) -> Result<Path, Outcome>,
    ) -> Result<Path, Outcome> {
        let is_given = matches!(search.problem.goal(), Goal::Configurations(_));
        loop {
            if is_given && self.added == self.removed {
                return Err(Outcome::GoalsInvalid);
            }
            let (found, spent) = match search.begin_iteration() {
                Ok(()) => {
                    if self.added - self.removed < self.most {
                        for goal in new_goals(search)? {
                            self.add(&goal, search);
                        }
                    }
                    let can_grow = self.added > self.removed;
                    (can_grow.then(|| self.connector.grow(search)).flatten(), None)
                }
                Err(outcome) => (self.connector.best(), Some(outcome)),
            };
            match (found, spent) {
                (Some((path, _)), _) => return Ok(path),
                (None, Some(outcome)) => return Err(outcome),
                (None, None) => {}
            }
        }
    }

    fn add(&mut self, goal: &[f64], search: &mut Search) {
        self.connector.add_goal(goal, search);
        self.added += 1;
    }
}

/// Returns the goals of one more iteration, unless there can be none.
fn draw(pool: &mut GoalPool, scratch: &mut Scratch, search: &mut Search) -> Result<Path, Outcome> {
    let goals = pool.draw(&mut search.random, scratch, &mut search.statistics);
    if pool.is_hopeless() {
        Err(Outcome::NoReachableGrasp)
    } else {
        Ok(goals.into_iter().map(|(_, q)| q).collect())
    }
}
