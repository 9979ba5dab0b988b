//! Unions of many boxes or points as one solid: the cells of a map of space, and point clouds.

pub(crate) mod box_chunk;
pub(crate) mod box_order;
pub(crate) mod box_union;
pub(crate) mod free_grid;
