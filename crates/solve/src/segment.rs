use strum::{EnumString, IntoStaticStr};

/// What a robot does along a [`Segment`] (a mode: Hauser & Latombe 2010).
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Mode {
    /// Goes to the grasp, the hand open and empty.
    Reach,
    /// Takes the object, in the closed hand, off what it rests on.
    LiftOff,
    /// Carries it on.
    Carry,
    /// Puts it down where it then rests.
    SetDown,
    /// Takes the hand, open and empty, off the object.
    Retreat,
    /// Goes back to where it started from.
    Return,
}

impl Mode {
    /// Whether the object is in the closed hand meanwhile.
    pub fn holds(self) -> bool {
        matches!(self, Self::LiftOff | Self::Carry | Self::SetDown)
    }
}

/// A piece of a path during which the hand holds what it holds: straight lines between way points.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// What the robot does meanwhile.
    pub mode: Mode,
    /// The object that the hand carries, if it carries one.
    pub attached: Option<String>,
    /// How far apart the fingers are, in metres; `None`: as far as they go.
    pub opening_m: Option<f64>,
    /// How much farther the finger that meets the object last would have to go than the first, in metres: so far the
    /// object is pushed, or the hand; `None` while nothing is held.
    pub uneven_m: Option<f64>,
    /// One value per joint each (m, rad).
    pub waypoints: Vec<Vec<f64>>,
    /// The least distance along each edge, in metres, proven; `None` where nothing is near, empty without a proof.
    pub clearances_m: Vec<Option<f64>>,
}

impl Segment {
    /// One along which the hand is open and empty.
    pub(crate) fn empty(mode: Mode, waypoints: Vec<Vec<f64>>) -> Self {
        Self { mode, attached: None, opening_m: None, uneven_m: None, waypoints, clearances_m: Vec::new() }
    }
}

/// The way points of segments that follow each other: where two meet, one.
pub fn joined(segments: &[Segment]) -> Vec<Vec<f64>> {
    let mut joined: Vec<Vec<f64>> = Vec::new();
    for segment in segments {
        joined.pop();
        joined.extend_from_slice(&segment.waypoints);
    }
    joined
}
