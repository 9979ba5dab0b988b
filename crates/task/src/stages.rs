//! Tasks: stages, the segments of their paths, and the states between.

pub(crate) mod corner;
pub(crate) mod payload;
pub(crate) mod pose_bounds;
pub(crate) mod region;
pub(crate) mod region_row;
pub(crate) mod segment;
pub(crate) mod speed_limits;
pub(crate) mod stage;
pub(crate) mod stage_segments;
pub(crate) mod state;
pub(crate) mod straight;
