use cranny_spatial::Vector;

/// A bound on the tilt of what is held: on the angle between the direction in it that pointed up where it stood when it was
/// grasped, and up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltLimit {
    /// That direction in the frame of the robot's tip, of length 1.
    pub axis_in_tip: Vector,
    /// Up in the planning frame, of length 1.
    pub up: Vector,
    /// The greatest angle, in radians.
    pub most_rad: f64,
}

impl TiltLimit {
    /// The angle of a direction in the planning frame (a unit vector) against up, in radians.
    pub(crate) fn angle_rad(&self, axis: &Vector) -> f64 {
        libm::atan2(self.up.cross(axis).norm(), self.up.dot(axis))
    }
}
