#![doc = include_str!("../README.md")]

pub mod system;

mod archive_names;
mod bound;
mod counted;
mod distinct;
mod excerpt;
mod fault;
mod opener;
mod spelling;
mod text;

pub use archive_names::archive_names;
pub use bound::{at_least, at_most};
pub use counted::counted;
pub use distinct::distinct;
pub use excerpt::{excerpt, visible};
pub use fault::{FileFault, LIFTED_BY};
pub use opener::{
    ARCHIVE, MESH, PROGRAM, Readable, TABLE, TEXT, accept_streams, are_limits_lifted, head, is_there,
    lift_limits,
};
pub use spelling::{did_you_mean, did_you_mean_here, nearest_files, nearest_names, suggested};
pub use text::{TextFault, json, yaml};
