use cranny_robot::Robot;
use cranny_task::{Mode, Segment, legs};

/// What becomes of an object along a path on which it is carried away: it stands, the hand closes on it, and from then on
/// it goes with the hand, until that opens again where it is put down, if it is.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownCarry {
    /// What it is called.
    pub object: String,
    /// The configuration at which the hand closes (m, rad).
    pub grasp: Vec<f64>,
    /// How far the fingers have closed then, from 0, open, to 1.
    pub closing: f64,
    /// The configuration at which the hand opens again, if it does.
    pub placed: Option<Vec<f64>>,
    /// One after the other; where the object comes into the hand or leaves it the robot stands, and the hand moves.
    pub modes: Vec<ShownMode>,
}

/// What a robot does from when to when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownMode {
    /// What it does.
    pub mode: Mode,
    /// Index of the segment.
    pub segment: usize,
    /// In seconds.
    pub from_s: f64,
    /// In seconds.
    pub until_s: f64,
}

/// When a leg of a path is at its way points, in seconds.
pub(crate) type LegTimes = Vec<f64>;

impl ShownCarry {
    /// What each object of segments undergoes, one after the other; `times_s` are those of all way points of each leg.
    pub(crate) fn all_of(robot: &Robot, segments: &[Segment], times_s: &[LegTimes]) -> Vec<Self> {
        let mut modes: Vec<ShownMode> = Vec::new();
        let mut first = 0;
        for (leg, times_s) in legs(segments).zip(times_s) {
            let mut passed = 0;
            for segment in leg {
                let [from_s, until_s] = [passed, passed + segment.waypoints.len().saturating_sub(1)]
                    .map(|index| times_s.get(index).or(times_s.last()).copied().unwrap_or_default());
                passed += segment.waypoints.len().saturating_sub(1);
                modes.push(ShownMode { mode: segment.mode, segment: first, from_s, until_s });
                first += 1;
            }
        }
        // Once an object is let go, the next motion that does not leave it is towards another.
        let of_objects = modes.chunk_by(|a, b| b.mode.leaves || !a.mode.leaves);
        of_objects.filter_map(|modes| Self::of_modes(robot, segments, modes)).collect()
    }

    fn of_modes(robot: &Robot, segments: &[Segment], modes: &[ShownMode]) -> Option<Self> {
        let closes = modes.iter().position(|shown| shown.mode.holds)?;
        let holding = &segments[modes[closes].segment];
        let closing = holding.opening_m.zip(robot.hand());
        let let_go = modes[closes..].iter().take_while(|shown| shown.mode.holds).count() + closes;
        let placed =
            (let_go < modes.len()).then(|| segments[modes[let_go - 1].segment].waypoints.last().cloned());
        Some(Self {
            object: holding.attached.clone().unwrap_or_default(),
            grasp: holding.waypoints.first().cloned().unwrap_or_default(),
            closing: closing.map_or(0.0, |(opening_m, hand)| hand.pads.closing(opening_m)),
            placed: placed.flatten(),
            modes: modes.to_vec(),
        })
    }

    /// From when to when the hand closes, in seconds.
    pub fn closes_s(&self) -> [f64; 2] {
        self.hand_moves_s(false).unwrap_or_default()
    }

    /// From when to when it opens again, in seconds, if it does.
    pub fn opens_s(&self) -> Option<[f64; 2]> {
        self.hand_moves_s(true)
    }

    fn hand_moves_s(&self, opens: bool) -> Option<[f64; 2]> {
        let is_change = |modes: &&[ShownMode]| modes[0].mode.holds == opens && modes[1].mode.holds != opens;
        let change = self.modes.windows(2).find(is_change)?;
        Some([change[0].until_s, change[1].from_s])
    }

    /// How far the fingers have closed at an instant, from 0, open, to 1: evenly while the robot stands.
    pub fn closing_at(&self, time_s: f64) -> f64 {
        let share = |[from_s, until_s]: [f64; 2]| ((time_s - from_s) / (until_s - from_s)).clamp(0.0, 1.0);
        let opened = self.opens_s().map_or(0.0, share);
        self.closing * share(self.closes_s()) * (1.0 - opened)
    }

    /// Whether the hand has closed at an instant, so that the object goes with it.
    pub fn is_held_at(&self, time_s: f64) -> bool {
        time_s >= self.closes_s()[1] && !self.is_placed_at(time_s)
    }

    /// Whether the hand has begun to open again, so that the object stands where it is.
    pub fn is_placed_at(&self, time_s: f64) -> bool {
        self.opens_s().is_some_and(|[opens_s, _]| time_s >= opens_s)
    }
}
