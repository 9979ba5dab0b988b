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
    /// A bound on the tilt of what is held is none.
    #[error("a tilt of {:.3}° bounds nothing: it must be above 0° and at most 180°", tilt_rad.to_degrees())]
    Tilt {
        /// The bound, in radians.
        tilt_rad: f64,
    },
    /// A bound is stated for a link that the robot does not have.
    #[error("the robot has no link '{name}', which is bounded")]
    UnknownLink {
        /// The name of the link.
        name: String,
    },
    /// A bound is stated for a finger, which the hand moves by itself.
    #[error("link '{name}' is a finger, which the hand moves by itself: bound the palm or the gripper frame")]
    FingerBound {
        /// The name of the link.
        name: String,
    },
    /// A bound on the tool is none.
    #[error(
        "'{name}' bounds nothing: directions must have a length, an angle be above 0° and at most 180°, and sizes be positive \
         and at most 1000 m"
    )]
    ToolBound {
        /// Its name.
        name: String,
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
    /// A body is in contact with something other than a face below it that carries it, or too deep in that.
    #[error(
        "'{name}' touches '{other}', {:.2} mm deep, and does not rest on it: it may touch the faces below it that carry it, \
         up to {:.1} mm deep, and nothing else; move them apart",
        depth_m * 1e3,
        crate::CONTACT_ALLOWANCE_M * 1e3
    )]
    Touches {
        /// The body.
        name: String,
        /// The body that it touches.
        other: String,
        /// Their depth in each other, in metres.
        depth_m: f64,
    },
    /// The centre of mass of a body is not over what it touches below it.
    #[error(
        "'{name}' touches '{other}' and does not rest on it: its centre of mass is {:.2} mm beside what is below it",
        off_m * 1e3
    )]
    Topples {
        /// The body.
        name: String,
        /// The body that it touches.
        other: String,
        /// Distance of the centre of mass from what is below the body, seen along gravity, in metres.
        off_m: f64,
    },
    /// A pose is not finite, or farther away than [`cranny_spatial::FARTHEST_M`].
    #[error("the pose of body '{name}' is not within 1000 m of the robot's root")]
    Pose {
        /// Which body.
        name: String,
    },
}
