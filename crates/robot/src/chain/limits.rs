use std::f64::consts::TAU;

/// The limits of a continuous joint are minus and plus this, in radians: one and a half turns either way, so that from
/// any start within a full turn the nearest way to every other angle stays inside, and cables are not wound up for ever.
pub const CONTINUOUS_LIMIT_RAD: f64 = 3.0 * std::f64::consts::PI;

/// What a joint of the group may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Least value, in `unit`.
    pub lower: f64,
    /// Greatest value, in `unit`.
    pub upper: f64,
    /// Greatest speed, in `unit`/s, greater than zero.
    pub velocity: f64,
    /// Greatest acceleration, in `unit`/s², if known.
    pub acceleration: Option<f64>,
    /// Greatest jerk, in `unit`/s³, if known.
    pub jerk: Option<f64>,
    /// What its value is measured in.
    pub unit: JointUnit,
}

impl JointLimits {
    /// Whether `value` lies in [`lower`, `upper`]. A NaN does not.
    pub fn contain(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// The value within the limits that is nearest to `value`.
    pub fn clamp(&self, value: f64) -> f64 {
        value.clamp(self.lower, self.upper)
    }
}

/// What the value of a joint is measured in; shown as its symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::Display, strum::IntoStaticStr)]
pub enum JointUnit {
    /// A prismatic joint.
    #[strum(to_string = "m")]
    Metre,
    /// A revolute joint.
    #[strum(to_string = "rad")]
    Radian,
}

impl JointUnit {
    /// Its symbol: "m" or "rad".
    pub fn symbol(self) -> &'static str {
        self.into()
    }
}

/// A joint value outside its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitViolation {
    /// Index of the joint in `q`.
    pub joint: usize,
    /// Its value.
    pub value: f64,
    /// Its lower limit.
    pub lower: f64,
    /// Its upper limit.
    pub upper: f64,
}

/// Along each of its axes, a planar or floating joint without limits goes from minus to plus this, in metres: about what
/// stands around a task.
pub const FREE_JOINT_LIMIT_M: f64 = 2.0;

/// `value` and whole turns, within [lower, upper] as near to `reference` as can be; `None` if none is within.
pub(crate) fn wrapped(value: f64, reference: f64, [lower, upper]: [f64; 2]) -> Option<f64> {
    let most = ((upper - value) / TAU).floor();
    let least = ((lower - value) / TAU).ceil();
    let turns = ((reference - value) / TAU).round().min(most).max(least);
    let turned = value + turns * TAU;
    (lower..=upper).contains(&turned).then_some(turned)
}
