use std::sync::Arc;

use cranny_plan::Observer;
use cranny_robot::{LinkFrames, Robot};
use serde::Serialize;

use crate::viewer::number_row;

/// Observer that records the position of the gripper frame at each node of the search trees, in the order of insertion.
///
/// A second root of the start tree clears all trees: planners that try goals in turn number the nodes of each attempt from 0.
#[derive(Clone, Debug)]
pub struct TreeRecording {
    robot: Arc<Robot>,
    frames: LinkFrames,
    positions: Vec<[f32; 3]>,
    parents: Vec<u32>,
    trees: Vec<u32>,
    /// Row index of each node, per tree.
    places: Vec<Vec<u32>>,
    most: usize,
    left_out: usize,
}

impl TreeRecording {
    /// Default maximum number of nodes kept, the first ones: the limit of one draw call and of the memory of a page.
    pub const MOST_NODES: usize = 200_000;

    /// Creates a recorder for searches with this robot that keeps at most `most` nodes.
    pub fn new(robot: Arc<Robot>, most: usize) -> Self {
        Self {
            frames: robot.frames(),
            robot,
            positions: Vec::new(),
            parents: Vec::new(),
            trees: Vec::new(),
            places: Vec::new(),
            most,
            left_out: 0,
        }
    }

    /// Number of nodes kept.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns true if no node is kept.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Number of nodes that were added after the last one kept.
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    pub(crate) fn rows(&self) -> SearchTreeRows {
        self.rows_after(0)
    }

    /// Returns the rows of all nodes but the first `nodes`.
    pub(crate) fn rows_after(&self, nodes: usize) -> SearchTreeRows {
        let nodes = nodes.min(self.len());
        SearchTreeRows {
            positions: number_row::floats32(self.positions[nodes..].iter().copied().flatten()),
            parents: number_row::unsigned32(self.parents[nodes..].iter().copied()),
            trees: number_row::unsigned32(self.trees[nodes..].iter().copied()),
        }
    }
}

impl Observer for TreeRecording {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        if self.positions.len() >= self.most {
            self.left_out += 1;
            return;
        }
        if self.places.len() <= tree {
            self.places.resize(tree + 1, Vec::new());
        }
        if tree == 0 && parent.is_none() {
            self.places.iter_mut().for_each(Vec::clear);
        }
        let place = number_row::index(self.positions.len());
        let known = parent.and_then(|parent| self.places[tree].get(parent).copied());
        self.places[tree].push(place);
        self.parents.push(known.unwrap_or(place));
        self.trees.push(number_row::index(tree));
        self.robot.tip_kinematics(q, &mut self.frames);
        let tip = self.frames.link(self.robot.tip()).translation.vector;
        self.positions.push([tip.x, tip.y, tip.z].map(number_row::single));
    }
}

/// Search trees in the encoding of the page.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SearchTreeRows {
    positions: String,
    parents: String,
    trees: String,
}
