/// What can be wrong with a robot in a world.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CollisionError {
    /// A body is named that the world does not have.
    #[error("the world has no body '{name}' (it has: {known})")]
    UnknownBody {
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// A margin is negative or not finite.
    #[error("a margin must be a finite number of metres, at least 0, but is {value}")]
    Margin {
        /// The offending value.
        value: f64,
    },
    /// A pose has a number that is not finite.
    #[error("the pose of body '{name}' has a number that is not finite")]
    Pose {
        /// Which body.
        name: String,
    },
}
