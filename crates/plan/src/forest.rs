use crate::NearestNeighbours;
use crate::joint_metric::JointMetric;

/// Trees of configurations that grow from any number of roots, from which nodes can be cut off again.
///
/// A node's edge to its parent is taken to be free until it is proven or refuted.
#[derive(Clone, Debug)]
pub(crate) struct Forest {
    dof: usize,
    metric: JointMetric,
    configurations: Vec<f64>,
    parents: Vec<Option<usize>>,
    proven: Vec<bool>,
    index: NearestNeighbours,
    /// Node of each point of the index.
    indexed: Vec<usize>,
    scaled: Vec<f64>,
}

impl Forest {
    pub fn new(dof: usize, metric: JointMetric) -> Self {
        Self {
            dof,
            metric,
            configurations: Vec::new(),
            parents: Vec::new(),
            proven: Vec::new(),
            index: NearestNeighbours::new(dof),
            indexed: Vec::new(),
            scaled: vec![0.0; dof],
        }
    }

    /// How many nodes can be grown from.
    pub fn len(&self) -> usize {
        self.indexed.len()
    }

    pub fn q(&self, node: usize) -> &[f64] {
        &self.configurations[node * self.dof..(node + 1) * self.dof]
    }

    pub fn add(&mut self, q: &[f64], parent: Option<usize>) -> usize {
        self.configurations.extend_from_slice(q);
        self.parents.push(parent);
        self.proven.push(parent.is_none());
        self.metric.scale(q, &mut self.scaled);
        self.index.add(&self.scaled);
        self.indexed.push(self.parents.len() - 1);
        self.parents.len() - 1
    }

    /// The node nearest to `q`; `None` for a forest without nodes.
    pub fn nearest(&mut self, q: &[f64]) -> Option<usize> {
        self.metric.scale(q, &mut self.scaled);
        self.index.nearest(&self.scaled).map(|point| self.indexed[point])
    }

    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.metric.distance(a, b)
    }

    /// The nodes from `node` up to its root.
    pub fn way_to_root(&self, node: usize) -> Vec<usize> {
        std::iter::successors(Some(node), |&node| self.parents[node]).collect()
    }

    /// The edge from the node to its parent, unless it is proven already or the node is a root.
    pub fn open_edge(&self, node: usize) -> Option<usize> {
        self.parents[node].filter(|_| !self.proven[node])
    }

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
