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
    /// A link's triangles cannot be checked.
    #[error("link '{link}': {source}")]
    Link {
        /// Which link.
        link: String,
        /// What is wrong with its triangles.
        source: cranny_shape::ShapeError,
    },
    /// A margin is negative or not finite.
    #[error("a margin must be a finite number of metres, at least 0, but is {value}")]
    Margin {
        /// The offending value.
        value: f64,
    },
    /// Something cannot be held like that.
    #[error(
        "'{name}' cannot be held: it must have bounds, the hand be empty, its pose be within {} m of the tip, and the \
         fingers closed by a share from 0 to 1",
        cranny_robot::FARTHEST_HELD_M
    )]
    Hold {
        /// What was to be held.
        name: String,
    },
    /// A body rests in a hollow.
    #[error(
        "'{name}' rests in a hollow of '{other}': no direction leads off it, so that no lift-off can be proven"
    )]
    Hollow {
        /// The body.
        name: String,
        /// What it rests in.
        other: String,
    },
    /// A pose is not finite, or farther away than [`cranny_spatial::FARTHEST_M`].
    #[error("the pose of body '{name}' is not within 1000 m of the robot's root")]
    Pose {
        /// Which body.
        name: String,
    },
}
