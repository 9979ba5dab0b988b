//! Solids and triangle meshes: how far apart they are, how deep they overlap, what bounds them, what a ray
//! meets, what they weigh and how they come to rest, and how they are read from mesh files.
//!
//! A [`Solid`] is full: something wholly inside it touches it. A [`Surface`] is only its triangles, as in
//! the released `paper` check. Distances come with a certificate: [`Separation::lower_m`] is never above
//! the true distance, whatever the iteration behind it did, because it is read off a separating plane.
//!
//! Hulls, depths of overlap and convex decomposition are `parry3d-f64`'s; this crate alone names that library.
//!
//! ## Limits
//! No point clouds, no height fields, no signed distance fields. Density is uniform. Meshes with holes have
//! no volume here, and nothing fills the holes. A body that crosses itself is full where it winds around; one that
//! winds backwards somewhere is refused, if the part is wider than a sixteenth of the body.

mod area;
mod backwards;
mod ball_tree;
mod bound;
mod closest;
mod coarse_hull;
mod collada;
mod convex;
mod convex_hull;
mod convex_parts;
mod cuboid_run;
mod cut;
mod disjoint_sets;
mod enclosure;
mod error;
mod geodesic_sphere;
mod gjk;
mod hull;
mod inner_balls;
mod loft;
mod mesh;
mod mesh_file;
mod moments;
mod painted_mesh;
mod parry;
mod patch;
mod ply;
mod pose_symmetry;
mod ray;
mod repair;
mod self_crossing;
mod separation;
mod shell;
mod solid;
mod stable_pose;
mod stl;
mod surface;
mod tessellation;
mod walls;

pub use area::{AreaDistribution, SurfacePoint};
pub use ball_tree::{BallNode, BallTree};
pub use bound::{Aabb, Ball, Bounds};
pub use closest::closest_points;
pub use coarse_hull::CoarseHull;
pub use convex_parts::{ConvexParts, DecompositionSettings, VolumeError};
pub use cuboid_run::cuboid_of_faces;
pub use error::ShapeError;
pub use hull::MOST_HULL_CORNERS;
pub use inner_balls::inner_balls;
pub use loft::Loft;
pub use mesh_file::TriangleSoup;
pub use moments::VolumeMoments;
pub use painted_mesh::{PaintedMesh, PaintedPiece};
pub use pose_symmetry::{distinct_poses, equal_poses};
pub use ray::RayHit;
pub use repair::{MeshRepairs, RepairedMesh, SAME_PLACE_M};
pub use separation::{Overlap, Separation, overlap, quick_lower_bound, reaches, separation};
pub use solid::{Outline, Solid};
pub use stable_pose::{StablePose, stable_poses};
pub use surface::Surface;
