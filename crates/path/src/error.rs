/// Error for a malformed path, or for limits that permit no trajectory. A collision of the path is a verdict, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// A path has no way point.
    #[error("the path has no way points")]
    EmptyPath,
    /// A path has too many way points to be judged.
    #[error("the path has {actual} way points, but at most {most} are judged")]
    TooManyWayPoints {
        /// Number of way points, those of all segments together.
        actual: usize,
        /// Maximum number.
        most: usize,
    },
    /// The joints travel too far for a path to be judged.
    #[error(
        "the joints travel {travel:.1} (rad, m) from the start to the end of edge {edge} of the path, but paths of at \
         most {most} are judged"
    )]
    TooMuchTravel {
        /// Index of the edge at which the limit is exceeded, from 0.
        edge: usize,
        /// Travel up to its end, in rad or m.
        travel: f64,
        /// Maximum travel, in rad or m.
        most: u32,
    },
    /// The weight of the grasp score is invalid.
    #[error("{weight} is not a valid weight of the score: it must be finite and at least 0")]
    ScoreWeight {
        /// The weight.
        weight: f64,
    },
    /// A joint lacks a limit that a trajectory needs.
    #[error(
        "joint '{joint}' has no {quantity} limit, which a trajectory needs; give it one in the limits.yaml of \
         the robot"
    )]
    MissingLimit {
        /// Name of the joint.
        joint: String,
        /// Limited quantity: `acceleration` or `jerk`.
        quantity: &'static str,
    },
    /// A joint has a limit that is not positive and finite.
    #[error("joint '{joint}' has a {quantity} limit of {value}, but it must be positive and finite")]
    Limit {
        /// Name of the joint.
        joint: String,
        /// Limited quantity.
        quantity: &'static str,
        /// Value of the limit.
        value: f64,
    },
    /// The URDF states no effort for a joint, which torque limits need.
    #[error(
        "joint '{joint}' has no effort above 0 in the URDF, which torque limits need; add it to its <limit>"
    )]
    MissingEffort {
        /// Name of the joint.
        joint: String,
    },
    /// The URDF states no mass and inertia for a link, which torque limits need.
    #[error(
        "link '{link}' has no valid mass and inertia in the URDF, which torque limits need; give it an \
         <inertial>"
    )]
    MissingInertia {
        /// Name of the link.
        link: String,
    },
    /// The mass and moments of a held object are unknown, and torque limits need them.
    #[error(
        "the mass of '{object}' is unknown, which torque limits need, and it encloses no volume from which \
         it could be estimated; state the mass and moments of the object, or give it a closed surface"
    )]
    UnknownMass {
        /// Name of the object.
        object: String,
    },
    /// A drive may be too weak to support the robot at rest.
    #[error(
        "joint '{joint}' may be too weak to hold the arm on edge {edge} of the motion: up to {needed:.1} (N, \
         N m) are needed there, its effort is {effort:.1}"
    )]
    Weight {
        /// Name of the joint.
        joint: String,
        /// Index of the edge, from 0.
        edge: usize,
        /// Upper bound of the required force, in N or N m.
        needed: f64,
        /// Maximum force of the drive, in N or N m.
        effort: f64,
    },
    /// A rounded corner does not lie at a corner of the path.
    #[error("the path has no corner at way point {waypoint}, where one is rounded")]
    NoCorner {
        /// Index of the way point.
        waypoint: usize,
    },
    /// The sample rate of a trajectory is out of range.
    #[error("the sample rate of a trajectory must be above 0 and at most {greatest_hz} Hz, but is {rate_hz}")]
    SampleRate {
        /// Requested rate, in Hz.
        rate_hz: f64,
        /// Maximum rate, in Hz.
        greatest_hz: f64,
    },
    /// A trajectory has too many samples.
    #[error(
        "{duration_s:.3e} s at {rate_hz} Hz are more than {greatest:.0e} samples (give a lower rate, or a higher speed)"
    )]
    TooManySamples {
        /// Duration, in seconds.
        duration_s: f64,
        /// Requested rate, in Hz.
        rate_hz: f64,
        /// Maximum number of samples.
        greatest: f64,
    },
    /// The task of the path is malformed.
    #[error(transparent)]
    Task(#[from] cranny_task::TaskError),
}
