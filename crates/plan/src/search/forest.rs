use cranny_path::JointMetric;

use crate::NearestNeighbours;

/// Trees of configurations that grow from any number of roots, and from which nodes can be cut off. Nodes are numbered from 0
/// in the order in which they were added, including roots, and keep their numbers.
///
/// Edges that prolong each other form one straight edge. Edges are assumed free until they are proven or refuted as a whole.
///
/// All methods that take a node panic if there is none of that number.
#[derive(Clone, Debug)]
pub struct Forest {
    dof: usize,
    metric: JointMetric,
    configurations: Vec<f64>,
    parents: Vec<Option<usize>>,
    /// First node of the straight edge to each node; itself for a root.
    begins: Vec<usize>,
    /// Length of the path from its root to each node, plus the cost of the root.
    costs: Vec<f64>,
    /// True for each node with a proven straight edge.
    proven: Vec<bool>,
    index: NearestNeighbours,
    /// Node of each point of the index.
    indexed: Vec<usize>,
    scaled: Vec<f64>,
}

impl Forest {
    /// Creates a forest without nodes, for configurations of `dof` values; `metric` determines the nearest node.
    pub fn new(dof: usize, metric: JointMetric) -> Self {
        Self {
            dof,
            metric,
            configurations: Vec::new(),
            parents: Vec::new(),
            begins: Vec::new(),
            costs: Vec::new(),
            proven: Vec::new(),
            index: NearestNeighbours::new(dof),
            indexed: Vec::new(),
            scaled: vec![0.0; dof],
        }
    }

    /// Removes all nodes.
    pub fn clear(&mut self) {
        *self = Self::new(self.dof, self.metric.clone());
    }

    /// Returns the number of nodes ever added, including those that were cut off.
    pub fn added(&self) -> usize {
        self.parents.len()
    }

    /// Returns the number of nodes that are not cut off.
    pub fn len(&self) -> usize {
        self.indexed.len()
    }

    /// Returns true if [`Self::len`] is 0.
    pub fn is_empty(&self) -> bool {
        self.indexed.is_empty()
    }

    /// Returns the configuration (m, rad; one per joint) of a node.
    pub fn q(&self, node: usize) -> &[f64] {
        &self.configurations[node * self.dof..(node + 1) * self.dof]
    }

    /// Returns the length of the path from its root to a node, plus the cost of the root.
    pub fn cost(&self, node: usize) -> f64 {
        self.costs[node]
    }

    /// Adds a root at `q` (m, rad; one per joint) with its own cost, and returns it.
    pub fn add_root(&mut self, q: &[f64], cost: f64) -> usize {
        let node = self.add(q, None);
        self.costs[node] = cost;
        node
    }

    /// Adds a node at `q` (m, rad; one per joint), the end of an edge from its parent or a root, and returns it.
    pub fn add(&mut self, q: &[f64], parent: Option<usize>) -> usize {
        self.add_on_edge(q, parent, parent.unwrap_or(self.parents.len()))
    }

    /// Adds a node at `q` (m, rad; one per joint) that prolongs the straight edge to its parent, and returns it.
    pub fn prolong(&mut self, q: &[f64], parent: usize) -> usize {
        self.add_on_edge(q, Some(parent), self.begins[parent])
    }

    fn add_on_edge(&mut self, q: &[f64], parent: Option<usize>, begin: usize) -> usize {
        self.configurations.extend_from_slice(q);
        self.costs.push(parent.map_or(0.0, |parent| self.costs[parent] + self.distance(self.q(parent), q)));
        self.parents.push(parent);
        self.begins.push(begin);
        self.proven.push(parent.is_none());
        self.metric.scale(q, &mut self.scaled);
        self.index.add(&self.scaled);
        self.indexed.push(self.parents.len() - 1);
        self.parents.len() - 1
    }

    /// Returns the node nearest to `q` (m, rad; one per joint); `None` for a forest without nodes.
    pub fn nearest(&mut self, q: &[f64]) -> Option<usize> {
        self.metric.scale(q, &mut self.scaled);
        self.index.nearest(&self.scaled).map(|point| self.indexed[point])
    }

    /// Returns the distance between two configurations (m, rad; one per joint) in the metric of the forest.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.metric.distance(a, b)
    }

    /// Returns the nodes at which the path from `node` to its root turns, including both.
    pub fn turns_to_root(&self, node: usize) -> Vec<usize> {
        let next = |&node: &usize| Some(self.begins[node]).filter(|begin| *begin != node);
        std::iter::successors(Some(node), next).collect()
    }

    /// Returns the nodes from `node` to its root, including both.
    pub fn nodes_to_root(&self, node: usize) -> Vec<usize> {
        std::iter::successors(Some(node), |&node| self.parents[node]).collect()
    }

    /// Returns the configurations (m, rad; one value per joint) from the root of a node to the node.
    pub fn path_to(&self, node: usize) -> Vec<Vec<f64>> {
        self.nodes_to_root(node).into_iter().rev().map(|node| self.q(node).to_vec()).collect()
    }

    /// Returns the first node of the straight edge to `node`, unless the edge is proven or `node` is a root.
    pub fn unproven_edge(&self, node: usize) -> Option<usize> {
        Some(self.begins[node]).filter(|_| !self.proven[node])
    }

    /// Returns the first node on the straight edge to `node` at or beyond the share `place` of its length.
    pub fn first_beyond(&self, node: usize, place: f64) -> usize {
        let begin = self.begins[node];
        let from_begin = |node: usize| self.distance(self.q(begin), self.q(node));
        let bar = place * from_begin(node);
        let before = |&node: &usize| self.parents[node].filter(|parent| *parent != begin);
        let beyond = std::iter::successors(Some(node), before).take_while(|&node| from_begin(node) >= bar);
        beyond.last().unwrap_or(node)
    }

    /// Marks the straight edge to the node as proven.
    pub fn set_proven(&mut self, node: usize) {
        self.proven[node] = true;
    }

    /// Removes the node and all its descendants from the forest.
    pub fn cut(&mut self, node: usize) {
        let mut is_cut = vec![false; self.parents.len()];
        is_cut[node] = true;
        // Parents come before their children.
        for child in node + 1..self.parents.len() {
            is_cut[child] = self.parents[child].is_some_and(|parent| is_cut[parent]);
        }
        let living: Vec<usize> = self.indexed.iter().copied().filter(|&node| !is_cut[node]).collect();
        self.index = NearestNeighbours::new(self.dof);
        for &node in &living {
            let q = &self.configurations[node * self.dof..(node + 1) * self.dof];
            self.metric.scale(q, &mut self.scaled);
            self.index.add(&self.scaled);
        }
        self.indexed = living;
    }
}
