//! Loading of robots from files: URDF, SRDF, limits, meshes.

pub(crate) mod assembly;
pub(crate) mod inertial;
pub(crate) mod mesh_path;
pub(crate) mod options;
pub(crate) mod planning_limits;
pub(crate) mod rate_limits;
pub(crate) mod robot_description;
pub(crate) mod robot_files;
pub(crate) mod srdf;
pub(crate) mod text_source;
pub(crate) mod unread;
pub(crate) mod urdf;
pub(crate) mod urdf_model;
pub(crate) mod urdf_text;
pub(crate) mod visual;
pub(crate) mod xml;
