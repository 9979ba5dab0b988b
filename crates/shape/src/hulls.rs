//! Convex hulls, inner balls and convex decompositions.

pub(crate) mod coarse_hull;
pub(crate) mod convex_hull;
pub(crate) mod convex_parts;
pub(crate) mod cut;
pub(crate) mod geodesic_sphere;
pub(crate) mod hull;
pub(crate) mod inner_balls;
pub(crate) mod quickhull;
