use std::path::PathBuf;

use cranny_spatial::{Pose, Vector};

/// How a piece of a link looks: a `<visual>` of the URDF, which no check of collision knows.
///
/// Two attributes of `<visual>` are an extension to URDF. `rounding` rounds the edges of a cuboid or cylinder
/// inwards. `blend` melts a primitive into the link's other primitives of the same colour that have one, so
/// that a few of them look like one cast body.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkVisual {
    /// Where it stands on the link.
    pub link_from_visual: Pose,
    /// Its form, in its own frame.
    pub form: LinkForm,
    /// Red, green, blue and opacity of its material, 0 to 1, in the sRGB colour space; None if it has none
    /// or one without a colour.
    pub colour: Option<[f64; 4]>,
    /// The radius of its edges, in metres; 0 for sharp ones.
    pub rounding_m: f64,
    /// How wide the fillet is with which it goes over into others, in metres; 0 for none.
    pub blend_m: f64,
}

/// The form of a `<visual>` or a `<collision>`; lengths in metres, all greater than zero. Cylinder and capsule lie
/// along z.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkForm {
    /// A cuboid.
    Cuboid {
        /// Its lengths.
        size: Vector,
    },
    /// A sphere.
    Sphere {
        /// Its radius.
        radius_m: f64,
    },
    /// A cylinder.
    Cylinder {
        /// Its length.
        length_m: f64,
        /// Its radius.
        radius_m: f64,
    },
    /// A capsule.
    Capsule {
        /// The length of its cylindrical part.
        length_m: f64,
        /// Its radius.
        radius_m: f64,
    },
    /// A mesh file. That of a visual is not opened before somebody wants to see it: a robot can be planned for without.
    Mesh {
        /// The name in the URDF.
        name: String,
        /// The files that the name may mean, in the order in which they are tried.
        candidates: Vec<PathBuf>,
        /// What its coordinates are multiplied by to become metres.
        scale: Vector,
    },
}
