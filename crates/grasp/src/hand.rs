use cranny_shape::{ShapeError, Solid};
use cranny_spatial::{Pose, Vector};
use serde::{Deserialize, Serialize};

/// A parallel hand with its fingers open, as solids in the gripper frame: x across the fingers, y the axis on which they
/// close, z the approach direction. Turned by half a turn about z it is the same hand.
#[derive(Clone, Debug)]
pub struct Hand {
    /// What it is called.
    pub name: String,
    /// Its solids, each with its pose `gripper_from_part`: the palm's first.
    pub parts: Vec<(Pose, Solid)>,
    /// The fingers.
    pub fingers: Vec<Finger>,
    /// Between the pads, in metres.
    pub opening_m: f64,
    /// How far behind the origin of the gripper frame the palm begins, in metres: an object that reaches farther
    /// back than that does not fit between the fingers.
    pub finger_depth_m: f64,
    /// With what the pads press on what they hold, in newtons.
    pub closing_force_n: f64,
}

/// A finger that closes in a straight line.
#[derive(Clone, Debug, PartialEq)]
pub struct Finger {
    /// Which of the hand's parts it has.
    pub parts: std::ops::Range<usize>,
    /// How far it moves until the hand is closed on nothing, in the gripper frame (m).
    pub stroke_m: Vector,
}

/// A parallel hand as data: two equal fingers, each a box, on a palm, which is a box too. Lengths in
/// metres, along the axes of the gripper frame (see [`Hand`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxHand {
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
    /// With what the pads press on what they hold, in newtons.
    #[serde(default = "default_closing_force_n")]
    pub closing_force_n: f64,
}

/// What small hands can do: between a Robotiq 2F-85's least (20 N) and a Panda's continuous force (70 N).
fn default_closing_force_n() -> f64 {
    40.0
}

impl BoxHand {
    /// The hand of these boxes.
    ///
    /// # Errors
    /// [`ShapeError::Size`] for a size that is none.
    pub fn hand(&self) -> Result<Hand, ShapeError> {
        let is_force = self.closing_force_n.is_finite() && self.closing_force_n > 0.0;
        for (what, value, is_sound) in [
            ("the opening", self.opening_m, self.opening_m > 0.0),
            ("the closing force", self.closing_force_n, is_force),
            ("how far the tips are ahead", self.tip_ahead_m, self.tip_ahead_m.is_finite()),
        ] {
            if !is_sound {
                return Err(ShapeError::Size { what, value });
            }
        }
        let cuboid = |center: Vector, size: Vector| -> Result<(Pose, Solid), ShapeError> {
            Ok((Pose::translation(center.x, center.y, center.z), Solid::cuboid(size * 0.5)?))
        };
        let finger_size = Vector::new(self.finger_width_m, self.finger_thickness_m, self.finger_length_m);
        let out_m = 0.5 * (self.opening_m + self.finger_thickness_m);
        let finger_z = self.tip_ahead_m - 0.5 * self.finger_length_m;
        let palm_size = Vector::from(self.palm_size_m);
        let palm_z = self.tip_ahead_m - self.finger_length_m - 0.5 * palm_size.z;
        let stroke_m = |side: f64| Vector::new(0.0, -0.5 * side * self.opening_m, 0.0);
        Ok(Hand {
            name: self.name.clone(),
            parts: vec![
                cuboid(Vector::new(0.0, 0.0, palm_z), palm_size)?,
                cuboid(Vector::new(0.0, out_m, finger_z), finger_size)?,
                cuboid(Vector::new(0.0, -out_m, finger_z), finger_size)?,
            ],
            fingers: vec![
                Finger { parts: 1..2, stroke_m: stroke_m(1.0) },
                Finger { parts: 2..3, stroke_m: stroke_m(-1.0) },
            ],
            opening_m: self.opening_m,
            finger_depth_m: self.finger_length_m - self.tip_ahead_m,
            closing_force_n: self.closing_force_n,
        })
    }
}
