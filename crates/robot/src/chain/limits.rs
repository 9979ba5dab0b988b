use std::f64::consts::TAU;

/// Limits of a continuous joint are ± this value, in radians: one and a half turns in either direction, so that from any start
/// within a full turn the shortest rotation to every other angle stays inside, and cables are not wound up indefinitely.
pub const CONTINUOUS_LIMIT_RAD: f64 = 3.0 * std::f64::consts::PI;

/// Cautious default speed of a joint that turns: `MoveIt`'s 1 rad/s.
pub const DEFAULT_SPEED_RAD_S: f64 = 1.0;

/// Cautious default speed of a joint that slides, in m/s.
pub const DEFAULT_SPEED_M_S: f64 = 0.5;

/// Limits of a joint of the group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Minimum value, in `unit`.
    pub lower: f64,
    /// Maximum value, in `unit`.
    pub upper: f64,
    /// Maximum speed, in `unit`/s, greater than zero.
    pub velocity: f64,
    /// Maximum acceleration, in `unit`/s², if known.
    pub acceleration: Option<f64>,
    /// Maximum jerk, in `unit`/s³, if known.
    pub jerk: Option<f64>,
    /// Unit of the joint value.
    pub unit: JointUnit,
}

impl JointLimits {
    /// Returns true if `value` lies in [`lower`, `upper`]; false for NaN.
    pub fn contain(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// Returns the value within the limits that is nearest to `value`.
    pub fn clamp(&self, value: f64) -> f64 {
        value.clamp(self.lower, self.upper)
    }
}

/// Unit of a joint value; displayed as its symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::Display, strum::IntoStaticStr)]
pub enum JointUnit {
    /// Unit of a prismatic joint.
    #[strum(to_string = "m")]
    Metre,
    /// Unit of a revolute joint.
    #[strum(to_string = "rad")]
    Radian,
}

impl JointUnit {
    /// Returns the symbol: "m" or "rad".
    pub fn symbol(self) -> &'static str {
        self.into()
    }
}

/// A joint value outside its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitViolation {
    /// Index of the joint in `q`.
    pub joint: usize,
    /// Value of the joint.
    pub value: f64,
    /// Lower limit of the joint.
    pub lower: f64,
    /// Upper limit of the joint.
    pub upper: f64,
}

/// Default limits of a planar or floating joint, ± this value along each of its axes, in metres: the usual extent of a scene.
pub const FREE_JOINT_LIMIT_M: f64 = 2.0;

/// Returns `value` plus whole turns, in [lower, upper] and as near to `reference` as possible; `None` if none is within.
pub(crate) fn wrapped(value: f64, reference: f64, [lower, upper]: [f64; 2]) -> Option<f64> {
    let most = ((upper - value) / TAU).floor();
    let least = ((lower - value) / TAU).ceil();
    let turns = ((reference - value) / TAU).round().min(most).max(least);
    let turned = value + turns * TAU;
    (lower..=upper).contains(&turned).then_some(turned)
}
