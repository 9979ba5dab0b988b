use std::path::PathBuf;

/// Error of a shape or a mesh file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// A size is zero, negative, beyond [`cranny_spatial::FARTHEST_M`] or not a number.
    #[error("{what} must be a positive number of metres, at most 1000, but is {value}")]
    Size {
        /// Name of the size and its shape.
        what: &'static str,
        /// The offending value, in metres.
        value: f64,
    },
    /// A vertex has a coordinate beyond [`cranny_spatial::FARTHEST_M`], or that is not a number.
    #[error("vertex {vertex} has a coordinate that is no number of metres within ±1000: ({x}, {y}, {z})")]
    NotFinite {
        /// Index of the vertex, from 0.
        vertex: usize,
        /// x in metres.
        x: f64,
        /// y in metres.
        y: f64,
        /// z in metres.
        z: f64,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices} vertices")]
    VertexIndex {
        /// Index of the triangle, from 0.
        triangle: usize,
        /// Index that it refers to.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// The points span no volume, so they have no convex hull.
    #[error("{points} points span no volume, so they have no convex hull (are they all in one plane?)")]
    FlatHull {
        /// Number of points given.
        points: usize,
    },
    /// A mesh that should be solid has a hole.
    #[error(
        "the mesh has a hole: {edges} of its edges belong to one triangle only (equal triangles count once), so it \
         encloses no volume (close it, or take its convex hull)"
    )]
    Open {
        /// Number of edges that lack their second triangle.
        edges: usize,
    },
    /// Faces of a mesh do not separate its inside from the space around it.
    #[error(
        "the mesh has no inside: {faces} of its faces have the same space on both sides, or cross others that they \
         share edges with (is it one-sided? take its convex hull, or unite its bodies with Blender's boolean \
         modifier or `trimesh.boolean.union` in Python)"
    )]
    OneSided {
        /// Number of such faces.
        faces: usize,
    },
    /// A mesh crosses itself so that its inside is undefined.
    #[error(
        "the mesh winds backwards around ({x:.4}, {y:.4}, {z:.4}) m: a body in it crosses itself, so that its inside \
         cannot be told from its outside (mend it with Blender's boolean modifier or `trimesh.boolean.union` in \
         Python, or take its convex hull)"
    )]
    WoundBackwards {
        /// x of a point there, in metres.
        x: f64,
        /// y of that point, in metres.
        y: f64,
        /// z of that point, in metres.
        z: f64,
    },
    /// Triangles of a mesh pass through each other.
    #[error(
        "the mesh crosses itself: at least {pairs} pairs of triangles pass through each other, triangles {first} and \
         {second} by {:.3} mm near ({x:.4}, {y:.4}, {z:.4}) m (unite its bodies into one \
         surface with Blender's boolean modifier or `trimesh.boolean.union` in Python)",
        depth_m * 1000.0
    )]
    SelfCrossing {
        /// Number of crossing pairs of triangles that were found before the mesh was refused.
        pairs: usize,
        /// Index of one triangle of the deepest of these pairs.
        first: usize,
        /// Index of the other triangle.
        second: usize,
        /// Depth of the deepest crossing, in metres.
        depth_m: f64,
        /// x of a corner of the first triangle, in metres.
        x: f64,
        /// y of that corner, in metres.
        y: f64,
        /// z of that corner, in metres.
        z: f64,
    },
    /// The triangles of a mesh are so long and narrow that the search for crossing ones would compare nearly all pairs.
    #[error(
        "the boxes of its {triangles} triangles overlap in more than {most} pairs, too many to compare: they are long \
         and narrow (divide them by Blender's remesh modifier or `subdivide_to_size` of trimesh in Python, or take \
         fewer)"
    )]
    NarrowTriangles {
        /// Number of triangles.
        triangles: usize,
        /// Maximum number of pairs with overlapping boxes.
        most: usize,
    },
    /// Closed surfaces of a mesh contain each other, like the layers of an onion, in more layers than are compared.
    #[error(
        "{bodies} bodies of the mesh surround another one, but at most {most} may (leave out the inner ones)"
    )]
    NestedBodies {
        /// Number of closed surfaces around one.
        bodies: usize,
        /// Maximum number.
        most: usize,
    },
    /// The closed surfaces of a mesh are so many and so close that the search for those inside others would compare nearly all.
    #[error(
        "its {bodies} bodies are too many to find out which lie inside others: it takes more than {most} comparisons of \
         their triangles (unite those that touch with Blender's boolean modifier or `trimesh.boolean.union` in Python, \
         or leave out inner ones)"
    )]
    ManyBodies {
        /// Number of closed surfaces.
        bodies: usize,
        /// Maximum number of comparisons.
        most: usize,
    },
    /// A mesh encloses no volume, or a negative one.
    #[error("the mesh encloses no volume ({volume_m3:.3e} m³; do its faces look inwards?)")]
    NoVolume {
        /// Enclosed volume, in cubic metres.
        volume_m3: f64,
    },
    /// A centre of mass lies outside the convex hull.
    #[error("the centre of mass ({x}, {y}, {z}) m lies outside the convex hull, so nothing could rest")]
    CenterOutside {
        /// x in metres.
        x: f64,
        /// y in metres.
        y: f64,
        /// z in metres.
        z: f64,
    },
    /// Rings do not form a loft.
    #[error(
        "{rings} rings, the first of {points} points, make no body: it takes two rings of the same three points or more"
    )]
    Rings {
        /// Number of rings.
        rings: usize,
        /// Number of points of the first ring.
        points: usize,
    },
    /// A mesh is scaled by zero, or by a value that is not finite.
    #[error("a mesh cannot be scaled by ({x}, {y}, {z}): each factor must be a number other than zero")]
    Scale {
        /// The factor of x.
        x: f64,
        /// The factor of y.
        y: f64,
        /// The factor of z.
        z: f64,
    },
    /// A cloud, or a map of cells, where a mesh is wanted.
    #[error("a cloud of points, or a map of cells, cannot be written as a mesh")]
    NoMesh,
    /// A cloud has no points, or a union no boxes.
    #[error("a cloud needs at least one point (were all of them cut away or invalid?)")]
    NoPoints,
    /// A mesh has no triangles.
    #[error("the mesh has no triangles (is it a mesh at all?)")]
    Empty,
    /// A file cannot be read.
    #[error("{path}: cannot read the mesh: {source}", path = path.display())]
    Read {
        /// Path of the mesh file.
        path: PathBuf,
        /// Error of the system or of the parser; a parser names the line.
        source: std::io::Error,
    },
    /// The extension of a file names no supported mesh format.
    #[error("{path}: the ending '{extension}' names no mesh format (known: obj, stl, dae, ply, msh)", path = path.display())]
    Format {
        /// Path of the mesh file.
        path: PathBuf,
        /// Extension of the file.
        extension: String,
    },
    /// A file was read, but contains no valid mesh.
    #[error("{path}: {source}", path = path.display())]
    Content {
        /// Path of the mesh file.
        path: PathBuf,
        /// Fault of the mesh.
        source: Box<ShapeError>,
    },
}

