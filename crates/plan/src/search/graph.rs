//! Graphs of configurations: roadmaps, their shortest paths, trees that meet, and cells with nodes.

pub(crate) mod cell_grid;
pub(crate) mod roadmap;
pub(crate) mod shortest_path;
pub(crate) mod two_trees;
