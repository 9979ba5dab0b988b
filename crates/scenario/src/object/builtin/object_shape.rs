use cranny_shape::{Solid, TriangleSoup};

/// Mesh, and the convex parts that it consists of.
pub(super) struct ObjectShape {
    pub mesh: TriangleSoup,
    pub parts: Vec<TriangleSoup>,
    /// Exact shape, about the origin, if it is a ball or a box.
    pub solid: Option<Solid>,
}