impl ShapeError {
    /// Returns the error with the path of the file that caused it.
    #[must_use]
    pub fn in_file(self, path: &std::path::Path) -> Self {
        match self {
            Self::Read { .. } | Self::Format { .. } | Self::Content { .. } => self,
            fault => Self::Content { path: path.to_owned(), source: Box::new(fault) },
        }
    }
}

/// Checks that a size is positive and within bounds, in metres.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, ShapeError> {
    if value > 0.0 && value <= cranny_spatial::FARTHEST_M {
        Ok(value)
    } else {
        Err(ShapeError::Size { what, value })
    }
}

/// Rejects scale factors of a mesh if one of them is zero or not finite.
pub(crate) fn check_scale(scale: &cranny_spatial::Vector) -> Result<(), ShapeError> {
    if scale.iter().all(|factor| factor.is_finite() && *factor != 0.0) {
        Ok(())
    } else {
        Err(ShapeError::Scale { x: scale.x, y: scale.y, z: scale.z })
    }
}

pub(crate) fn usable(vertex: usize, p: &cranny_spatial::Point) -> Result<(), ShapeError> {
    if p.iter().all(|x| x.abs() <= cranny_spatial::FARTHEST_M) {
        Ok(())
    } else {
        Err(ShapeError::NotFinite { vertex, x: p.x, y: p.y, z: p.z })
    }
}
