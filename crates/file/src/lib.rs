#![doc = include_str!("../README.md")]

pub mod system;

mod counted;
mod excerpt;
mod fault;
mod opener;
mod spelling;
mod text;
mod told_apart;

pub use counted::counted;
pub use excerpt::{excerpt, visible};
pub use fault::{FileFault, LIFTED_BY};
pub use opener::{ARCHIVE, MESH, PROGRAM, Readable, TABLE, TEXT, are_limits_lifted, is_there, lift_limits};
pub use spelling::{did_you_mean, did_you_mean_here, nearest_files, nearest_names, suggested};
pub use text::{TextFault, json, yaml};
pub use told_apart::told_apart;
