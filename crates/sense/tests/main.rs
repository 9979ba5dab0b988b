//! Tests of depth images, point clouds and their files.

mod clouds;
mod known_bodies;
mod measuring;
mod rendering;
mod seen;
mod view_files;
