use cranny_task::{Mode, SpeedLimits};

/// Speed limits that a scenario states for motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedSpeed {
    /// Mode of the motions; `None`: all motions.
    pub mode: Option<Mode>,
    /// Share of the velocity limits, above 0 and at most 1.
    pub velocity: Option<f64>,
    /// Share of the acceleration limits, above 0 and at most 1.
    pub acceleration: Option<f64>,
    /// Maximum speed of the gripper frame, in m/s.
    pub tool_m_s: Option<f64>,
    /// Maximum angular speed of the hand, in °/s.
    pub turn_deg_s: Option<f64>,
}

impl StatedSpeed {
    /// Returns the name of its mode in files; `all` for all motions.
    pub fn key(&self) -> &'static str {
        self.mode.map_or(ALL, |mode| mode.name)
    }

    /// Returns the first invalid value, with a description of the valid values.
    pub(crate) fn fault(&self) -> Option<(f64, &'static str)> {
        let Self { velocity, acceleration, tool_m_s, turn_deg_s, .. } = *self;
        let full = SpeedLimits::default();
        let pace = SpeedLimits {
            velocity: velocity.unwrap_or(full.velocity),
            acceleration: acceleration.unwrap_or(full.acceleration),
            tool_m_s,
            turn_rad_s: turn_deg_s.map(f64::to_radians),
        };
        pace.fault().map(|(_, value, values)| (value, values))
    }
}

/// Key of the speeds of all motions.
pub(crate) const ALL: &str = "all";
