use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::{Pose, Vector};

use crate::description::inertial::Inertial;
use crate::description::visual::LinkVisual;

/// A rigid part of a robot.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Index of the link it hangs on; None for the root.
    pub parent: Option<usize>,
    /// Its collision geometry; empty for a bare frame.
    pub collisions: Vec<LinkShape>,
    /// How it looks; empty for a bare frame, and where the URDF does not say.
    pub visuals: Vec<LinkVisual>,
    /// What it weighs, as far as the URDF says so.
    pub inertial: Option<Inertial>,
}

/// A piece of a link's collision geometry.
#[derive(Clone, Debug)]
pub struct LinkShape {
    /// Where the solid stands on the link.
    pub link_from_shape: Pose,
    /// The solid, in its own frame.
    pub solid: Solid,
    /// The triangles as read and scaled, in the solid's frame, where the geometry is a mesh.
    pub soup: Option<TriangleSoup>,
}

/// What kind of motion a joint allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis; positive by the right-hand rule.
    Revolute,
    /// Slides along its axis.
    Prismatic,
}

/// A joint of the group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupJoint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// The link that it moves. The joint's axis runs through the origin of this link.
    pub child_link: usize,
    /// Its axis in the frame of `child_link`, a unit vector.
    pub axis_in_child: Vector,
    /// The greatest force or torque of its drive (N, N m), if the URDF says one above 0.
    pub effort: Option<f64>,
}

/// A joint that moves a link: one of the group, or one that mimics a joint of the group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mover {
    /// Index in `q`.
    pub joint: usize,
    /// How much this joint moves for a unit of `q[joint]`: 1 for the joint itself, otherwise the mimic
    /// factor, never 0.
    pub multiplier: f64,
    /// How it moves.
    pub kind: JointKind,
    /// The link right below it.
    pub child_link: usize,
    /// Its axis in the frame of `child_link`, a unit vector.
    pub axis_in_child: Vector,
}
