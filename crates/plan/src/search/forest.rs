use cranny_path::JointMetric;

use crate::NearestNeighbours;

/// Trees of configurations that grow from any number of roots, from which nodes can be cut off again. Nodes are numbered
/// from 0 in the order in which they were added, roots included, and keep their numbers.
///
/// Edges that prolong each other make one straight edge; edges are taken to be free until they are proven or
/// refuted as a whole.
///
/// All methods that take a node panic if there is none of that number.
#[derive(Clone, Debug)]
pub struct Forest {
    dof: usize,
    metric: JointMetric,
    configurations: Vec<f64>,
    parents: Vec<Option<usize>>,
    /// Per node where the straight edge begins that leads to it; itself for a root.
    begins: Vec<usize>,
    /// Per node the length of the path from its root, and what the root costs.
    costs: Vec<f64>,
    /// Whether that edge is proven.
    proven: Vec<bool>,
    index: NearestNeighbours,
    /// Node of each point of the index.
    indexed: Vec<usize>,
    scaled: Vec<f64>,
}

impl Forest {
    /// Without any node, for configurations of `dof` values; which node is the nearest, `metric` says.
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

    /// Takes all nodes out.
    pub fn clear(&mut self) {
        *self = Self::new(self.dof, self.metric.clone());
    }

    /// How many nodes were ever added, those that are cut off included.
    pub fn added(&self) -> usize {
        self.parents.len()
    }

    /// How many nodes can be grown from.
    pub fn len(&self) -> usize {
        self.indexed.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.indexed.is_empty()
    }

    /// The configuration (m, rad; one per joint) of a node.
    pub fn q(&self, node: usize) -> &[f64] {
        &self.configurations[node * self.dof..(node + 1) * self.dof]
    }

    /// Length of the path from its root to a node, and what the root costs.
    pub fn cost(&self, node: usize) -> f64 {
        self.costs[node]
    }

    /// A new root at `q` (m, rad; one per joint) that costs so much by itself.
    pub fn add_root(&mut self, q: &[f64], cost: f64) -> usize {
        let node = self.add(q, None);
        self.costs[node] = cost;
        node
    }

    /// A new node at `q` (m, rad; one per joint), the end of an edge from its parent; without a parent, a root.
    pub fn add(&mut self, q: &[f64], parent: Option<usize>) -> usize {
        self.add_on_edge(q, parent, parent.unwrap_or(self.parents.len()))
    }

    /// A new node at `q` (m, rad; one per joint) that prolongs the straight edge that led to its parent.
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

    /// The node nearest to `q` (m, rad; one per joint); `None` for a forest without nodes.
    pub fn nearest(&mut self, q: &[f64]) -> Option<usize> {
        self.metric.scale(q, &mut self.scaled);
        self.index.nearest(&self.scaled).map(|point| self.indexed[point])
    }

    /// The distance of two configurations (m, rad; one per joint) in the metric of the forest.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.metric.distance(a, b)
    }

    /// The nodes at which the path from `node` to its root turns, both included.
    pub fn turns_to_root(&self, node: usize) -> Vec<usize> {
        let next = |&node: &usize| Some(self.begins[node]).filter(|begin| *begin != node);
        std::iter::successors(Some(node), next).collect()
    }

    /// The nodes from `node` to its root, both included.
    pub fn nodes_to_root(&self, node: usize) -> Vec<usize> {
        std::iter::successors(Some(node), |&node| self.parents[node]).collect()
    }

    /// The configurations (m, rad; one value per joint) from the root of `node` to it.
    pub fn path_to(&self, node: usize) -> Vec<Vec<f64>> {
        self.nodes_to_root(node).into_iter().rev().map(|node| self.q(node).to_vec()).collect()
    }

    /// Where the straight edge to the node begins, unless it is proven already or the node is a root.
    pub fn unproven_edge(&self, node: usize) -> Option<usize> {
        Some(self.begins[node]).filter(|_| !self.proven[node])
    }

    /// The first node on the straight edge to `node` that lies at the share `place` of it, or beyond.
    pub fn first_beyond(&self, node: usize, place: f64) -> usize {
        let begin = self.begins[node];
        let from_begin = |node: usize| self.distance(self.q(begin), self.q(node));
        let bar = place * from_begin(node);
        let before = |&node: &usize| self.parents[node].filter(|parent| *parent != begin);
        let beyond = std::iter::successors(Some(node), before).take_while(|&node| from_begin(node) >= bar);
        beyond.last().unwrap_or(node)
    }

    /// The straight edge that leads to the node is proven.
    pub fn set_proven(&mut self, node: usize) {
        self.proven[node] = true;
    }

    /// Takes the node and all that grew from it out of the forest.
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
