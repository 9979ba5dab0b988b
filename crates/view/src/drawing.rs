//! Rendering of a scene to pictures and picture files.

pub(crate) mod camera;
pub(crate) mod contact_sheet;
pub(crate) mod draw_list;
pub(crate) mod film_file;
pub(crate) mod framing;
pub(crate) mod ground;
pub(crate) mod light;
pub(crate) mod painter;
pub(crate) mod picture;
pub(crate) mod picture_file;
pub(crate) mod sample_buffer;
pub(crate) mod scan;
