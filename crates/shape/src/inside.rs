//! Inside of a mesh: checks that its surface encloses a volume, and repairs to that end.

pub(crate) mod backwards;
pub(crate) mod closed_mesh;
pub(crate) mod disjoint_sets;
pub(crate) mod edge_use;
pub(crate) mod enclosure;
pub(crate) mod fan_boxes;
pub(crate) mod mesh_repairs;
pub(crate) mod near_pairs;
pub(crate) mod patch;
pub(crate) mod repair;
pub(crate) mod same_place;
pub(crate) mod self_crossing;
pub(crate) mod shell;
pub(crate) mod shell_sides;
pub(crate) mod small_holes;
