/// Fault of a robot in a world, or of a request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CollisionError {
    /// The world has no body of that name.
    #[error("the world has no body '{name}' (it has: {known})")]
    UnknownBody {
        /// The unknown name.
        name: String,
        /// The known names.
        known: String,
    },
    /// The triangles of a link cannot be checked.
    #[error("link '{link}': {source}")]
    Link {
        /// Name of the link.
        link: String,
        /// Fault of its triangles.
        source: cranny_shape::ShapeError,
    },
    /// A margin is negative or not finite.
    #[error("a margin must be a finite number of metres, at least 0, but is {value}")]
    Margin {
        /// The margin, in metres.
        value: f64,
    },
    /// The bound on the tilt of the held object is out of range.
    #[error(
        "a bound of {:.3}° on the tilt is not valid: it must be above 0° and at most 180°",
        tilt_rad.to_degrees()
    )]
    Tilt {
        /// The bound, in radians.
        tilt_rad: f64,
    },
    /// A bound refers to a link that the robot does not have.
    #[error("a bound refers to link '{name}', which the robot does not have")]
    UnknownLink {
        /// The name of the link.
        name: String,
    },
    /// A bound refers to a finger, which the hand moves by itself.
    #[error("link '{name}' is a finger, which the hand moves by itself: bound the palm or the gripper frame")]
    FingerBound {
        /// The name of the link.
        name: String,
    },
    /// A bound on the tool is out of range.
    #[error(
        "bound '{name}' is not valid: directions must not be zero, angles must be above 0° and at most 180°, \
         and sizes must be positive and at most 1000 m"
    )]
    ToolBound {
        /// Name of the bound.
        name: String,
    },
    /// The hold of an object is not valid, the object is unbounded, or the hand is not empty.
    #[error(
        "'{name}' cannot be held: it must be of finite size, the hand must be empty, its pose must be within \
         {} m of the tip, and the fingers must be closed by a share from 0 to 1",
        cranny_robot::FARTHEST_HELD_M
    )]
    Hold {
        /// Name of the object.
        name: String,
    },
    /// A body is in contact with anything other than a support face below it, or penetrates its support face too deeply.
    #[error(
        "'{name}' touches '{other}', {:.2} mm deep, and does not rest on it: it may touch the faces below it that carry it, \
         up to {:.1} mm deep, and nothing else; move them apart",
        depth_m * 1e3,
        crate::CONTACT_ALLOWANCE_M * 1e3
    )]
    Touches {
        /// Name of the body.
        name: String,
        /// Name of the body that it touches.
        other: String,
        /// Their penetration depth, in metres.
        depth_m: f64,
    },
    /// The centre of mass of a body is not above its contact with the body below it.
    #[error(
        "'{name}' touches '{other}' and does not rest on it: its centre of mass is {:.2} mm outside its \
         support",
        off_m * 1e3
    )]
    Topples {
        /// Name of the body.
        name: String,
        /// Name of the body that it touches.
        other: String,
        /// Distance of the centre of mass from the contact regions below the body, as seen along gravity, in metres.
        off_m: f64,
    },
    /// A pose is not finite, or farther away than [`cranny_spatial::FARTHEST_M`].
    #[error("the pose of body '{name}' is not within 1000 m of the robot's root")]
    Pose {
        /// Name of the body.
        name: String,
    },
}
