/// Why a joint has no value of its own to choose.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Hindrance {
    /// Its type is `fixed`.
    #[error("it is of type `fixed`")]
    Fixed,
    /// It follows another joint.
    #[error("it mimics joint `{master}`")]
    Mimic {
        /// The joint it follows.
        master: String,
    },
    /// It follows another joint to another value.
    #[error("it mimics joint `{master}`, which puts it at {value}")]
    MimicValue {
        /// The joint it follows.
        master: String,
        /// The value it has because of that, in metres or radians.
        value: f64,
    },
    /// It follows another joint to a value outside its limits.
    #[error("it mimics joint `{master}`, which puts it {beyond} outside its limits")]
    MimicOutsideLimits {
        /// The joint it follows.
        master: String,
        /// Distance to the nearer limit, in metres or radians.
        beyond: f64,
    },
    /// It is a finger of the hand, which stands open.
    #[error("it is a finger of the hand, which stands open with it at {open}")]
    Finger {
        /// The value it has because of that, in metres or radians.
        open: f64,
    },
    /// It does not belong to the joint group.
    #[error("it is not among the joints that move")]
    NotInGroup,
    /// It belongs to the joint group.
    #[error("it belongs to the joint group")]
    InGroup,
    /// Its value is not a finite number.
    #[error("{value} is not a finite number")]
    NotFinite {
        /// The value.
        value: f64,
    },
}
