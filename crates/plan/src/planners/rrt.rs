use cranny_path::{JointMetric, RELEASED_STEP_M};
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::connector::{Connector, Path, connect};
use crate::search::forest::Forest;
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// RRT (`LaValle` 1998, "Rapidly-exploring random trees", whole; with goal bias: `LaValle` & Kuffner 2001, §5.3) to the goals
/// of all grasps at once.
///
/// 1. Inverse kinematics finds goal configurations during the search.
/// 2. With probability `p_goal` towards a random goal, otherwise towards a uniform random configuration, one step is taken from
///    the nearest node (L2 in joint space), and kept if it is proven.
/// 3. A step that ends at a goal completes a path.
///
/// One iteration is one step, or one batch of inverse kinematics before there is a goal. Differs from the publication in 1,
/// and in that the length of a step is measured at the links.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rrt {
    /// Probability of a step towards a goal, in [0, 1]. Default 0.05.
    pub p_goal: f64,
    /// Maximum motion of the origin of any link frame in a step, in metres. Default 0.1, that of the released planners.
    pub step_m: f64,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
}

impl Default for Rrt {
    fn default() -> Self {
        Self { p_goal: 0.05, step_m: RELEASED_STEP_M, goals: 100 }
    }
}

impl Planner for Rrt {
    fn name(&self) -> &'static str {
        "rrt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name()).share("p_goal", self.p_goal)?.positive("step_m", self.step_m)?.count(
            "goals",
            self.goals,
            usize::MAX,
        )?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let dof = problem.robot().dof();
        let mut tree = Tree {
            p_goal: self.p_goal,
            nodes: Forest::new(dof, JointMetric::plain(dof)),
            goals: KnownGoals::default(),
            grower: Grower::new(problem, Growth::Step { step_m: self.step_m }),
        };
        connect(self.name(), &mut tree, self.goals, problem, (budget, seed), observer)
    }
}

struct Tree<'a> {
    p_goal: f64,
    nodes: Forest,
    goals: KnownGoals,
    grower: Grower<'a>,
}

impl Connector for Tree<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        search.observer.node_added(0, q, None);
        self.nodes.add(q, None);
    }

    fn add_goal(&mut self, q: &[f64], _search: &mut Search) {
        self.goals.add(q);
    }

    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        let (target, goal) = self.goals.target(self.p_goal, search);
        let begin = now();
        let nearest = self.nodes.nearest(&target)?;
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let from = self.nodes.q(nearest).to_vec();
        if from == target {
            return Some((self.nodes.path_to(nearest), goal?));
        }
        let (end, is_target) = self.grower.step(&from, &target, search)?;
        search.observer.node_added(0, &end, Some(nearest));
        let node = self.nodes.add(&end, Some(nearest));
        goal.filter(|_| is_target).map(|goal| (self.nodes.path_to(node), goal))
    }

    fn remove_goal(&mut self, goal: usize, _search: &mut Search) {
        self.goals.remove(goal);
    }

    fn nodes(&self) -> usize {
        self.nodes.len()
    }
}

/// Goals towards which a tree from the start grows at times.
#[derive(Clone, Debug, Default)]
pub(crate) struct KnownGoals {
    configurations: Vec<Vec<f64>>,
    /// Indices of the goals that were not removed.
    living: Vec<usize>,
}

impl KnownGoals {
    /// Adds a goal (m, rad; one per joint).
    pub fn add(&mut self, q: &[f64]) {
        self.living.push(self.configurations.len());
        self.configurations.push(q.to_vec());
    }

    pub fn remove(&mut self, goal: usize) {
        self.living.retain(|living| *living != goal);
    }

    /// Returns the configuration (m, rad; one per joint) to grow towards next: with probability `p_goal` a random goal, with
    /// its index, otherwise a random configuration.
    pub fn target(&self, p_goal: f64, search: &mut Search) -> (Vec<f64>, Option<usize>) {
        match self.draw(p_goal, search) {
            Some((q, goal)) => (q, Some(goal)),
            None => (search.sample(), None),
        }
    }

    /// Returns with probability `p_goal` a random goal (m, rad; one per joint), with its index.
    pub fn draw(&self, p_goal: f64, search: &mut Search) -> Option<(Vec<f64>, usize)> {
        let is_drawn = search.random.uniform() < p_goal;
        is_drawn.then(|| {
            let goal = self.living[search.random.index(self.living.len())];
            (self.configurations[goal].clone(), goal)
        })
    }
}
