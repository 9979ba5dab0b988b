/// Distance below which a pair counts as in contact, in metres: less than the export noise of meshes (0.1 mm), more than every
/// rounding error of an `f64` distance. One value for the exact check, its fast forms and the proof of a motion.
pub const CONTACT_M: f64 = 1e-5;

/// Maximum distance of the gripper from a grasp in an exact answer, in metres (README, "What solved means").
pub const EXACT_TRANSLATION_M: f64 = 1e-3;

/// Maximum rotation of the gripper from a grasp in an exact answer: 1°, in radians.
pub const EXACT_ROTATION_RAD: f64 = std::f64::consts::PI / 180.0;

/// Maximum size and distance of anything, in metres: larger values are in other units, and round by more than [`ROUNDING_M`].
pub const FARTHEST_M: f64 = 1e3;

/// Amount that a proof subtracts from every `f64` distance to cover its rounding, in metres. Coordinates stay below
/// [`FARTHEST_M`] and chains below 30 products, so the true error is under 1e-11 m; this leaves two digits to spare.
pub const ROUNDING_M: f64 = 1e-9;
