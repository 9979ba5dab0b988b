use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_file::TextFault;
use cranny_robot::Robot;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::PlanError;
use crate::neighbours::near_set::NearSet;
use crate::search::graph::shortest_path::shortest_path;
use crate::search::growth::Grower;
use crate::search::search_state::Search;

/// Graph of configurations, kept in a file for any number of queries (multi-query).
///
/// Edges from a file are not trusted: those of a path are proven, and edges without a proof are removed. A roadmap of another
/// world, or of one that has changed, costs time but never correctness.
#[derive(Clone, Debug)]
pub struct Roadmap {
    joints: Vec<String>,
    nodes: Vec<Vec<f64>>,
    near: NearSet,
    /// Neighbours of each node.
    neighbours: Vec<Vec<Neighbour>>,
    /// Representative of each node in the union-find forest of connected components.
    components: Vec<usize>,
    /// True if edges were removed since the components were determined.
    is_cut: bool,
}

#[derive(Clone, Copy, Debug)]
struct Neighbour {
    node: usize,
    is_proven: bool,
}

/// File of a roadmap, read together with the setting that names it.
#[derive(Clone, Debug)]
pub struct RoadmapFile {
    path: PathBuf,
    content: Arc<Content>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    format: String,
    joints: Vec<String>,
    nodes: Vec<Vec<f64>>,
    edges: Vec<[usize; 2]>,
}

impl RoadmapFile {
    /// Reads a [`Roadmap`] that was serialised as JSON.
    ///
    /// # Errors
    /// [`PlanError::Roadmap`] for a file that cannot be read or is not a roadmap.
    pub fn read(path: &Path) -> Result<Self, PlanError> {
        let fault = |problem: String| PlanError::Roadmap { path: path.to_owned(), problem };
        let text = cranny_file::TEXT.text(path).map_err(|reason| fault(reason.to_string()))?;
        let content = cranny_file::json(text.as_bytes())
            .map_err(|TextFault { line, problem }| fault(format!("line {line}: {problem}")))?;
        Ok(Self { path: path.to_owned(), content: Arc::new(content) })
    }
}

impl PartialEq for RoadmapFile {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path
    }
}

