use cranny_robot::Robot;
use cranny_task::{Mode, Segment, legs};

/// Motion of one object that a path carries: it rests, the hand closes on it, it moves with the hand, and it stays where the
/// hand opens, if it does.
#[derive(Clone, Debug, PartialEq)]
pub struct CarriedObjectMotion {
    /// Name of the object.
    pub object: String,
    /// The configuration at which the hand closes (m, rad).
    pub grasp: Vec<f64>,
    /// Closing of the fingers at the grasp, from 0 (open) to 1.
    pub closing: f64,
    /// Configuration at which the hand opens again, if it does (m, rad).
    pub placed: Option<Vec<f64>>,
    /// Modes in order of time. Between two modes of which only one holds the object, the robot stands still and the hand moves.
    pub modes: Vec<ShownMode>,
}

/// Mode of the robot over a time interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownMode {
    /// Mode of the motion.
    pub mode: Mode,
    /// Index of the segment.
    pub segment: usize,
    /// Start, in seconds.
    pub from_s: f64,
    /// End, in seconds.
    pub until_s: f64,
}

/// Times of the way points of a leg, in seconds.
pub(crate) type LegTimes = Vec<f64>;

impl CarriedObjectMotion {
    /// Returns the carries of all objects in order; `times_s` contains the way point times of each leg, in seconds.
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
        // After a release, the next motion that does not leave the object approaches another one.
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

    /// Returns the start and the end of the closing of the hand, in seconds.
    pub fn closes_s(&self) -> [f64; 2] {
        self.hand_moves_s(false).unwrap_or_default()
    }

    /// Returns the start and the end of the opening of the hand, in seconds, if it opens again.
    pub fn opens_s(&self) -> Option<[f64; 2]> {
        self.hand_moves_s(true)
    }

    fn hand_moves_s(&self, opens: bool) -> Option<[f64; 2]> {
        let is_change = |modes: &&[ShownMode]| modes[0].mode.holds == opens && modes[1].mode.holds != opens;
        let change = self.modes.windows(2).find(is_change)?;
        Some([change[0].until_s, change[1].from_s])
    }

    /// Returns the closing of the fingers at an instant, from 0 (open) to 1; its speed is constant while the robot stands.
    pub fn closing_at(&self, time_s: f64) -> f64 {
        let share = |[from_s, until_s]: [f64; 2]| ((time_s - from_s) / (until_s - from_s)).clamp(0.0, 1.0);
        let opened = self.opens_s().map_or(0.0, share);
        self.closing * share(self.closes_s()) * (1.0 - opened)
    }

    /// Returns true if the hand has closed at an instant, so that the object moves with it.
    pub fn is_held_at(&self, time_s: f64) -> bool {
        time_s >= self.closes_s()[1] && !self.is_placed_at(time_s)
    }

    /// Returns true if the hand has begun to open again at an instant, so that the object stays in its location.
    pub fn is_placed_at(&self, time_s: f64) -> bool {
        self.opens_s().is_some_and(|[opens_s, _]| time_s >= opens_s)
    }
}
