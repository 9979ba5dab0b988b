use cranny_task::{Mode, SpeedLimits};

/// Requested speeds of motions: for all, and for those of single modes.
#[derive(Clone, Debug, PartialEq)]
pub struct Paces {
    /// Limits of all modes that have none of their own.
    pub all: SpeedLimits,
    /// Paces of single modes, which take precedence over `all`; the last entry for a mode counts.
    pub of_modes: Vec<(Mode, SpeedLimits)>,
}

/// Default speed of the gripper frame at which an object is put down, in m/s: contact occurs at a twentieth of the speed of a
/// fall from 20 cm.
pub const SET_DOWN_M_S: f64 = 0.1;

impl Default for Paces {
    /// The full limits of the robot, except for the set-down ([`SET_DOWN_M_S`]).
    fn default() -> Self {
        Self::new(SpeedLimits::default())
    }
}

impl Paces {
    /// Creates one pace for all motions, with the tool no faster than [`SET_DOWN_M_S`] during the set-down.
    pub fn new(all: SpeedLimits) -> Self {
        let tool_m_s = all.tool_m_s.map_or(SET_DOWN_M_S, |speed| speed.min(SET_DOWN_M_S));
        Self { all, of_modes: vec![(Mode::SET_DOWN, SpeedLimits { tool_m_s: Some(tool_m_s), ..all })] }
    }

    /// Returns the pace of motions of a mode.
    pub fn of(&self, mode: Mode) -> SpeedLimits {
        let named = self.of_modes.iter().rev().find(|(of, _)| *of == mode);
        named.map_or(self.all, |(_, pace)| *pace)
    }

    /// Returns the first invalid value ([`SpeedLimits::fault`]).
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        std::iter::once(&self.all)
            .chain(self.of_modes.iter().map(|(_, pace)| pace))
            .find_map(SpeedLimits::fault)
    }
}
