use serde::{Deserialize, Serialize};

/// Limits asked of a motion besides those of the robot's joints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pace {
    /// Share of the limits of velocity, above 0 and at most 1.
    pub velocity: f64,
    /// Share of the limits of acceleration, above 0 and at most 1.
    pub acceleration: f64,
    /// Greatest speed of the origin of the gripper frame, in m/s; `None`: no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool_m_s: Option<f64>,
}

impl Default for Pace {
    fn default() -> Self {
        Self { velocity: 1.0, acceleration: 1.0, tool_m_s: None }
    }
}

impl Pace {
    /// Whether it limits nothing.
    pub fn is_full(&self) -> bool {
        *self == Self::default()
    }

    /// The first value that is no limit, with its name and the values that are.
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        let is_share = |share: f64| share > 0.0 && share <= 1.0;
        const SHARES: &str = "above 0 and at most 1";
        if !is_share(self.velocity) {
            return Some(("velocity", self.velocity, SHARES));
        }
        if !is_share(self.acceleration) {
            return Some(("acceleration", self.acceleration, SHARES));
        }
        let speed = self.tool_m_s.filter(|speed| !(*speed > 0.0 && speed.is_finite()))?;
        Some(("tool_m_s", speed, "above 0, in m/s"))
    }
}
