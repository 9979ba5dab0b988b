//! Contact: closing fingers, resting objects, grasping and setting down.

pub(crate) mod closing;
pub(crate) mod contact;
pub(crate) mod contact_patch;
pub(crate) mod holding;
pub(crate) mod put_down;
pub(crate) mod resting;
pub(crate) mod resting_face;
pub(crate) mod standing;
pub(crate) mod world_clearance;
