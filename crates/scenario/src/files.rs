//! File access: reading with a location for each fault, and atomic writing.

pub(crate) mod atomic_file;
pub(crate) mod mesh_solids;
pub(crate) mod number_table;
pub(crate) mod sizes;
pub(crate) mod staging_folder;
pub(crate) mod temporary;
pub(crate) mod yaml;
