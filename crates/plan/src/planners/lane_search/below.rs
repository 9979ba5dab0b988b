//! Search for paths that cost less than a known one.

use cranny_robot::between;

use super::{EdgeRelation, LaneSearch, SearchState, as_count};
use crate::search::connector::Path;
use crate::search::forest::Forest;
use crate::search::goal_pool::GoalPool;
use crate::{Observer, Outcome};

impl LaneSearch<'_> {
    /// Clears both sides, except for the start and the known goals.
    fn begin_anew(&mut self, observer: &mut dyn Observer) {
        self.sides.iter_mut().for_each(Forest::clear);
        self.domains = [Vec::new(), Vec::new()];
        self.add_root(0, self.problem.start(), 0.0, observer);
        self.goals.clear();
        self.stage = SearchState::Between;
        for (goal, cost) in std::mem::take(&mut self.known) {
            self.remember_goal(&goal, cost, observer);
        }
    }

    /// Returns the number of completed iterations.
    pub fn iterations(&self) -> u64 {
        self.statistics.iterations
    }

    /// Sets the costs that the grasps add to the length of the paths to them (one per grasp), in the unit of the cost.
    pub fn set_grasp_costs(&mut self, costs: Vec<f64>) {
        self.grasp_costs = costs;
    }

    /// Adds the free goal configurations of the problem to the known goals.
    pub fn know_goals(&mut self) {
        let goals = self.problem.goal_configurations();
        self.known.extend(
            goals
                .iter()
                .filter(|goal| self.cell.is_free(goal, &mut self.scratch))
                .map(|goal| (goal.clone(), 0.0)),
        );
    }

    /// Draws one more batch of goals for the next search, about a known path of way points (m, rad; one value per joint): those
    /// to which a path may cost less than `bound`.
    pub fn draw_goals(&mut self, pool: &mut GoalPool, path: &[Vec<f64>], bound: f64) {
        let Self { random, scratch, statistics, .. } = self;
        let found = pool.draw_batch(path, random, scratch, statistics);
        let cost = |grasp: usize| self.grasp_costs.get(grasp).copied().unwrap_or(0.0);
        self.drawn.extend(found.into_iter().map(|(grasp, goal)| (goal, cost(grasp))));
        let least = |goal: &[f64]| self.sides[0].distance(self.problem.start(), goal);
        self.drawn.retain(|(goal, cost)| least(goal) + cost < bound);
    }

    /// Searches anew for a path that may cost less than `bound` once shortened, in a limited number of iterations. Goals to
    /// which the straight line costs more are dropped. The tree from the start begins with the way points of `along` (m, rad;
    /// one value per joint), if any, except for its goal, so that a new path departs from it.
    pub fn run_below(
        &mut self,
        bound: f64,
        iterations: u64,
        along: Option<&[Vec<f64>]>,
        observer: &mut dyn Observer,
    ) -> Result<Path, Outcome> {
        self.bound = bound;
        self.began = self.statistics.iterations;
        self.last = self.began.saturating_add(iterations);
        let drawn = std::mem::take(&mut self.drawn);
        self.known.extend(drawn);
        self.begin_anew(observer);
        if let Some((_, path)) = along.and_then(<[_]>::split_last) {
            self.add_path(path, observer);
        }
        self.search(observer)
    }

    /// Adds a path from the start to its tree, with nodes as far apart as in a growth.
    fn add_path(&mut self, path: &[Vec<f64>], observer: &mut dyn Observer) {
        let mut node = 0;
        for edge in path.windows(2) {
            let steps = (self.sides[0].distance(&edge[0], &edge[1]) / self.settings.step).ceil().max(1.0);
            let mut way = EdgeRelation::Turns;
            for step in 1..=as_count(steps) {
                let q: Vec<f64> = between(&edge[0], &edge[1], step as f64 / steps).collect();
                node = self.add_node(0, &q, (node, way), observer);
                way = EdgeRelation::GoesOn;
            }
        }
    }
}
