//! Point clouds and their files.

mod ascii_rows;
mod back_projection;
mod cloud_file;
mod collector;
mod lzf;
pub(crate) mod message;
mod npy;
mod number;
mod pcd;
mod pcd_header;
mod ply;
pub(crate) mod point_cloud;
pub(crate) mod read_cloud;
mod row;
pub(crate) mod surface_samples;
