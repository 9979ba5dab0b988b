use cranny_spatial::Vector;

use crate::JointKind;

/// Joint that moves while a hand closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandJoint {
    /// Child link of the joint.
    pub link: usize,
    /// Parent joint, as an index into the joints of the hand; `None` if attached to the palm.
    pub parent: Option<usize>,
    /// Kind of motion.
    pub kind: JointKind,
    /// Axis in the frame of `link`, a unit vector.
    pub axis_in_link: Vector,
    /// Signed travel from open to closed (m, rad).
    pub stroke: f64,
    /// Finger that it belongs to, counted from 0.
    pub finger: usize,
    /// Maximum speed, in m/s or rad/s, if known.
    pub velocity: Option<f64>,
    /// Maximum acceleration, in m/s² or rad/s², if known.
    pub acceleration: Option<f64>,
}
