//! Depth images and point clouds.

pub mod cloud;
pub mod depth_view;
mod image;
pub mod seen;
pub mod seen_summary;
