use cranny_task::{Mode, Pace};

/// Speeds that are asked of motions: for all, and for those of single modes.
#[derive(Clone, Debug, PartialEq)]
pub struct Paces {
    /// Of motions of modes that are not named.
    pub all: Pace,
    /// Of motions of a mode, each before that of all; the last counts.
    pub of_modes: Vec<(Mode, Pace)>,
}

/// Speed of the gripper frame at which an object is put down unless another one is asked for, in m/s: it then meets what
/// carries it at a twentieth of the speed of a fall from 20 cm.
pub const SET_DOWN_M_S: f64 = 0.1;

impl Default for Paces {
    /// All that the limits of the robot allow, but for putting down ([`SET_DOWN_M_S`]).
    fn default() -> Self {
        Self::new(Pace::default())
    }
}

impl Paces {
    /// One pace for all motions, the tool no faster than [`SET_DOWN_M_S`] while it puts an object down.
    pub fn new(all: Pace) -> Self {
        let tool_m_s = all.tool_m_s.map_or(SET_DOWN_M_S, |speed| speed.min(SET_DOWN_M_S));
        Self { all, of_modes: vec![(Mode::SET_DOWN, Pace { tool_m_s: Some(tool_m_s), ..all })] }
    }

    /// The pace of motions of a mode.
    pub fn of(&self, mode: Mode) -> Pace {
        let named = self.of_modes.iter().rev().find(|(of, _)| *of == mode);
        named.map_or(self.all, |(_, pace)| *pace)
    }

    /// The first value that is no limit ([`Pace::fault`]).
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        std::iter::once(&self.all).chain(self.of_modes.iter().map(|(_, pace)| pace)).find_map(Pace::fault)
    }
}
