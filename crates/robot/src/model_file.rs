//! Models in other formats than URDF, converted to URDF.

pub(crate) mod body_tree;
pub(crate) mod contact_pairs;
pub(crate) mod hull_points;
pub(crate) mod model_text;
pub(crate) mod orientation;
pub(crate) mod unread_list;
pub(crate) mod urdf_writer;
pub(crate) mod world_links;
