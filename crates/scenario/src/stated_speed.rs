use cranny_task::{Mode, Pace};

/// Speeds that a scenario states of motions, as far as it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedSpeed {
    /// The mode of the motions; `None`: all.
    pub mode: Option<Mode>,
    /// Share of the limits of velocity, above 0 and at most 1.
    pub velocity: Option<f64>,
    /// Share of the limits of acceleration, above 0 and at most 1.
    pub acceleration: Option<f64>,
    /// Greatest speed of the gripper frame, in m/s.
    pub tool_m_s: Option<f64>,
    /// Greatest speed with which the hand turns, in °/s.
    pub turn_deg_s: Option<f64>,
}

impl StatedSpeed {
    /// The name of its mode in files, `all` for all.
    pub fn key(&self) -> &'static str {
        self.mode.map_or(ALL, |mode| mode.name)
    }

    /// The first value that is no limit, with the values that are.
    pub(crate) fn fault(&self) -> Option<(f64, &'static str)> {
        let Self { velocity, acceleration, tool_m_s, turn_deg_s, .. } = *self;
        let full = Pace::default();
        let pace = Pace {
            velocity: velocity.unwrap_or(full.velocity),
            acceleration: acceleration.unwrap_or(full.acceleration),
            tool_m_s,
            turn_rad_s: turn_deg_s.map(f64::to_radians),
        };
        pace.fault().map(|(_, value, values)| (value, values))
    }
}

/// The key of speeds of all motions.
pub(crate) const ALL: &str = "all";
