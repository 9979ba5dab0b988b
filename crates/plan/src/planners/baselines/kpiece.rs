use cranny_path::{JointMetric, RELEASED_STEP_M};
use cranny_robot::{LinkFrames, Robot};
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::planners::rrt::KnownGoals;
use crate::search::connector::{Connector, Path, connect};
use crate::search::forest::Forest;
use crate::search::graph::cell_grid::CellGrid;
use crate::search::growth::{Branch, Grower, Growth};
use crate::search::search_state::Search;
use crate::{Budget, Observer, PlanError, PlanReport, Planner, Ranges};

/// KPIECE (Şucan & Kavraki 2009, "Kinodynamic motion planning by interior-exterior cell exploration", whole, without its dynamics
/// and with one level of cells) to the goals of all grasps at once.
///
/// 1. Inverse kinematics finds goal configurations during the search. The nodes of a tree from the start lie in the cells of a grid
///    over the position of the tip.
/// 2. A cell is chosen: with probability `border`, or with the share of cells at the border if that is greater, among those at the
///    border, which have a neighbour (along one axis) without nodes; otherwise among the others. It is the one of greatest
///    importance (1 + ln I)·score / (S·(1 + N)·C), for a cell created in iteration I, chosen S times, with N neighbours and C nodes.
/// 3. A node of the cell is drawn, rather a recent one (half of a normal distribution over a third of them).
/// 4. The tree grows by steps towards a random goal, with probability `p_goal`, or towards a random configuration near the node, until
///    it arrives or is blocked. Nodes are kept if they cover more than `least_share` of the motion; otherwise the score of the
///    cell, at first 1, is multiplied by `failure`. A motion that arrives at a goal completes a path.
///
/// One iteration is one motion, or one batch of inverse kinematics before there is a goal. The constants are those of OMPL's
/// `KPIECE1`. Differs from it in 1, and in that each step of a motion is a node: every step is proven by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kpiece {
    /// Least probability of a cell at the border, in [0, 1]. Default 0.9.
    pub border: f64,
    /// Probability of a motion towards a goal, in [0, 1]. Default 0.05.
    pub p_goal: f64,
    /// Factor of the score of a cell from which a motion failed, in [0, 1]. Default 0.5.
    pub failure: f64,
    /// Share of a motion above which its proven part is kept, in [0, 1]. Default 0.2.
    pub least_share: f64,
    /// Maximum difference of any joint between a node and a random configuration near it, in m or rad. Default 1.
    pub range: f64,
    /// Edge length of a cell, in metres. Default 0.1, a twentieth of a common workspace, as in OMPL.
    pub cell_m: f64,
    /// Maximum motion of the origin of any link frame in a step, in metres. Default 0.1, that of the released planners.
    pub step_m: f64,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
}

impl Default for Kpiece {
    fn default() -> Self {
        Self {
            border: 0.9,
            p_goal: 0.05,
            failure: 0.5,
            least_share: 0.2,
            range: 1.0,
            cell_m: 0.1,
            step_m: RELEASED_STEP_M,
            goals: 100,
        }
    }
}

impl Planner for Kpiece {
    fn name(&self) -> &'static str {
        "kpiece"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .share("border", self.border)?
            .share("p_goal", self.p_goal)?
            .share("failure", self.failure)?
            .share("least_share", self.least_share)?
            .positive("range", self.range)?
            .positive("cell_m", self.cell_m)?
            .positive("step_m", self.step_m)?
            .count("goals", self.goals, usize::MAX)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        self.check()?;
        let robot = problem.robot().as_ref();
        let mut tree = Tree {
            settings: self,
            robot,
            frames: robot.frames(),
            nodes: Forest::new(robot.dof(), JointMetric::plain(robot.dof())),
            grid: CellGrid::default(),
            goals: KnownGoals::default(),
            grower: Grower::new(problem, Growth::Step { step_m: self.step_m }),
            motions: 0,
        };
        connect(self.name(), &mut tree, self.goals, problem, (budget, seed), observer)
    }
}

struct Tree<'a> {
    settings: &'a Kpiece,
    robot: &'a Robot,
    frames: LinkFrames,
    nodes: Forest,
    grid: CellGrid,
    goals: KnownGoals,
    grower: Grower<'a>,
    /// Number of motions up to now.
    motions: u64,
}

impl Tree<'_> {
    /// Returns the cell of a configuration.
    fn cell_of(&mut self, q: &[f64]) -> [i64; 3] {
        self.robot.tip_kinematics(q, &mut self.frames);
        let tip = self.frames.link(self.robot.tip()).translation;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the nearest integer serves where it is too large"
        )]
        [tip.x, tip.y, tip.z].map(|value| (value / self.settings.cell_m).floor() as i64)
    }

    /// Returns the proven steps from `q` towards `target` until it arrives or is blocked.
    fn motion(&mut self, q: &[f64], target: &[f64], search: &mut Search) -> Branch {
        let mut branch = Branch::default();
        while !branch.is_target {
            let from = branch.nodes.last().map_or(q, Vec::as_slice);
            let Some((end, is_target)) = self.grower.step(from, target, search) else { break };
            branch.nodes.push(end);
            branch.is_target = is_target;
        }
        branch
    }

    fn add(&mut self, node: usize) {
        let q = self.nodes.q(node).to_vec();
        let coordinates = self.cell_of(&q);
        self.grid.add(coordinates, node, self.motions);
    }
}

impl Connector for Tree<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        search.observer.node_added(0, q, None);
        let root = self.nodes.add(q, None);
        self.add(root);
    }

    fn add_goal(&mut self, q: &[f64], _search: &mut Search) {
        self.goals.add(q);
    }

    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        self.motions += 1;
        // 2. and 3.
        let cell = self.grid.choose(self.settings.border, &mut search.random)?;
        let from = self.grid.node_of(cell, &mut search.random);
        let q = self.nodes.q(from).to_vec();
        // 4.
        let goal = self.goals.draw(self.settings.p_goal, search);
        let (target, goal) = match goal {
            Some((target, goal)) => (target, Some(goal)),
            None => (search.sample_near(&q, self.settings.range), None),
        };
        if q == target {
            return goal.map(|goal| (self.nodes.path_to(from), goal));
        }
        let branch = self.motion(&q, &target, search);
        let covered = branch.nodes.last().map_or(0.0, |end| self.nodes.distance(&q, end));
        if !branch.is_target && covered <= self.settings.least_share * self.nodes.distance(&q, &target) {
            self.grid.lower(cell, self.settings.failure);
            return None;
        }
        let first = self.nodes.added();
        let end = branch.add_to(&mut self.nodes, 0, from, search.observer)?;
        (first..=end).for_each(|node| self.add(node));
        goal.filter(|_| branch.is_target).map(|goal| (self.nodes.path_to(end), goal))
    }

    fn remove_goal(&mut self, goal: usize, _search: &mut Search) {
        self.goals.remove(goal);
    }

    fn nodes(&self) -> usize {
        self.nodes.len()
    }
}
