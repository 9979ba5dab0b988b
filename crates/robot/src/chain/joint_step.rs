use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation, Vector, sin_cos};

/// Forward kinematics of one link from its parent.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) link: usize,
    pub(crate) parent: usize,
    pub(crate) motion: Motion,
}

impl Step {
    #[inline]
    pub(crate) fn root_from_link(&self, root_from_parent: &Pose, loose: &[Pose], q: &[f64]) -> Pose {
        let within = |translation: Vector| {
            root_from_parent.translation.vector + root_from_parent.rotation * translation
        };
        let (translation, rotation) = match &self.motion {
            Motion::Rigid { parent_from_link } => (
                within(parent_from_link.translation.vector),
                root_from_parent.rotation * parent_from_link.rotation,
            ),
            Motion::Loose { slot } => return root_from_parent * loose[*slot],
            Motion::Slide { value, rotation, translation, axis_in_parent } => {
                (within(translation + axis_in_parent * value.at(q)), root_from_parent.rotation * rotation)
            }
            Motion::Turn { value, translation, at_zero, at_half_turn } => {
                let (sine, cosine) = sin_cos(0.5 * value.at(q));
                // A sum of two perpendicular unit quaternions, weighted by cosine and sine, has unit length.
                let turned = Rotation::new_unchecked(at_zero * cosine + at_half_turn * sine);
                (within(*translation), root_from_parent.rotation * turned)
            }
        };
        Pose::from_parts(translation.into(), rotation)
    }
}

/// Motion of a joint with precomputed constants.
#[derive(Clone, Debug)]
pub(crate) enum Motion {
    Rigid {
        parent_from_link: Pose,
    },
    Slide {
        value: Value,
        rotation: Rotation,
        translation: Vector,
        axis_in_parent: Vector,
    },
    Turn {
        value: Value,
        translation: Vector,
        /// Rotation at value 0, and that rotation times a half turn: `cos(v/2) · at_zero + sin(v/2) · at_half_turn` is the
        /// rotation at value v.
        at_zero: Quaternion<f64>,
        at_half_turn: Quaternion<f64>,
    },
    /// Rigidly attached to the tip by a hold.
    Loose {
        slot: usize,
    },
}

impl Motion {
    /// Returns the motion of a joint that slides along `axis` (in its own frame).
    pub(crate) fn slide(value: Value, parent_from_joint: &Pose, axis: &Vector) -> Self {
        Self::Slide {
            value,
            rotation: parent_from_joint.rotation,
            translation: parent_from_joint.translation.vector,
            axis_in_parent: parent_from_joint.rotation * axis,
        }
    }

    /// Returns the motion of a joint that turns about `axis` (in its own frame).
    pub(crate) fn turn(value: Value, parent_from_joint: &Pose, axis: &Vector) -> Self {
        let at_zero = parent_from_joint.rotation.into_inner();
        Self::Turn {
            value,
            translation: parent_from_joint.translation.vector,
            at_zero,
            at_half_turn: at_zero * Quaternion::from_imag(*axis),
        }
    }
}

/// Joint value `multiplier · q[joint] + offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Value {
    pub(crate) joint: usize,
    pub(crate) multiplier: f64,
    pub(crate) offset: f64,
}

impl Value {
    fn at(&self, q: &[f64]) -> f64 {
        self.multiplier * q[self.joint] + self.offset
    }
}
