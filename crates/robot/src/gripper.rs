//! Hands and tools: their fingers, and the objects they hold.

pub(crate) mod hand;
pub(crate) mod hand_description;
pub(crate) mod hand_joint;
pub(crate) mod holding;
pub(crate) mod loose_links;
pub(crate) mod open_hands;
pub(crate) mod pad_distance;
pub(crate) mod tool_description;
