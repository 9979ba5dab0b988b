//! Solids and triangle meshes: how far apart they are, how deep they overlap, what bounds them, and how
//! they are read from mesh files.
//!
//! A [`Solid`] is full: something wholly inside it touches it. A [`Surface`] is only its triangles, as in
//! the released `paper` check. Distances come with a certificate: [`Separation::lower_m`] is never above
//! the true distance, whatever the iteration behind it did, because it is read off a separating plane.
//!
//! The narrow phase is `parry3d-f64`'s GJK and EPA; this crate alone names that library.
//!
//! ## Limits
//! No point clouds, no height fields, no signed distance fields. Volumes and inertia of objects are not
//! here yet.

mod ball_tree;
mod bound;
mod convex;
mod cuboid_run;
mod error;
mod inner_balls;
mod mesh;
mod mesh_file;
mod parry;
mod separation;
mod solid;
mod surface;

pub use ball_tree::{BallNode, BallTree};
pub use bound::{Aabb, Ball, Bounds};
pub use cuboid_run::cuboid_of_faces;
pub use error::ShapeError;
pub use inner_balls::inner_balls;
pub use mesh_file::TriangleSoup;
pub use separation::{Overlap, Separation, overlap, quick_lower_bound, separation};
pub use solid::{Outline, Solid};
pub use surface::Surface;
