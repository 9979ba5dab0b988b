use std::path::PathBuf;

/// What can be wrong with a shape or a mesh file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// A size is zero, negative, beyond [`cranny_spatial::FARTHEST_M`] or not a number.
    #[error("{what} must be a positive number of metres, at most 1000, but is {value}")]
    Size {
        /// Which size of which shape.
        what: &'static str,
        /// The offending value.
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
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices} vertices")]
    VertexIndex {
        /// Index of the triangle, from 0.
        triangle: usize,
        /// The index it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The points span no volume, so they have no convex hull.
    #[error("{points} points span no volume, so they have no convex hull (are they all in one plane?)")]
    FlatHull {
        /// How many points were given.
        points: usize,
    },
    /// A mesh that should be solid has a hole.
    #[error(
        "the mesh has a hole: {edges} of its edges belong to one triangle only, so it encloses no volume \
         (close it, or take its convex hull)"
    )]
    Open {
        /// How many edges lack their second triangle.
        edges: usize,
    },
    /// Faces of a mesh do not part its inside from what is around it.
    #[error(
        "the mesh has no inside: {faces} of its faces have the same space on both sides, or cross others that they \
         share edges with (is it one-sided? take its convex hull, or unite its bodies with Blender's boolean \
         modifier or `trimesh.boolean.union` in Python)"
    )]
    OneSided {
        /// How many faces do not.
        faces: usize,
    },
    /// A mesh crosses itself so that what is inside cannot be told.
    #[error(
        "the mesh winds backwards around ({x:.4}, {y:.4}, {z:.4}) m: a body in it crosses itself, so that its inside \
         cannot be told from its outside (mend it with Blender's boolean modifier or `trimesh.boolean.union` in \
         Python, or take its convex hull)"
    )]
    WoundBackwards {
        /// x of a point there, in metres.
        x: f64,
        /// y of it.
        y: f64,
        /// z of it.
        z: f64,
    },
    /// Triangles of a mesh pass through each other.
    #[error(
        "the mesh crosses itself: {pairs} pairs of triangles pass through each other, triangles {first} and \
         {second} by {:.3} mm near ({x:.4}, {y:.4}, {z:.4}) m (unite its bodies into one \
         surface with Blender's boolean modifier or `trimesh.boolean.union` in Python)",
        depth_m * 1000.0
    )]
    SelfCrossing {
        /// How many pairs of triangles do.
        pairs: usize,
        /// Index of one of the two that do so most deeply.
        first: usize,
        /// Index of the other.
        second: usize,
        /// How deeply, in metres.
        depth_m: f64,
        /// x of a corner there, in metres.
        x: f64,
        /// y of it.
        y: f64,
        /// z of it.
        z: f64,
    },
    /// A mesh encloses no volume, or a negative one.
    #[error("the mesh encloses no volume ({volume_m3:.3e} m³; do its faces look inwards?)")]
    NoVolume {
        /// What it encloses, in cubic metres.
        volume_m3: f64,
    },
    /// A centre of mass lies outside the body.
    #[error("the centre of mass ({x}, {y}, {z}) m lies outside the convex hull, so nothing could rest")]
    CenterOutside {
        /// x in metres.
        x: f64,
        /// y in metres.
        y: f64,
        /// z in metres.
        z: f64,
    },
    /// Rings do not make a body.
    #[error(
        "{rings} rings, the first of {points} points, make no body: it takes two rings of the same three points or more"
    )]
    Rings {
        /// How many rings there are.
        rings: usize,
        /// How many points the first one has.
        points: usize,
    },
    /// A mesh is scaled by zero, or by something that is not a number.
    #[error("a mesh cannot be scaled by ({x}, {y}, {z}): each factor must be a number other than zero")]
    Scale {
        /// The factor of x.
        x: f64,
        /// The factor of y.
        y: f64,
        /// The factor of z.
        z: f64,
    },
    /// There are more triangles than are worked with.
    #[error(
        "the mesh has {triangles} triangles, more than {most} (reduce it, with Blender's decimate modifier or \
         `simplify_quadric_decimation` of trimesh in Python)"
    )]
    TooManyTriangles {
        /// How many there are.
        triangles: usize,
        /// How many there may be.
        most: usize,
    },
    /// There is no triangle.
    #[error("the mesh has no triangles (is it a mesh at all?)")]
    Empty,
    /// The file cannot be read.
    #[error("{path}: cannot read the mesh: {source}", path = path.display())]
    Read {
        /// The mesh file.
        path: PathBuf,
        /// What the system or the parser says; a parser names the line.
        source: std::io::Error,
    },
    /// The file's ending names no format that is read here.
    #[error("{path}: the ending '{extension}' names no mesh format (known: obj, stl, dae, ply)", path = path.display())]
    Format {
        /// The mesh file.
        path: PathBuf,
        /// Its ending.
        extension: String,
    },
    /// The file was read, but what it holds is no mesh.
    #[error("{path}: {source}", path = path.display())]
    Content {
        /// The mesh file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<ShapeError>,
    },
}

impl ShapeError {
    /// The same fault, said of the file it was found in.
    #[must_use]
    pub fn in_file(self, path: &std::path::Path) -> Self {
        match self {
            Self::Read { .. } | Self::Format { .. } | Self::Content { .. } => self,
            fault => Self::Content { path: path.to_owned(), source: Box::new(fault) },
        }
    }
}

/// A size, if it is one.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, ShapeError> {
    if value > 0.0 && value <= cranny_spatial::FARTHEST_M {
        Ok(value)
    } else {
        Err(ShapeError::Size { what, value })
    }
}

/// Refuses factors of a mesh of which one is zero or no finite number.
pub(crate) fn check_scale(scale: &cranny_spatial::Vector) -> Result<(), ShapeError> {
    if scale.iter().all(|factor| factor.is_finite() && *factor != 0.0) {
        Ok(())
    } else {
        Err(ShapeError::Scale { x: scale.x, y: scale.y, z: scale.z })
    }
}

/// A vertex, if all its coordinates are usable.
pub(crate) fn usable(vertex: usize, p: &cranny_spatial::Point) -> Result<(), ShapeError> {
    if p.iter().all(|x| x.abs() <= cranny_spatial::FARTHEST_M) {
        Ok(())
    } else {
        Err(ShapeError::NotFinite { vertex, x: p.x, y: p.y, z: p.z })
    }
}
