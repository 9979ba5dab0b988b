use cranny_task::Problem;

use crate::search::connector::{Connector, Path};
use crate::search::graph::two_trees::TwoTrees;
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;

/// Tree from the start and forest from goals that grow towards each other in turn: RRT-Connect (Kuffner & `LaValle` 2000, §II),
/// and with burs RBT-Connect (Lačević, Osmanković & Ademović 2016, whole).
pub(crate) struct Bidirectional<'a> {
    grower: Grower<'a>,
    trees: TwoTrees,
    /// Side that grows next.
    side: usize,
}

impl<'a> Bidirectional<'a> {
    pub fn new(problem: &'a Problem, growth: Growth) -> Self {
        let trees = TwoTrees::new(problem.robot().dof());
        Self { grower: Grower::new(problem, growth), trees, side: 0 }
    }

    /// Adds nodes (m, rad; one value per joint) below the root of a goal, each below the one before; the motions between them are proven.
    pub fn add_branch(&mut self, goal: usize, nodes: &[Vec<f64>], search: &mut Search) {
        let mut parent = self.trees.root(goal);
        for q in nodes {
            parent = self.trees.add(1, q, Some(parent), search);
        }
    }

    /// Grows one side towards `sample` (m, rad; one per joint), and the other as far as possible towards the end of the first.
    pub fn grow_towards(&mut self, sample: &[f64], search: &mut Search) -> Option<(Path, usize)> {
        let side = self.side;
        self.side = 1 - side;
        let from = self.nearest(side, sample, search);
        let (node, _) = self.extend(side, from, sample, true, search)?;
        let meeting = self.trees.sides[side].q(node).to_vec();
        let mut at = self.nearest(1 - side, &meeting, search);
        let mut is_met = self.trees.sides[1 - side].q(at) == meeting;
        while !is_met {
            (at, is_met) = self.extend(1 - side, at, &meeting, false, search)?;
        }
        Some(self.trees.path_through(if side == 0 { [node, at] } else { [at, node] }))
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
        let q = self.trees.sides[side].q(from).to_vec();
        let grown = self.grower.grow(&q, target, explores, search);
        for branch in &grown.aside {
            branch.add_to(&mut self.trees.sides[side], side, from, search.observer);
        }
        let end = grown.ahead.add_to(&mut self.trees.sides[side], side, from, search.observer)?;
        Some((end, grown.ahead.is_target))
    }

    fn nearest(&mut self, side: usize, q: &[f64], search: &mut Search) -> usize {
        let begin = now();
        let nearest = self.trees.sides[side].nearest(q).unwrap_or(0);
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        nearest
    }
}

impl Connector for Bidirectional<'_> {
    fn add_start(&mut self, q: &[f64], search: &mut Search) {
        self.trees.add(0, q, None, search);
    }

    fn add_goal(&mut self, q: &[f64], search: &mut Search) {
        self.trees.add_goal(q, search);
    }

    /// Grows one side towards a random configuration, and the other as far as possible towards the end of the first.
    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        let sample = search.sample();
        self.grow_towards(&sample, search)
    }

    fn remove_goal(&mut self, goal: usize, search: &mut Search) {
        self.trees.remove_goal(goal, search);
    }

    fn nodes(&self) -> usize {
        self.trees.len()
    }
}
