use cranny_shape::TriangleSoup;

/// A mesh, and the convex bodies that it is made of.
pub(super) struct ObjectShape {
    pub mesh: TriangleSoup,
    pub parts: Vec<TriangleSoup>,
}
