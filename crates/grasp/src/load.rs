//! Load of a grasp: the factor by which loads may grow before the pads slip.

pub(crate) mod between;
pub(crate) mod limit_surface;
pub(crate) mod load_state;
#[cfg(test)]
mod load_tests;
pub(crate) mod measure;
pub(crate) mod pads;
pub(crate) mod patch;
pub(crate) mod seat;
pub(crate) mod shake_test;
