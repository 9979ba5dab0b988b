use cranny_spatial::{Pose, Vector};

use crate::{Inertial, JointKind, LinkForm};

/// Bodies of a model and the joints between them, as MJCF and SDF describe them.
pub(crate) struct BodyTree {
    pub(crate) name: String,
    /// Bodies, parents before children; the first is the world, or the root link of a model.
    pub(crate) bodies: Vec<TreeBody>,
    /// Pairs of bodies without contacts.
    pub(crate) excluded: Vec<[usize; 2]>,
    /// Pairs of contact groups ([`ContactMask::pair`]) with contacts regardless of their masks.
    pub(crate) included: Vec<[usize; 2]>,
    /// True if a body and its parent have no contacts, unless the parent does not move (MJCF, `filterparent`).
    pub(crate) filters_parents: bool,
    pub(crate) planes: Vec<Plane>,
    pub(crate) states: Vec<KeyState>,
    /// Content that was not read, one line for each kind.
    pub(crate) notes: Vec<String>,
}

/// A rigid body.
pub(crate) struct TreeBody {
    pub(crate) name: String,
    /// Index of the parent; `None` for the first body only.
    pub(crate) parent: Option<usize>,
    /// Pose in the frame of the parent with all joints at their reference values.
    pub(crate) parent_from_body: Pose,
    /// Joints to the parent, applied in this order.
    pub(crate) joints: Vec<TreeJoint>,
    pub(crate) shapes: Vec<TreeShape>,
    pub(crate) inertial: Option<Inertial>,
    /// True if the body moves freely in the world.
    pub(crate) is_free: bool,
}

impl TreeBody {
    pub(crate) fn bare(name: String, parent: Option<usize>, parent_from_body: Pose) -> Self {
        let (joints, shapes) = (Vec::new(), Vec::new());
        Self { name, parent, parent_from_body, joints, shapes, inertial: None, is_free: false }
    }
}

/// A joint of one degree of freedom.
pub(crate) struct TreeJoint {
    pub(crate) name: String,
    pub(crate) kind: JointKind,
    /// Point of the axis in the frame of the body.
    pub(crate) anchor: Vector,
    /// Unit vector in the frame of the body.
    pub(crate) axis: Vector,
    /// Lower and upper limit (m, rad), if there are any.
    pub(crate) range: Option<[f64; 2]>,
    /// Value (m, rad) at which the body has its pose of the file.
    pub(crate) reference: f64,
    pub(crate) rule: JointRule,
    /// Maximum speed and force of the joint, if given (m/s, rad/s; N, N m).
    pub(crate) velocity: Option<f64>,
    pub(crate) effort: Option<f64>,
}

/// Constraint on the value of a joint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum JointRule {
    Free,
    /// The value is `multiplier · value of the master + offset`.
    Mimic {
        master: String,
        multiplier: f64,
        offset: f64,
    },
    /// The value is constant (m, rad).
    Constant(f64),
}

/// A shape of a body.
pub(crate) struct TreeShape {
    pub(crate) body_from_shape: Pose,
    pub(crate) form: LinkForm,
    pub(crate) contacts: ContactMask,
    /// Colour to draw it in; `None` for a shape that is not drawn.
    pub(crate) look: Option<Look>,
}

/// Look of a shape: red, green, blue and opacity, 0 to 1, if given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Look {
    pub(crate) colour: Option<[f64; 4]>,
}

/// Bits that decide which shapes collide, as in MJCF: two shapes do if a bit of the one's `own` is in the other's `others`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ContactMask {
    pub(crate) own: u32,
    pub(crate) others: u32,
    /// Contact group of a shape that a pair of the model names.
    pub(crate) pair: Option<usize>,
}

impl ContactMask {
    /// Mask of shapes that collide with each other.
    pub(crate) const ALL: Self = Self { own: 1, others: 1, pair: None };

    /// Returns true if no shape collides with one of this mask.
    pub(crate) fn is_empty(self) -> bool {
        self.own == 0 && self.others == 0 && self.pair.is_none()
    }

    pub(crate) fn meets(self, other: Self) -> bool {
        self.own & other.others != 0 || other.own & self.others != 0
    }
}

/// Half-space of the world below a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Name of the plane.
    pub name: String,
    /// Pose of the plane in the world; its normal, z, points out of the solid.
    pub world_from_plane: Pose,
}

/// Named joint values.
pub(crate) struct KeyState {
    pub(crate) name: String,
    /// Joint and value (m, rad).
    pub(crate) values: Vec<(String, f64)>,
}
