//! Commands of depth cameras.

pub mod sense;
