use crate::NearestNeighbours;

/// A tree of configurations that grows from a root.
#[derive(Clone, Debug)]
pub(crate) struct SearchTree {
    dof: usize,
    configurations: Vec<f64>,
    parents: Vec<usize>,
    index: NearestNeighbours,
}

impl SearchTree {
    pub fn new(root: &[f64]) -> Self {
        let mut tree = Self {
            dof: root.len(),
            configurations: Vec::new(),
            parents: Vec::new(),
            index: NearestNeighbours::new(root.len()),
        };
        tree.add(root, 0);
        tree
    }

    pub fn len(&self) -> usize {
        self.parents.len()
    }

    pub fn q(&self, node: usize) -> &[f64] {
        &self.configurations[node * self.dof..(node + 1) * self.dof]
    }

    pub fn add(&mut self, q: &[f64], parent: usize) -> usize {
        self.configurations.extend_from_slice(q);
        self.parents.push(parent);
        self.index.add(q)
    }

    pub fn nearest(&mut self, q: &[f64]) -> usize {
        self.index.nearest(q).unwrap_or(0)
    }

    /// The configurations from the root to `node`.
    pub fn path_to(&self, node: usize) -> Vec<Vec<f64>> {
        let mut path = vec![self.q(node).to_vec()];
        let mut at = node;
        while at != 0 {
            at = self.parents[at];
            path.push(self.q(at).to_vec());
        }
        path.reverse();
        path
    }
}
