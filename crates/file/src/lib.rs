#![doc = include_str!("../README.md")]

pub mod system;

mod archive_names;
mod bound;
mod counted;
mod distinct;
mod excerpt;
mod fault;
mod npy;
mod opener;
mod shell_word;
mod spelling;
mod text;
mod xml_excess;

pub use archive_names::archive_names;
pub use bound::{at_least, at_most};
pub use counted::counted;
pub use distinct::distinct;
pub use excerpt::{excerpt, visible, visible_line};
pub use fault::{FileFault, LIFTED_BY};
pub use npy::{NpyArray, npy_header};
pub use opener::{
    ARCHIVE, MESH, PROGRAM, Readable, TABLE, TEXT, accept_streams, are_limits_lifted, head, is_there,
    lift_limits,
};
pub use shell_word::{shell_file, shell_word};
pub use spelling::{did_you_mean, did_you_mean_here, nearest_files, nearest_names, suggested};
pub use text::{TextFault, json, yaml};
pub use xml_excess::{XmlExcess, xml_excess};
