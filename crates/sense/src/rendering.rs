//! Exact depth images of solids.

pub(crate) mod interval;
pub(crate) mod pixel_range;
pub(crate) mod render;
pub(crate) mod surface;
