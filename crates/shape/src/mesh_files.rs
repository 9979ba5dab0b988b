//! Mesh files and their polygons.

pub(crate) mod collada;
pub(crate) mod corner_tree;
pub(crate) mod mesh_colour;
pub(crate) mod mesh_file;
pub(crate) mod mesh_size;
pub(crate) mod msh;
pub(crate) mod obj;
pub(crate) mod painted_mesh;
pub(crate) mod painted_obj;
pub(crate) mod painted_piece;
pub(crate) mod ply;
pub(crate) mod polygon;
pub(crate) mod side_sweep;
pub(crate) mod stl;
