//! Scenarios on disk: Cranny's layout, the released layout, archives; reading, checking, writing.

pub(crate) mod archive;
pub(crate) mod archive_contents;
pub(crate) mod identity;
pub(crate) mod inspection;
pub(crate) mod model_world;
pub(crate) mod open;
pub(crate) mod own;
pub(crate) mod own_bounds;
pub(crate) mod own_colours;
pub(crate) mod own_export;
pub(crate) mod own_file;
pub(crate) mod own_tasks;
pub(crate) mod recipe;
pub(crate) mod recipe_file;
pub(crate) mod released;
pub(crate) mod released_export;
pub(crate) mod released_frame;
pub(crate) mod released_grasps;
pub(crate) mod released_objects;
pub(crate) mod template;
