//! Meshes and colours of robots and objects.

pub(crate) mod colour;
pub(crate) mod melted_body;
pub(crate) mod mesh;
pub(crate) mod paint;
pub(crate) mod robot_look;
pub(crate) mod rounded;
pub(crate) mod seen_look;
pub(crate) mod stroke;
