//! Volume and area: moments, stable poses, symmetry.

pub(crate) mod area;
pub(crate) mod moments;
pub(crate) mod pose_symmetry;
pub(crate) mod roundness;
pub(crate) mod stable_pose;
pub(crate) mod union_moments;