impl Serialize for RoadmapFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.path.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for RoadmapFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::read(&PathBuf::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// Format identifier at the beginning of a roadmap file.
const FORMAT: &str = "cranny-roadmap/1";

impl Roadmap {
    /// Creates a roadmap without nodes.
    pub fn new(robot: &Robot) -> Self {
        Self {
            joints: robot.joint_names().to_vec(),
            nodes: Vec::new(),
            near: NearSet::new(robot.dof()),
            neighbours: Vec::new(),
            components: Vec::new(),
            is_cut: false,
        }
    }

    /// Creates the roadmap of a file, which must be for the same robot.
    ///
    /// # Errors
    /// [`PlanError::Roadmap`] for a roadmap of another robot.
    pub fn of_file(file: &RoadmapFile, robot: &Robot) -> Result<Self, PlanError> {
        let fault = |problem: String| PlanError::Roadmap { path: file.path.clone(), problem };
        let file = &file.content;
        if file.format != FORMAT {
            return Err(fault(format!("its format is '{}', but must be '{FORMAT}'", file.format)));
        }
        if file.joints != robot.joint_names() {
            let [theirs, ours] = [&file.joints[..], robot.joint_names()].map(|names| names.join(", "));
            return Err(fault(format!("it is of a robot with the joints {theirs}; this one has {ours}")));
        }
        let mut roadmap = Self::new(robot);
        for (index, q) in file.nodes.iter().enumerate() {
            if q.len() != robot.dof() || !robot.within_limits(q) {
                return Err(fault(format!("node {index} is no configuration within the joint limits")));
            }
            roadmap.add(q);
        }
        for &[a, b] in &file.edges {
            if a == b || a.max(b) >= roadmap.len() {
                return Err(fault(format!(
                    "the edge from node {a} to {b} is not valid: both nodes must exist and differ"
                )));
            }
            roadmap.join(a, b, false);
        }
        Ok(roadmap)
    }

    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Returns true if there is no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Returns the number of edges.
    pub fn edges(&self) -> usize {
        self.neighbours.iter().map(Vec::len).sum::<usize>() / 2
    }

    pub(crate) fn q(&self, node: usize) -> &[f64] {
        &self.nodes[node]
    }

    pub(crate) fn add(&mut self, q: &[f64]) -> usize {
        self.nodes.push(q.to_vec());
        self.neighbours.push(Vec::new());
        self.components.push(self.components.len());
        self.near.add(q)
    }

    /// Returns the nodes nearest to `q`, the nearest first.
    pub(crate) fn nearest(&self, q: &[f64], k: usize) -> Vec<usize> {
        self.near.nearest(q, k)
    }

    pub(crate) fn join(&mut self, a: usize, b: usize, is_proven: bool) {
        for (a, b) in [(a, b), (b, a)] {
            self.neighbours[a].push(Neighbour { node: b, is_proven });
        }
        let (a, b) = (self.component(a), self.component(b));
        self.components[a.max(b)] = a.min(b);
    }

    /// Returns true if a path connects two nodes.
    pub(crate) fn are_connected(&mut self, a: usize, b: usize) -> bool {
        if std::mem::take(&mut self.is_cut) {
            self.find_components();
        }
        self.component(a) == self.component(b)
    }

    fn component(&mut self, node: usize) -> usize {
        let mut root = node;
        while self.components[root] != root {
            // Each node on the path skips one: the next search is half as long.
            self.components[root] = self.components[self.components[root]];
            root = self.components[root];
        }
        self.components[node] = root;
        root
    }

    /// Returns the nodes of the shortest path (L2) from a node to any of `goals`.
    pub(crate) fn shortest_way(&self, from: usize, goals: &[usize]) -> Option<Vec<usize>> {
        let beside = |node: usize| self.neighbours[node].iter().map(|next| next.node);
        shortest_path(&self.nodes, beside, from, goals)
    }

    pub(crate) fn are_joined(&self, a: usize, b: usize) -> bool {
        self.neighbours[a].iter().any(|next| next.node == b)
    }

    pub(crate) fn is_proven(&self, a: usize, b: usize) -> bool {
        self.neighbours[a].iter().any(|next| next.node == b && next.is_proven)
    }

    pub(crate) fn set_proven(&mut self, a: usize, b: usize) {
        for (a, b) in [(a, b), (b, a)] {
            let all = self.neighbours[a].iter_mut().filter(|next| next.node == b);
            all.for_each(|next| next.is_proven = true);
        }
    }

    pub(crate) fn cut(&mut self, a: usize, b: usize) {
        for (a, b) in [(a, b), (b, a)] {
            self.neighbours[a].retain(|next| next.node != b);
        }
        self.is_cut = true;
    }

    /// Removes all edges of a node, and keeps it from being the nearest to any other.
    pub(crate) fn isolate(&mut self, node: usize) {
        for next in std::mem::take(&mut self.neighbours[node]) {
            self.neighbours[next.node].retain(|back| back.node != node);
        }
        self.near.remove(node);
        self.is_cut = true;
    }

    /// Proves the edges of a path; returns the first one without a proof, after it was removed.
    pub(crate) fn refuted_edge(
        &mut self,
        way: &[usize],
        grower: &mut Grower,
        search: &mut Search,
    ) -> Option<[usize; 2]> {
        for edge in way.windows(2) {
            let (a, b) = (edge[0], edge[1]);
            if self.is_proven(a, b) {
                continue;
            }
            if !grower.edge(self.q(a), self.q(b), search) {
                self.cut(a, b);
                return Some([a, b]);
            }
            self.set_proven(a, b);
        }
        None
    }

    fn find_components(&mut self) {
        self.components = (0..self.len()).collect();
        for node in 0..self.len() {
            for index in 0..self.neighbours[node].len() {
                let (a, b) = (self.component(node), self.component(self.neighbours[node][index].node));
                self.components[a.max(b)] = a.min(b);
            }
        }
    }
}

impl Serialize for Roadmap {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let later = |node: usize| self.neighbours[node].iter().map(|n| n.node).filter(move |n| *n > node);
        let edges = (0..self.nodes.len()).flat_map(|node| later(node).map(move |other| [node, other]));
        let content = Content {
            format: FORMAT.to_owned(),
            joints: self.joints.clone(),
            nodes: self.nodes.clone(),
            edges: edges.collect(),
        };
        content.serialize(serializer)
    }
}
