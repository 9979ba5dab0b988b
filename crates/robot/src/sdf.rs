//! Reader of SDF, the format of Gazebo (sdformat specification, versions 1.4 to 1.12).

pub(crate) mod collector;
pub(crate) mod frames;
pub(crate) mod geometry;
pub(crate) mod includes;
pub(crate) mod joints;
pub(crate) mod model;
pub(crate) mod scope;
pub(crate) mod values;

pub(crate) use model::read;
