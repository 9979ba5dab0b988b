//! Robot links with geometry, bodies of the world with their parts, and the held object.

pub(crate) mod cell_parts;
pub(crate) mod extent;
pub(crate) mod held_body;
pub(crate) mod link_balls;
pub(crate) mod link_body;
pub(crate) mod part_tree;
pub(crate) mod robot_body;
pub(crate) mod tool_bound;
pub(crate) mod world;
