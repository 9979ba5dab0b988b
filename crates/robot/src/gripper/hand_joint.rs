use cranny_spatial::Vector;

use crate::JointKind;

/// A joint that moves while a hand closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandJoint {
    /// The link right below it.
    pub link: usize,
    /// The joint of the hand above it, by its number among them; `None` right on the palm.
    pub parent: Option<usize>,
    /// Kind of motion.
    pub kind: JointKind,
    /// Its axis in the frame of `link`, a unit vector.
    pub axis_in_link: Vector,
    /// Signed travel from open to closed (m, rad).
    pub stroke: f64,
    /// The finger that it belongs to, counted from 0.
    pub finger: usize,
    /// Greatest speed, in m/s or rad/s, if known.
    pub velocity: Option<f64>,
    /// Greatest acceleration, in m/s² or rad/s², if known.
    pub acceleration: Option<f64>,
}
