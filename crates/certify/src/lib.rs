#![doc = include_str!("../README.md")]

mod bound_gap;
mod certificate;
mod common_point;
mod enclosure;
mod error;
mod gap;
mod joint_curve;
mod link_bound;
mod model;
mod moment;
mod pair_tree;
mod repeats;
mod scene_text;
mod span;
mod word;

pub use certificate::{certificate, impossibility, impossible_grasps};
pub use error::CertifyError;
