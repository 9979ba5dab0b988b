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
