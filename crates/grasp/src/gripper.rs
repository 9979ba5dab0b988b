use cranny_shape::{ShapeError, Solid};
use cranny_spatial::{Pose, Vector};
use serde::{Deserialize, Serialize};

/// A parallel gripper as data: two equal fingers, each a box, on a palm, which is a box too. Lengths in
/// metres, along the axes of the gripper frame: x across the fingers, y the axis on which they close, z the
/// approach direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gripper {
    /// What it is called.
    pub name: String,
    /// Between the pads when the fingers stand open.
    pub opening_m: f64,
    /// A finger's size across (x).
    pub finger_width_m: f64,
    /// A finger's size outwards from its pad (y).
    pub finger_thickness_m: f64,
    /// From the palm to the tips of the fingers (z).
    pub finger_length_m: f64,
    /// How far the tips reach beyond the origin of the gripper frame (z).
    pub tip_ahead_m: f64,
    /// The palm's sizes along x, y, z.
    pub palm_size_m: [f64; 3],
}

impl Gripper {
    /// The hand of the Franka Panda, from the maker's dimensions, with the gripper frame 0.105 m before its
    /// flange.
    pub fn panda_hand() -> Self {
        Self {
            name: "panda_hand".into(),
            opening_m: 0.08,
            finger_width_m: 0.02,
            finger_thickness_m: 0.015,
            finger_length_m: 0.0536,
            tip_ahead_m: 0.007,
            palm_size_m: [0.06, 0.204, 0.066],
        }
    }

    /// How far behind the origin of the gripper frame the palm begins, in metres: an object that reaches farther
    /// back than that does not fit between the fingers.
    pub fn finger_depth_m(&self) -> f64 {
        self.finger_length_m - self.tip_ahead_m
    }

    /// The boxes of palm and open fingers, each with its pose `gripper_from_box`.
    ///
    /// # Errors
    /// [`ShapeError::Size`] for a size that is none.
    pub fn parts(&self) -> Result<Vec<(Pose, Solid)>, ShapeError> {
        let cuboid = |center: Vector, size: Vector| -> Result<(Pose, Solid), ShapeError> {
            Ok((Pose::translation(center.x, center.y, center.z), Solid::cuboid(size * 0.5)?))
        };
        let finger_size = Vector::new(self.finger_width_m, self.finger_thickness_m, self.finger_length_m);
        let out_m = 0.5 * (self.opening_m + self.finger_thickness_m);
        let finger_z = self.tip_ahead_m - 0.5 * self.finger_length_m;
        let palm_size = Vector::from(self.palm_size_m);
        let palm_z = self.tip_ahead_m - self.finger_length_m - 0.5 * palm_size.z;
        Ok(vec![
            cuboid(Vector::new(0.0, out_m, finger_z), finger_size)?,
            cuboid(Vector::new(0.0, -out_m, finger_z), finger_size)?,
            cuboid(Vector::new(0.0, 0.0, palm_z), palm_size)?,
        ])
    }
}
