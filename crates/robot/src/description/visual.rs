use std::path::PathBuf;

use cranny_spatial::{Point, Pose, Vector};

/// Visual geometry of a link: a `<visual>` of the URDF, which collision tests ignore.
///
/// Two attributes of `<visual>` are an extension to URDF. `rounding` rounds the edges of a cuboid or cylinder inwards. `blend`
/// joins all primitives of the link that have it and the same colour by fillets, so that they appear as one casting.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkVisual {
    /// Pose of the visual in the link frame.
    pub link_from_visual: Pose,
    /// Shape, in its own frame.
    pub form: LinkForm,
    /// Red, green, blue and opacity of its material, 0 to 1, sRGB; `None` if it has no material or one without a colour.
    pub colour: Option<[f64; 4]>,
    /// Radius of its edges, in metres; 0 for sharp ones.
    pub rounding_m: f64,
    /// Width of the fillet to the primitives it is blended with, in metres; 0 for none.
    pub blend_m: f64,
}

/// Shape of a `<visual>` or a `<collision>`; lengths in metres, all greater than zero. The axis of a cylinder or capsule is z.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkForm {
    /// A cuboid.
    Cuboid {
        /// Edge lengths, in metres.
        size: Vector,
    },
    /// A sphere.
    Sphere {
        /// Radius, in metres.
        radius_m: f64,
    },
    /// A cylinder.
    Cylinder {
        /// Length, in metres.
        length_m: f64,
        /// Radius, in metres.
        radius_m: f64,
    },
    /// A capsule.
    Capsule {
        /// Length of the cylindrical section, in metres.
        length_m: f64,
        /// Radius, in metres.
        radius_m: f64,
    },
    /// Convex hull of points in metres, an extension to URDF: `<hull points="x y z x y z …"/>`.
    Hull {
        /// The points; at least four, not in one plane.
        points: Vec<Point>,
    },
    /// A mesh file. That of a visual is opened only for display: planning does not need it.
    Mesh {
        /// Name in the URDF.
        name: String,
        /// Files that the name may refer to, in the order in which they are tried.
        candidates: Vec<PathBuf>,
        /// Factors that convert its coordinates to metres.
        scale: Vector,
    },
}
