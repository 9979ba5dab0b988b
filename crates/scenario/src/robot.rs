//! Robots and hands: built in, from files, and as scenario files modify them.

pub(crate) mod builtin;
pub(crate) mod file;
pub(crate) mod gripper_file;
pub(crate) mod hand;
pub(crate) mod in_folder;
pub(crate) mod opening;
pub(crate) mod short_arm;
pub(crate) mod source;
