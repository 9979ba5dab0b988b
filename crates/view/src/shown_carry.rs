use cranny_robot::Robot;
use cranny_scenario::PlanFile;
use cranny_solve::{CLOSING_S, Mode};

/// What becomes of an object along a path on which it is carried away: it stands, the hand closes on it, and from then on
/// it goes with the hand.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownCarry {
    /// What it is called.
    pub object: String,
    /// The configuration at which the hand closes (m, rad).
    pub grasp: Vec<f64>,
    /// How far the fingers have closed then, from 0, open, to 1.
    pub closing: f64,
    /// One after the other; between the first two the hand closes.
    pub modes: [ShownMode; 3],
}

/// What a robot does from when to when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownMode {
    /// What it does.
    pub mode: Mode,
    /// In seconds.
    pub from_s: f64,
    /// In seconds.
    pub until_s: f64,
}

impl ShownCarry {
    /// Of a plan whose hand begins to close at `closes_s`; `onward` is when what follows is at its way points, from 0 s, and when it ends.
    pub(crate) fn of(
        robot: &Robot,
        plan: &PlanFile,
        grasp: &[f64],
        closes_s: f64,
        onward: (&[f64], f64),
    ) -> Self {
        let lift_off = plan.segments.iter().find(|segment| segment.mode == Mode::LiftOff.name());
        let opening_m = lift_off.and_then(|segment| segment.opening_m);
        let open_m = robot.hand().map(|hand| hand.description.opening_m);
        let closing = opening_m.zip(open_m).map_or(0.0, |(opening_m, open_m)| 1.0 - opening_m / open_m);
        let edges = lift_off.map_or(0, |segment| segment.waypoints.len().saturating_sub(1));
        let goes_on_s = closes_s + CLOSING_S;
        let lifted_s = goes_on_s + onward.0.get(edges).copied().unwrap_or_default();
        let mode = |mode, from_s, until_s| ShownMode { mode, from_s, until_s };
        Self {
            object: lift_off.and_then(|segment| segment.attached.clone()).unwrap_or_default(),
            grasp: grasp.to_vec(),
            closing: closing.clamp(0.0, 1.0),
            modes: [
                mode(Mode::Reach, 0.0, closes_s),
                mode(Mode::LiftOff, goes_on_s, lifted_s),
                mode(Mode::Carry, lifted_s, goes_on_s + onward.1),
            ],
        }
    }

    /// How far the fingers have closed at an instant, from 0, open, to 1: evenly while the robot stands.
    pub fn closing_at(&self, time_s: f64) -> f64 {
        let [reach, lift_off, _] = &self.modes;
        let share = (time_s - reach.until_s) / (lift_off.from_s - reach.until_s);
        self.closing * share.clamp(0.0, 1.0)
    }

    /// Whether the hand has closed at an instant, so that the object goes with it.
    pub fn is_held_at(&self, time_s: f64) -> bool {
        time_s >= self.modes[1].from_s
    }
}
