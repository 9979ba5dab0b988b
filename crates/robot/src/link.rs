use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::{Pose, Vector};

use crate::description::inertial::Inertial;
use crate::description::visual::LinkVisual;

/// A rigid link of a robot.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name of the link.
    pub name: String,
    /// Index of the parent link; `None` for the root.
    pub parent: Option<usize>,
    /// Collision geometry; empty for a bare frame.
    pub collisions: Vec<LinkShape>,
    /// Visual geometry; empty for a bare frame, and if the URDF has none.
    pub visuals: Vec<LinkVisual>,
    /// Mass and inertia, if given in the URDF.
    pub inertial: Option<Inertial>,
}

/// One solid of a link's collision geometry.
#[derive(Clone, Debug)]
pub struct LinkShape {
    /// Pose of the solid in the link frame.
    pub link_from_shape: Pose,
    /// The solid, in its own frame.
    pub solid: Solid,
    /// Triangles as read and scaled, in the solid's frame, if the geometry is a mesh.
    pub soup: Option<TriangleSoup>,
}

/// Kind of motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about the joint's axis; positive by the right-hand rule.
    Revolute,
    /// Translation along the joint's axis.
    Prismatic,
}

/// A joint of the group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupJoint {
    /// Name of the joint.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Link moved by this joint. The joint's axis passes through the origin of this link.
    pub child_link: usize,
    /// Axis in the frame of `child_link`, a unit vector.
    pub axis_in_child: Vector,
    /// Maximum force or torque of its drive (N, N m), if the URDF gives one above 0.
    pub effort: Option<f64>,
}

/// Joint that moves a link: one of the group, or one that mimics a joint of the group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mover {
    /// Index in `q`.
    pub joint: usize,
    /// Motion of this joint per unit of `q[joint]`: 1 for the joint itself, otherwise the mimic factor, never 0.
    pub multiplier: f64,
    /// Kind of motion.
    pub kind: JointKind,
    /// Child link of the joint.
    pub child_link: usize,
    /// Axis in the frame of `child_link`, a unit vector.
    pub axis_in_child: Vector,
}
