use cranny_shape::Solid;
use cranny_spatial::{Pose, Vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::GraspError;

/// Parallel hand with its fingers open, as solids in the gripper frame: x across the fingers, y the closing axis, z the
/// approach direction. It is symmetric under half a turn about z.
#[derive(Clone, Debug)]
pub struct Hand {
    /// Name of the hand.
    pub name: String,
    /// Solids, each with its pose `gripper_from_part`; the palm comes first.
    pub parts: Vec<(Pose, Solid)>,
    /// The fingers.
    pub fingers: Vec<Finger>,
    /// Distance between the pads, in metres.
    pub opening_m: f64,
    /// Distance of the palm behind the origin of the gripper frame, in metres: an object that reaches farther back does
    /// not fit between the fingers.
    pub finger_depth_m: f64,
    /// Force of the pads on the held object, in newtons.
    pub closing_force_n: f64,
    /// Flat pads, if known better than from the solids of the fingers ([`Pads::of`](crate::Pads::of)).
    pub pads: Option<PadRectangle>,
}

impl Hand {
    /// Returns the gap that stays between the pads of the closed hand, in metres; 0 without two straight fingers.
    pub fn closed_gap_m(&self) -> f64 {
        let [one, other] = &self.fingers[..] else { return 0.0 };
        (self.opening_m - (one.stroke_m.y - other.stroke_m.y).abs()).max(0.0)
    }
}

/// The flat pads of a hand, along x and z of the gripper frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadRectangle {
    /// Centre along x and z, in metres.
    pub middle_m: [f64; 2],
    /// Half of the size along x and z, in metres.
    pub half_m: [f64; 2],
}

/// A finger that closes in a straight line.
#[derive(Clone, Debug, PartialEq)]
pub struct Finger {
    /// Indices of its solids in [`Hand::parts`].
    pub parts: std::ops::Range<usize>,
    /// Travel until the hand is closed on nothing, in the gripper frame (m).
    pub stroke_m: Vector,
}

/// A parallel hand as data: two equal box-shaped fingers on a box-shaped palm. Lengths in metres, along the axes of the
/// gripper frame (see [`Hand`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxHand {
    /// Name of the hand.
    pub name: String,
    /// Distance between the pads of the open hand.
    pub opening_m: f64,
    /// Size of a finger across (x).
    pub finger_width_m: f64,
    /// Size of a finger outwards from its pad (y).
    pub finger_thickness_m: f64,
    /// Distance from the palm to the tips of the fingers (z).
    pub finger_length_m: f64,
    /// Distance of the tips beyond the origin of the gripper frame (z).
    pub tip_ahead_m: f64,
    /// Sizes of the palm along x, y, z.
    pub palm_size_m: [f64; 3],
    /// Force of the pads on the held object, in newtons. Default: 40, usual for small hands, between the minimum of a
    /// Robotiq 2F-85 (20) and the continuous force of a Franka hand (70).
    #[serde(default = "default_closing_force_n")]
    pub closing_force_n: f64,
}

fn default_closing_force_n() -> f64 {
    40.0
}

impl Default for BoxHand {
    /// Approximate dimensions of a Franka hand.
    fn default() -> Self {
        Self {
            name: "boxes".to_owned(),
            opening_m: 0.08,
            finger_width_m: 0.02,
            finger_thickness_m: 0.015,
            finger_length_m: 0.0536,
            tip_ahead_m: 0.007,
            palm_size_m: [0.06, 0.204, 0.066],
            closing_force_n: default_closing_force_n(),
        }
    }
}

/// Valid ranges of a length of a hand, in metres, and of a force, in newtons.
const LENGTHS_M: (f64, f64) = (1e-6, 10.0);
const FORCES_N: (f64, f64) = (1e-3, 1e6);

impl BoxHand {
    /// Builds the hand of these boxes.
    ///
    /// # Errors
    /// [`GraspError::HandFigure`] for a value out of range: lengths lie in [1 µm, 10 m], the closing force in [1 mN, 1
    /// MN], and the tips at most 10 m from the origin.
    ///
    /// # Panics
    /// Never: sizes in this range form boxes.
    pub fn hand(&self) -> Result<Hand, GraspError> {
        let [palm_x_m, palm_y_m, palm_z_m] = self.palm_size_m;
        for (figure, value, (least, greatest)) in [
            ("opening_m", self.opening_m, LENGTHS_M),
            ("finger_width_m", self.finger_width_m, LENGTHS_M),
            ("finger_thickness_m", self.finger_thickness_m, LENGTHS_M),
            ("finger_length_m", self.finger_length_m, LENGTHS_M),
            ("tip_ahead_m", self.tip_ahead_m, (-LENGTHS_M.1, LENGTHS_M.1)),
            ("first palm_size_m", palm_x_m, LENGTHS_M),
            ("second palm_size_m", palm_y_m, LENGTHS_M),
            ("third palm_size_m", palm_z_m, LENGTHS_M),
            ("closing_force_n", self.closing_force_n, FORCES_N),
        ] {
            if !(least..=greatest).contains(&value) {
                return Err(GraspError::HandFigure { figure, value, least, greatest });
            }
        }
        let cuboid = |center: Vector, size: Vector| {
            let solid = Solid::cuboid(size * 0.5).expect("the sizes are positive");
            (Pose::translation(center.x, center.y, center.z), solid)
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
                cuboid(Vector::new(0.0, 0.0, palm_z), palm_size),
                cuboid(Vector::new(0.0, out_m, finger_z), finger_size),
                cuboid(Vector::new(0.0, -out_m, finger_z), finger_size),
            ],
            fingers: vec![
                Finger { parts: 1..2, stroke_m: stroke_m(1.0) },
                Finger { parts: 2..3, stroke_m: stroke_m(-1.0) },
            ],
            opening_m: self.opening_m,
            finger_depth_m: self.finger_length_m - self.tip_ahead_m,
            closing_force_n: self.closing_force_n,
            pads: None,
        })
    }
}
