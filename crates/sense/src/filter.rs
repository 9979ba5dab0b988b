//! Filters of point clouds.

mod crop;
pub(crate) mod near_solids;
mod voxel;
