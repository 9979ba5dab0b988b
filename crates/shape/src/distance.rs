//! Distances, rays and the trees that accelerate them.

pub(crate) mod ball_tree;
pub(crate) mod closest;
pub(crate) mod convex;
pub(crate) mod gjk;
pub(crate) mod parry;
pub(crate) mod range;
pub(crate) mod ray;
pub(crate) mod separation;
pub(crate) mod signed;
pub(crate) mod triangle_tree;
