use cranny_spatial::{Pose, Rotation, Vector};

/// Height of the floor in the planning frame of the released scenarios, in metres.
pub(crate) const FLOOR_M: f64 = -0.05;

/// Returns the pose of the scene in the planning frame: the root is at (1, 0, 0.05) m in the scene, rotated by +90° about z.
pub(crate) fn planning_from_scene() -> Pose {
    let quarter_turn = Rotation::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_2);
    Pose::from_parts(Vector::new(1.0, 0.0, -FLOOR_M).into(), quarter_turn).inverse()
}
