//! Files of cameras, views and depth images.

mod camera_entry;
pub(crate) mod camera_file;
pub(crate) mod camera_frame;
pub(crate) mod depth_format;
mod depth_reading;
pub(crate) mod views;
