//! Checks of many configurations at once, in vector lanes whose verdicts agree with the exact check.

pub(crate) mod ball_pack;
pub(crate) mod lane_ball;
pub(crate) mod lane_bits;
pub(crate) mod lane_body;
pub(crate) mod lane_hull;
pub(crate) mod lane_links;
pub(crate) mod lane_part;
pub(crate) mod lane_scratch;
pub(crate) mod lane_solid;
#[cfg(test)]
mod lane_tests;
pub(crate) mod lane_tree;
pub(crate) mod lane_vector;
pub(crate) mod lane_world;
pub(crate) mod lanes;
pub(crate) mod single_frame;
pub(crate) mod single_lane;
