//! Objects to be grasped: built in, from a mesh, from a folder; and their mass properties.

pub(crate) mod builtin;
pub(crate) mod error;
pub(crate) mod filter;
pub(crate) mod folder;
pub(crate) mod friction;
pub(crate) mod mesh_repairs;
pub(crate) mod object_type;
pub(crate) mod physics;
pub(crate) mod source;
pub(crate) mod target;
