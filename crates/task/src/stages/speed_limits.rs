use serde::{Deserialize, Serialize};

/// Limits of a motion besides those of the robot's joints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpeedLimits {
    /// Share of the limits of velocity, above 0 and at most 1.
    pub velocity: f64,
    /// Share of the limits of acceleration, above 0 and at most 1.
    pub acceleration: f64,
    /// Greatest speed of the origin of the gripper frame, in m/s; `None`: no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool_m_s: Option<f64>,
    /// Greatest angular speed of the hand, and of the object in it, in rad/s; `None`: no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn_rad_s: Option<f64>,
}

impl Default for SpeedLimits {
    fn default() -> Self {
        Self { velocity: 1.0, acceleration: 1.0, tool_m_s: None, turn_rad_s: None }
    }
}

impl SpeedLimits {
    /// Returns true if it adds no limit to those of the robot.
    pub fn is_full(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the first invalid value, with its name and its valid range.
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        let is_share = |share: f64| share > 0.0 && share <= 1.0;
        const SHARES: &str = "above 0 and at most 1";
        if !is_share(self.velocity) {
            return Some(("velocity", self.velocity, SHARES));
        }
        if !is_share(self.acceleration) {
            return Some(("acceleration", self.acceleration, SHARES));
        }
        let speeds = [("tool_m_s", self.tool_m_s), ("turn_rad_s", self.turn_rad_s)];
        let is_fault = |speed: &f64| !(*speed > 0.0 && speed.is_finite());
        let fault = |(name, speed): (_, Option<f64>)| Some((name, speed.filter(is_fault)?, "above 0"));
        speeds.into_iter().find_map(fault)
    }
}
