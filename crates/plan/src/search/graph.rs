//! Graphs of configurations: roadmaps, their shortest paths, and trees that meet.

pub(crate) mod roadmap;
pub(crate) mod shortest_path;
pub(crate) mod two_trees;
