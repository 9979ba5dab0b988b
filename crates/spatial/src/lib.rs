#![doc = include_str!("../README.md")]

mod difference;
mod lanes;
mod quaternion;
mod random;
mod tolerance;
mod trigonometry;

pub use difference::PoseDifference;
pub use lanes::{
    LANES, LaneArray, LaneVector, MOST_TURN_IN_LANES_RAD, SINE_ERROR_IN_LANES, simd_level, simd_level_name,
    simd_levels, sin_cos_lanes,
};
pub use quaternion::rotation_from_xyzw;
pub use random::{Stream, other_seed};
pub use tolerance::{CONTACT_M, EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, FARTHEST_M, ROUNDING_M};
pub use trigonometry::sin_cos;

pub use nalgebra;

/// A rigid transform of three-dimensional space, `target_from_source`.
pub type Pose = nalgebra::Isometry3<f64>;
/// A rotation of three-dimensional space.
pub type Rotation = nalgebra::UnitQuaternion<f64>;
/// A point, in metres.
pub type Point = nalgebra::Point3<f64>;
/// A direction or displacement, in metres where it is a displacement.
pub type Vector = nalgebra::Vector3<f64>;
