use cranny_path::JointMetric;

use crate::search::connector::Path;
use crate::search::forest::Forest;
use crate::search::search_state::Search;

/// Tree from the start (side 0) and forest from goals (side 1), until a path connects them.
pub(crate) struct TwoTrees {
    pub sides: [Forest; 2],
    /// Root of each goal.
    goals: Vec<usize>,
}

impl TwoTrees {
    /// Creates two sides without nodes, for configurations of `dof` values.
    pub fn new(dof: usize) -> Self {
        let forest = Forest::new(dof, JointMetric::plain(dof));
        Self { sides: [forest.clone(), forest], goals: Vec::new() }
    }

    /// Adds a node at `q` (m, rad; one per joint) to a side, a root without a parent, and returns it.
    pub fn add(&mut self, side: usize, q: &[f64], parent: Option<usize>, search: &mut Search) -> usize {
        search.observer.node_added(side, q, parent);
        self.sides[side].add(q, parent)
    }

    /// Adds the root of another goal at `q` (m, rad; one per joint), and returns it.
    pub fn add_goal(&mut self, q: &[f64], search: &mut Search) -> usize {
        let root = self.add(1, q, None, search);
        self.goals.push(root);
        root
    }

    /// Returns the root of a goal.
    pub fn root(&self, goal: usize) -> usize {
        self.goals[goal]
    }

    /// Removes a goal with all nodes that grew from it.
    pub fn remove_goal(&mut self, goal: usize, search: &mut Search) {
        search.observer.node_cut(1, self.goals[goal]);
        self.sides[1].cut(self.goals[goal]);
    }

    /// Returns the path through a node of each side, both at the same configuration, and its goal.
    pub fn path_through(&self, [from_start, from_goal]: [usize; 2]) -> (Path, usize) {
        let mut path = self.sides[0].path_to(from_start);
        let way = self.sides[1].nodes_to_root(from_goal);
        // Both paths end at the meeting configuration, which is added once.
        path.extend(way.iter().skip(1).map(|&node| self.sides[1].q(node).to_vec()));
        let root = way.last().copied().unwrap_or(from_goal);
        (path, self.goals.iter().position(|goal| *goal == root).unwrap_or(0))
    }

    /// Returns the number of nodes of both sides.
    pub fn len(&self) -> usize {
        self.sides.iter().map(Forest::len).sum()
    }
}
