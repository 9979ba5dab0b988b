//! The inside of a mesh: whether its surface encloses a volume, and what is mended so that it does.

pub(crate) mod backwards;
pub(crate) mod closed_mesh;
pub(crate) mod disjoint_sets;
pub(crate) mod edge_use;
pub(crate) mod enclosure;
pub(crate) mod mesh_repairs;
pub(crate) mod patch;
pub(crate) mod repair;
pub(crate) mod same_place;
pub(crate) mod self_crossing;
pub(crate) mod shell;
pub(crate) mod small_holes;
pub(crate) mod walls;
