//! Neighbours of a configuration.

pub(crate) mod box_pages;
pub(crate) mod near_set;
pub(crate) mod nearest;
