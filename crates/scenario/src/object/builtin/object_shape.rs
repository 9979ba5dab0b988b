use cranny_shape::{Solid, TriangleSoup};

/// A mesh, and the convex bodies that it is made of.
pub(super) struct ObjectShape {
    pub mesh: TriangleSoup,
    pub parts: Vec<TriangleSoup>,
    /// The shape itself, about the origin, where it is a ball or a box.
    pub solid: Option<Solid>,
}
