/// Reason why the value of a joint cannot be chosen freely.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JointConstraint {
    /// The joint is of type `fixed`.
    #[error("it is of type `fixed`")]
    Fixed,
    /// The joint mimics another joint.
    #[error("it mimics joint `{master}`")]
    Mimic {
        /// Name of the mimicked joint.
        master: String,
    },
    /// The joint mimics another joint, which gives it a different value.
    #[error("it mimics joint `{master}`, which puts it at {value}")]
    MimicValue {
        /// Name of the mimicked joint.
        master: String,
        /// Value that the mimicry gives it, in metres or radians.
        value: f64,
    },
    /// The joint mimics another joint, which gives it a value outside its limits.
    #[error("it mimics joint `{master}`, which puts it {beyond} outside its limits")]
    MimicOutsideLimits {
        /// Name of the mimicked joint.
        master: String,
        /// Distance to the nearer limit, in metres or radians.
        beyond: f64,
    },
    /// The joint belongs to a finger of the hand, which is open.
    #[error("it is a finger of the hand, whose open position is {open}")]
    Finger {
        /// Value of the joint with the hand open, in metres or radians.
        open: f64,
    },
    /// The joint does not belong to the joint group.
    #[error("it is not in the joint group")]
    NotInGroup,
    /// The joint belongs to the joint group.
    #[error("it belongs to the joint group")]
    InGroup,
    /// The value is not a finite number.
    #[error("{value} is not a finite number")]
    NotFinite {
        /// The value.
        value: f64,
    },
}
