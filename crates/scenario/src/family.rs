//! Families of environments with a difficulty parameter, and large random sets of them.

pub(crate) mod error;
pub(crate) mod kind;
pub(crate) mod maker;
pub(crate) mod resized;
pub(crate) mod scene_scale;
pub(crate) mod set;
pub(crate) mod set_file;
pub(crate) mod unfinished_set;
