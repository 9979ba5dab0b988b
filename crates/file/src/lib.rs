//! What a file says: every file that is read is opened here, and YAML and JSON are read here, so that a file that
//! hurts (a pipe that never ends, gigabytes where a page is meant) is refused once for all readers, and what is
//! wrong with a text is said in one language.
//!
//! ```no_run
//! # fn main() -> std::io::Result<()> {
//! let urdf = cranny_file::TEXT.text("robot.urdf".as_ref())?;
//! # Ok(()) }
//! ```
//!
//! ## Limits
//!
//! A file is held in memory as a whole. What is looked at before a file is opened may have changed when it is read.

mod excerpt;
mod fault;
mod opener;
mod text;

pub use excerpt::{excerpt, visible};
pub use fault::{FileFault, LIFTED_BY};
pub use opener::{ARCHIVE, MESH, PROGRAM, Readable, TABLE, TEXT, are_limits_lifted, is_there, lift_limits};
pub use text::{TextFault, json, yaml};
