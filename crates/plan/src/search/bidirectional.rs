use cranny_path::JointMetric;
use cranny_task::Problem;

use crate::search::connector::{Connector, Path};
use crate::search::forest::Forest;
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;

/// Tree from the start and forest from goals that grow towards each other in turn: RRT-Connect (Kuffner & `LaValle` 2000, §II),
/// and with burs RBT-Connect (Lačević, Osmanković & Ademović 2016, whole).
pub(crate) struct Bidirectional<'a> {
    grower: Grower<'a>,
    sides: [Forest; 2],
    /// Root of each goal.
    goals: Vec<usize>,
    /// Side that grows next.
    side: usize,
}

impl<'a> Bidirectional<'a> {
    pub fn new(problem: &'a Problem, growth: Growth) -> Self {
        let dof = problem.robot().dof();
        let forest = Forest::new(dof, JointMetric::plain(dof));
        Self {
            grower: Grower::new(problem, growth),
            sides: [forest.clone(), forest],
            goals: Vec::new(),
            side: 0,
        }
    }

    /// Adds nodes (m, rad; one value per joint) below the root of a goal, each below the one before; the motions between them are proven.
    pub fn add_branch(&mut self, goal: usize, nodes: &[Vec<f64>], search: &mut Search) {
        let mut parent = self.goals[goal];
        for q in nodes {
            parent = self.add(1, q, Some(parent), search);
        }
    }

    /// Grows one side towards `sample` (m, rad; one per joint), and the other as far as possible towards the end of the first.
    pub fn grow_towards(&mut self, sample: &[f64], search: &mut Search) -> Option<(Path, usize)> {
        let side = self.side;
        self.side = 1 - side;
        let from = self.nearest(side, sample, search);
        let (node, _) = self.extend(side, from, sample, true, search)?;
        let meeting = self.sides[side].q(node).to_vec();
        let mut at = self.nearest(1 - side, &meeting, search);
        let mut is_met = self.sides[1 - side].q(at) == meeting;
        while !is_met {
            (at, is_met) = self.extend(1 - side, at, &meeting, false, search)?;
        }
        Some(self.path_through(if side == 0 { [node, at] } else { [at, node] }))
    }

    /// Extends a side from a node towards `target`, and returns the new node, and true if it is the target.
    fn extend(
        &mut self,
        side: usize,
        from: usize,
        target: &[f64],
        explores: bool,
        search: &mut Search,
    ) -> Option<(usize, bool)> {
        let q = self.sides[side].q(from).to_vec();
        let grown = self.grower.grow(&q, target, explores, search);
        for branch in &grown.aside {
            branch.add_to(&mut self.sides[side], side, from, search.observer);
        }
        let end = grown.ahead.add_to(&mut self.sides[side], side, from, search.observer)?;
        Some((end, grown.ahead.is_target))
    }

    /// Returns the path through two nodes at the same configuration, and its goal.
    fn path_through(&self, [from_start, from_goal]: [usize; 2]) -> (Path, usize) {
        let mut path = self.sides[0].path_to(from_start);
        let way = self.sides[1].nodes_to_root(from_goal);
        // Both paths end at the meeting configuration, which is added once.
        path.extend(way.iter().skip(1).map(|&node| self.sides[1].q(node).to_vec()));
        let root = way.last().copied().unwrap_or(from_goal);
        (path, self.goals.iter().position(|goal| *goal == root).unwrap_or(0))
    }

    fn nearest(&mut self, side: usize, q: &[f64], search: &mut Search) -> usize {
        let begin = now();
        let nearest = self.sides[side].nearest(q).unwrap_or(0);
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        nearest
    }

    fn add(&mut self, side: usize, q: &[f64], parent: Option<usize>, search: &mut Search) -> usize {
        search.observer.node_added(side, q, parent);
        self.sides[side].add(q, parent)
    }
}

impl Connector for Bidirectional<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        self.add(0, q, None, search);
    }

    fn add_goal(&mut self, q: &[f64], search: &mut Search) {
        let root = self.add(1, q, None, search);
        self.goals.push(root);
    }

    /// Grows one side towards a random configuration, and the other as far as possible towards the end of the first.
    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        let sample = search.sample();
        self.grow_towards(&sample, search)
    }

    fn remove_goal(&mut self, goal: usize, search: &mut Search) {
        search.observer.node_cut(1, self.goals[goal]);
        self.sides[1].cut(self.goals[goal]);
    }

    fn nodes(&self) -> usize {
        self.sides.iter().map(Forest::len).sum()
    }
}
