/// A malformed path, or limits along which there is no trajectory. That a path collides is a verdict, not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// A path has no way point.
    #[error("the path has no way points")]
    EmptyPath,
    /// The weight of a grasp's score is none.
    #[error("{weight} is no weight of a score; it must be finite and at least 0")]
    ScoreWeight {
        /// The weight.
        weight: f64,
    },
    /// A joint has no limit that a trajectory needs.
    #[error(
        "joint '{joint}' has no {quantity} limit, which a trajectory needs; give it one in the limits.yaml of \
         the robot"
    )]
    MissingLimit {
        /// Which joint.
        joint: String,
        /// Of what: `acceleration` or `jerk`.
        quantity: &'static str,
    },
    /// A joint has a limit that no motion can keep to.
    #[error("joint '{joint}' has a {quantity} limit of {value}, but it must be positive and finite")]
    Limit {
        /// Which joint.
        joint: String,
        /// Of what.
        quantity: &'static str,
        /// The limit.
        value: f64,
    },
    /// The URDF states no effort of a joint, which limits of torque need.
    #[error(
        "the URDF states no effort above 0 of joint '{joint}', which limits of torque need; add it to its <limit>"
    )]
    MissingEffort {
        /// The joint.
        joint: String,
    },
    /// The URDF states no mass and inertia of a link, which limits of torque need.
    #[error(
        "the URDF states no mass and inertia of link '{link}' that a body can have, which limits of torque need; give it \
         an <inertial>"
    )]
    MissingInertia {
        /// The link.
        link: String,
    },
    /// Neither mass nor moments of an object in the hand are known, which limits of torque need.
    #[error(
        "nothing states how '{object}' weighs, which limits of torque need, and it encloses no volume from which that could be \
         assumed; state the mass and moments of an object, or give it a closed surface"
    )]
    UnknownMass {
        /// The object.
        object: String,
    },
    /// A drive may not hold the robot at rest.
    #[error(
        "joint '{joint}' may not hold the weight of the arm on edge {edge} of the motion: that takes {needed:.1} (N, N m) there, \
         its effort is {effort:.1}"
    )]
    Weight {
        /// The joint.
        joint: String,
        /// The edge, from 0.
        edge: usize,
        /// A bound of the force that it needs, in N or N m.
        needed: f64,
        /// The greatest force of its drive, in N or N m.
        effort: f64,
    },
    /// A rounded corner is none of the path.
    #[error("the path has no corner at way point {waypoint}, where one is rounded")]
    NoCorner {
        /// Index of the way point.
        waypoint: usize,
    },
    /// A trajectory cannot be sampled at this rate.
    #[error("a trajectory is sampled at more than 0 and at most {greatest_hz} Hz, not at {rate_hz}")]
    SampleRate {
        /// The rate asked for.
        rate_hz: f64,
        /// The greatest that there is.
        greatest_hz: f64,
    },
    /// The task of the path is malformed.
    #[error(transparent)]
    Task(#[from] cranny_task::TaskError),
}
