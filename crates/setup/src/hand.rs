//! Hands and tools of a robot, found by their structure.

pub(crate) mod grip_place;
pub(crate) mod hand_guess;
pub(crate) mod marks;
pub(crate) mod palm;
pub(crate) mod posture;
pub(crate) mod tool_guess;
