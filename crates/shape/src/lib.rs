#![doc = include_str!("../README.md")]

mod bound;
mod cuboid_run;
mod distance;
mod error;
mod hulls;
mod inside;
mod loft;
mod mesh;
mod mesh_files;
mod solid;
mod surface;
mod tessellation;
mod union;
mod volume;

pub use bound::{Aabb, Ball, Bounds};
pub use cuboid_run::cuboid_of_faces;
pub use distance::ball_tree::{BallNode, BallTree};
pub use distance::closest::closest_points;
pub use distance::range::Range;
pub use distance::ray::RayHit;
pub use distance::separation::{
    Overlap, Separation, overlap, quick_lower_bound, reaches, separation, separation_in,
};
pub use distance::signed::{SignedDistance, signed_distance};
pub use error::ShapeError;
pub use hulls::coarse_hull::CoarseHull;
pub use hulls::convex_parts::{ConvexParts, DecompositionSettings, VolumeError};
pub use hulls::hull::MOST_HULL_CORNERS;
pub use hulls::inner_balls::inner_balls;
pub use inside::mesh_repairs::MeshRepairs;
pub use inside::repair::RepairedMesh;
pub use inside::same_place::VERTEX_MERGE_M;
pub use loft::Loft;
pub use mesh_files::mesh_colour::mesh_colour;
pub use mesh_files::mesh_file::TriangleSoup;
pub use mesh_files::painted_mesh::PaintedMesh;
pub use mesh_files::painted_piece::PaintedPiece;
pub use solid::{Outline, Solid};
pub use surface::Surface;
pub use union::box_union::BoxUnion;
pub use volume::area::{AreaDistribution, SurfacePoint};
pub use volume::moments::VolumeMoments;
pub use volume::pose_symmetry::{distinct_poses, equal_poses};
pub use volume::roundness::Roundness;
pub use volume::stable_pose::{StablePose, stable_poses};
pub use volume::union_moments::UnionMoments;
