/// Closer than this counts as contact, in metres: below the export noise of meshes (0.1 mm), above every
/// rounding error of an `f64` distance. One value for the exact check, its fast forms and the proof of a
/// motion.
pub const CONTACT_M: f64 = 1e-5;

/// An answer is exact when the gripper is at most this far from a grasp, in metres (README, "What solved means").
pub const EXACT_TRANSLATION_M: f64 = 1e-3;

/// An answer is exact when the gripper is turned at most this far from a grasp: 1°, in radians.
pub const EXACT_ROTATION_RAD: f64 = std::f64::consts::PI / 180.0;

/// Nothing may be larger or farther away than this, in metres: what is, was meant in other units, and the
/// rounding that [`ROUNDING_M`] covers would no longer hold.
pub const FARTHEST_M: f64 = 1e3;

/// What a proof takes off every `f64` distance to cover its rounding, in metres. Coordinates stay below
/// [`FARTHEST_M`] and chains below 30 products, so the true error is under 1e-11 m; this leaves two digits to
/// spare.
pub const ROUNDING_M: f64 = 1e-9;
