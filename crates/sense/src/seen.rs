//! Map of the space that cameras have seen to be free.

pub(crate) mod cell_merge;
pub(crate) mod depth_table;
pub(crate) mod known_solids;
pub(crate) mod occupancy_grid;
pub(crate) mod pixel_window;
pub(crate) mod seen_map;
pub(crate) mod sight;
